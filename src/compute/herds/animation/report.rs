use super::tracks::Pose;
use crate::compute::geometry::Point;

/// What held an animal up most.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Why {
    /// Its way was too long for V_max.
    Distance,
    /// Slopes slowed it.
    Slope,
    /// An obstacle was in its way.
    Obstacle,
    /// Other animals were in its way.
    Crowding,
}

/// An animal that was not at its place at a key-frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Late {
    /// Which animal.
    pub animal: usize,
    /// How far it was from its place, in metres.
    pub distance_m: f64,
    /// What held it up.
    pub why: Why,
}

/// How a key-frame was met.
#[derive(Debug, Clone, PartialEq)]
pub struct Arrival {
    /// Which key-frame; the first has nothing to arrive at and is left out.
    pub key_frame: usize,
    /// Its time in seconds.
    pub time_s: f64,
    /// Seconds there were since the key-frame before.
    pub given_s: f64,
    /// Seconds the animal with the longest way needs at V_max on these slopes.
    pub needed_s: f64,
    /// Animals whose own way needs more than the time given.
    pub cannot_reach: usize,
    /// Share of the animals within half a body length of their place.
    pub on_place: f64,
    /// The others, by index.
    pub late: Vec<Late>,
}

impl Arrival {
    /// Whether no animal at all can be there in time.
    pub fn is_unreachable(&self, animals: usize) -> bool {
        self.cannot_reach == animals
    }
}

/// Who reached the key-frames in time, who did not and why.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Report {
    /// One entry for each key-frame but the first.
    pub arrivals: Vec<Arrival>,
    /// Length of the herd's path in metres.
    pub path_m: f64,
    /// Seconds for which the herd frame waited, wholly or in part, for stragglers.
    pub waited_s: f64,
}

/// Counts what holds an animal up, in steps.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Hindrance {
    /// At full speed.
    pub distance: u32,
    /// Slowed by slopes.
    pub slope: u32,
    /// Held or turned by obstacles.
    pub obstacle: u32,
    /// Held by others.
    pub crowding: u32,
}

impl Hindrance {
    fn why(&self) -> Why {
        let causes = [
            (self.crowding, Why::Crowding),
            (self.obstacle, Why::Obstacle),
            (self.slope, Why::Slope),
            (self.distance, Why::Distance),
        ];
        causes
            .into_iter()
            .max_by_key(|(steps, why)| (*steps, *why == Why::Distance))
            .map_or(Why::Distance, |(_, why)| why)
    }
}

/// The animals farther than half a body length from their places.
pub(super) fn late(poses: &[Pose], places: &[Point], bodies: &[(f64, f64)], hindered: &[Hindrance]) -> Vec<Late> {
    let all = poses.iter().zip(places).zip(bodies.iter().zip(hindered)).enumerate();
    all.map(|(animal, ((pose, place), (body, hindrance)))| {
        (Late { animal, distance_m: pose.place.distance(*place), why: hindrance.why() }, body.0)
    })
    .filter(|(late, half_length)| late.distance_m > *half_length)
    .map(|(late, _)| late)
    .collect()
}
