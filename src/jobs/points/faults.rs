//! What the core says of a pattern, in the words of the wire.

use biotope_api::error::ErrorCode;

use crate::compute::geometry::PolygonError;
use crate::compute::pcf::PcfError;
use crate::jobs::Failure;
use crate::jobs::Invalid;

/// The fault of a polygon given at `pointer`.
pub fn polygon(error: &PolygonError, pointer: &str) -> Invalid {
    let at = |polygon: &usize| format!("{pointer}/polygons/{polygon}");
    match error {
        PolygonError::TooFewVertices { polygon, found } => {
            Invalid::new(at(polygon), ErrorCode::WrongCount, "rings of at least 3 places", found)
        }
        PolygonError::NotFinite { polygon } => {
            Invalid::new(at(polygon), ErrorCode::OutOfRange, "finite numbers", "one that is not")
        }
        PolygonError::Crossing { polygon, how } => {
            Invalid::new(at(polygon), ErrorCode::SelfCrossing, "rings that do not cross", how)
        }
        PolygonError::TooManyVertices { found } => {
            Invalid::new(pointer, ErrorCode::WrongCount, "at most 200000 places", found)
        }
        PolygonError::NoArea => Invalid::new(pointer, ErrorCode::ZeroArea, "a domain with an area", "none"),
    }
}

/// The fault of a pattern: `elements` is the pointer of its list, `exemplar` of what holds it.
/// `name` gives the names of classes. `None` for a stop.
pub fn pattern(error: &PcfError, exemplar: &str, name: impl Fn(usize) -> String) -> Option<Invalid> {
    let at = |index: &usize| format!("{exemplar}/elements/{index}");
    let invalid = match error {
        PcfError::Stopped(_) => return None,
        PcfError::Polygon(error) => polygon(error, &format!("{exemplar}/domain")),
        PcfError::Axis { field, expected, found } => {
            Invalid::new(format!("{exemplar}/{field}"), ErrorCode::OutOfRange, *expected, found)
        }
        PcfError::TooFewElements { found } => {
            Invalid::new(format!("{exemplar}/elements"), ErrorCode::WrongCount, "at least 2 elements", found)
        }
        PcfError::BadElement { index, field, expected, found } => {
            Invalid::new(format!("{}/{field}", at(index)), ErrorCode::OutOfRange, *expected, found)
        }
        PcfError::Duplicate { first, second } => Invalid::new(
            at(second),
            ErrorCode::DuplicateElements,
            "elements of one class that differ in place or radius",
            format!("the same as element {first}"),
        ),
        PcfError::Outside { index, x, y } => {
            Invalid::new(at(index), ErrorCode::OutsideDomain, "a place in the domain", format!("({x}, {y})"))
        }
        PcfError::NoBorder { reason } => {
            let expected = "at least three places, not on one line, to learn a border from";
            Invalid::new(format!("{exemplar}/elements"), ErrorCode::NoBorder, expected, reason)
        }
        PcfError::EmptyClass { class } => Invalid::new(
            format!("{exemplar}/dependencies"),
            ErrorCode::EmptyClass,
            "classes that have elements",
            name(*class),
        ),
        PcfError::Cycle { classes } => {
            let circle: Vec<String> = classes.iter().map(|c| name(*c)).collect();
            let found = circle.join(" → ");
            Invalid::new(
                format!("{exemplar}/dependencies"),
                ErrorCode::DependencyCycle,
                "dependencies without circles",
                found,
            )
        }
        PcfError::NoRoom => Invalid::new("/target", ErrorCode::ZeroArea, "room for new elements", "none"),
        PcfError::TooManyElements { asked, most } => {
            Invalid::new("/target/counts", ErrorCode::OutOfRange, format!("at most {most} elements"), asked)
        }
        PcfError::CannotFit { class, asked, cover, exemplar } => Invalid::new(
            "/target/counts",
            ErrorCode::CannotFit,
            "disks that cover at most 0.907 of the target, as they do not overlap in the exemplar",
            format!("{asked} of {} that cover {cover:.2}, in the exemplar {exemplar:.2}", name(*class)),
        ),
        PcfError::BadDensity { reason } => {
            Invalid::new("/target/density", ErrorCode::OutOfRange, "numbers from 0, not all 0", reason)
        }
        PcfError::BadClusterCount { asked, most } => {
            Invalid::new("/clusters", ErrorCode::OutOfRange, format!("1 to {most} clusters"), asked)
        }
    };
    Some(invalid)
}

/// The same for a job that runs.
pub fn failure(error: PcfError, name: impl Fn(usize) -> String) -> Failure {
    pattern(&error, "/exemplar", name).map_or(Failure::Stopped, Failure::Invalid)
}
