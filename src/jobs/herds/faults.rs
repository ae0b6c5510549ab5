//! What the work on herds refuses, as faults of the fields concerned.

use biotope_api::error::ErrorCode;

use crate::codec::sheet::RasterError;
use crate::compute::herds::extraction::ExtractionError;
use crate::jobs::Failure;
use crate::jobs::Invalid;

/// A raster that cannot be read.
pub fn raster(error: &RasterError, pointer: &str) -> Invalid {
    let code = ErrorCode::from_code(error.code()).unwrap_or(ErrorCode::Unreadable);
    Invalid::new(pointer, code, error.expected(), error.found())
}

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
