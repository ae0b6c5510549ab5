//! What the work on herds refuses, as faults of the fields concerned.

use biotope_api::error::ErrorCode;

use crate::compute::geometry::Point;
use crate::compute::graph::assignment::AssignmentError;
use crate::compute::herds::animation::AnimationError;
use crate::compute::herds::extraction::ExtractionError;
use crate::compute::herds::key_herd::KeyHerdError;
use crate::compute::pcf::PcfError;
use crate::jobs::Failure;
use crate::jobs::Invalid;
use crate::jobs::herds::key_frames::KeyFrames;

/// Why there was nothing to extract, where it is the client's fault.
pub fn extraction(error: &ExtractionError) -> Option<Invalid> {
    use ErrorCode as C;
    use ExtractionError as E;
    let (pointer, code, expected, found) = match error {
        E::OneKindOnly { missing } => {
            let found = format!("no {missing}");
            ("/scribbles".into(), C::OneKindOfScribble, "marks of animals and of ground".into(), found)
        }
        E::OutsidePicture { stroke, point, x, y, width, height } => (
            format!("/scribbles/strokes/{stroke}/points/{point}"),
            C::OutsidePicture,
            format!("a place in the picture: x 0 to {width}, y 0 to {height}"),
            format!("({x}, {y})"),
        ),
        E::LabelSize { expected, found } => (
            "/scribbles/labels".into(),
            C::SizeMismatch,
            format!("{expected} pixels, as the photo has"),
            format!("{found} pixels"),
        ),
        E::Contradiction { count, column, row } => (
            "/scribbles".into(),
            C::ContradictingScribbles,
            "every pixel marked as animal or as ground, not both".into(),
            format!("{count} pixels marked as both, the first in column {column}, row {row} from the top"),
        ),
        E::SameColours { percent } => (
            "/scribbles".into(),
            C::ColoursAlike,
            "animals and ground of different colours".into(),
            format!("only {percent:.0} % of the marked pixels can be told apart"),
        ),
        E::NoRegion => (
            "/scribbles".into(),
            C::NoRegion,
            "a region of the picture that looks like the marked animals".into(),
            "none that is large enough".into(),
        ),
        E::UnknownAnimal { id, count } => (
            "/corrections".into(),
            C::UnknownAnimal,
            format!("a number below {count}, as so many animals were found"),
            id.to_string(),
        ),
        E::BadEllipse { index } => (
            "/corrections".into(),
            C::NotAnEllipse,
            "axes a ≥ b > 0 and a centre in the picture".into(),
            format!("another in ellipse {index}, added ones first"),
        ),
        E::Stopped(_) => return None,
    };
    Some(Invalid::new(pointer, code, expected, found))
}

/// Why an extraction ended.
pub fn extraction_failure(error: ExtractionError) -> Failure {
    match (extraction(&error), error) {
        (Some(faults), _) => faults.into(),
        (None, ExtractionError::Stopped(stopped)) => stopped.into(),
        (None, error) => Failure::fault(error),
    }
}

/// Why there will be no animation, where it is the client's fault: all there is to say.
pub fn animations(errors: &[AnimationError], frames: &KeyFrames) -> Invalid {
    let mut all = Invalid::default();
    errors.iter().filter_map(|error| animation(error, frames)).for_each(|faults| all.extend(faults));
    all
}

