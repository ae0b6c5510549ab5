//! How an animal can move: forwards, turning at a limited rate, never sideways.

use super::AnimationError;
use crate::compute::geometry::Point;
use std::f64::consts::PI;

/// How fast animals move and turn. All limits hold at every step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gait {
    /// V_max (T 4.1.1) in metres a second, along the ground. Default: 3.
    pub max_speed_m_per_s: f64,
    /// Limit of the turning rate of heading and course, radians a second. Default: 1.5 (ours).
    pub max_turn_rad_per_s: f64,
    /// Largest change of speed, metres a second squared. Default: 3 (ours).
    pub max_acceleration_m_per_s2: f64,
    /// An animal that moves never looks further from its course than this, in radians. The text
    /// names animals that move sideways as its failure (T 4.4.2). Default: 0.35, 20 degrees (ours).
    pub max_slip_rad: f64,
    /// Within this distance of a key-herd along the path, in body lengths, headings blend towards
    /// those of the key-herd. Default: 4 (ours).
    pub blend_body_lengths: f64,
}

impl Default for Gait {
    fn default() -> Self {
        Self {
            max_speed_m_per_s: 3.0,
            max_turn_rad_per_s: 1.5,
            max_acceleration_m_per_s2: 3.0,
            max_slip_rad: 0.35,
            blend_body_lengths: 4.0,
        }
    }
}

impl Gait {
    pub(super) fn check(&self) -> Result<(), AnimationError> {
        let rules = [
            ("max_speed_m_per_s", self.max_speed_m_per_s, 0.01..=100.0, "from 0.01 to 100"),
            ("max_turn_rad_per_s", self.max_turn_rad_per_s, 0.01..=100.0, "from 0.01 to 100"),
            ("max_acceleration_m_per_s2", self.max_acceleration_m_per_s2, 0.01..=1000.0, "from 0.01 to 1000"),
            ("max_slip_rad", self.max_slip_rad, 0.0..=1.5, "from 0 to 1.5"),
            ("blend_body_lengths", self.blend_body_lengths, 0.0..=1000.0, "from 0 to 1000"),
        ];
        match rules.into_iter().find(|(_, found, range, _)| !range.contains(found)) {
            Some((field, found, _, expected)) => Err(AnimationError::BadOption { field, expected, found }),
            None => Ok(()),
        }
    }

    /// Share of V_max that is left on a slope (rise over run along the course): Tobler's hiking
    /// function (1993) over its value on flat ground, at most 1, and so that the speed along the
    /// ground, not only its projection, stays within V_max; never below 5 %.
    pub(super) fn slope_factor(slope: f64) -> f64 {
        let tobler = libm::exp(-3.5 * ((slope + 0.05).abs() - 0.05));
        tobler.min(1.0 / (1.0 + slope * slope).sqrt()).clamp(0.05, 1.0)
    }
}

/// Seconds in which an animal answers to a wish to turn (ours): in as long it has made up all but a
/// third of what its heading lacks. Without it every change of mind is a jerk of the body.
const ANSWER_S: f64 = 0.3;

/// An animal on the move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mover {
    pub place: Point,
    /// Where it looks.
    pub heading: f64,
    /// Where it goes; the heading while it stands.
    pub course: f64,
    /// Metres a second.
    pub speed: f64,
}

/// What an animal wants of the next step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Wish {
    /// Velocity in metres a second; the null vector to stand.
    pub velocity: Point,
    /// Where the nearest key-herd has it look.
    pub key_heading: f64,
    /// How much that counts, from 0 to 1.
    pub key_weight: f64,
    /// The fastest it can go here, metres a second.
    pub limit: f64,
}

/// The angle in (−π, π] that differs from `angle` by whole turns.
pub(super) fn wrapped(angle: f64) -> f64 {
    let turned = libm::fmod(angle, 2.0 * PI);
    if turned > PI {
        turned - 2.0 * PI
    } else if turned <= -PI {
        turned + 2.0 * PI
    } else {
        turned
    }
}

impl Mover {
    /// A standing animal.
    pub(super) fn standing(place: Point, heading: f64) -> Self {
        Self { place, heading: wrapped(heading), course: wrapped(heading), speed: 0.0 }
    }

    /// Velocity in metres a second.
    pub(super) fn velocity(&self) -> Point {
        if self.speed > 0.0 { Point::from_angle(self.course) * self.speed } else { Point::default() }
    }

