//! `herd-extraction`, `key-herd` and `herd-animation`: from a photo to animals that walk.
//!
//! Sources: T = thesis of 2020, chapter 4; H = "Image-based authoring of herd animations" (2019).
//! An animal is an ellipse. In a photo its unit is a pixel of the upright picture, x to the right
//! and y **up** from the lower left corner; on the ground it is a metre, x east and y north.
//! Angles are in radians, counter-clockwise from the right or from east.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::ecosystem::TerrainInput;
use crate::points::PaintedInput;
use crate::points::PolygonInput;
use crate::reference::Given;
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

/// A round obstacle: a tree, a rock.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DiskInput {
    /// East, metres.
    pub x: f64,
    /// North, metres.
    pub y: f64,
    /// Radius, metres.
    #[schemars(range(min = 0.0, max = 100000.0))]
    pub radius: f64,
}

/// What animals may not enter.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ObstaclesInput {
    /// Trees and rocks.
    #[schemars(length(max = 100_000))]
    pub disks: Vec<DiskInput>,
    /// Closed areas.
    #[schemars(length(max = 10_000))]
    pub areas: Vec<PolygonInput>,
    /// A map, such as another job's water: cells above `mask_above` are closed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mask: Option<PaintedInput>,
    /// Values of the mask above this are closed. Default: 0.
    pub mask_above: f64,
}

/// A herd of an `ecosystem` result. Its size gives the number of animals, its path over the day
/// the trajectory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EcosystemHerdInput {
    /// The output `herds` of an ecosystem.
    pub herds: Reference,
    /// The output `paths` of the same ecosystem.
    pub paths: Reference,
    /// Number of the herd in both.
    pub herd: u64,
    /// From when on, seconds of the local solar day. Default: the begin of its path.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from_s: Option<f64>,
    /// Until when. Default: the end of its path.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to_s: Option<f64>,
}

/// Where a key-herd stands and where it looks: give one of `position`, `trajectory` and
/// `ecosystem_herd`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SiteInput {
    /// The herd's middle [x, y], metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 2]>,
    /// With a position: the direction of the trajectory there, radians counter-clockwise from
    /// east. Default: 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<f64>,
    /// Places [x, y] the herd walks through, metres; a spline is laid through them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 2, max = 10_000))]
    pub trajectory: Option<Vec<[f64; 2]>>,
    /// The trajectory of a herd of an `ecosystem` result between `from_s` and `to_s`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ecosystem_herd: Option<EcosystemHerdInput>,
    /// Where on the trajectory the herd stands: 0 at its begin, 1 at its end. Default: 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub along: Option<f64>,
}

/// The size of an animal on the ground; all of a herd have the same.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BodyInput {
    /// Length, metres, at least the width.
    #[schemars(range(min = 0.01, max = 200.0))]
    pub length_m: f64,
    /// Width, metres.
    #[schemars(range(min = 0.01, max = 200.0))]
    pub width_m: f64,
}

impl Default for BodyInput {
    fn default() -> Self {
        Self { length_m: 2.4, width_m: 1.0 }
    }
}

/// Whether the headings of an exemplar can be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum HeadingsInput {
    /// Each animal looks where its ellipse says.
    #[default]
    Trusted,
    /// Only the axes are known: all look towards the exemplar's own direction.
    Axes,
}

/// What becomes of an exemplar's suspect animals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SuspectsInput {
    /// They count as the others do.
    #[default]
    Keep,
    /// They are left out.
    LeaveOut,
}

/// Where the density map comes from.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "lowercase", deny_unknown_fields)]
pub enum DensityInput {
    /// The exemplar's, laid on the ground and scaled until it holds all animals.
    #[default]
    Exemplar,
    /// None: even over the exemplar's domain.
    Even,
    /// Painted on the ground, such as the output `density` of an earlier run, edited: values from
    /// 0, of which only the proportions count; nowhere else is there an animal.
    Painted {
        /// The map.
        map: PaintedInput,
    },
}

