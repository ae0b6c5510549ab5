//! The `ecosystem` process: a whole ecosystem on a terrain at its steady state.
//!
//! Sources: L = "Authoring Consistent Landscapes with Flora and Fauna" (2021); T = thesis of
//! 2020, chapter 5 and appendix A. Fields left out take the default named in their description;
//! the manifest repeats every value that was used and where it comes from.

use crate::reference::Reference;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;
use std::collections::BTreeMap;

/// What the `ecosystem` process takes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EcosystemInputs {
    /// The terrain's heights.
    pub terrain: TerrainInput,
    /// The climate at a reference height.
    pub climate: ClimateInput,
    /// The plants that may grow, at most 200.
    #[serde(default)]
    #[schemars(length(max = 200))]
    pub plants: Vec<PlantInput>,
    /// The animals that may live there, at most 100.
    #[serde(default)]
    #[schemars(length(max = 100))]
    pub animals: Vec<AnimalInput>,
    /// Resource maps given instead of computed ones.
    #[serde(default)]
    pub maps: GivenMaps,
    /// How plants compete.
    #[serde(default)]
    pub competition: CompetitionInput,
    /// Places where animals may pass although the terrain says otherwise.
    #[serde(default)]
    pub passages: PassagesInput,
    /// How trails are drawn.
    #[serde(default)]
    pub trails: TrailsInput,
    /// How plannings are made.
    #[serde(default)]
    pub planning: PlanningInput,
    /// Biomes: a name and the plant species that belong to it. Default: the biome of each plant.
    #[serde(default)]
    pub biomes: BTreeMap<String, Vec<String>>,
    /// Seed of all random choices. Default: 0.
    #[serde(default)]
    pub seed: u64,
}

/// A height map and what its file does not say.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TerrainInput {
    /// GeoTIFF, 16-bit grey PNG, R16 or ESRI ASCII grid; recognised by content.
    pub source: Reference,
    /// Height of the lowest value, metres: needed for PNG and R16.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height_min_m: Option<f64>,
    /// Height of the highest value (65535, or 255), metres: needed for PNG and R16.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height_max_m: Option<f64>,
    /// Side of a cell, metres: needed where the file does not say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.001, max = 100000.0))]
    pub cell_m: Option<f64>,
    /// Columns of an R16 file. Default: the square root of its length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub columns: Option<u32>,
    /// Rows of an R16 file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rows: Option<u32>,
    /// Byte order of an R16 file. Default: little.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub byte_order: Option<ByteOrder>,
    /// Latitude in degrees north, for the sun. Default: what the file's coordinate system says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = -90.0, max = 90.0))]
    pub latitude_deg: Option<f64>,
}

/// Order of the bytes of a 16-bit sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ByteOrder {
    /// Least significant first.
    Little,
    /// Most significant first.
    Big,
}

/// The climate at a reference height.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ClimateInput {
    /// Twelve months, January first.
    #[schemars(length(min = 12, max = 12))]
    pub months: Vec<MonthInput>,
    /// Height for which the temperatures hold, metres. Default: 0.
    #[serde(default)]
    pub reference_height_m: f64,
    /// Fall of the temperature with height, °C per 100 m. Default: 0.65.
    #[serde(default = "default_lapse")]
    #[schemars(range(min = -5.0, max = 5.0))]
    pub lapse_c_per_100m: f64,
    /// Where the numbers come from, for the manifest.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub source: String,
    /// Whether the numbers are estimates. Default: false.
    #[serde(default)]
    pub estimated: bool,
}

fn default_lapse() -> f64 {
    0.65
}

/// The climate of a month.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MonthInput {
    /// Mean temperature, °C.
    #[schemars(range(min = -90.0, max = 60.0))]
    pub temperature_mean_c: f64,
    /// Half the monthly range: mean ± this are the usual minimum and maximum, °C.
    #[schemars(range(min = 0.0, max = 40.0))]
    pub temperature_half_range_c: f64,
    /// Precipitation, mm.
    #[schemars(range(min = 0.0, max = 20000.0))]
    pub precipitation_mm: f64,
    /// Share of the time between sunrise and sunset with sunshine, 0..=1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub sunshine_fraction: f64,
}

