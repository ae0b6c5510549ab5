//! The five steering forces (T 4.3.2, after Reynolds 1987 and 1999): separation, alignment,
//! cohesion, obstacle avoidance by prediction, and following the guide.

use super::AnimationError;
use super::motion::Mover;
use super::terrain::Ground;
use crate::compute::geometry::Point;
use crate::compute::herds::contact::Footprint;

/// Weights and ranges of the forces. The text gives none: all defaults are ours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steering {
    /// Pushes neighbours apart that are closer than their guides are, as a share of V_max.
    /// Default: 0.6.
    pub separation: f64,
    /// Takes on the neighbours' velocity, as far as the animal is away from its guide. Default: 0.3.
    pub alignment: f64,
    /// Draws towards the neighbours, likewise, as a share of V_max. Default: 0.1.
    pub cohesion: f64,
    /// Steers away from where a collision with an obstacle is predicted, as a share of V_max.
    /// Default: 1.
    pub avoidance: f64,
    /// Seconds in which an animal makes up what it lacks to its guide. Default: 1.
    pub following_s: f64,
    /// How far ahead collisions with obstacles are predicted, in seconds. Default: 2.
    pub foresight_s: f64,
    /// Neighbours are those within this many body lengths. Default: 2.
    pub neighbourhood_body_lengths: f64,
}

impl Default for Steering {
    fn default() -> Self {
        Self {
            separation: 0.6,
            alignment: 0.3,
            cohesion: 0.1,
            avoidance: 1.0,
            following_s: 1.0,
            foresight_s: 2.0,
            neighbourhood_body_lengths: 2.0,
        }
    }
}

impl Steering {
    pub(super) fn check(&self) -> Result<(), AnimationError> {
        let rules = [
            ("steering.separation", self.separation, 0.0..=10.0, "from 0 to 10"),
            ("steering.alignment", self.alignment, 0.0..=10.0, "from 0 to 10"),
            ("steering.cohesion", self.cohesion, 0.0..=10.0, "from 0 to 10"),
            ("steering.avoidance", self.avoidance, 0.0..=10.0, "from 0 to 10"),
            ("steering.following_s", self.following_s, 0.05..=60.0, "from 0.05 to 60"),
            ("steering.foresight_s", self.foresight_s, 0.0..=60.0, "from 0 to 60"),
            ("steering.neighbourhood_body_lengths", self.neighbourhood_body_lengths, 0.5..=10.0, "from 0.5 to 10"),
        ];
        match rules.into_iter().find(|(_, found, range, _)| !range.contains(found)) {
            Some((field, found, _, expected)) => Err(AnimationError::BadOption { field, expected, found }),
            None => Ok(()),
        }
    }

    /// The force of the guide: its velocity, and what makes up the lag within `following_s`.
    pub(super) fn follow(&self, place: Point, guide: Point, guide_velocity: Point) -> Point {
        guide_velocity + (guide - place) * (1.0 / self.following_s)
    }

    /// The force away from an obstacle that the animal would come near: judged where it will be
    /// in `foresight_s` and half-way there. Along the obstacle's rim towards where it goes, and
    /// off it, the stronger the nearer.
    pub(super) fn avoid(&self, mover: &Mover, ground: &Ground<'_>, (half_width, speed): (f64, f64)) -> Point {
        let velocity = mover.velocity();
        let comfort = 3.0 * half_width;
        let clearance = ground.clearance();
        if clearance.at(mover.place) > comfort + speed * self.foresight_s {
            return Point::default();
        }
        let ahead = |share: f64| mover.place + velocity * (self.foresight_s * share);
        [0.0, 0.5, 1.0].into_iter().map(ahead).fold(Point::default(), |force, p| {
            let lack = 1.0 - clearance.at(p) / comfort;
            match clearance.away(p).or_else(|| clearance.away(mover.place)) {
                Some(away) if lack > 0.0 => force + away * (lack.min(1.5) * self.avoidance * speed / 3.0),
                _ => force,
            }
        })
    }
}

/// What an animal sees of its neighbours, summed in the order they are met.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Company {
    apart: Point,
    velocity: Point,
    centre: Point,
    count: f64,
}

/// Neighbours keep at most this many times the distance at which they touch (ours).
const COMFORT: f64 = 1.4;

impl Company {
    /// Takes in a neighbour: its footprint and velocity, seen from `own`, and how far apart the
    /// two guides are.
    pub(super) fn meet(&mut self, own: &Footprint, (other, velocity): (&Footprint, Point), guides_apart: f64) {
        let offset = own.centre() - other.centre();
        let distance = offset.norm();
        self.velocity = self.velocity + velocity;
        self.centre = self.centre + other.centre();
        self.count += 1.0;
        let Some(away) = offset.normalised() else { return };
        let touch = own.support(away) + other.support(away);
        let comfort = (guides_apart / touch).clamp(1.0, COMFORT);
        let lack = comfort - distance / touch;
        if lack > 0.0 {
            self.apart = self.apart + away * (lack / 0.4).min(2.0);
        }
    }

    /// Separation, alignment and cohesion as one velocity. `lost` from 0 (at the guide) to 1
    /// (two body lengths away) weighs the last two: the guide knows better.
    pub(super) fn forces(&self, steering: &Steering, mover: &Mover, (speed, lost): (f64, f64)) -> Point {
        if self.count == 0.0 {
            return Point::default();
        }
        let mean = 1.0 / self.count;
        let align = (self.velocity * mean - mover.velocity()) * (steering.alignment * lost);
        let centre = (self.centre * mean - mover.place).normalised().unwrap_or_default();
        self.apart * (steering.separation * speed) + align + centre * (steering.cohesion * speed * lost)
    }
}
