use super::AnimationError;
use super::AnimationOptions;
use super::frames;
use super::frames::KeyFrame;
use crate::compute::geometry::Point;

/// The most positions kept of an animation.
const MAX_POSES: usize = 20_000_000;

/// The most steps simulated, times animals.
const MAX_MOVES: f64 = 4e9;

/// Where an animal is at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Place in metres.
    pub place: Point,
    /// Height in metres.
    pub z: f64,
    /// Where it looks, radians counter-clockwise from east.
    pub heading: f64,
}

/// Where all animals are over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracks {
    /// Seconds, rising; all key-frames' times are among them.
    pub times_s: Vec<f64>,
    /// Number of animals.
    pub animals: usize,
    /// Poses, all animals of a time together.
    pub poses: Vec<Pose>,
}

impl Tracks {
    /// The pose of `animal` at the time `times_s[step]`.
    pub fn pose(&self, step: usize, animal: usize) -> Pose {
        self.poses[step * self.animals + animal]
    }
}

/// The steps of an animation: a whole number of equal ones in each interval between key-frames.
pub(super) struct Plan {
    pub start_s: f64,
    /// Steps and their length in seconds, per interval.
    pub intervals: Vec<(usize, f64)>,
    pub keep_every: usize,
    /// Times kept, at most.
    pub kept: usize,
}

impl Plan {
    pub(super) fn new(frames: &[KeyFrame], options: &AnimationOptions) -> Result<Self, AnimationError> {
        let animals = frames::first_herd(frames).len();
        let steps = |pair: &[KeyFrame]| ((pair[1].time_s - pair[0].time_s) / options.step_s - 1e-9).ceil().max(1.0);
        let total: f64 = frames.windows(2).map(steps).sum();
        let kept = (total / options.keep_every as f64).ceil() + frames.len() as f64;
        if kept * animals as f64 > MAX_POSES as f64 || total * animals as f64 > MAX_MOVES {
            return Err(AnimationError::TooLarge { animals, steps: kept.min(1e15) as usize, most: MAX_POSES });
        }
        let intervals = frames
            .windows(2)
            .map(|pair| (steps(pair) as usize, (pair[1].time_s - pair[0].time_s) / steps(pair)))
            .collect();
        Ok(Self { start_s: frames[0].time_s, intervals, keep_every: options.keep_every, kept: kept as usize })
    }
}
