//! Stage 2b: **soil type** and **texture** where no map is given: estimated from the terrain and
//! the water, and to be flagged as such.
//!
//! The rule is ours; the types are those of T table A.1. Water where water is; alluvium near
//! streams on gentle ground; fallen rocks below slopes steeper than 35°; of the rest marl on
//! gentle and limestone on steeper slopes, for the soft rock wears down and the hard one stands.

use crate::compute::ecosystem::species::Soil;
use crate::compute::ecosystem::terrain::Terrain;
use crate::compute::ecosystem::water::Water;
use crate::compute::raster::BucketQueue;
use crate::compute::raster::Raster;
use crate::compute::raster::box_mean;
use crate::compute::raster::compass::Compass;
use crate::compute::raster::compass::LENGTHS;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;

/// How the soil is estimated. Slopes are rise over run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SoilRules {
    /// Alluvium reaches so high above the nearest water, m.
    pub alluvium_height_m: f32,
    /// Alluvium lies on slopes up to this.
    pub alluvium_slope: f32,
    /// Rocks fall from slopes steeper than this, and do not rest on them.
    pub cliff_slope: f32,
    /// **Reach angle**: rocks come to rest before the straight line down to them from where they
    /// fell gets flatter than this.
    pub reach_slope: f32,
    /// Marl up to this slope, limestone above.
    pub marl_slope: f32,
    /// The slope that tells marl from limestone is the mean over so far around, m: rock does not
    /// change with every hump.
    pub rock_radius_m: f64,
    /// Texture (1 clay … 9 slab) per type, in the order of the codes of [`Soil`].
    pub texture: [f32; 5],
    /// Texture of slopes steeper than `cliff_slope`.
    pub cliff_texture: f32,
}

impl Default for SoilRules {
    /// 35° for cliffs; a reach angle of 32° (A. Heim's Fahrböschung of rock falls); the rest ours.
    /// Textures in Julve's classes: stony limestone soil as fine sand (4), marl and alluvium as
    /// silt (3), mud under water as clay and silt (2), fallen rocks as pebbles (7), cliffs as
    /// blocks and cracks (8).
    fn default() -> Self {
        Self {
            alluvium_height_m: 2.0,
            alluvium_slope: 0.15,
            cliff_slope: 0.7002,
            reach_slope: 0.6249,
            marl_slope: 0.25,
            rock_radius_m: 50.0,
            texture: [4.0, 2.0, 3.0, 7.0, 3.0],
            cliff_texture: 8.0,
        }
    }
}

/// The estimated soil type of every cell, as codes of [`Soil`]; where there is no data, limestone.
pub fn soil(terrain: &Terrain, water: &Water, rules: &SoilRules, run: &Run) -> Result<Raster<u8>, Stopped> {
    let rocks = rock_fall(terrain, rules, run)?;
    let radius = (rules.rock_radius_m / terrain.grid().cell_m).min(1000.0) as usize;
    let relief = box_mean(&terrain.slope, radius);
    let kind = |cell: usize| {
        let slope = terrain.slope.data[cell];
        if water.is_open(cell) {
            Soil::Water
        } else if slope <= rules.alluvium_slope && water.above_water_m.data[cell] <= rules.alluvium_height_m {
            Soil::Alluvium
        } else if rocks[cell] && slope <= rules.cliff_slope {
            Soil::FallenRocks
        } else if relief.data[cell] <= rules.marl_slope {
            Soil::Marl
        } else {
            Soil::Limestone
        }
    };
    let data = (0..terrain.grid().len()).into_par_iter().map(|cell| kind(cell) as u8).collect();
    Ok(Raster { grid: terrain.grid(), data })
}

/// The texture of a soil map, by the type and for cliffs; NaN where there is no data. A code that
/// is no type counts as limestone.
pub fn texture(terrain: &Terrain, soil: &Raster<u8>, rules: &SoilRules) -> Raster<f32> {
    let value = |(slope, code): (&f32, &u8)| {
        if slope.is_nan() {
            f32::NAN
        } else if *slope > rules.cliff_slope && *code == Soil::Limestone as u8 {
            rules.cliff_texture
        } else {
            rules.texture[usize::from(*code).min(Soil::ALL.len()) % Soil::ALL.len()]
        }
    };
    Raster { grid: soil.grid, data: terrain.slope.data.par_iter().zip(&soil.data).map(value).collect() }
}

/// Buckets of the queue (ours).
const BUCKETS: usize = 1 << 12;

