//! Which of its partners an element of a block can have while blocks are filled one after another,
//! and elements one after another within a block.
//!
//! Of a ring around an element, what lies in its own block holds the block's elements so far, what
//! lies in a block filled before is full, what lies in one filled later is still empty. Border
//! weights leave out what lies outside the domain, so at the domain's border more of a ring is the
//! block's own than within.

use super::patch::Patch;
use crate::compute::geometry::Point;
use crate::compute::random::Purpose;
use crate::compute::random::Stream;
use std::f64::consts::TAU;

const SHARES: Purpose = Purpose::new("distribution.shares");

/// Places of the block whose rings are looked at.
const PLACES: usize = 300;

/// Points on a ring.
const DIRECTIONS: usize = 8;

/// Rings, from 0 to the farthest; between them the shares are near enough linear.
const RINGS: usize = 24;

/// Parts of a ring in the domain, in the mean over uniform places of the block, and what their
/// products are in the mean.
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

/// The shares of rings of any radius around the places of a block.
pub(super) struct Shares {
    /// Metres from one ring to the next.
    step: f64,
    /// By ring; empty for a block that is all of the domain.
    rings: Vec<Share>,
}

impl Shares {
    /// Of the block of `patch`, up to rings of `farthest` metres.
    pub(super) fn of(patch: &Patch<'_>, farthest: f64) -> Self {
        if patch.sampler.is_all_of(patch.scene.domain) || farthest <= 0.0 {
            return Self { step: 1.0, rings: Vec::new() };
        }
        let step = farthest / RINGS as f64;
        let mut random = Stream::new(0, SHARES, patch.scene.class as u64);
        let mut rings = vec![Share::default(); RINGS + 1];
        let mut seen = [0.0; RINGS + 1];
        for _ in 0..PLACES {
            let Some(p) = patch.sampler.draw(patch.block, &mut random) else { continue };
            let turn = random.unit();
            for (k, ring) in rings.iter_mut().enumerate() {
                if let Some(share) = around(patch, p, (k as f64 * step, turn)) {
                    *ring = Share::mixed((*ring, 1.0), (share, 1.0));
                    seen[k] += 1.0;
                }
            }
        }
        let mean = |(ring, seen): (Share, f64)| {
            if seen > 0.0 { Share::mixed((ring, 1.0 / seen), (ring, 0.0)) } else { Share::WHOLE }
        };
        Self { step, rings: rings.into_iter().zip(seen).map(mean).collect() }
    }

    /// Of rings of `radius` metres.
    pub(super) fn at(&self, radius: f64) -> Share {
        let Some(last) = self.rings.len().checked_sub(1) else { return Share::WHOLE };
        let at = (radius / self.step).clamp(0.0, last as f64);
        let lower = (at as usize).min(last.saturating_sub(1));
        let share = at - lower as f64;
        Share::mixed((self.rings[lower], 1.0 - share), (self.rings[lower + 1], share))
    }
}

/// Of the ring around `p`, its points turned by a share of their distance; `None` when none of it
/// lies in the domain.
fn around(patch: &Patch<'_>, p: Point, (radius, turn): (f64, f64)) -> Option<Share> {
    let (mut inside, mut own, mut filled) = (0.0, 0.0, 0.0);
    for k in 0..DIRECTIONS {
        let q = p + Point::from_angle(TAU * (k as f64 + turn) / DIRECTIONS as f64) * radius;
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
