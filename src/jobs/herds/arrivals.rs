//! Who was at their place in time: the report of an animation and its warnings.

use biotope_api::warning::Warning;
use biotope_api::warning::WarningCode;
use serde_json::Value;
use serde_json::json;

use crate::compute::geometry::Point;
use crate::compute::herds::animation::Animation;
use crate::compute::herds::animation::Arrival;
use crate::compute::herds::animation::Late;
use crate::compute::herds::animation::Why;
use crate::jobs::herds::key_frames::KeyFrames;

/// The document `report`.
pub fn report(walked: &Animation, frames: &KeyFrames, origin: Point) -> Value {
    let arrivals: Vec<Value> = walked.report.arrivals.iter().map(|a| arrival(a, walked.tracks.animals)).collect();
    let times = &walked.tracks.times_s;
    json!({
        "animals": walked.tracks.animals,
        "key_frames": frames.frames.len(),
        "poses_each": times.len(),
        "from_s": times.first(),
        "to_s": times.last(),
        "path_m": walked.report.path_m,
        "waited_s": walked.report.waited_s,
        "origin_m": [origin.x, origin.y],
        "arrivals": arrivals,
    })
}

fn arrival(arrival: &Arrival, animals: usize) -> Value {
    let late = |late: &Late| json!({"id": late.animal, "distance_m": late.distance_m, "why": word(late.why)});
    json!({
        "key_frame": arrival.key_frame,
        "time_s": arrival.time_s,
        "given_s": arrival.given_s,
        "needed_s": arrival.needed_s,
        "reachable": !arrival.is_unreachable(animals),
        "cannot_reach": arrival.cannot_reach,
        "on_place": arrival.on_place,
        "late": arrival.late.iter().map(late).collect::<Vec<_>>(),
    })
}

const fn word(why: Why) -> &'static str {
    match why {
        Why::Distance => "distance",
        Why::Slope => "slope",
        Why::Obstacle => "obstacle",
        Why::Crowding => "crowding",
    }
}

/// A warning for every key-frame that cannot be reached, and for every one with late animals.
pub fn warnings(walked: &Animation, frames: &KeyFrames) -> Vec<Warning> {
    let animals = walked.tracks.animals;
    walked.report.arrivals.iter().filter_map(|a| warning(a, animals, frames)).collect()
}

fn warning(arrival: &Arrival, animals: usize, frames: &KeyFrames) -> Option<Warning> {
    let pointer = frames.pointers.get(arrival.key_frame).cloned().unwrap_or_default();
    let Arrival { time_s, given_s, needed_s, .. } = arrival;
    if arrival.is_unreachable(animals) {
        let message = format!(
            "no animal can be at its place at {time_s} s: {given_s:.1} s are given, about {needed_s:.1} s are needed"
        );
        return Some(Warning::new(WarningCode::KeyFrameUnreachable, pointer, message).with_count(animals as u64));
    }
    let late = arrival.late.len();
    if late == 0 {
        return None;
    }
    let of = |why: Why| arrival.late.iter().filter(|l| l.why == why).count();
    let reasons: Vec<String> = [Why::Distance, Why::Slope, Why::Obstacle, Why::Crowding]
        .into_iter()
        .filter(|why| of(*why) > 0)
        .map(|why| format!("{} by {}", of(why), word(why)))
        .collect();
    let message = format!(
        "{late} of {animals} animals were not within half a body length of their place at {time_s} s ({}); \
         {given_s:.1} s were given, about {needed_s:.1} s are needed",
        reasons.join(", ")
    );
    Some(Warning::new(WarningCode::LateAnimals, pointer, message).with_count(late as u64))
}
