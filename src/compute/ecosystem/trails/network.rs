//! What the routes share: a network of portions between junctions, each with its load, and the
//! longest contiguous trails through it.

use super::routes::Route;
use std::collections::BTreeMap;

/// What each species carries, kg a year, by ascending species.
pub(crate) type Loads = Vec<(usize, f64)>;

/// A stretch between two junctions.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Portion {
    /// Neighbouring cells; first and last are junctions, unless it is a ring.
    pub(crate) cells: Vec<u32>,
    pub(crate) loads: Loads,
}

impl Portion {
    /// Mass of all species, kg a year.
    pub(crate) fn kg(&self) -> f64 {
        self.loads.iter().map(|load| load.1).sum()
    }
}

/// One trail: portions end to end, each with whether it is walked from its last cell.
pub(crate) type Chain = Vec<(usize, bool)>;

/// A link between two neighbouring cells, from the smaller to the larger.
struct Link {
    ends: (u32, u32),
    loads: Loads,
}

/// The portions of the network that the routes wear; the sum of load × length is that of the
/// routes. Junctions are where more or less than two links meet, and where routes end.
pub(crate) fn portions(routes: &[Route]) -> Vec<Portion> {
    let links = links(routes);
    let ends = ends(routes);
    let mut at: Vec<(u32, usize)> =
        links.iter().enumerate().flat_map(|(i, link)| [(link.ends.0, i), (link.ends.1, i)]).collect();
    at.sort_unstable();
    let meeting = |cell: u32| {
        let first = at.partition_point(|entry| entry.0 < cell);
        let end = first + at[first..].partition_point(|entry| entry.0 == cell);
        &at[first..end]
    };
    let junction = |cell: u32| meeting(cell).len() != 2 || ends.binary_search(&cell).is_ok();
    let mut done = vec![false; links.len()];
    let mut portions = Vec::new();
    // Rings without a junction come last, from their first cell.
    for rings in [false, true] {
        for &(start, first) in &at {
            if done[first] || (!rings && !junction(start)) {
                continue;
            }
            let mut cells = vec![start];
            let (mut cell, mut link) = (start, first);
            loop {
                done[link] = true;
                cell = if links[link].ends.0 == cell { links[link].ends.1 } else { links[link].ends.0 };
                cells.push(cell);
                let onward = meeting(cell).iter().find(|entry| !done[entry.1]);
                match onward {
                    Some(&(_, next)) if !junction(cell) => link = next,
                    _ => break,
                }
            }
            portions.push(Portion { cells, loads: links[first].loads.clone() });
        }
    }
    portions
}

/// The cells where routes begin and end, ascending.
pub(crate) fn ends(routes: &[Route]) -> Vec<u32> {
    let mut ends: Vec<u32> = routes.iter().flat_map(|r| [r.cells[0], r.cells[r.cells.len() - 1]]).collect();
    ends.sort_unstable();
    ends.dedup();
    ends
}

fn links(routes: &[Route]) -> Vec<Link> {
    let mut steps: Vec<((u32, u32), usize, f64)> = routes
        .iter()
        .flat_map(|r| r.cells.windows(2).map(|w| ((w[0].min(w[1]), w[0].max(w[1])), r.species, r.kg)))
        .collect();
    steps.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
    let of_species = |steps: &[((u32, u32), usize, f64)]| (steps[0].1, steps.iter().map(|step| step.2).sum());
    steps
        .chunk_by(|a, b| a.0 == b.0)
        .map(|steps| Link { ends: steps[0].0, loads: steps.chunk_by(|a, b| a.1 == b.1).map(of_species).collect() })
        .collect()
}

