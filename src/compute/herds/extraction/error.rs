use crate::compute::run::Stopped;

/// Why no animals could be extracted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ExtractionError {
    /// Only one kind of scribble: there is nothing to tell apart.
    #[error("{missing} is not marked anywhere; both animals and ground must be")]
    OneKindOnly {
        /// The kind that is missing: `animal` or `ground`.
        missing: &'static str,
    },
    /// A scribble leaves the picture.
    #[error("point {point} of stroke {stroke} at ({x}, {y}) lies outside the picture of {width} × {height} pixels")]
    OutsidePicture {
        /// Which stroke.
        stroke: usize,
        /// Which of its points.
        point: usize,
        /// Where, from the left.
        x: f64,
        /// Where, from the bottom.
        y: f64,
        /// Width of the picture in pixels.
        width: usize,
        /// Height of the picture in pixels.
        height: usize,
    },
    /// The label image has another size than the photo.
    #[error("the label image has {found} pixels, the photo {expected}")]
    LabelSize {
        /// Pixels of the photo.
        expected: usize,
        /// Pixels of the label image.
        found: usize,
    },
    /// A pixel is marked as animal and as ground.
    #[error(
        "{count} pixels are marked as both animal and ground, the first in column {column}, row {row} from the top"
    )]
    Contradiction {
        /// How many pixels.
        count: usize,
        /// Column of the first from the left.
        column: usize,
        /// Row of the first from the top.
        row: usize,
    },
    /// The marked animals look like the marked ground.
    #[error(
        "the colours marked as animal and as ground are alike: only {percent:.0} % of the marked pixels can be told apart"
    )]
    SameColours {
        /// Share of the marked pixels that the classifier gets right, in percent.
        percent: f64,
    },
    /// Nothing in the picture looks like an animal.
    #[error("no region of the picture looks like the marked animals")]
    NoRegion,
    /// A correction names an animal that is not there.
    #[error("there is no animal {id} among the {count} found")]
    UnknownAnimal {
        /// The id that was named.
        id: u64,
        /// How many animals there are.
        count: usize,
    },
    /// An ellipse of a correction is not one, or not in the picture.
    #[error("ellipse {index} of the corrections has its centre outside the picture, or axes that are not a ≥ b > 0")]
    BadEllipse {
        /// Which of the ellipses, added ones first.
        index: usize,
    },
    /// The work was stopped.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}
