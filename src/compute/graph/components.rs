//! **Connected components** of the open cells of a grid, by runs and union-find
//! (J. Hopcroft and R. Tarjan 1973; run-based two-pass labelling after A. Rosenfeld 1966).

use crate::compute::raster::Grid;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;

/// The label of a cell that belongs to no component.
pub const NONE: u32 = u32::MAX;

/// Which cells count as neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Connectivity {
    /// The four that share a side.
    Four,
    /// These and the four that share a corner.
    Eight,
}

/// The components of a grid.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Components {
    /// Number of the component per cell, or [`NONE`]. Numbers follow the first cell of each
    /// component in row-major order.
    pub label: Vec<u32>,
    /// Number of cells per component.
    pub cells: Vec<u32>,
}

/// A row's longest stretch of cells that are open and joined to one another.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    from: u32,
    to: u32,
}

/// Labels the components of the cells for which `open` holds, where neighbours `a < b` belong
/// together if `joined(a, b)` (asked of open cells only; symmetric by meaning).
///
/// Linear in the number of cells; the numbering does not depend on the number of threads.
pub fn components(
    grid: &Grid,
    connectivity: Connectivity,
    open: impl Fn(usize) -> bool + Sync,
    joined: impl Fn(usize, usize) -> bool + Sync,
    run: &Run,
) -> Result<Components, Stopped> {
    run.check()?;
    let rows: Vec<Vec<Stretch>> =
        (0..grid.height).into_par_iter().map(|row| stretches(grid, row, &open, &joined)).collect();
    run.check()?;
    let first = offsets(&rows);
    let mut sets = Sets::new(first[grid.height]);
    let reach = u32::from(connectivity == Connectivity::Eight);
    for row in 1..grid.height {
        let (above, below) = (&rows[row - 1], &rows[row]);
        let base = (row - 1) * grid.width;
        let touching = |a: Stretch, b: Stretch| touch(base, grid.width, (a, b), reach, &joined);
        join_rows(&mut sets, (above, first[row - 1]), (below, first[row]), reach, touching);
    }
    run.check()?;
    Ok(number(grid, &rows, &first, &mut sets))
}

fn stretches(
    grid: &Grid,
    row: usize,
    open: &impl Fn(usize) -> bool,
    joined: &impl Fn(usize, usize) -> bool,
) -> Vec<Stretch> {
    let base = row * grid.width;
    let mut found: Vec<Stretch> = Vec::new();
    for column in 0..grid.width {
        if !open(base + column) {
            continue;
        }
        let column_u = column as u32;
        match found.last_mut() {
            Some(last) if last.to == column_u && joined(base + column - 1, base + column) => last.to += 1,
            _ => found.push(Stretch { from: column_u, to: column_u + 1 }),
        }
    }
    found
}

/// Index of the first stretch of each row, and the number of all at the end.
fn offsets(rows: &[Vec<Stretch>]) -> Vec<usize> {
    let mut sum = 0;
    let starts = rows.iter().map(|row| {
        sum += row.len();
        sum
    });
    std::iter::once(0).chain(starts).collect()
}

/// Whether a stretch of a row and one of the next row have neighbours that are joined.
fn touch(
    base: usize,
    width: usize,
    (above, below): (Stretch, Stretch),
    reach: u32,
    joined: &impl Fn(usize, usize) -> bool,
) -> bool {
    (below.from.max(above.from.saturating_sub(reach))..below.to.min(above.to + reach)).any(|column| {
        let lower = base + width + column as usize;
        let upper = above.from.max(column.saturating_sub(reach))..above.to.min(column + reach + 1);
        upper.into_iter().any(|c| joined(base + c as usize, lower))
    })
}

fn join_rows(
    sets: &mut Sets,
    (above, first_above): (&[Stretch], usize),
    (below, first_below): (&[Stretch], usize),
    reach: u32,
    touching: impl Fn(Stretch, Stretch) -> bool,
) {
    let mut start = 0;
    for (b, lower) in below.iter().enumerate() {
        while start < above.len() && above[start].to + reach <= lower.from {
            start += 1;
        }
        for (a, upper) in above.iter().enumerate().skip(start) {
            if upper.from >= lower.to + reach {
                break;
            }
            let (x, y) = (sets.root(first_above + a), sets.root(first_below + b));
            if x != y && touching(*upper, *lower) {
                sets.join(x, y);
            }
        }
    }
}