/// Greedy chaining (L 6.1, T 5.5.1): from the heaviest portion left, both ends are extended by
/// the heaviest portion left that meets them, until all portions are in a trail.
pub(crate) fn chains(portions: &[Portion]) -> Vec<Chain> {
    let mut order: Vec<usize> = (0..portions.len()).collect();
    order.sort_by(|&a, &b| portions[b].kg().total_cmp(&portions[a].kg()).then(a.cmp(&b)));
    let mut meeting: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for &i in &order {
        let cells = &portions[i].cells;
        meeting.entry(cells[0]).or_default().push(i);
        meeting.entry(cells[cells.len() - 1]).or_default().push(i);
    }
    let mut done = vec![false; portions.len()];
    let mut chains = Vec::new();
    for i in order {
        if std::mem::replace(&mut done[i], true) {
            continue;
        }
        let cells = &portions[i].cells;
        let back = extended(cells[0], portions, &meeting, &mut done);
        let ahead = extended(cells[cells.len() - 1], portions, &meeting, &mut done);
        let mut chain: Chain = back.into_iter().rev().map(|(p, reversed)| (p, !reversed)).collect();
        chain.push((i, false));
        chain.extend(ahead);
        chains.push(chain);
    }
    chains
}

/// The portions that continue a trail from `end` on, marked as taken.
fn extended(mut end: u32, portions: &[Portion], meeting: &BTreeMap<u32, Vec<usize>>, done: &mut [bool]) -> Chain {
    let mut chain = Chain::new();
    while let Some(&next) = meeting.get(&end).and_then(|near| near.iter().find(|i| !done[**i])) {
        done[next] = true;
        let cells = &portions[next].cells;
        let reversed = cells[0] != end;
        end = if reversed { cells[0] } else { cells[cells.len() - 1] };
        chain.push((next, reversed));
    }
    chain
}

#[cfg(test)]
mod tests {
    use super::*;

    fn route(cells: &[u32], species: usize, kg: f64) -> Route {
        Route { species, cells: cells.to_vec(), kg, both_ways: true }
    }

    #[test]
    fn shared_stretches_carry_the_sum_of_their_routes() {
        let routes = [route(&[1, 2, 3, 4, 5], 0, 10.0), route(&[12, 3, 4, 15], 1, 4.0), route(&[5, 4, 3], 0, 1.0)];
        let portions = portions(&routes);
        let with = |a: u32, b: u32| {
            let holds = |p: &&Portion| p.cells.contains(&a) && p.cells.contains(&b);
            portions.iter().find(holds).unwrap().clone()
        };
        assert_eq!(with(3, 4).loads, [(0, 11.0), (1, 4.0)]);
        assert_eq!(with(1, 3).loads, [(0, 10.0)]);
        assert_eq!(with(12, 3).loads, [(1, 4.0)]);
        assert_eq!(portions.len(), 5);
        let walked: f64 = portions.iter().map(|p| p.kg() * (p.cells.len() - 1) as f64).sum();
        assert_eq!(walked, 4.0 * 10.0 + 3.0 * 4.0 + 2.0);
    }

    #[test]
    fn a_ring_without_a_junction_is_a_portion_too() {
        let ring = route(&[1, 2, 3, 4, 1], 0, 1.0);
        let portions = portions(&[ring]);
        assert_eq!(portions.iter().map(|p| p.cells.len() - 1).sum::<usize>(), 4);
    }

    #[test]
    fn trails_start_at_the_heaviest_portion_and_follow_the_heaviest() {
        let routes = [
            route(&[1, 2, 3], 0, 5.0),
            route(&[3, 4], 0, 9.0),
            route(&[4, 5, 6], 0, 7.0),
            route(&[4, 14], 0, 2.0),
            route(&[3, 13], 0, 1.0),
        ];
        let portions = portions(&routes);
        let chains = chains(&portions);
        let cells = |chain: &Chain| {
            let mut cells: Vec<u32> = Vec::new();
            for &(p, reversed) in chain {
                let mut part = portions[p].cells.clone();
                if reversed {
                    part.reverse();
                }
                assert!(cells.last().is_none_or(|last| *last == part[0]));
                cells.extend(part);
            }
            cells.dedup();
            cells
        };
        let mut first = cells(&chains[0]);
        if first[0] != 1 {
            first.reverse();
        }
        assert_eq!(first, [1, 2, 3, 4, 5, 6]);
        assert_eq!(chains.len(), 3);
        assert_eq!(chains.iter().map(Vec::len).sum::<usize>(), portions.len());
    }
}