    /// The animal a step later, if nothing is in its way. The heading turns first, as far as it
    /// may; the course follows within the slip; the speed falls with what the course lacks.
    pub(super) fn stepped(&self, wish: Wish, gait: &Gait, step_s: f64) -> Self {
        let (turn, gain) = (gait.max_turn_rad_per_s * step_s, gait.max_acceleration_m_per_s2 * step_s);
        let wanted = wish.velocity.norm();
        if wanted <= 0.0 && self.speed <= gain {
            let heading = if wish.key_weight > 0.0 { wish.key_heading } else { self.heading };
            let heading = wrapped(self.heading + wrapped(heading - self.heading).clamp(-turn, turn));
            return Self { heading, course: heading, speed: 0.0, ..*self };
        }
        let goal = if wanted > 0.0 { wish.velocity.angle() } else { self.course };
        let lean = (wish.key_weight * wrapped(wish.key_heading - goal)).clamp(-gait.max_slip_rad, gait.max_slip_rad);
        let answer = 1.0 - libm::exp(-step_s / ANSWER_S);
        let heading = self.heading + (answer * wrapped(goal + lean - self.heading)).clamp(-turn, turn);
        let was = if self.speed > 0.0 { self.course } else { self.heading };
        // Both bounds can be kept: the old course is within the slip of the old heading.
        let course = was + (answer * wrapped(goal - was)).clamp(-turn, turn);
        let course = heading + wrapped(course - heading).clamp(-gait.max_slip_rad, gait.max_slip_rad);
        let ahead = wanted * libm::cos(wrapped(goal - course)).max(0.0);
        let speed = ahead.clamp(self.speed - gain, self.speed + gain).min(wish.limit).max(0.0);
        let place = self.place + Point::from_angle(course) * (speed * step_s);
        Self { place, heading: wrapped(heading), course: wrapped(course), speed }
    }

    /// As much of the step to `to` as can be made without turning the body.
    pub(super) fn straight(&self, to: &Self, gait: &Gait) -> Self {
        let course = self.heading + wrapped(to.course - self.heading).clamp(-gait.max_slip_rad, gait.max_slip_rad);
        let speed = to.speed * libm::cos(wrapped(to.course - course)).max(0.0);
        Self { heading: self.heading, course: wrapped(course), speed, ..*self }
    }

    /// Only the turn of the step to `to`.
    pub(super) fn turned(&self, to: &Self) -> Self {
        Self { heading: to.heading, course: to.heading, speed: 0.0, ..*self }
    }

    /// As much of a turn as in the step to `to`, the other way round.
    pub(super) fn turned_back(&self, to: &Self) -> Self {
        let heading = wrapped(self.heading - wrapped(to.heading - self.heading));
        Self { heading, course: heading, speed: 0.0, ..*self }
    }

    /// The animal when it has to stay where it was.
    pub(super) fn held(&self) -> Self {
        Self { speed: 0.0, course: self.heading, ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::random::Purpose;
    use crate::compute::random::Stream;

    #[test]
    fn no_wish_makes_an_animal_too_fast_too_quick_to_turn_or_go_sideways() {
        let mut random = Stream::new(1, Purpose::new("test.motion"), 0);
        let gait = Gait::default();
        let mut mover = Mover::standing(Point::default(), 0.3);
        for _ in 0..5000 {
            let wish = Wish {
                velocity: Point::new(random.range(-5.0, 5.0), random.range(-5.0, 5.0))
                    * f64::from(random.below(3) as u8),
                key_heading: random.range(-3.1, 3.1),
                key_weight: random.unit(),
                limit: random.range(0.5, 3.0),
            };
            let next = mover.stepped(wish, &gait, 0.1);
            let moved = next.place - mover.place;
            assert!(moved.norm() <= wish.limit * 0.1 + 1e-12);
            assert!(wrapped(next.heading - mover.heading).abs() <= 0.15 + 1e-12);
            if moved.norm() > 1e-9 {
                assert!(wrapped(moved.angle() - next.heading).abs() <= gait.max_slip_rad + 1e-9);
                assert!(mover.speed == 0.0 || wrapped(next.course - mover.course).abs() <= 0.15 + 1e-12);
            }
            mover = if random.below(10) == 0 { next.held() } else { next };
        }
    }

    #[test]
    fn an_animal_turns_round_and_goes_back() {
        let gait = Gait::default();
        let mut mover = Mover::standing(Point::default(), 0.0);
        let wish = Wish { velocity: Point::new(-2.0, 0.0), key_heading: 0.0, key_weight: 0.0, limit: 3.0 };
        for _ in 0..60 {
            mover = mover.stepped(wish, &gait, 0.1);
        }
        assert!(mover.place.x < -5.0 && mover.place.y.abs() < 2.0, "{mover:?}");
        assert!((mover.velocity().x + 2.0).abs() < 1e-6);
    }

    #[test]
    fn slopes_slow_in_both_directions_and_never_hasten() {
        assert_eq!(Gait::slope_factor(0.0), 1.0);
        assert!(Gait::slope_factor(0.3) < 0.4 && Gait::slope_factor(-0.4) < 0.4);
        for k in -40..40 {
            let slope = f64::from(k) * 0.05;
            let factor = Gait::slope_factor(slope);
            assert!(factor <= 1.0 && (factor * (1.0 + slope * slope).sqrt() <= 1.0 + 1e-12 || factor == 0.05));
        }
    }
}
