use super::AnimationError;
use super::route::Width;
use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Point;
use crate::compute::herds::Obstacles;
use crate::compute::raster::Raster;
use std::cmp::Ordering;

/// Where the herd is to be at a time.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyFrame {
    /// Seconds; rising from key-frame to key-frame.
    pub time_s: f64,
    /// The herd's place, or the places of all its animals.
    pub pose: KeyPose,
}

/// What a key-frame fixes.
#[derive(Debug, Clone, PartialEq)]
pub enum KeyPose {
    /// The herd's centre only (T 4.3.1, "extra position-only key-frames").
    Position(Point),
    /// A key-herd: every animal's place, size and heading, in metres.
    Herd(Vec<Ellipse>),
}

impl KeyFrame {
    /// The herd's centre: the mean of the animals' centres.
    pub fn centre(&self) -> Point {
        match &self.pose {
            KeyPose::Position(place) => *place,
            KeyPose::Herd(herd) => {
                herd.iter().fold(Point::default(), |sum, e| sum + e.centre) * (1.0 / herd.len().max(1) as f64)
            }
        }
    }

    /// The key-herd, if there is one.
    pub fn herd(&self) -> Option<&[Ellipse]> {
        match &self.pose {
            KeyPose::Position(_) => None,
            KeyPose::Herd(herd) => Some(herd),
        }
    }
}

/// The centres of all key-frames.
pub(super) fn centres(frames: &[KeyFrame]) -> Vec<Point> {
    frames.iter().map(KeyFrame::centre).collect()
}

/// The first key-herd; empty without one.
pub(super) fn first_herd(frames: &[KeyFrame]) -> &[Ellipse] {
    frames.iter().find_map(KeyFrame::herd).unwrap_or(&[])
}

/// Half a body, and half the widest key-herd.
pub(super) fn width(frames: &[KeyFrame]) -> Width {
    let herd = first_herd(frames);
    let least_m = herd.iter().map(|e| e.b).fold(0.0, f64::max);
    let body = herd.iter().map(|e| e.a).fold(0.0, f64::max);
    let spread = |frame: &KeyFrame| {
        let centre = frame.centre();
        let far = |herd: &[Ellipse]| herd.iter().map(|e| e.centre.distance(centre)).fold(0.0, f64::max);
        frame.herd().map_or(0.0, far)
    };
    Width { least_m, ample_m: frames.iter().map(spread).fold(2.0 * body, f64::max) }
}

/// The most faults of a list of key-frames that are told (ours): a herd that stands off the terrain
/// is seen from fewer.
const MOST_FAULTS: usize = 100;

/// Everything that keeps key-frames from making an animation, at most [`MOST_FAULTS`].
pub(super) fn faults(terrain: &Raster<f32>, obstacles: &Obstacles, frames: &[KeyFrame]) -> Vec<AnimationError> {
    let expected = first_herd(frames).len();
    let herds = frames.iter().filter(|f| f.herd().is_some_and(|h| !h.is_empty())).count();
    let few = AnimationError::TooFewKeyFrames { frames: frames.len(), herds };
    let too_few = (frames.len() < 2 || expected == 0).then_some(few);
    let of = |index: usize| {
        let herd = frames[index].herd();
        let before_s = index.checked_sub(1).map(|before| frames[before].time_s);
        let number = herd.map(<[Ellipse]>::len).filter(|found| *found != expected);
        let number = number.map(|found| AnimationError::NumbersDiffer { index, expected, found });
        // The mean of the animals may fall into an obstacle that the herd surrounds.
        let centre = herd.is_none().then(|| (None, frames[index].centre()));
        let animals = herd.unwrap_or(&[]).iter().enumerate().map(|(i, e)| (Some(i), e.centre));
        let places = centre.into_iter().chain(animals);
        let misplaced = places.filter_map(move |(animal, place)| misplaced(terrain, obstacles, (index, animal, place)));
        out_of_order(index, before_s, frames[index].time_s).into_iter().chain(number).chain(misplaced)
    };
    too_few.into_iter().chain((0..frames.len()).flat_map(of)).take(MOST_FAULTS).collect()
}

fn out_of_order(index: usize, before_s: Option<f64>, time_s: f64) -> Option<AnimationError> {
    let before_s = before_s.unwrap_or(f64::NEG_INFINITY);
    (!time_s.is_finite() || time_s.partial_cmp(&before_s) != Some(Ordering::Greater))
        .then_some(AnimationError::TimesNotRising { index, time_s, before_s })
}

/// Why there can be no animal, or no middle of a herd, at a place.
fn misplaced(
    terrain: &Raster<f32>,
    obstacles: &Obstacles,
    (index, animal, place): (usize, Option<usize>, Point),
) -> Option<AnimationError> {
    let height = place.is_finite().then(|| terrain.at(place)).flatten();
    if height.is_none_or(|z| !z.is_finite()) {
        return Some(AnimationError::OffTerrain { index, animal, place });
    }
    obstacles.hold(place).then_some(AnimationError::InObstacle { index, animal, place })
}
