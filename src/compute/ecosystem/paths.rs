//! **Paths**: the trodden courses between places that are next to each other on the trails, and
//! the quickest way over them. What trails have found, plannings walk.

use super::ways::Way;
use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::collections::BinaryHeap;

/// A trodden course of one species, in one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// Who walks it.
    pub species: usize,
    /// The cells passed, at least one; each is one of the eight neighbours of the one before.
    pub cells: Vec<u32>,
    /// How long it takes, seconds.
    pub seconds: f64,
}

impl Path {
    fn from(&self) -> u32 {
        self.cells[0]
    }

    fn to(&self) -> u32 {
        self.cells[self.cells.len() - 1]
    }
}

/// All trodden courses.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Paths {
    list: Vec<Path>,
}

impl Paths {
    /// Courses in any order; those without cells are left out, and of several between the same
    /// places all but the quickest.
    pub fn new(mut list: Vec<Path>) -> Self {
        list.retain(|path| !path.cells.is_empty() && path.seconds.is_finite());
        list.sort_by(|a, b| key(a).cmp(&key(b)).then(a.seconds.total_cmp(&b.seconds)).then(a.cells.cmp(&b.cells)));
        list.dedup_by(|next, first| key(next) == key(first));
        Self { list }
    }

    /// The courses, by species, first and last cell.
    pub fn list(&self) -> &[Path] {
        &self.list
    }

    /// Seconds over the paths from a cell to each of `to`; infinite where they do not lead there.
    pub fn times_s(&self, species: usize, from: usize, to: &[usize]) -> Vec<f64> {
        let reached = self.search(species, from as u32, None);
        to.iter().map(|cell| reached.get(&(*cell as u32)).map_or(f64::INFINITY, |at| at.seconds)).collect()
    }

    /// The quickest way over the paths; `None` where they do not lead there.
    pub fn way(&self, species: usize, from: usize, to: usize) -> Option<Way> {
        let (from, to) = (from as u32, to as u32);
        let reached = self.search(species, from, Some(to));
        let seconds = reached.get(&to)?.seconds;
        let mut legs = Vec::new();
        let mut cell = to;
        while cell != from {
            let path = &self.list[reached.get(&cell)?.by];
            legs.push(path);
            cell = path.from();
        }
        let onward = legs.iter().rev().flat_map(|path| path.cells[1..].iter().copied());
        Some(Way { cells: std::iter::once(from).chain(onward).collect(), seconds })
    }

    /// What is reached from a cell, up to and including `to` (E. W. Dijkstra, 1959).
    fn search(&self, species: usize, from: u32, to: Option<u32>) -> BTreeMap<u32, Arrival> {
        let mut reached = BTreeMap::from([(from, Arrival { seconds: 0.0, by: usize::MAX })]);
        let mut queue = BinaryHeap::from([Reverse((0u64, from))]);
        while let Some(Reverse((bits, cell))) = queue.pop() {
            let now = f64::from_bits(bits);
            if reached.get(&cell).is_some_and(|at| now > at.seconds) {
                continue;
            }
            if to == Some(cell) {
                break;
            }
            for (by, path) in self.leaving(species, cell) {
                let seconds = now + path.seconds;
                if reached.get(&path.to()).is_none_or(|at| seconds < at.seconds) {
                    reached.insert(path.to(), Arrival { seconds, by });
                    queue.push(Reverse((seconds.to_bits(), path.to())));
                }
            }
        }
        reached
    }

    /// The paths that begin at a cell, with their places in the list.
    fn leaving(&self, species: usize, cell: u32) -> impl Iterator<Item = (usize, &Path)> {
        let first = self.list.partition_point(|path| (path.species, path.from()) < (species, cell));
        let here = move |path: &&Path| (path.species, path.from()) == (species, cell);
        self.list[first..].iter().take_while(here).enumerate().map(move |(i, path)| (first + i, path))
    }
}

/// How a place was reached.
struct Arrival {
    seconds: f64,
    /// The path walked last.
    by: usize,
}

fn key(path: &Path) -> (usize, u32, u32) {
    (path.species, path.from(), path.to())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(species: usize, cells: &[u32], seconds: f64) -> Path {
        Path { species, cells: cells.to_vec(), seconds }
    }

    fn paths() -> Paths {
        Paths::new(vec![
            path(0, &[1, 2, 3], 10.0),
            path(0, &[3, 2, 1], 12.0),
            path(0, &[3, 4, 5], 5.0),
            path(0, &[1, 8, 5], 40.0),
            path(0, &[1, 9, 3], 11.0),
            path(1, &[5, 4, 3], 1.0),
            path(0, &[7], f64::INFINITY),
        ])
    }

    #[test]
    fn the_quickest_way_goes_over_several_paths() {
        let way = paths().way(0, 1, 5).unwrap();
        assert_eq!((way.cells, way.seconds), (vec![1, 2, 3, 4, 5], 15.0));
        assert_eq!(paths().times_s(0, 1, &[1, 3, 5, 7]), [0.0, 10.0, 15.0, f64::INFINITY]);
    }

    #[test]
    fn paths_are_walked_in_their_direction_by_their_species_only() {
        assert_eq!(paths().way(0, 5, 3), None);
        assert_eq!(paths().way(1, 5, 3).unwrap().seconds, 1.0);
        assert_eq!(paths().way(0, 3, 1).unwrap().seconds, 12.0);
        assert_eq!(paths().way(0, 3, 3).unwrap().cells, [3]);
    }

    #[test]
    fn of_two_paths_between_the_same_places_the_quicker_stays() {
        let paths = paths();
        assert_eq!(paths.list().iter().filter(|p| (p.species, p.from(), p.to()) == (0, 1, 3)).count(), 1);
        assert_eq!(paths.way(0, 1, 3).unwrap().cells, [1, 2, 3]);
    }
}
