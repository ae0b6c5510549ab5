//! Where a key-herd stands and how large it is: from the exemplar's frame to the ground.

use super::KeyHerdError;
use super::KeyHerdOptions;
use super::exemplar::Exemplar;
use super::hull;
use crate::compute::geometry::Bounds;
use crate::compute::geometry::Point;
use crate::compute::herds::Obstacles;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use rayon::prelude::*;

/// Samples across the exemplar's domain when the size is sought.
const SAMPLES: usize = 128;

/// Steps of the search for the size: growth by a seventh until there is room, then halving.
const GROWTHS: usize = 60;
const GROWTH: f64 = 1.15;
const HALVINGS: usize = 24;

/// The ground a key-herd stands on.
#[derive(Debug, Clone, Copy)]
pub struct Site<'a> {
    /// Heights in metres; off the map and in its holes no animal stands. Without a terrain the
    /// plane goes on for ever.
    pub terrain: Option<&'a Raster<f32>>,
    /// What animals may not stand in.
    pub obstacles: &'a Obstacles,
}

impl Site<'_> {
    /// Whether an animal of half this width may stand at `p`: on the ground, and no nearer to an
    /// obstacle than half its width.
    pub fn admits(&self, p: Point, half_width_m: f64) -> bool {
        let ground = self.terrain.is_none_or(|t| t.at(p).is_some_and(|z| z.is_finite()));
        ground && !self.obstacles.touch(p, half_width_m)
    }
}

/// A map from the exemplar's frame to the ground: rotation, scale, shift.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placement {
    from: Point,
    to: Point,
    /// The scaled rotation as a complex number.
    turn: Point,
}

impl Placement {
    fn new(exemplar: &Exemplar, (to, direction): (Point, Point), metres_per_unit: f64) -> Self {
        let d = exemplar.direction;
        let turn = Point::new(direction.dot(d), d.cross(direction)) * metres_per_unit;
        Self { from: exemplar.centre, to, turn }
    }

    fn times(p: Point, q: Point) -> Point {
        Point::new(p.x * q.x - p.y * q.y, p.x * q.y + p.y * q.x)
    }

    /// From the exemplar's frame to the ground.
    pub(super) fn to_ground(self, p: Point) -> Point {
        self.to + Self::times(self.turn, p - self.from)
    }

    /// From the ground to the exemplar's frame.
    pub(super) fn to_exemplar(self, p: Point) -> Point {
        let inverse = Point::new(self.turn.x, -self.turn.y) * (1.0 / self.turn.norm_sq());
        self.from + Self::times(inverse, p - self.to)
    }

    /// A unit vector of the exemplar as it points on the ground.
    pub(super) fn turned(self, v: Point) -> Point {
        Self::times(self.turn, v) * (1.0 / self.turn.norm())
    }
}

/// Scales the density map "in or out until it fits the requested number of animals" (T 4.2.4):
/// the smallest size at which its integral over what is not masked is `count`. The density in
/// animals per square metre stays that of the exemplar with animals of `metres_per_unit`.
pub(super) fn fit(
    exemplar: &Exemplar,
    site: Site<'_>,
    (to, direction): (Point, Point),
    (options, metres_per_unit): (&KeyHerdOptions, f64),
    run: &Run,
) -> Result<(Placement, f64), KeyHerdError> {
    let (samples, whole) = samples(exemplar);
    let (count, wanted) = (options.count, options.count as f64);
    let at = |k: f64| Placement::new(exemplar, (to, direction), k * metres_per_unit);
    let room = |k: f64| -> Result<f64, KeyHerdError> {
        run.check()?;
        let place = at(k);
        let free: Vec<f64> = samples
            .par_iter()
            .with_min_len(256)
            .map(|(p, weight)| if site.admits(place.to_ground(*p), options.body.1) { *weight } else { 0.0 })
            .collect();
        Ok(free.iter().sum::<f64>() * k * k)
    };
    let smallest = (wanted / whole).sqrt();
    let (mut low, mut high) = (0.0, smallest);
    let mut most = 0f64;
    for growth in 0..=GROWTHS {
        let found = room(high)?;
        most = most.max(found);
        if found >= wanted * (1.0 - 1e-9) {
            break;
        }
        if growth == GROWTHS || (growth > 8 && found < 0.999 * most) {
            return Err(KeyHerdError::NoRoom { wanted: count, most: most as usize });
        }
        low = high;
        high *= GROWTH;
    }
    if low > 0.0 {
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if room(middle)? >= wanted { high = middle } else { low = middle }
        }
    }
    Ok((at(high), high))
}

/// The placement under a painted density map, which fixes the herd's size itself: as large as the
/// exemplar with its density, so that the orientation field lies under the herd.
pub(super) fn unscaled(
    exemplar: &Exemplar,
    to: (Point, Point),
    (count, learnt): (usize, usize),
    metres_per_unit: f64,
) -> (Placement, f64) {
    let scale = (count as f64 / learnt as f64).sqrt();
    (Placement::new(exemplar, to, scale * metres_per_unit), scale)
}

/// Places over the exemplar's domain with the number of animals each stands for, and their sum.
fn samples(exemplar: &Exemplar) -> (Vec<(Point, f64)>, f64) {
    let corners = &exemplar.corners;
    let bounds = Bounds::of(corners.iter().copied()).unwrap_or(Bounds::new(Point::default(), Point::default()));
    let step = bounds.width().max(bounds.height()) / SAMPLES as f64;
    let place = |k: usize| {
        let p = bounds.min + Point::new((k % SAMPLES) as f64 + 0.5, (k / SAMPLES) as f64 + 0.5) * step;
        hull::contains(corners, p).then(|| (p, exemplar.at(p).1))
    };
    let mut all: Vec<(Point, f64)> = (0..SAMPLES * SAMPLES).into_par_iter().filter_map(place).collect();
    // The map is right in its shape; its integral is set to the exemplar's number.
    let sum: f64 = all.iter().map(|(_, density)| density).sum();
    let number = exemplar.count() as f64;
    all.iter_mut().for_each(|(_, weight)| *weight *= number / sum);
    (all, number)
}