/// A range of the scale 1–9 and what is consumed of it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NeedInput {
    /// Lower end of the fitness range, scale 1–9.
    pub min: f64,
    /// Upper end of the fitness range, scale 1–9.
    pub max: f64,
    /// Yearly consumption of a unit, scale units. Default: 0.
    #[serde(default, rename = "use")]
    #[schemars(range(min = 0.0, max = 9.0))]
    pub consumption: f64,
}

/// A growth form.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FormInput {
    /// Trees.
    Tree,
    /// Shrubs.
    Shrub,
    /// Herbs.
    Herb,
}

/// Viability of a plant per soil type, 0 (cannot live) to 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ViabilityInput {
    /// On limestone.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub limestone: f64,
    /// In water.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub water: f64,
    /// On marl.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub marl: f64,
    /// On fallen rocks.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub fallen_rocks: f64,
    /// On alluvium.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub alluvium: f64,
}

/// A plant species: one of the library by its name, any of its numbers overridden, or a new one
/// with all of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlantInput {
    /// Name.
    #[schemars(length(min = 1, max = 100))]
    pub species: String,
    /// Growth form.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub form: Option<FormInput>,
    /// Biome it belongs to, in the user's words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub biome: Option<String>,
    /// Light.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub illumination: Option<NeedInput>,
    /// Temperature.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature: Option<NeedInput>,
    /// Soil moisture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moisture: Option<NeedInput>,
    /// Soil texture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub texture: Option<NeedInput>,
    /// Viability per soil type.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub viability: Option<ViabilityInput>,
    /// The coldest monthly minimum survived, °C. Default: no bound.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub survival_min_c: Option<f64>,
    /// Yearly growth, kg of dry matter per covered square metre. Default: by growth form.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 100.0))]
    pub growth_kg_per_m2: Option<f64>,
    /// Share of the growth that animals may take, 0..=1. Default: by growth form.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub offtake: Option<f64>,
    /// Share of the covered area wanted, in any unit; give it for all plants or for none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub proportion: Option<f64>,
    /// A painted map of its cover, 0..=1; not a number where nothing is painted. Less than grows
    /// there removes plants; more is placed as far as the resources bear, the rest is told in a
    /// warning.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub painted_cover: Option<Reference>,
    /// Where the numbers given here come from, by field name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub sources: BTreeMap<String, String>,
}

/// An alternative in a diet.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DietInput {
    /// `tree`, `shrub`, `herb` (all plants of that form), or the name of a species in the request.
    pub food: String,
    /// How much it is liked against the others. Default: 1.
    #[serde(default = "default_preference")]
    #[schemars(range(min = 0.0))]
    pub preference: f64,
}

fn default_preference() -> f64 {
    1.0
}

