//! How the elements of a block lie by their distance to the border of the domain.
//!
//! Border weights make up for the partners that an element at the border lacks, but nothing makes
//! up for the ground it saves: where elements keep apart, one at the border keeps others off half
//! as much ground as one within. Darts find a place there more often, and elements that settle go
//! there to get out of each other's way; the curves, means over all elements, hardly change. But a
//! curve is of a pattern that is the same everywhere. So elements are counted in strips along the
//! border, each of which is to hold its share.

use super::patch::Patch;
use super::sampler::Cell;
use crate::compute::geometry::Point;
use crate::compute::random::Purpose;
use crate::compute::random::Stream;

const DEPTHS: Purpose = Purpose::new("distribution.depths");

/// Number of strips.
const STRIPS: usize = 6;

/// Where the strips are, in r_max from the border, finer towards it (ours: elements crowd within
/// half the distance they keep, and lie thin up to twice as far). An element between two counts
/// for both, one beyond the last for the last.
const PLACES: [f64; STRIPS] = [0.0, 0.1, 0.25, 0.5, 0.9, 1.4];

/// Elements farther from the border than this, in r_max, all count the same.
pub(super) const FARTHEST: f64 = PLACES[STRIPS - 1];

/// Places looked at in every cell of the grid search near the border.
const LOOKS: usize = 16;

/// One value a strip.
type Strips = [f64; STRIPS];

/// The strips of one block. All depths are in r_max.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Depths {
    /// What part of the block each strip is.
    shares: Strips,
    /// How many elements each holds.
    counts: Strips,
    /// Σ of the counts.
    total: f64,
}

impl Depths {
    /// The strips in the block of `patch`, and in them the elements there that are not its own.
    pub(super) fn of(patch: &Patch<'_>) -> Self {
        let mut depths = Self { shares: shares(patch), ..Self::default() };
        let before = patch.context.list().iter().filter(|p| patch.holds(p.place));
        before.for_each(|p| depths.add(patch.scene.depth(p.place), 1.0));
        depths
    }

    /// Adds an element `times` at `depth`.
    pub(super) fn add(&mut self, depth: f64, times: f64) {
        add(&mut self.counts, depth, times);
        self.total += times;
    }

    /// How far the strips are from holding their shares: the sum of squared differences over the
    /// variance of independent elements (that of one at least), about 1 a strip for these.
    pub(super) fn unevenness(&self) -> f64 {
        let square = |(count, share): (&f64, &f64)| {
            let expected = share * self.total;
            (count - expected).powi(2) / expected.max(1.0)
        };
        self.counts.iter().zip(&self.shares).map(square).sum()
    }

    /// The same with one more element at `depth`.
    pub(super) fn unevenness_with(&self, depth: f64) -> f64 {
        let mut more = *self;
        more.add(depth, 1.0);
        more.unevenness()
    }
}

/// What part of the block of `patch` each strip is: its density over the block's.
fn shares(patch: &Patch<'_>) -> Strips {
    let (scene, mut random) = (patch.scene, Stream::new(0, DEPTHS, patch.scene.class as u64));
    let (mut shares, mut before) = (Strips::default(), 0.0);
    for cell in patch.block.cells() {
        let share = (cell.up_to() - before) / patch.block.mass;
        before = cell.up_to();
        if is_deep(patch, cell) {
            shares[STRIPS - 1] += share;
            continue;
        }
        let looks: Vec<Point> = (0..LOOKS).filter_map(|_| patch.sampler.draw_in(cell, &mut random)).collect();
        looks.iter().for_each(|p| add(&mut shares, scene.depth(*p), share / looks.len() as f64));
    }
    shares
}

/// Whether all of `cell` is beyond the last strip.
fn is_deep(patch: &Patch<'_>, cell: &Cell) -> bool {
    let (middle, half_diagonal) = patch.sampler.circle_around(cell);
    let deep = FARTHEST * patch.scene.unit + half_diagonal;
    patch.scene.domain.clearance(middle, deep * 1.01) > deep
}

/// Adds `times` an element at `depth` to the strips it counts for.
fn add(strips: &mut Strips, depth: f64, times: f64) {
    let next = PLACES.iter().position(|place| *place > depth).unwrap_or(STRIPS).max(1);
    let last = next - 1;
    let share = PLACES.get(next).map_or(0.0, |place| (depth - PLACES[last]) / (place - PLACES[last]));
    strips[last] += times * (1.0 - share);
    if let Some(strip) = strips.get_mut(next) {
        *strip += times * share;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_element_counts_as_one_wherever_it_lies() {
        for depth in [0.0, 0.05, 0.1, 0.3, 0.9, 1.3, FARTHEST, 7.0] {
            let mut strips = Strips::default();
            add(&mut strips, depth, 2.0);
            assert!((strips.iter().sum::<f64>() - 2.0).abs() < 1e-12, "{depth}: {strips:?}");
            let mean = strips.iter().zip(PLACES).map(|(count, place)| count * place).sum::<f64>() / 2.0;
            assert!((mean - depth.min(FARTHEST)).abs() < 1e-12, "{depth}: {mean}");
        }
    }

    #[test]
    fn strips_that_hold_their_shares_are_even_and_one_more_at_the_border_is_not() {
        let mut depths = Depths { shares: [0.05, 0.1, 0.1, 0.15, 0.2, 0.4], ..Depths::default() };
        let shares = depths.shares;
        PLACES.iter().zip(shares).for_each(|(place, share)| depths.add(*place, 100.0 * share));
        assert!(depths.unevenness() < 1e-12);
        assert!(depths.unevenness_with(0.0) > depths.unevenness_with(5.0));
        depths.add(0.0, 1.0);
        depths.add(0.0, -1.0);
        assert!(depths.unevenness() < 1e-12);
    }
}