/// A change of the orientation field (T 4.2.5).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "lowercase", deny_unknown_fields)]
pub enum OrientationEditInput {
    /// Merges with a direction.
    Blend {
        /// Radians counter-clockwise from east.
        direction: f64,
        /// 0 keeps the field, 1 replaces it.
        #[schemars(range(min = 0.0, max = 1.0))]
        weight: f64,
    },
    /// Turns every orientation.
    Rotate {
        /// Radians counter-clockwise.
        angle: f64,
    },
    /// Evens the field out.
    Smooth {
        /// Radius, metres.
        #[schemars(range(min = 0.0, max = 1000000.0))]
        radius_m: f64,
    },
    /// Adds smooth noise.
    Noise {
        /// Standard deviation, radians.
        #[schemars(range(min = 0.0, max = 7.0))]
        deviation: f64,
        /// Size of its features, metres.
        #[schemars(range(max = 1000000.0), extend("exclusiveMinimum" = 0))]
        size_m: f64,
    },
}

/// Inputs of `key-herd`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KeyHerdInputs {
    /// The herd to look like: the output `ellipses` of an extraction, or a list of animals in any
    /// unit, y up.
    #[schemars(title = "Exemplar")]
    pub exemplar: Given<Vec<EllipseInput>>,
    /// What becomes of its suspect animals. Default: keep.
    #[schemars(title = "Suspect animals")]
    #[serde(default)]
    pub suspects: SuspectsInput,
    /// Whether its headings can be trusted. Default: trusted.
    #[schemars(title = "Headings")]
    #[serde(default)]
    pub headings: HeadingsInput,
    /// Number of animals. Default: the size of the `ecosystem_herd`.
    #[schemars(title = "Number", range(min = 1, max = 100_000))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<u32>,
    /// Where the herd stands and looks.
    #[schemars(title = "Place")]
    pub place: SiteInput,
    /// Size of an animal. Default: 2.4 m by 1 m.
    #[schemars(title = "Body")]
    #[serde(default)]
    pub body: BodyInput,
    /// The ground: off it no animal stands. Default: a plane without end.
    #[schemars(title = "Terrain")]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub terrain: Option<TerrainInput>,
    /// What animals may not stand in.
    #[schemars(title = "Obstacles")]
    #[serde(default)]
    pub obstacles: ObstaclesInput,
    /// Where the density map comes from. Default: the exemplar.
    #[schemars(title = "Density")]
    #[serde(default)]
    pub density: DensityInput,
    /// An orientation field painted on the ground, such as the output `orientation` of an earlier
    /// run, edited: radians, laid over the exemplar's where it has values. The levels of a grey
    /// picture stand for a full turn.
    #[schemars(title = "Orientation")]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<PaintedInput>,
    /// Changes of the orientation field, in this order.
    #[schemars(title = "Edits of the orientation", length(max = 100))]
    #[serde(default)]
    pub orientation_edits: Vec<OrientationEditInput>,
    /// Darts after which the best so far is taken. Default: 48.
    #[schemars(title = "Darts", range(min = 1, max = 100_000))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_fails: Option<u32>,
    /// Seed of the darts and of noise. Default: 0.
    #[schemars(title = "Seed")]
    #[serde(default)]
    pub seed: u64,
}

/// Where the herd is to be at a time: give a position or a herd.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KeyFrameInput {
    /// Seconds; rising from key-frame to key-frame.
    pub time_s: f64,
    /// The place [x, y] of the herd's middle, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 2]>,
    /// A key-herd: the output `ellipses` of `key-herd`, or a list of animals in metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub herd: Option<Given<Vec<EllipseInput>>>,
}

/// How fast animals move and turn. What is left out takes its default.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GaitInput {
    /// Top speed V_max, m/s. Default: 3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.01, max = 100.0))]
    pub max_speed_m_per_s: Option<f64>,
    /// Fastest turn, rad/s. Default: 1.5.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.01, max = 100.0))]
    pub max_turn_rad_per_s: Option<f64>,
    /// Fastest change of speed, m/s². Default: 3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.01, max = 1000.0))]
    pub max_acceleration_m_per_s2: Option<f64>,
    /// Largest angle between heading and motion, radians. Default: 0.35.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.5))]
    pub max_slip_rad: Option<f64>,
    /// How near its place in a key-herd an animal begins to turn as it stands there, in body
    /// lengths. Default: 4.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub blend_body_lengths: Option<f64>,
}

