use crate::compute::geometry::Point;
use crate::compute::graph::assignment::AssignmentError;
use crate::compute::run::Stopped;

/// Why a herd could not be animated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AnimationError {
    /// Fewer than two key-frames, or none with a herd.
    #[error("an animation needs two key-frames, at least one of them with a key-herd; there are {frames} with {herds}")]
    TooFewKeyFrames {
        /// Key-frames given.
        frames: usize,
        /// Those with a key-herd.
        herds: usize,
    },
    /// A key-frame is not later than the one before it.
    #[error("key-frame {index} is at {time_s} s, not after the one before it at {before_s} s")]
    TimesNotRising {
        /// Which key-frame.
        index: usize,
        /// Its time in seconds.
        time_s: f64,
        /// The time of the one before it in seconds.
        before_s: f64,
    },
    /// A key-frame lies off the terrain or on a hole in it.
    #[error("key-frame {index} at ({}, {}) lies off the terrain", place.x, place.y)]
    OffTerrain {
        /// Which key-frame.
        index: usize,
        /// Which of its animals; `None` for its centre.
        animal: Option<usize>,
        /// Where, in metres.
        place: Point,
    },
    /// A key-frame, or an animal of its herd, lies in an obstacle.
    #[error("key-frame {index} has ({}, {}) inside an obstacle", place.x, place.y)]
    InObstacle {
        /// Which key-frame.
        index: usize,
        /// Which of its animals; `None` for its centre.
        animal: Option<usize>,
        /// Where, in metres.
        place: Point,
    },
    /// Two key-herds differ in number.
    #[error("the key-herd of key-frame {index} has {found} animals, the first has {expected}")]
    NumbersDiffer {
        /// Which key-frame.
        index: usize,
        /// Animals of the first key-herd.
        expected: usize,
        /// Animals of this one.
        found: usize,
    },
    /// Obstacles leave no way from one key-frame to the next.
    #[error("no way leads round the obstacles from key-frame {from} to the next; the nearest place that can be reached is ({}, {})", nearest.x, nearest.y)]
    NoWay {
        /// The key-frame before the gap.
        from: usize,
        /// The reachable place nearest to the next key-frame, in metres.
        nearest: Point,
    },
    /// An option is out of its range.
    #[error("{field} is {found}, not {expected}")]
    BadOption {
        /// Which option.
        field: &'static str,
        /// What it may be.
        expected: &'static str,
        /// What it is.
        found: f64,
    },
    /// The tracks would be too large.
    #[error("{animals} animals at {steps} times are more than {most} positions: ask for fewer times or animals")]
    TooLarge {
        /// Animals.
        animals: usize,
        /// Times.
        steps: usize,
        /// The most positions.
        most: usize,
    },
    /// Pairing failed.
    #[error(transparent)]
    Pairing(#[from] AssignmentError),
    /// The work was stopped.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}