/// Why there was no animation, where it is the client's fault.
fn animation(error: &AnimationError, frames: &KeyFrames) -> Option<Invalid> {
    use AnimationError as E;
    use ErrorCode as C;
    let at = |index: &usize| frames.pointers.get(*index).cloned().unwrap_or_else(|| "/key_frames".to_owned());
    let place = |p: &Point| format!("({}, {})", p.x, p.y);
    let within = |index: &usize, animal: &Option<usize>| {
        animal.map_or_else(|| at(index), |animal| format!("{}/herd/{animal}", at(index)))
    };
    let (pointer, code, expected, found) = match error {
        E::TooFewKeyFrames { frames, herds } => (
            "/key_frames".into(),
            C::WrongCount,
            "two key-frames, at least one of them with a herd".into(),
            format!("{frames} with {herds} herds"),
        ),
        E::TimesNotRising { index, time_s, before_s } => (
            format!("{}/time_s", at(index)),
            C::TimesNotRising,
            format!("a time after {before_s} s, that of the key-frame before"),
            format!("{time_s} s"),
        ),
        E::OffTerrain { index, animal, place: p } => {
            (within(index, animal), C::OffTerrain, "a place on the terrain, not in a hole of it".into(), place(p))
        }
        E::InObstacle { index, animal, place: p } => {
            (within(index, animal), C::InObstacle, "a place outside every obstacle".into(), place(p))
        }
        E::NumbersDiffer { index, expected, found } => (
            format!("{}/herd", at(index)),
            C::NumbersDiffer,
            format!("{expected} animals, as the first key-herd has"),
            found.to_string(),
        ),
        E::NoWay { from, nearest } => (
            at(&(from + 1)),
            C::NoWay,
            "a place that can be reached from the key-frame before".into(),
            format!("no way round the obstacles; the nearest place that can be reached is {}", place(nearest)),
        ),
        E::BadOption { field, expected, found } => {
            let inside = field.contains('.') || matches!(*field, "step_s" | "keep_every");
            let pointer = if inside { format!("/{}", field.replace('.', "/")) } else { format!("/gait/{field}") };
            (pointer, C::OutOfRange, (*expected).into(), found.to_string())
        }
        E::TooLarge { animals, steps, most } => (
            "/every_s".into(),
            C::OutOfRange,
            format!("at most {most} positions"),
            format!("{animals} animals at {steps} times"),
        ),
        E::Pairing(_) | E::Stopped(_) => return None,
    };
    Some(Invalid::new(pointer, code, expected, found))
}

/// Why an animation ended.
pub fn animation_failure(error: AnimationError, frames: &KeyFrames) -> Failure {
    match (animation(&error, frames), error) {
        (Some(faults), _) => faults.into(),
        (None, AnimationError::Stopped(stopped)) => stopped.into(),
        (None, AnimationError::Pairing(AssignmentError::Stopped(stopped))) => stopped.into(),
        (None, error) => Failure::fault(error),
    }
}

/// Why there is no key-herd, where it is the client's fault.
pub fn key_herd(error: &KeyHerdError) -> Option<Invalid> {
    use ErrorCode as C;
    use KeyHerdError as E;
    let (pointer, code, expected, found) = match error {
        E::NoExemplar => ("/exemplar".into(), C::WrongCount, "at least one animal".into(), "none".into()),
        E::BadEllipse { index } => {
            (format!("/exemplar/{index}"), C::NotAnEllipse, "axes a ≥ b > 0".into(), "others".into())
        }
        E::BadOption { field, expected, found } => {
            let field = if *field == "body" { "body/length_m".to_owned() } else { field.replace('.', "/") };
            (format!("/{field}"), C::OutOfRange, (*expected).into(), found.to_string())
        }
        E::NoRoom { wanted, most } => (
            "/count".into(),
            C::NoRoomForHerd,
            format!("at most about {most}, given the density, the obstacles and the terrain"),
            wanted.to_string(),
        ),
        E::NoDensity => {
            ("/density/map".into(), C::NoDensity, "a density above 0 where animals may stand".into(), "none".into())
        }
        E::Curve(PcfError::Stopped(_)) | E::Stopped(_) => return None,
        E::Curve(error) => {
            let expected = "animals whose correlation curve can be made".into();
            ("/exemplar".into(), C::Inconsistent, expected, error.to_string())
        }
    };
    Some(Invalid::new(pointer, code, expected, found))
}

/// Why a key-herd ended.
pub fn key_herd_failure(error: KeyHerdError) -> Failure {
    key_herd(&error).map_or(Failure::Stopped, Failure::Invalid)
}
