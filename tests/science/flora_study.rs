//! What the ablation studies and the comparison of climates measure (L 7.2, figures 8 and 13).

use biotope::compute::ecosystem::biomes::DENSEST_SHARE;
use biotope::compute::ecosystem::biomes::densest;
use biotope::compute::ecosystem::climate::Climate;
use biotope::compute::ecosystem::fitness::Fitness;
use biotope::compute::ecosystem::fitness::FitnessOptions;
use biotope::compute::ecosystem::fitness::Needs;
use biotope::compute::ecosystem::fitness::fitness;
use biotope::compute::ecosystem::flora;
use biotope::compute::ecosystem::flora::Flora;
use biotope::compute::ecosystem::flora::FloraOptions;
use biotope::compute::ecosystem::resources::GivenMaps;
use biotope::compute::ecosystem::resources::MONTHS;
use biotope::compute::ecosystem::resources::ResourceRules;
use biotope::compute::ecosystem::resources::Resources;
use biotope::compute::ecosystem::species::PlantSpecies;
use biotope::compute::ecosystem::species::Stratum;
use biotope::compute::ecosystem::terrain::Terrain;
use biotope::compute::ecosystem::water::Water;
use biotope::compute::ecosystem::water::WaterRules;
use biotope::compute::raster::Raster;
use biotope::compute::run::Run;

/// A terrain with its water, and what a climate makes of them.
pub struct Land {
    pub terrain: Terrain,
    pub water: Water,
    pub resources: Resources,
}

impl Land {
    /// The land of a height map in a climate, everything by default rules.
    pub fn new(height: Raster<f32>, climate: &Climate) -> Self {
        let run = Run::silent();
        let terrain = Terrain::new(height, &run).unwrap();
        let water = Water::derived(&terrain.height, &WaterRules::default(), &run).unwrap();
        let own = (GivenMaps::default(), &ResourceRules::default());
        let resources = Resources::assemble((&terrain, &water), climate, own, &run).unwrap();
        Self { terrain, water, resources }
    }

    /// The plants that grow there when these needs count.
    pub fn flora(&self, species: &[PlantSpecies], needs: Needs) -> (Flora, Fitness) {
        let run = Run::silent();
        let fit = fitness(&run, species, &self.resources, &FitnessOptions { needs, ..Default::default() }).unwrap();
        let options = FloraOptions { needs, ..FloraOptions::default() };
        (flora::compete(&run, species, &self.resources, &fit, &options).unwrap(), fit)
    }

    /// Mean moisture of the year, on the scale.
    pub fn mean_moisture(&self, cell: usize) -> f64 {
        let months = (0..MONTHS).map(|m| f64::from(self.resources.moisture.value(m, cell)));
        months.sum::<f64>() / MONTHS as f64
    }

    /// Highest less lowest height, m.
    pub fn relief_m(&self) -> f64 {
        let heights = self.terrain.height.data.iter().filter(|h| !h.is_nan());
        let (low, high) = heights.fold((f32::MAX, f32::MIN), |(l, h), z| (l.min(*z), h.max(*z)));
        f64::from(high - low)
    }
}

/// What the densest twentieth of a land's cells is like.
#[derive(Debug, Clone, Copy)]
pub struct Densest {
    /// Mean cosine of the aspect from south.
    pub southness: f64,
    /// Mean moisture on the scale.
    pub moisture: f64,
    /// Mean height, m.
    pub height_m: f64,
}

/// Measures the 5 % of cells with the highest total plant density; cells that tie at the
/// threshold share its weight.
pub fn densest_cells(land: &Land, flora: &Flora) -> Densest {
    let weights = densest(&flora.total_map(|_| true), DENSEST_SHARE);
    let mean = |value: &dyn Fn(usize) -> f64| weighted_mean(&weights, value);
    Densest {
        southness: mean(&|cell| f64::from(land.terrain.southness(cell))),
        moisture: mean(&|cell| land.mean_moisture(cell)),
        height_m: mean(&|cell| f64::from(land.terrain.height.data[cell])),
    }
}

fn weighted_mean(weights: &Raster<f32>, value: &dyn Fn(usize) -> f64) -> f64 {
    let cells = weights.data.iter().enumerate().filter(|(_, w)| **w > 0.0);
    let (sum, weight) =
        cells.fold((0.0, 0.0), |(s, n), (cell, w)| (s + f64::from(*w) * value(cell), n + f64::from(*w)));
    sum / weight
}

/// How much trees cover.
#[derive(Debug, Clone, Copy)]
pub struct TreeCover {
    /// Mean over the land.
    pub mean: f64,
    /// Mean over slopes steeper than 15° that face more south than east or west.
    pub south: f64,
    /// Mean over slopes steeper than 15° that face more north than east or west.
    pub north: f64,
}

/// Measures the cover of trees over the land and on its steep south and north slopes.
pub fn tree_cover(land: &Land, species: &[PlantSpecies], flora: &Flora) -> TreeCover {
    let trees = flora.stratum_map(species, Stratum::Tree);
    let steep = f64::to_radians(15.0).tan() as f32;
    let facing = |cell: usize| land.terrain.southness(cell);
    let mean = |chosen: &dyn Fn(usize) -> bool| {
        let cells = (0..trees.data.len()).filter(|c| !land.terrain.height.data[*c].is_nan() && chosen(*c));
        let (sum, n) = cells.fold((0.0, 0.0), |(s, n), c| (s + f64::from(trees.data[c]), n + 1.0));
        sum / n
    };
    let half = std::f32::consts::FRAC_1_SQRT_2;
    TreeCover {
        mean: mean(&|_| true),
        south: mean(&|c| land.terrain.slope.data[c] > steep && facing(c) > half),
        north: mean(&|c| land.terrain.slope.data[c] > steep && facing(c) < -half),
    }
}