/// Gives the sets their numbers in the order of their first stretch, and every cell its number.
fn number(grid: &Grid, rows: &[Vec<Stretch>], first: &[usize], sets: &mut Sets) -> Components {
    let mut name = vec![NONE; sets.parent.len()];
    let mut cells: Vec<u32> = Vec::new();
    for (i, stretch) in rows.iter().flatten().enumerate() {
        let root = sets.root(i);
        if name[root] == NONE {
            name[root] = cells.len() as u32;
            cells.push(0);
        }
        name[i] = name[root];
        cells[name[i] as usize] += stretch.to - stretch.from;
    }
    let mut label = vec![NONE; grid.len()];
    label.par_chunks_mut(grid.width).enumerate().for_each(|(row, out)| {
        for (stretch, name) in rows[row].iter().zip(&name[first[row]..]) {
            out[stretch.from as usize..stretch.to as usize].fill(*name);
        }
    });
    Components { label, cells }
}

/// **Union-find** with path halving; the root of a set is its lowest member.
struct Sets {
    parent: Vec<u32>,
}

impl Sets {
    fn new(n: usize) -> Self {
        Self { parent: (0..n as u32).collect() }
    }

    fn root(&mut self, item: usize) -> usize {
        let mut at = item;
        while self.parent[at] as usize != at {
            self.parent[at] = self.parent[self.parent[at] as usize];
            at = self.parent[at] as usize;
        }
        at
    }

    fn join(&mut self, a: usize, b: usize) {
        self.parent[a.max(b)] = a.min(b) as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::random::Purpose;
    use crate::compute::random::hash;

    fn label(grid: &Grid, connectivity: Connectivity, open: &[bool]) -> Components {
        components(grid, connectivity, |i| open[i], |_, _| true, &Run::silent()).unwrap()
    }

    fn drawing(rows: &[&str]) -> (Grid, Vec<bool>) {
        let grid = Grid::new(rows[0].len(), rows.len(), 1.0);
        (grid, rows.iter().flat_map(|r| r.bytes().map(|b| b == b'#')).collect())
    }

    #[test]
    fn a_spiral_is_one_and_a_diagonal_is_one_only_by_corners() {
        let (grid, open) = drawing(&["#####", "#...#", "#.#.#", "#.###", "#...."]);
        assert_eq!(label(&grid, Connectivity::Four, &open).cells, vec![15]);
        let (grid, open) = drawing(&["#..", ".#.", "..#"]);
        assert_eq!(label(&grid, Connectivity::Four, &open).cells, vec![1, 1, 1]);
        assert_eq!(label(&grid, Connectivity::Eight, &open).cells, vec![3]);
    }

    /// Flood filling cell by cell, in row-major order.
    fn flood(
        grid: &Grid,
        connectivity: Connectivity,
        open: &[bool],
        joined: impl Fn(usize, usize) -> bool,
    ) -> Components {
        let neighbours = if connectivity == Connectivity::Four { 4 } else { 8 };
        let mut out = Components { label: vec![NONE; grid.len()], cells: Vec::new() };
        for start in (0..grid.len()).filter(|i| open[*i]) {
            if out.label[start] != NONE {
                continue;
            }
            let name = out.cells.len() as u32;
            out.cells.push(1);
            out.label[start] = name;
            let mut stack = vec![start];
            while let Some(at) = stack.pop() {
                for (n, d) in grid.neighbours(at) {
                    if open[n] && out.label[n] == NONE && (neighbours == 8 || d == 1.0) && joined(at.min(n), at.max(n))
                    {
                        out.label[n] = name;
                        out.cells[name as usize] += 1;
                        stack.push(n);
                    }
                }
            }
        }
        out
    }

    #[test]
    fn labels_equal_those_of_flood_filling() {
        const TEST: Purpose = Purpose::new("test.components");
        for seed in 0..60 {
            let grid = Grid::new(1 + (seed as usize * 7) % 40, 1 + (seed as usize * 11) % 37, 1.0);
            let open: Vec<bool> = (0..grid.len()).map(|i| hash(seed, TEST, i as u64) % 10 < 6).collect();
            let fence = |a: usize, b: usize| !hash(seed, TEST, (a * 10_007 + b) as u64).is_multiple_of(5);
            for connectivity in [Connectivity::Four, Connectivity::Eight] {
                let ours = components(&grid, connectivity, |i| open[i], fence, &Run::silent()).unwrap();
                assert_eq!(ours, flood(&grid, connectivity, &open, fence), "seed {seed}");
            }
        }
    }
}
