//! Which of its partners an element of a block can have while blocks are filled one after another,
//! and elements one after another within a block.
//!
//! Of a ring around an element, what lies in its own block holds the block's elements so far, what
//! lies in a block filled before is full, what lies in one filled later is still empty. Border
//! weights leave out what lies outside the domain, so at the domain's border more of a ring is the
//! block's own than within.

use super::nodes::Nodes;
use super::patch::Patch;
use crate::compute::geometry::Point;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Points on a ring.
const DIRECTIONS: usize = 24;

/// Rings, from 0 to the farthest; between them the shares are near enough linear.
const RINGS: usize = 24;

/// Distance of two places whose rings are looked at, in r_max; between them the shares are near
/// enough linear.
const NODE_STEP: f64 = 1.0;

/// The most such places of a block.
const MOST_NODES: f64 = 4_000.0;

/// Parts of a ring in the domain, and their products, which are mixed by themselves.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Share {
    /// In the block itself.
    pub(super) own: f64,
    /// In blocks filled before.
    pub(super) filled: f64,
    /// The part in the block squared.
    pub(super) own_sq: f64,
    /// Both parts multiplied.
    pub(super) both: f64,
    /// The part in blocks filled before squared.
    pub(super) filled_sq: f64,
}

impl Share {
    /// All of a ring is in the block.
    const WHOLE: Self = Self { own: 1.0, filled: 0.0, own_sq: 1.0, both: 0.0, filled_sq: 0.0 };

    /// Of one ring.
    fn of(own: f64, filled: f64) -> Self {
        Self { own, filled, own_sq: own * own, both: own * filled, filled_sq: filled * filled }
    }

    /// The sum of two, each of them `times` itself.
    fn mixed((a, times_a): (Self, f64), (b, times_b): (Self, f64)) -> Self {
        Self {
            own: a.own * times_a + b.own * times_b,
            filled: a.filled * times_a + b.filled * times_b,
            own_sq: a.own_sq * times_a + b.own_sq * times_b,
            both: a.both * times_a + b.both * times_b,
            filled_sq: a.filled_sq * times_a + b.filled_sq * times_b,
        }
    }
}

/// The shares of rings of any radius around the places of a block, by a grid of places.
#[derive(Debug, Clone)]
pub(super) struct Shares {
    grid: Nodes,
    /// Metres from one ring to the next.
    ring_step: f64,
    /// By node and ring; empty for a block that is all of the domain.
    nodes: Vec<Share>,
}

impl Shares {
    /// Of the block of `patch`, up to rings of `farthest` metres.
    pub(super) fn of(patch: &Patch<'_>, farthest: f64) -> Self {
        let bounds = patch.block.bounds;
        let step = (NODE_STEP * patch.scene.unit).max((bounds.area() / MOST_NODES).sqrt());
        let (grid, ring_step) = (Nodes::over(bounds, step), farthest / RINGS as f64);
        let mut shares = Self { grid, ring_step, nodes: Vec::new() };
        if patch.sampler.is_all_of(patch.scene.domain) || farthest <= 0.0 {
            return shares;
        }
        let ring = |k: usize| {
            let (node, ring) = (k / (RINGS + 1), k % (RINGS + 1));
            let p = grid.place(node % grid.columns, node / grid.columns);
            around(patch, p, ring as f64 * ring_step).unwrap_or(Share::WHOLE)
        };
        shares.nodes = (0..grid.columns * grid.rows * (RINGS + 1)).into_par_iter().map(ring).collect();
        shares
    }

    /// Writes the shares of the rings around `p`, from 0 to the farthest, to `rings`; none for a
    /// block that is all of the domain.
    pub(super) fn around(&self, p: Point, rings: &mut Vec<Share>) {
        rings.clear();
        if self.nodes.is_empty() {
            return;
        }
        rings.resize(RINGS + 1, Share::default());
        for (node, part) in self.grid.corners(p) {
            let first = node * (RINGS + 1);
            for (ring, share) in rings.iter_mut().zip(&self.nodes[first..]) {
                *ring = Share::mixed((*ring, 1.0), (*share, part));
            }
        }
    }

    /// Of `rings`, the share of the one of `radius` metres.
    pub(super) fn at(&self, rings: &[Share], radius: f64) -> Share {
        let Some(last) = rings.len().checked_sub(1) else { return Share::WHOLE };
        let at = (radius / self.ring_step).clamp(0.0, last as f64);
        let lower = (at as usize).min(last.saturating_sub(1));
        let share = at - lower as f64;
        Share::mixed((rings[lower], 1.0 - share), (rings[lower + 1], share))
    }
}

/// Of the ring around `p`; `None` when none of it lies in the domain.
fn around(patch: &Patch<'_>, p: Point, radius: f64) -> Option<Share> {
    let (mut inside, mut own, mut filled) = (0.0, 0.0, 0.0);
    for k in 0..DIRECTIONS {
        let q = p + Point::from_angle(TAU * (k as f64 + 0.5) / DIRECTIONS as f64) * radius;
        if !patch.scene.domain.contains(q) {
            continue;
        }
        inside += 1.0;
        if patch.sampler.allows(q) {
            let colour = patch.sampler.colour_at(q);
            own += f64::from(u8::from(patch.block.bounds.contains(q)));
            filled += f64::from(u8::from(colour < patch.block.colour));
        }
    }
    (inside > 0.0).then(|| Share::of(own / inside, filled / inside))
}