/// Where rocks that fall from cliffs pass or come to rest: cells below a line that starts at a
/// cliff and falls by the reach angle. Lines are followed from the highest down, so each cell
/// is passed by the one that is highest there.
fn rock_fall(terrain: &Terrain, rules: &SoilRules, run: &Run) -> Result<Vec<bool>, Stopped> {
    let grid = terrain.grid();
    let height = &terrain.height.data;
    let compass = Compass::new(grid);
    let mut line = vec![f32::NEG_INFINITY; grid.len()];
    let cliffs = || (0..grid.len()).filter(|c| terrain.slope.data[*c] > rules.cliff_slope);
    let (low, high) = cliffs().map(|c| height[c]).fold((0.0f32, 0.0f32), |(l, h), z| (l.min(z), h.max(z)));
    let mut queue = BucketQueue::new(-high, -low, BUCKETS);
    for cell in cliffs() {
        line[cell] = height[cell];
        queue.push(-height[cell], cell);
    }
    let fall = rules.reach_slope * grid.cell_m as f32;
    for step in 0usize.. {
        if step.is_multiple_of(1 << 16) {
            run.check()?;
        }
        let Some((depth, cell)) = queue.pop() else { break };
        if -depth < line[cell] {
            continue;
        }
        compass.around(cell, |d, n| {
            let there = -depth - fall * LENGTHS[d];
            if there > height[n] && there > line[n] {
                line[n] = there;
                queue.push(-there, n);
            }
        });
    }
    Ok(line.par_iter().zip(height).map(|(line, height)| line > height).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::ecosystem::water::WaterRules;
    use crate::compute::raster::Grid;

    fn types(grid: Grid, height: impl Fn(f64, f64) -> f64) -> Vec<Soil> {
        let data = (0..grid.len()).map(|i| grid.centre(i)).map(|p| height(p.x, p.y) as f32).collect();
        let terrain = Terrain::new(Raster { grid, data }, &Run::silent()).unwrap();
        let water = Water::derived(&terrain.height, &WaterRules::default(), &Run::silent()).unwrap();
        let soil = soil(&terrain, &water, &SoilRules::default(), &Run::silent()).unwrap();
        soil.data.iter().map(|code| Soil::ALL[usize::from(*code)]).collect()
    }

    #[test]
    fn below_a_cliff_lie_fallen_rocks_as_far_as_the_reach_angle() {
        // A plateau 60 m high ends in a face of 63° over 30 m, above a plain.
        let grid = Grid::new(100, 5, 5.0);
        let face = |x: f64| if x < 200.0 { 60.0 } else { (60.0 - 2.0 * (x - 200.0)).max(0.0) };
        let soil = types(grid, |x, _| face(x));
        let at = |x: f64| soil[grid.index((x / 5.0) as usize, 2)];
        assert_eq!(at(100.0), Soil::Marl);
        assert_eq!(at(215.0), Soil::Limestone, "rocks do not rest on the face");
        assert_eq!(at(240.0), Soil::FallenRocks);
        // From the top at 200 m the line falls 60 m over 96 m.
        assert_eq!(at(280.0), Soil::FallenRocks);
        assert_eq!(at(320.0), Soil::Marl);
    }

    #[test]
    fn rock_follows_the_slope() {
        let soil = |slope: f64| types(Grid::new(9, 9, 10.0), |x, _| slope * x)[40];
        assert_eq!((soil(0.1), soil(0.4)), (Soil::Marl, Soil::Limestone));
    }

    #[test]
    fn a_valley_floor_is_alluvium_beside_its_stream() {
        let grid = Grid::new(60, 60, 30.0);
        let soil = types(grid, |x, y| 0.002 * y + (libm::fabs(x - 900.0) - 100.0).max(0.0) * 0.5);
        assert_eq!(soil[grid.index(30, 50)], Soil::Alluvium);
        assert_eq!(soil[grid.index(5, 50)], Soil::Limestone);
    }

    #[test]
    fn texture_follows_the_type_and_cliffs_are_bare() {
        let grid = Grid::new(3, 1, 1.0);
        let terrain = Terrain::new(Raster { grid, data: vec![0.0, 1.0, f32::NAN] }, &Run::silent()).unwrap();
        let map = texture(&terrain, &Raster::filled(grid, Soil::Limestone as u8), &SoilRules::default());
        assert_eq!(map.data[..2], [8.0, 8.0]);
        assert!(map.data[2].is_nan());
        let map = texture(&terrain, &Raster::filled(grid, Soil::FallenRocks as u8), &SoilRules::default());
        assert_eq!(map.data[0], 7.0);
    }
}
