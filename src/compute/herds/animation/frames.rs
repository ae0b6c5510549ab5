use super::AnimationError;
use super::route::Width;
use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Point;
use crate::compute::herds::Obstacles;
use crate::compute::raster::Raster;

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

/// Refuses key-frames that make no animation.
pub(super) fn check(terrain: &Raster<f32>, obstacles: &Obstacles, frames: &[KeyFrame]) -> Result<(), AnimationError> {
    let expected = first_herd(frames).len();
    if frames.len() < 2 || expected == 0 {
        let herds = frames.iter().filter(|f| f.herd().is_some_and(|h| !h.is_empty())).count();
        return Err(AnimationError::TooFewKeyFrames { frames: frames.len(), herds });
    }
    for (index, frame) in frames.iter().enumerate() {
        if let Some(before) = index.checked_sub(1).map(|i| frames[i].time_s)
            && frame.time_s.partial_cmp(&before) != Some(std::cmp::Ordering::Greater)
        {
            return Err(AnimationError::TimesNotRising { index, time_s: frame.time_s, before_s: before });
        }
        if let Some(found) = frame.herd().map(<[Ellipse]>::len).filter(|found| *found != expected) {
            return Err(AnimationError::NumbersDiffer { index, expected, found });
        }
        // The mean of the animals may fall into an obstacle that the herd surrounds.
        let centre = frame.herd().is_none().then(|| (None, frame.centre()));
        let animals = frame.herd().unwrap_or(&[]).iter().enumerate().map(|(i, e)| (Some(i), e.centre));
        for (animal, place) in centre.into_iter().chain(animals) {
            let height = place.is_finite().then(|| terrain.at(place)).flatten();
            if height.is_none_or(|z| !z.is_finite()) {
                return Err(AnimationError::OffTerrain { index, place });
            }
            if obstacles.hold(place) {
                return Err(AnimationError::InObstacle { index, animal, place });
            }
        }
    }
    Ok(())
}