/// An animal species: one of the library by its name, any of its numbers overridden, or a new
/// one. What is left out is estimated by published allometry and flagged as such.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AnimalInput {
    /// Name.
    #[schemars(length(min = 1, max = 100))]
    pub species: String,
    /// What it eats.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub diet: Option<Vec<DietInput>>,
    /// Mean mass of an individual, kg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<f64>,
    /// Individuals in the smallest typical group: the unit that settles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 100000))]
    pub group_size_min: Option<u32>,
    /// Individuals in the largest typical group.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1, max = 100000))]
    pub group_size_max: Option<u32>,
    /// Share of the individuals of its level wanted, in any unit; for all of a level or for none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub proportion: Option<f64>,
    /// The most individuals per km² that it bears beside its own kind; one group always has room.
    /// Default: ten times the density of its living relative, where one is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0))]
    pub max_density_per_km2: Option<f64>,
    /// Food needed, kg a day (dry matter of plants, or mass of prey).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub food_kg_per_day: Option<f64>,
    /// Whether it must drink. Default: true.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub needs_water: Option<bool>,
    /// Births per individual and year.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 100.0))]
    pub growth_per_year: Option<f64>,
    /// Share of the births that predators may take, 0..=1. Default: 0.5.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub offtake: Option<f64>,
    /// Walking speed on flat ground, m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_m_per_s: Option<f64>,
    /// Steepest slope climbed, degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 89.0))]
    pub max_slope_up_deg: Option<f64>,
    /// Steepest slope descended, degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 89.0))]
    pub max_slope_down_deg: Option<f64>,
    /// Deepest water waded through, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 100.0))]
    pub ford_depth_m: Option<f64>,
    /// Tree cover above which it does not enter, 0..=1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub max_tree_cover: Option<f64>,
    /// Start of the active day, hours of the local solar day.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 24.0))]
    pub active_from_h: Option<f64>,
    /// Length of the active day, hours.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.5, max = 24.0))]
    pub active_h: Option<f64>,
    /// Where the numbers given here come from, by field name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub sources: BTreeMap<String, String>,
}

/// Resource maps given instead of computed ones, all of the terrain's size.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GivenMaps {
    /// Depth of lakes and rivers, metres; 0 where dry. A grey picture is a mask: white is water one
    /// metre deep.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub water_depth_m: Option<Reference>,
    /// Soil type: 0 limestone, 1 water, 2 marl, 3 fallen rocks, 4 alluvium.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub soil: Option<Reference>,
    /// Soil texture, scale 1–9.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub texture: Option<Reference>,
    /// Soil moisture, scale 1–9: one map for the year, or twelve.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 12))]
    pub moisture: Vec<Reference>,
    /// Sunlight, the fraction of the hours of the year's day with direct sun: one map, or twelve.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 12))]
    pub sunlight: Vec<Reference>,
    /// Monthly minimum temperature, °C, nowhere above the maximum: one map, or twelve.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 12))]
    pub temperature_min_c: Vec<Reference>,
    /// Monthly maximum temperature, °C: one map, or twelve.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 12))]
    pub temperature_max_c: Vec<Reference>,
    /// Where no plant may grow: 1 excluded, 0 free.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exclusion: Option<Reference>,
}

/// How fitness over the months becomes one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum MonthsRule {
    /// The mean over the months (T).
    #[default]
    Mean,
    /// The worst month (L 4.2).
    Minimum,
}

/// How physical quantities become the scale 1–9.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ScalesPreset {
    /// The conversion the authors of L used.
    #[default]
    Authors,
    /// The physical anchors of the Julve tables.
    Julve,
}

/// A need that an ablation can leave out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum NeedName {
    /// Light.
    Illumination,
    /// Temperature.
    Temperature,
    /// Soil moisture.
    Moisture,
    /// Soil texture and type.
    Soil,
}

/// How plants and animals compete.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CompetitionInput {
    /// Fitness over the months. Default: mean.
    pub months: MonthsRule,
    /// Conversion to the scale 1–9. Default: authors.
    pub scales: ScalesPreset,
    /// Needs to leave out, as in the ablations of L figure 8. Default: none.
    pub ignore: Vec<NeedName>,
    /// With proportions: the distance from them at which placing stops, 0..=1. Default: 0.02.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub proportion_tolerance: f64,
    /// With proportions: go on placing until nothing fits. Default: false.
    pub fill: bool,
}

impl Default for CompetitionInput {
    fn default() -> Self {
        Self {
            months: MonthsRule::Mean,
            scales: ScalesPreset::Authors,
            ignore: Vec::new(),
            proportion_tolerance: 0.02,
            fill: false,
        }
    }
}

/// A round place on the terrain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaceInput {
    /// East, metres: from the terrain's south-west corner, or in its coordinate system.
    pub x: f64,
    /// North, metres: from the terrain's south-west corner, or in its coordinate system.
    pub y: f64,
    /// Radius, metres. Default: one cell and a half.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius_m: Option<f64>,
}

