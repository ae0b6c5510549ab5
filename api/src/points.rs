//! `distribution-analysis`, `disk-synthesis`, `distribution-inpainting` and
//! `distribution-decomposition`: arrangements of points and disks.
//!
//! A pattern is a list of elements in classes with the domain it was observed in. Its correlation
//! curves say how many partners an element has at each distance, over the number in a uniform
//! pattern. Lengths are in metres; curves run over distances in r_max, the spacing of as many
//! elements spread as far as can be.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::reference::Given;
use crate::reference::Reference;

/// A point or disk.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ElementInput {
    /// A number of the client's; not looked at.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub id: Option<i64>,
    /// Name of its class. Default: "a".
    #[serde(default = "default_class")]
    #[schemars(length(min = 1, max = 64))]
    pub class: String,
    /// East, in metres.
    pub x: f64,
    /// North, in metres.
    pub y: f64,
    /// Radius in metres, at least 0. Default: 0, a point.
    #[serde(default)]
    pub radius: f64,
}

/// The class of an element that names none.
pub fn default_class() -> String {
    "a".to_owned()
}

/// A polygon with holes; rings need not repeat their first place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PolygonInput {
    /// The outer ring: places as [x, y] in metres.
    #[schemars(length(min = 3, max = 200_000))]
    pub outer: Vec<[f64; 2]>,
    /// Rings cut out of it.
    #[serde(default)]
    pub holes: Vec<Vec<[f64; 2]>>,
}

/// A raster and where its cells lie.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PaintedInput {
    /// The raster: GeoTIFF, grey PNG, ASCII grid, or another job's map. First row north.
    pub raster: Reference,
    /// South-west corner [x, y] in metres. Default: what the file says; else, for a raster over
    /// a target, the corner of the rectangle around the target; else [0, 0].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub origin: Option<[f64; 2]>,
    /// Side of a cell in metres. Default: what the file says; else, for a raster over a target,
    /// the target's width over the columns.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub cell_m: Option<f64>,
}

/// A part of the plane.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "kebab-case", deny_unknown_fields)]
pub enum DomainInput {
    /// A rectangle.
    Rectangle {
        /// South-west corner [x, y] in metres.
        min: [f64; 2],
        /// North-east corner.
        max: [f64; 2],
    },
    /// One or several polygons with holes; where they overlap they are joined.
    Polygons {
        /// The polygons.
        #[schemars(length(min = 1, max = 10_000))]
        polygons: Vec<PolygonInput>,
    },
    /// The cells of a raster above one half of its range.
    Mask {
        /// The raster.
        mask: PaintedInput,
    },
    /// Learnt from the elements: Delaunay triangles up to a size, with a margin.
    FreeForm {
        /// Triangles up to this circumradius, in r_max, belong to the domain. Default: a size learnt
        /// from the triangles themselves, about 2 for elements that do not care for each other, less
        /// for those that keep apart, more for groups.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(range(max = 100.0), extend("exclusiveMinimum" = 0))]
        max_circumradius: Option<f64>,
        /// Instead: triangles whose edges are at most this many times the shortest at either end
        /// (the rule of the text, which uses 3).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(range(min = 1.0))]
        edge_ratio: Option<f64>,
        /// The border is moved outwards by this many √(area/n). Default: as far as the elements lie
        /// inside lines along which they are cut, about 0.45.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[schemars(range(min = 0.0, max = 10.0))]
        margin: Option<f64>,
    },
}

/// Which distance curves run over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum MetricInput {
    /// Distance of centres.
    Point,
    /// The saliency-based distance of disks: 1 at inner tangency, 2 with the smaller's centre on
    /// the larger's rim, 3 at outer tangency, then 3 + 2·gap.
    Disk,
}

/// Which classes a class looks at.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DependencyInput {
    /// The class.
    pub class: String,
    /// The classes it depends on.
    pub depends_on: Vec<String>,
}

