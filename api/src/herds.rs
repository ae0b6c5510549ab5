//! `herd-extraction`, `key-herd` and `herd-animation`: from a photo to animals that walk.
//!
//! Sources: T = thesis of 2020, chapter 4; H = "Image-based authoring of herd animations" (2019).
//! An animal is an ellipse. In a photo its unit is a pixel of the upright picture, x to the right
//! and y **up** from the lower left corner; on the ground it is a metre, x east and y north.
//! Angles are in radians, counter-clockwise from the right or from east.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::reference::Reference;

/// An animal seen from above. The fields are the columns of every output `ellipses`, so that one
/// process takes what another gives.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EllipseInput {
    /// Its number; not looked at, the place in the list counts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub id: Option<u64>,
    /// Centre, to the right or east.
    pub x: f64,
    /// Centre, up or north.
    pub y: f64,
    /// Half the length, at least `b`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub a: f64,
    /// Half the width.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub b: f64,
    /// Heading along the length, radians.
    pub theta: f64,
    /// Whether it may not be one animal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub suspect: Option<bool>,
    /// Why; not looked at.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
}

/// What lies under a stroke.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum MarkInput {
    /// Animals.
    Animal,
    /// Ground, or anything else that is no animal.
    Ground,
}

/// A line drawn over the photo.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StrokeInput {
    /// What lies under it.
    pub mark: MarkInput,
    /// Its corners as [x, y] in pixels from the lower left corner, y up; one is a dot.
    #[schemars(length(min = 1, max = 10_000))]
    pub points: Vec<[f64; 2]>,
    /// Its width in pixels. Default: 5.
    #[serde(default = "default_width")]
    #[schemars(range(min = 1.0, max = 1000.0))]
    pub width: f64,
}

fn default_width() -> f64 {
    5.0
}

/// What the user marks: as strokes or as a label image; animals and ground must both be marked.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScribblesInput {
    /// Lines drawn over the photo.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = 10_000))]
    pub strokes: Option<Vec<StrokeInput>>,
    /// A grey picture or raster of the size of the upright photo: 0 says nothing, 1 or 255 an
    /// animal, 2 or 128 ground.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub labels: Option<Reference>,
}

/// What one region is replaced by.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReplacementInput {
    /// Number of the region.
    pub id: u64,
    /// The animals there: the first keeps the number, the others get new ones.
    #[schemars(length(min = 1, max = 1000))]
    pub by: Vec<EllipseInput>,
}

/// What the user changes in the animals found by an earlier run on the same photo and scribbles.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CorrectionsInput {
    /// Numbers of regions that are no animals.
    #[schemars(length(max = 100_000))]
    pub remove: Vec<u64>,
    /// Regions that are replaced by one animal or several.
    #[schemars(length(max = 100_000))]
    pub replace: Vec<ReplacementInput>,
    /// Animals that were missed; they get the numbers after all others.
    #[schemars(length(max = 100_000))]
    pub add: Vec<EllipseInput>,
    /// Numbers of animals that face the other way.
    #[schemars(length(max = 100_000))]
    pub flip: Vec<u64>,
    /// Whether all animals found face the other way; those in `flip` are turned once more.
    pub flip_all: bool,
}

/// How animals are told from the ground and from each other. What is left out takes its default.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExtractionOptionsInput {
    /// The direction that all animals are first turned to within a quarter turn of, radians: a
    /// photo gives an axis, not a heading. Default: 0, to the right.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<f64>,
    /// Passes of smoothing over the decision before it becomes a mask. Default: 3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(max = 100))]
    pub smoothing: Option<u32>,
    /// Regions smaller than this many pixels are dropped. Default: 15 % of the median region
    /// under the animal strokes, at least 8.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1.0))]
    pub min_area_px: Option<f64>,
    /// Two parts of a region stay one animal while the neck between them is at least this share
    /// of the lower one's depth. Default: 0.92.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub merge_depth: Option<f64>,
    /// Two parts become one animal again when together they fill at least this share of their
    /// ellipse. Default: 0.95.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub merge_fill: Option<f64>,
    /// An animal is suspect when the logarithm of its area or proportion lies more than this many
    /// standard deviations from the median. Default: 3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 100.0))]
    pub suspect_deviations: Option<f64>,
    /// An animal is suspect when it fills less than this share of its ellipse. Default: 0.88.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub suspect_fill: Option<f64>,
}

/// Inputs of `herd-extraction`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HerdExtractionInputs {
    /// JPEG or PNG of at most 24 megapixels; turned upright as its EXIF data says.
    #[schemars(title = "Photo")]
    pub photo: Reference,
    /// A few spots of animals and of ground.
    #[schemars(title = "Scribbles")]
    pub scribbles: ScribblesInput,
    /// What to change in the animals found by an earlier run.
    #[schemars(title = "Corrections")]
    #[serde(default)]
    pub corrections: CorrectionsInput,
    /// How animals are told apart.
    #[schemars(title = "Options")]
    #[serde(default)]
    pub options: ExtractionOptionsInput,
    /// Seed; an extraction draws no random numbers. Default: 0.
    #[schemars(title = "Seed")]
    #[serde(default)]
    pub seed: u64,
}