/// A way-point: a place that animals pass or walk to, such as a way out of the valley (L 7.2, T
/// figure 5.15). It is a node of the Resource Access Graph that feeds nobody; slopes and vegetation
/// are no obstacle there for any animal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WaypointInput {
    /// East, metres: from the terrain's south-west corner, or in its coordinate system.
    pub x: f64,
    /// North, metres: from the terrain's south-west corner, or in its coordinate system.
    pub y: f64,
    /// Radius, metres. Default: one cell and a half.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius_m: Option<f64>,
    /// The share of their moves that animals make to it, 0..=1; those of all way-points of a
    /// region together draw at most a half. 0 draws nobody and only opens the place. Default: 0.1.
    #[serde(default = "default_share")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub share: f64,
    /// The animals of the request that it draws. Default: all.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 100))]
    pub species: Vec<String>,
    /// What it is called in the outputs. Default: `way-point` and its number, from 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(length(min = 1, max = 100))]
    pub name: Option<String>,
}

fn default_share() -> f64 {
    0.1
}

/// Places where animals may pass although the terrain says otherwise, and places they walk to.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PassagesInput {
    /// Fords: water is crossed there whatever its depth.
    #[schemars(length(max = 10000))]
    pub fords: Vec<PlaceInput>,
    /// Way-points, at most 100 of them with a share above 0.
    #[schemars(length(max = 10000))]
    pub waypoints: Vec<WaypointInput>,
    /// Confinement regions smaller than this are left empty, and what grows on less of a region
    /// than this is left alone, m²: less for a close-up. Default: 10 000 (the authors').
    pub min_region_m2: Option<f64>,
}

/// How trails are drawn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TrailsInput {
    /// The deepest a trail is carved into the terrain, metres. Default: 0.4.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub depth_limit_m: f64,
    /// Width of the busiest trails, metres. Default: 3.
    #[schemars(range(min = 0.4, max = 100.0))]
    pub width_m: f64,
}

impl Default for TrailsInput {
    fn default() -> Self {
        Self { depth_limit_m: 0.4, width_m: 3.0 }
    }
}

/// What to change in a herd's planning.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum PlanningChange {
    /// The herd visits `node` for `stay_s` before its visit `order`.
    Add,
    /// The visit `order` is left out.
    Drop,
    /// The visit `order` is from `arrive_s` to `leave_s`.
    Pin,
}

/// An edit of a herd's planning (L 6.2). Visits are counted as in the planning before any edit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlanningEdit {
    /// Number of the herd, as in the output `herds`.
    pub herd: u32,
    /// What to change.
    pub change: PlanningChange,
    /// Number of the visit, as in the output `plannings`.
    pub order: u32,
    /// For `add`: number of the node, as in the output `rag`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node: Option<u32>,
    /// For `add`: how long, seconds. Default: 3600.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1.0, max = 86400.0))]
    pub stay_s: Option<f64>,
    /// For `pin`: arrival, seconds of the local solar day on which the active day begins.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 172800.0))]
    pub arrive_s: Option<f64>,
    /// For `pin`: departure, seconds, after the arrival.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 172800.0))]
    pub leave_s: Option<f64>,
}

/// How plannings are made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PlanningInput {
    /// Step of the path in time, seconds. Default: 300.
    #[schemars(range(min = 1.0, max = 86400.0))]
    pub path_step_s: f64,
    /// Node capacity: the ground an individual takes at a node, m². Default: 25.
    #[schemars(range(min = 0.01, max = 1000000.0))]
    pub m2_each: f64,
    /// Edits, in order.
    #[schemars(length(max = 10000))]
    pub edits: Vec<PlanningEdit>,
}

impl Default for PlanningInput {
    fn default() -> Self {
        Self { path_step_s: 300.0, m2_each: 25.0, edits: Vec::new() }
    }
}