/// A pattern to learn from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExemplarInput {
    /// Its elements, at least two: a list, or a reference to a JSON list or CSV table of them.
    pub elements: Given<Vec<ElementInput>>,
    /// Where it was observed. Default: free-form, learnt from the elements.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub domain: Option<DomainInput>,
    /// The distance of the curves. Default: disk if any element has a radius, else point.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub metric: Option<MetricInput>,
    /// Which class depends on which, without circles. Default: every class on all earlier ones
    /// in the order of decreasing mean radius.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dependencies: Option<Vec<DependencyInput>>,
    /// Smoothness σ of the kernel exp(−x²/σ²)/(√π·σ), in r_max, positive. Default: 0.25.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub sigma: Option<f64>,
    /// Distance between two values of a curve, in r_max, positive and at most the extent.
    /// Default: 0.1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub step: Option<f64>,
    /// Where curves end, in the unit of their axis. Default: 5 for points, 7 for disks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(max = 200.0), extend("exclusiveMinimum" = 0))]
    pub extent: Option<f64>,
}

/// Inputs of `distribution-analysis`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AnalysisInputs {
    /// The pattern.
    #[schemars(title = "Pattern")]
    pub exemplar: ExemplarInput,
    /// Whether the curve of every single element is returned too. Default: false.
    #[schemars(title = "Individual curves")]
    #[serde(default)]
    pub individual: bool,
    /// Seed; an analysis draws no random numbers. Default: 0.
    #[schemars(title = "Seed")]
    #[serde(default)]
    pub seed: u64,
}

/// Where and how much to lay out.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TargetInput {
    /// The domain to fill. Default: the exemplar's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub domain: Option<DomainInput>,
    /// Parts that are cut out of it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub exclude: Vec<DomainInput>,
    /// A painted density, relative: only ratios count, 0 bars a place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub density: Option<PaintedInput>,
    /// Elements that are there, stay, and influence the new ones; of classes of the exemplar and
    /// in the domain, parts cut out of it included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fixed: Option<Given<Vec<ElementInput>>>,
    /// Elements in the result by class, fixed ones included. Default: the exemplar's density.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub counts: Option<BTreeMap<String, u64>>,
    /// Where no count is given: how many times the exemplar's density. Default: 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub density_factor: Option<f64>,
}

/// How new elements are laid out.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SynthesisInput {
    /// Successive rejections after which the grid search takes over. Default: 1000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 100_000))]
    pub max_fails: Option<u32>,
    /// The error accepted at the first dart. Default: 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub tolerance: Option<f64>,
    /// What every rejection adds to it. Default: 0.5.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub tolerance_step: Option<f64>,
    /// The most iterations of a descent; 0 leaves the refinement out. Default: 12.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(max = 10_000))]
    pub max_iterations: Option<u32>,
    /// Rounds in which every element may be laid out again where it fits best. Default: 4.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(max = 200))]
    pub outlier_rounds: Option<u32>,
    /// Elements of a class that are laid out as one block. Default: 1500.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 50, max = 20_000))]
    pub block_elements: Option<u32>,
}

/// Inputs of `disk-synthesis`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DiskSynthesisInputs {
    /// The pattern to learn from.
    #[schemars(title = "Exemplar")]
    pub exemplar: ExemplarInput,
    /// Where and how much to lay out.
    #[schemars(title = "Target")]
    #[serde(default)]
    pub target: TargetInput,
    /// How.
    #[schemars(title = "Options")]
    #[serde(default)]
    pub options: SynthesisInput,
    /// Seed of the random numbers. Default: 0.
    #[schemars(title = "Seed")]
    #[serde(default)]
    pub seed: u64,
}

