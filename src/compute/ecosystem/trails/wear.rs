//! What the traffic does to the ground: width, depth, and the maps of both.

use super::Trail;
use crate::compute::ecosystem::curve::Ground;
use crate::compute::ecosystem::species::Interval;
use crate::compute::raster::Raster;
use rayon::prelude::*;

/// How traffic wears the ground. All values are ours: the text carves "slightly", "based on the
/// associated weight". Game trails are a foot to a few metres wide, and widen less and less as
/// animals walk in file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wear {
    /// Width of a trail that hardly anyone walks, and of the busiest, metres; positive.
    /// Default: 0.4 to 3.
    pub width_m: Interval,
    /// Traffic that wears a trail half way between the two, kg a year; positive.
    /// Default: 5 000 000 (about 14 t a day).
    pub half_width_kg: f64,
    /// Depth per traffic, metres per kg a year. Default: 1e-8 (10 cm per 10 000 t).
    pub depth_m_per_kg: f64,
    /// The deepest a trail is carved, metres. Default: 0.4.
    pub depth_limit_m: f64,
}

impl Default for Wear {
    fn default() -> Self {
        Self { width_m: Interval::new(0.4, 3.0), half_width_kg: 5e6, depth_m_per_kg: 1e-8, depth_limit_m: 0.4 }
    }
}

impl Wear {
    /// Width in metres of a trail with this traffic (kg a year).
    pub fn width(&self, kg: f64) -> f64 {
        self.width_m.min + (self.width_m.max - self.width_m.min) * kg / (kg + self.half_width_kg)
    }

    /// Depth in metres of a trail with this traffic (kg a year): proportional, then limited.
    pub fn depth(&self, kg: f64) -> f64 {
        (self.depth_m_per_kg * kg).min(self.depth_limit_m)
    }
}

/// The maps of all trails, on the terrain's grid.
pub(crate) struct Maps {
    pub(crate) usage: Raster<f32>,
    pub(crate) worn: Raster<f32>,
    pub(crate) carving_m: Raster<f32>,
}

/// What one piece of a trail leaves in one cell: kg a year times metres, m², m³.
type Mark = (usize, [f64; 3]);

/// Spreads every trail over the cells under its width. The sums are kept: of usage × cell area
/// that is traffic × length, of worn × cell area width × length, of carving × cell area depth ×
/// width × length, but for what the limits (1, and the deepest carving) cut off.
pub(crate) fn maps(trails: &[Trail], ground: &Ground, wear: &Wear) -> Maps {
    let per_trail: Vec<Vec<Mark>> = trails.par_iter().map(|trail| marks(trail, ground)).collect();
    let mut all: Vec<Mark> = per_trail.into_iter().flatten().collect();
    all.sort_by_key(|mark| mark.0);
    let grid = *ground.grid;
    let mut maps = Maps {
        usage: Raster::filled(grid, 0.0),
        worn: Raster::filled(grid, 0.0),
        carving_m: Raster::filled(grid, 0.0),
    };
    for marks in all.chunk_by(|a, b| a.0 == b.0) {
        let sum = |k: usize| marks.iter().map(|mark| mark.1[k]).sum::<f64>() / grid.cell_area_m2();
        let cell = marks[0].0;
        maps.usage.data[cell] = sum(0) as f32;
        maps.worn.data[cell] = sum(1).min(1.0) as f32;
        maps.carving_m.data[cell] = sum(2).min(wear.depth_limit_m) as f32;
    }
    maps
}

/// The marks of one trail, summed per run of equal cells.
fn marks(trail: &Trail, ground: &Ground) -> Vec<Mark> {
    let mut marks: Vec<Mark> = Vec::new();
    let cell_m = ground.grid.cell_m;
    for stretch in &trail.stretches {
        let walker = stretch.main_species();
        let lanes = (stretch.width_m / (0.5 * cell_m)).ceil().max(1.0) as usize;
        for w in trail.points[stretch.points.clone()].windows(2) {
            let (along, length) = (w[1] - w[0], w[0].distance(w[1]));
            let Some(side) = along.rotated(std::f64::consts::FRAC_PI_2).normalised() else { continue };
            let pieces = (length / (0.25 * cell_m)).ceil().max(1.0) as usize;
            let share = length / (pieces * lanes) as f64;
            for k in 0..pieces * lanes {
                let middle = w[0] + along * (((k / lanes) as f64 + 0.5) / pieces as f64);
                let aside = (((k % lanes) as f64 + 0.5) / lanes as f64 - 0.5) * stretch.width_m;
                let beside = ground.grid.at(middle + side * aside).filter(|&cell| ground.ways.open(walker, cell));
                let Some(cell) = beside.or(ground.grid.at(middle)) else { continue };
                let mark = [stretch.kg_per_year, stretch.width_m, stretch.depth_m * stretch.width_m].map(|v| v * share);
                match marks.last_mut() {
                    Some(last) if last.0 == cell => last.1.iter_mut().zip(mark).for_each(|(sum, v)| *sum += v),
                    _ => marks.push((cell, mark)),
                }
            }
        }
    }
    marks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn width_and_depth_grow_with_traffic_up_to_their_limits() {
        let wear = Wear::default();
        assert_eq!(wear.width(0.0), 0.4);
        assert!((wear.width(5e6) - 1.7).abs() < 1e-12);
        assert!(wear.width(1e12) <= 3.0 && wear.width(1e12) > 2.99);
        assert!((wear.depth(1e7) - 0.1).abs() < 1e-12 && wear.depth(1e12) == 0.4);
    }
}