/// How animals of successive key-herds are paired: so that the sum of costs is least.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "metric", rename_all = "lowercase", deny_unknown_fields)]
pub enum PairingInput {
    /// The distance.
    Euclidean,
    /// A power of the distance: long ways are avoided the more, the higher it is.
    Power {
        /// From 1 to 8.
        #[schemars(range(min = 1, max = 8))]
        exponent: u32,
    },
    /// The distance with one axis stretched: `along` the herd's way or `across` it.
    Axis {
        /// Which.
        axis: AxisInput,
        /// How many times, from 1 to 1000.
        #[schemars(range(min = 1.0, max = 1000.0))]
        penalty: f64,
    },
}

impl Default for PairingInput {
    fn default() -> Self {
        Self::Power { exponent: 2 }
    }
}

/// An axis of the herd frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum AxisInput {
    /// In the direction of the herd's way.
    Along,
    /// At a right angle to it.
    Across,
}

/// Weights of the five steering forces. What is left out takes its default.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SteeringInput {
    /// Away from neighbours that are too near. Default: 0.6.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub separation: Option<f64>,
    /// To the neighbours' velocity. Default: 0.3.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub alignment: Option<f64>,
    /// To the neighbours' middle. Default: 0.1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub cohesion: Option<f64>,
    /// Away from obstacles ahead. Default: 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub avoidance: Option<f64>,
    /// Time in which an animal tries to reach its guide, seconds. Default: 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.05, max = 60.0))]
    pub following_s: Option<f64>,
    /// How far ahead obstacles are seen, seconds. Default: 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 60.0))]
    pub foresight_s: Option<f64>,
    /// Who is a neighbour, in body lengths. Default: 2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.5, max = 10.0))]
    pub neighbourhood_body_lengths: Option<f64>,
}

/// Position-only key-frames along the path of a herd of an `ecosystem` result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AlongPathInput {
    /// The herd and the part of its day.
    pub ecosystem_herd: EcosystemHerdInput,
    /// Time between two of them, seconds; times count from `from_s`. Default: 300.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1.0, max = 86400.0))]
    pub every_s: Option<f64>,
}

/// Inputs of `herd-animation`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HerdAnimationInputs {
    /// The ground.
    #[schemars(title = "Terrain")]
    pub terrain: TerrainInput,
    /// What animals may not enter.
    #[schemars(title = "Obstacles")]
    #[serde(default)]
    pub obstacles: ObstaclesInput,
    /// Where the herd is to be when; at least one with a herd, two in all.
    #[schemars(title = "Key-frames", length(min = 1, max = 1000))]
    pub key_frames: Vec<KeyFrameInput>,
    /// More position-only key-frames, between those given: the path of a herd of an `ecosystem`.
    #[schemars(title = "Along a path")]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub along: Option<AlongPathInput>,
    /// How fast animals move and turn.
    #[schemars(title = "Gait")]
    #[serde(default)]
    pub gait: GaitInput,
    /// How animals of successive key-herds are paired. Default: by the square of the distance.
    #[schemars(title = "Pairing")]
    #[serde(default)]
    pub pairing: PairingInput,
    /// The steering forces.
    #[schemars(title = "Steering")]
    #[serde(default)]
    pub steering: SteeringInput,
    /// Longest step of the simulation, seconds. Default: 0.1.
    #[schemars(title = "Step", range(min = 0.001, max = 5.0))]
    #[serde(default = "default_step")]
    pub step_s: f64,
    /// Time between two poses of a track, seconds; the nearest multiple of the step. Default: 0.5.
    #[schemars(title = "Time between poses", range(min = 0.001, max = 86400.0))]
    #[serde(default = "default_every")]
    pub every_s: f64,
    /// Seed; an animation draws no random numbers. Default: 0.
    #[schemars(title = "Seed")]
    #[serde(default)]
    pub seed: u64,
}

fn default_step() -> f64 {
    0.1
}

fn default_every() -> f64 {
    0.5
}
