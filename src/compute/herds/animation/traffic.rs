//! The rule of the road: nobody runs into anybody. Of two animals that would, one makes less of
//! its step.

use super::motion::Mover;
use crate::compute::geometry::CellGrid;
use crate::compute::geometry::Point;
use crate::compute::herds::contact::Footprint;
use rayon::prelude::*;

/// What an animal may make of its step, from most to least: all of it, straight on without
/// turning, turning on the spot.
pub(super) const TRIES: usize = 3;

/// The level of an animal that stays as it was.
const STAY: u8 = TRIES as u8;

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

/// The bodies before a step, and after each that an animal may make of it.
pub(super) struct Bodies<'a> {
    pub old: &'a [Footprint],
    pub tries: &'a [[Footprint; TRIES]],
    /// How far any part of the body moves at most, in metres.
    pub moves: &'a [f64],
}

/// Decides what each animal makes of its step: the number of the try, or [`TRIES`] to stay.
///
/// No two then overlap deeper than `allowed` metres, or than they did before. Where two would,
/// the one whose step alone would do it makes less of it, both if each would, the later one if
/// neither; and again until there is none left. To stay is always possible, so it ends.
pub(super) fn settle(bodies: &Bodies<'_>, (grid, reach): (&CellGrid, f64), allowed: f64) -> Vec<u8> {
    let pairs = contacts(bodies, (grid, reach), allowed);
    let mut levels = vec![0u8; bodies.old.len()];
    let mut changed = vec![true; bodies.old.len()];
    loop {
        let losers: Vec<u32> = pairs
            .par_iter()
            .filter(|p| changed[p.one as usize] || changed[p.two as usize])
            .flat_map_iter(|p| losers(p, bodies, &levels))
            .collect();
        if losers.is_empty() {
            return levels;
        }
        changed.fill(false);
        for i in losers {
            let i = i as usize;
            levels[i] += u8::from(!changed[i]);
            changed[i] = true;
        }
    }
}

impl Bodies<'_> {
    fn at(&self, i: usize, level: u8) -> &Footprint {
        self.tries[i].get(usize::from(level)).unwrap_or(&self.old[i])
    }
}

fn losers(pair: &Pair, bodies: &Bodies<'_>, levels: &[u8]) -> impl Iterator<Item = u32> + use<> {
    let (one, two) = (pair.one as usize, pair.two as usize);
    let (level_one, level_two) = (levels[one], levels[two]);
    let (new_one, new_two) = (bodies.at(one, level_one), bodies.at(two, level_two));
    let meet = new_one.depth(new_two) > pair.limit;
    let one_errs = meet && level_one < STAY && new_one.depth(&bodies.old[two]) > pair.limit;
    let two_errs = meet && level_two < STAY && bodies.old[one].depth(new_two) > pair.limit;
    let neither = meet && !one_errs && !two_errs;
    let earlier = one_errs || (neither && level_two == STAY && level_one < STAY);
    let later = two_errs || (neither && level_two < STAY);
    [(earlier, pair.one), (later, pair.two)].into_iter().filter(|(loses, _)| *loses).map(|(_, i)| i)
}

/// The pairs whose bodies may touch whatever they make of the step, each once, by index.
fn contacts(bodies: &Bodies<'_>, (grid, reach): (&CellGrid, f64), allowed: f64) -> Vec<Pair> {
    let of = |i: usize| {
        let mut pairs = Vec::new();
        grid.for_each_near(bodies.old[i].centre(), reach, |j| {
            if j > i {
                let depth = bodies.old[i].depth(&bodies.old[j]);
                if depth > -(bodies.moves[i] + bodies.moves[j]) {
                    pairs.push(Pair { one: i as u32, two: j as u32, limit: depth.max(allowed) });
                }
            }
        });
        pairs
    };
    (0..bodies.old.len()).into_par_iter().flat_map_iter(of).collect()
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
            let variants: Vec<[Mover; TRIES]> = movers
                .iter()
                .zip(wanted)
                .map(|(was, to)| [to, Mover { heading: was.heading, ..to }, Mover { place: was.place, ..to }])
                .collect();
            let tries: Vec<[Footprint; TRIES]> = variants.iter().map(|v| v.map(|m| footprint(&m, body))).collect();
            let (old, moves) = (prints(&movers), vec![0.3 + 0.2; 400]);
            let centres: Vec<Point> = movers.iter().map(|m| m.place).collect();
            let bodies = Bodies { old: &old, tries: &tries, moves: &moves };
            let levels = settle(&bodies, (&CellGrid::new(&centres, 2.0), 2.7), 0.08);
            assert!(levels.iter().filter(|l| **l == 0).count() > 5);
            for i in 0..400 {
                movers[i] = variants[i].get(usize::from(levels[i])).copied().unwrap_or(movers[i]);
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
