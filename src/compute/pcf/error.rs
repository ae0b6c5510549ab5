use crate::compute::geometry::PolygonError;
use crate::compute::run::Stopped;

/// Why a pattern could not be analysed or laid out.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PcfError {
    /// The work was stopped.
    #[error(transparent)]
    Stopped(#[from] Stopped),
    /// The domain's polygons bound no region.
    #[error(transparent)]
    Polygon(#[from] PolygonError),
    /// A number of the curve's axis makes no sense.
    #[error("{field} is {found}, expected {expected}")]
    Axis {
        /// `sigma`, `step` or `extent`.
        field: &'static str,
        /// What was expected.
        expected: &'static str,
        /// What was found.
        found: f64,
    },
    /// A pattern needs two elements.
    #[error("{found} elements, at least 2 are needed")]
    TooFewElements {
        /// Elements found.
        found: usize,
    },
    /// An element's place or size is not a finite number, or its size is negative.
    #[error("element {index}: {field} is {found}, expected {expected}")]
    BadElement {
        /// The element's place in the list.
        index: usize,
        /// `x`, `y`, `radius` or `class`.
        field: &'static str,
        /// What was expected.
        expected: &'static str,
        /// What was found.
        found: f64,
    },
    /// Two elements of one class have the same place and size.
    #[error("elements {first} and {second} have the same place, class and size")]
    Duplicate {
        /// The earlier one's place in the list.
        first: usize,
        /// The later one's.
        second: usize,
    },
    /// An element lies outside the domain.
    #[error("element {index} at ({x}, {y}) lies outside the domain")]
    Outside {
        /// The element's place in the list.
        index: usize,
        /// Its x.
        x: f64,
        /// Its y.
        y: f64,
    },
    /// No border can be learnt from points on one line or fewer than three places.
    #[error("no border can be learnt: {reason}")]
    NoBorder {
        /// Why.
        reason: &'static str,
    },
    /// A dependency names a class that has no elements.
    #[error("class {class} has no elements")]
    EmptyClass {
        /// The class.
        class: usize,
    },
    /// The dependencies run in a circle.
    #[error("the dependencies run in a circle: {classes:?}")]
    Cycle {
        /// The classes along the circle, each depending on the next, the first repeated last.
        classes: Vec<usize>,
    },
    /// Nothing is left of the target domain.
    #[error("nothing is left of the target domain")]
    NoRoom,
    /// More elements are asked for than the limit.
    #[error("{asked} elements asked for, at most {most} are allowed")]
    TooManyElements {
        /// Elements asked for.
        asked: usize,
        /// The limit.
        most: usize,
    },
    /// The disks asked for cover so much of the target that they cannot fit.
    #[error("class {class}: {asked} elements cover {cover} of the target; the exemplar's cover is {exemplar}")]
    CannotFit {
        /// The class.
        class: usize,
        /// Elements asked for.
        asked: usize,
        /// Their area over the target's.
        cover: f64,
        /// The same of the exemplar.
        exemplar: f64,
    },
    /// A relative density is negative, not finite, or zero everywhere in the domain.
    #[error("the relative density is {reason}")]
    BadDensity {
        /// What is wrong.
        reason: &'static str,
    },
    /// The number of clusters cannot be reached.
    #[error("{asked} clusters asked for, expected 1 to {most}")]
    BadClusterCount {
        /// Clusters asked for.
        asked: usize,
        /// The most there can be.
        most: usize,
    },
}
