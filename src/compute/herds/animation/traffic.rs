//! The rule of the road: nobody runs into anybody. Of two animals that would, one stays.

use super::motion::Mover;
use crate::compute::geometry::CellGrid;
use crate::compute::geometry::Point;
use crate::compute::herds::contact::Footprint;
use rayon::prelude::*;

/// The body of an animal in a pose.
pub(super) fn footprint(mover: &Mover, body: (f64, f64)) -> Footprint {
    Footprint::at(mover.place, Point::from_angle(mover.heading), body)
}

/// A pair that may come into contact in a step.
struct Pair {
    one: u32,
    two: u32,
    /// How deep they may overlap: what is allowed, or what they already do.
    limit: f64,
}

/// Decides who of the animals may make the step from `old` to `new`: `true` for those who may.
///
/// No two then overlap deeper than `allowed` metres, or than they did before. Where two would,
/// the one whose step alone would do it stays, both if each would, the later one if neither;
/// and again until there is none left. To stay is always possible, so it ends.
pub(super) fn settle(old: &[Footprint], new: &[Footprint], (grid, reach): (&CellGrid, f64), allowed: f64) -> Vec<bool> {
    let pairs = contacts(old, new, (grid, reach), allowed);
    let mut goes = vec![true; old.len()];
    loop {
        let at = |i: u32, goes: &[bool]| if goes[i as usize] { new[i as usize] } else { old[i as usize] };
        let stays: Vec<u32> = pairs
            .par_iter()
            .filter(|p| goes[p.one as usize] || goes[p.two as usize])
            .filter(|p| at(p.one, &goes).depth(&at(p.two, &goes)) > p.limit)
            .flat_map_iter(|p| losers(p, (old, new), &goes))
            .collect();
        if stays.is_empty() {
            return goes;
        }
        stays.into_iter().for_each(|i| goes[i as usize] = false);
    }
}

fn losers(pair: &Pair, (old, new): (&[Footprint], &[Footprint]), goes: &[bool]) -> impl Iterator<Item = u32> + use<> {
    let (one, two) = (pair.one as usize, pair.two as usize);
    let alone = |moves: &Footprint, stays: &Footprint| moves.depth(stays) > pair.limit;
    let one_errs = goes[one] && alone(&new[one], &old[two]);
    let two_errs = goes[two] && alone(&new[two], &old[one]);
    let later = goes[two] && !one_errs;
    let earlier = goes[one] && (one_errs || !goes[two]);
    let second = if one_errs || two_errs { two_errs } else { later };
    [(earlier, pair.one), (second, pair.two)].into_iter().filter(|(stays, _)| *stays).map(|(_, i)| i)
}

/// The pairs whose bodies may touch before or after the step, each once, by index.
fn contacts(old: &[Footprint], new: &[Footprint], (grid, reach): (&CellGrid, f64), allowed: f64) -> Vec<Pair> {
    let of = |i: usize| {
        let mut pairs = Vec::new();
        grid.for_each_near(old[i].centre(), reach, |j| {
            if j > i && new[i].depth(&new[j]).max(new[i].depth(&old[j])).max(old[i].depth(&new[j])) > 0.0 {
                let limit = old[i].depth(&old[j]).max(allowed);
                pairs.push(Pair { one: i as u32, two: j as u32, limit });
            }
        });
        pairs
    };
    (0..old.len()).into_par_iter().flat_map_iter(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::random::Purpose;
    use crate::compute::random::Stream;

    #[test]
    fn whatever_animals_want_none_gets_deeper_than_allowed() {
        let mut random = Stream::new(3, Purpose::new("test.traffic"), 0);
        let body = (1.0, 0.4);
        let mut movers: Vec<Mover> = (0..400)
            .map(|i| {
                let place = Point::new(f64::from(i % 20) * 2.1, f64::from(i / 20) * 2.1);
                Mover::standing(place, random.range(-3.0, 3.0))
            })
            .collect();
        for _ in 0..40 {
            // Everybody wants to the middle.
            let wanted: Vec<Mover> = movers
                .iter()
                .map(|m| {
                    let to = (Point::new(20.0, 20.0) - m.place).normalised().unwrap_or_default();
                    Mover { place: m.place + to * 0.3, heading: m.heading + random.range(-0.2, 0.2), ..*m }
                })
                .collect();
            let prints = |movers: &[Mover]| movers.iter().map(|m| footprint(m, body)).collect::<Vec<_>>();
            let (old, new) = (prints(&movers), prints(&wanted));
            let centres: Vec<Point> = movers.iter().map(|m| m.place).collect();
            let goes = settle(&old, &new, (&CellGrid::new(&centres, 2.0), 2.7), 0.08);
            assert!(goes.iter().filter(|g| **g).count() > 5);
            for i in 0..400 {
                movers[i] = if goes[i] { wanted[i] } else { movers[i] };
            }
            let now = prints(&movers);
            for i in 0..400 {
                for j in i + 1..400 {
                    assert!(now[i].depth(&now[j]) <= 0.08 + 1e-12);
                }
            }
        }
    }
}
