//! What the ablation studies and the comparison of climates measure (L 7.2, figures 8 and 13);
//! `flora_lines` holds what comes out on the example terrains.

use crate::science::tautavel;
use biotope::compute::ecosystem::biomes::DENSEST_SHARE;
use biotope::compute::ecosystem::biomes::NO_BIOME;
use biotope::compute::ecosystem::biomes::agreement;
use biotope::compute::ecosystem::biomes::densest;
use biotope::compute::ecosystem::biomes::density;
use biotope::compute::ecosystem::biomes::dominant;
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
use biotope::compute::geometry::Point;
use biotope::compute::random::Purpose;
use biotope::compute::random::hash2;
use biotope::compute::random::unit;
use biotope::compute::raster::Grid;
use biotope::compute::raster::Raster;
use biotope::compute::run::Run;

/// A terrain with its water, and what a climate makes of them.
pub struct Land {
    pub terrain: Terrain,
    pub resources: Resources,
}

impl Land {
    /// The land of a height map in a climate, everything by default rules.
    pub fn new(height: Raster<f32>, climate: &Climate) -> Self {
        Self::with_water(height, climate, |height, run| Water::derived(height, &WaterRules::default(), run).unwrap())
    }

    /// The land of a height map with this depth of water in a climate, all else by default rules.
    pub fn of_water(height: Raster<f32>, depth_m: &Raster<f32>, climate: &Climate) -> Self {
        Self::with_water(height, climate, |height, run| Water::given(height, depth_m, run).unwrap())
    }

    fn with_water(height: Raster<f32>, climate: &Climate, water: impl Fn(&Raster<f32>, &Run) -> Water) -> Self {
        let run = Run::silent();
        let terrain = Terrain::new(height, &run).unwrap();
        let water = water(&terrain.height, &run);
        let own = (GivenMaps::default(), &ResourceRules::default());
        let resources = Resources::assemble((&terrain, &water), climate, own, &run).unwrap();
        Self { terrain, resources }
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

/// Mountains of no particular place, 240 to 1080 m high: six octaves of noise with rounded ridges,
/// `size` cells of `cell_m` a side.
pub fn mountains(size: usize, cell_m: f64) -> Raster<f32> {
    let grid = Grid::new(size, size, cell_m);
    let octave = |p: Point, k: u32| {
        let wave = 8000.0 / f64::from(1 << k);
        let (x, y) = (p.x / wave, p.y / wave);
        let (column, row) = (x.floor(), y.floor());
        let corner = |dx: f64, dy: f64| {
            let (c, r) = ((column + dx) as u64, (row + dy) as u64);
            unit(hash2(1, Purpose::new("science.mountains"), c << 8 | u64::from(k), r))
        };
        let ease = |t: f64| t * t * (3.0 - 2.0 * t);
        let (u, v) = (ease(x - column), ease(y - row));
        let north = corner(0.0, 0.0) * (1.0 - u) + corner(1.0, 0.0) * u;
        let south = corner(0.0, 1.0) * (1.0 - u) + corner(1.0, 1.0) * u;
        (north * (1.0 - v) + south * v - 0.5) * f64::from(1 << k).powf(-0.9)
    };
    let rough: Vec<f64> = (0..grid.len()).map(|i| (0..6).map(|k| octave(grid.centre(i), k)).sum()).collect();
    let (low, high) = rough.iter().fold((f64::MAX, f64::MIN), |(l, h), z| (l.min(*z), h.max(*z)));
    Raster { grid, data: rough.iter().map(|z| (240.0 + 840.0 * (z - low) / (high - low)) as f32).collect() }
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

fn mountain_land(climate: &str) -> Land {
    Land::new(mountains(128, 90.0), &tautavel::climate(climate))
}

#[test]
fn of_the_four_biomes_of_the_sample_three_or_more_dominate_somewhere_and_a_map_tells_them_apart() {
    let land = mountain_land("mild");
    let (flora, _) = land.flora(&tautavel::plants(), Needs::default());
    let (of, names) = tautavel::biomes();
    let map = dominant(&flora, &of);
    assert_eq!(names, ["mediterranean", "mountain", "river", "ubiquist"]);
    let agreed = agreement(&map, &map, 4);
    assert!(agreed.iter().flatten().count() >= 3 && agreed.iter().flatten().all(|iou| *iou == 1.0), "{agreed:?}");
    for (cell, biome) in map.data.iter().enumerate().filter(|(_, b)| **b != NO_BIOME) {
        let densities: Vec<f32> =
            (0..4).map(|b| (0..18).filter(|s| of[*s] == b).map(|s| flora.cover(s, cell)).sum()).collect();
        assert!(densities.iter().all(|d| *d <= densities[usize::from(*biome)] + 1e-4), "{densities:?} {biome}");
    }
    let densest = densest(&density(&flora, &of, 3), DENSEST_SHARE);
    let weight: f64 = densest.data.iter().map(|w| f64::from(*w)).sum();
    assert!((weight - 0.05 * densest.data.len() as f64).abs() < 1.0, "{weight}");
}