/// Inputs of `distribution-inpainting`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InpaintingInputs {
    /// The pattern with holes; its domain is where the pattern is known (default: free-form),
    /// its elements stay.
    #[schemars(title = "Pattern with holes")]
    pub exemplar: ExemplarInput,
    /// The whole domain: its part outside the known one is filled. Default: the rectangle around
    /// the known domain.
    #[schemars(title = "Whole domain")]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub domain: Option<DomainInput>,
    /// How.
    #[schemars(title = "Options")]
    #[serde(default)]
    pub options: SynthesisInput,
    /// Seed of the random numbers. Default: 0.
    #[schemars(title = "Seed")]
    #[serde(default)]
    pub seed: u64,
}

/// Inputs of `distribution-decomposition`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DecompositionInputs {
    /// The pattern; its classes and dependencies are not looked at.
    #[schemars(title = "Pattern")]
    pub exemplar: ExemplarInput,
    /// Number of clusters, at most the number of elements.
    #[schemars(title = "Clusters", range(min = 1, max = 1000))]
    pub clusters: u32,
    /// Seed of the random numbers. Default: 0.
    #[schemars(title = "Seed")]
    #[serde(default)]
    pub seed: u64,
}

/// A class in the document `analysis`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ClassOutput {
    /// Its name.
    pub class: String,
    /// Number of its elements.
    pub count: usize,
    /// Mean of their radii in metres.
    pub mean_radius_m: f64,
    /// r_max: the unit of its curves, in metres.
    pub r_max_m: f64,
    /// The classes it depends on.
    pub depends_on: Vec<String>,
}

/// A curve in the document `analysis`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CurveOutput {
    /// The class whose elements look around.
    pub class: String,
    /// The class they look at.
    pub looks_at: String,
    /// Metres in one unit of the axis.
    pub r_max_m: f64,
    /// Where the curve is evaluated.
    pub r: Vec<f64>,
    /// Mean of the elements' own curves.
    pub mean: Vec<f64>,
    /// Their pointwise least value.
    pub lower: Vec<f64>,
    /// Their pointwise greatest value.
    pub upper: Vec<f64>,
    /// The elements' own curves, in the order of the elements of the class, if asked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub individual: Vec<Vec<f64>>,
}

/// The document `analysis`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AnalysisOutput {
    /// The distance of the curves.
    pub metric: MetricInput,
    /// Smoothness σ of the kernel.
    pub sigma: f64,
    /// Area of the domain in m².
    pub area_m2: f64,
    /// The classes.
    pub classes: Vec<ClassOutput>,
    /// The curves.
    pub curves: Vec<CurveOutput>,
    /// The domain, learnt or given.
    pub border: Vec<PolygonInput>,
}

/// A curve in the document `report`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CurveReportOutput {
    /// The class laid out.
    pub class: String,
    /// The class it looks at.
    pub looks_at: String,
    /// Root mean square difference to the exemplar's curve after the initialisation.
    pub error_before: f64,
    /// The same at the end.
    pub error_after: f64,
}

/// A class in the document `report`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ClassReportOutput {
    /// The class.
    pub class: String,
    /// Elements asked for, fixed ones included.
    pub asked: usize,
    /// Elements that were there.
    pub fixed: usize,
    /// Elements laid out.
    pub placed: usize,
    /// Elements that found no place.
    pub missing: usize,
    /// Darts thrown.
    pub darts: usize,
    /// Elements placed by the grid search.
    pub by_grid_search: usize,
    /// Iterations of the refinement, the most of any block.
    pub iterations: usize,
    /// Elements laid out again as outliers.
    pub replaced: usize,
    /// Elements whose own curve lies outside the exemplar's validity region in the end.
    pub outside_validity: usize,
}

/// The document `report` of a synthesis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SynthesisReport {
    /// Area of the target domain in m².
    pub area_m2: f64,
    /// The classes in the order they were laid out.
    pub classes: Vec<ClassReportOutput>,
    /// The curves of the elements laid out.
    pub curves: Vec<CurveReportOutput>,
    /// What a reader should know.
    pub warnings: Vec<crate::warning::Warning>,
}
