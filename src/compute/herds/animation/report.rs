use super::tracks::Pose;
use crate::compute::geometry::Point;

/// What held an animal up most.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Why {
    /// Its way was too long for the time given, had it been alone on level ground.
    Distance,
    /// Its way was too long as slopes let it go, had it been alone.
    Slope,
    /// It had the time, but was longer on its way round obstacles than held by others.
    Obstacle,
    /// It had the time, but others were in its way.
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

/// What an animal met in an interval.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Hindrance {
    /// Steps in which obstacles held or turned it.
    pub obstacle: u32,
    /// Steps in which others held it.
    pub crowding: u32,
}

/// Seconds that an animal needs for its way, if it is alone on it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Needed {
    /// At V_max throughout.
    pub level_s: f64,
    /// As slopes let it.
    pub slopes_s: f64,
}

impl Hindrance {
    /// Distance or slope if it could not have been there in time even alone, at the `cruise` share
    /// of V_max at which herds walk; else what held it more often.
    fn why(&self, needed: Needed, given_s: f64, cruise: f64) -> Why {
        let sloped = needed.level_s <= given_s && needed.slopes_s > SLOPED * needed.level_s;
        match (needed.slopes_s > given_s * cruise, sloped) {
            (true, true) => Why::Slope,
            (true, false) => Why::Distance,
            (false, _) if self.obstacle > self.crowding => Why::Obstacle,
            (false, _) => Why::Crowding,
        }
    }
}

/// Slopes that cost less than this many times the time on level ground are not told of (ours).
const SLOPED: f64 = 1.05;

/// What an interval gave the animals and asked of them.
pub(super) struct Asked<'a> {
    pub given_s: f64,
    /// The share of V_max at which herds walk.
    pub cruise: f64,
    /// By animal.
    pub needed: &'a [Needed],
    /// By animal.
    pub hindered: &'a [Hindrance],
}

/// The animals farther than half a body length from their places.
pub(super) fn late(poses: &[Pose], places: &[Point], bodies: &[(f64, f64)], asked: &Asked<'_>) -> Vec<Late> {
    let why = |i: usize| asked.hindered[i].why(asked.needed[i], asked.given_s, asked.cruise);
    let distance = |i: usize| poses[i].place.distance(places[i]);
    let late = (0..poses.len()).filter(|i| distance(*i) > bodies[*i].0);
    late.map(|animal| Late { animal, distance_m: distance(animal), why: why(animal) }).collect()
}
