//! Stage 1a: **slope** and **aspect** of the height map.

use crate::compute::raster::Grid;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;

/// The height map and its first derivatives.
#[derive(Debug, Clone, PartialEq)]
pub struct Terrain {
    /// Height in metres; NaN where there is no data.
    pub height: Raster<f32>,
    /// Slope as rise over run; NaN where there is no data.
    pub slope: Raster<f32>,
    /// Direction of steepest **descent** in radians counter-clockwise from east, in (−π, π]; 0
    /// where flat, NaN where there is no data.
    pub aspect: Raster<f32>,
}

impl Terrain {
    /// Slope and aspect of `height` (metres, NaN for no data; infinite heights count as no data)
    /// by Horn's method (B. K. P. Horn, "Hill shading and the reflectance map", 1981): central
    /// differences over three rows (columns) weighted 1, 2, 1. At the border and beside cells
    /// without data the differences are one-sided; a row (column) with no neighbour is left out.
    pub fn new(mut height: Raster<f32>, run: &Run) -> Result<Self, Stopped> {
        let grid = height.grid;
        height.data.par_iter_mut().filter(|h| h.is_infinite()).for_each(|h| *h = f32::NAN);
        let mut slope = Raster::filled(grid, 0.0f32);
        let mut aspect = Raster::filled(grid, 0.0f32);
        run.progress("terrain.slope", 0, 1)?;
        slope.data.par_chunks_mut(grid.width).zip(aspect.data.par_chunks_mut(grid.width)).enumerate().for_each(
            |(row, (slopes, aspects))| {
                if run.is_stopped() {
                    return;
                }
                for column in 0..grid.width {
                    let (east, north) = gradient(&height, column, row);
                    slopes[column] = (east * east + north * north).sqrt();
                    aspects[column] = descent(east, north);
                }
            },
        );
        run.progress("terrain.slope", 1, 1)?;
        Ok(Self { height, slope, aspect })
    }

    /// Where the cells lie.
    pub fn grid(&self) -> Grid {
        self.height.grid
    }

    /// Cosine of the angle between the downslope direction and south (north of the equator the
    /// sunny side): 1 on south slopes, −1 on north slopes, 0 where flat.
    pub fn southness(&self, cell: usize) -> f32 {
        if self.slope.data[cell] > 0.0 { -libm::sinf(self.aspect.data[cell]) } else { 0.0 }
    }
}

/// Direction of steepest descent for a gradient (rise per metre to the east and to the north).
fn descent(east: f32, north: f32) -> f32 {
    if east == 0.0 && north == 0.0 { 0.0 } else { libm::atan2f(-north, -east) }
}

/// Rise per metre to the east and to the north at a cell; NaN where there is no data.
pub fn gradient(height: &Raster<f32>, column: usize, row: usize) -> (f32, f32) {
    let grid = &height.grid;
    let here = height.get(column, row);
    if here.is_nan() {
        return (f32::NAN, f32::NAN);
    }
    let at = |dx: isize, dy: isize| match (column.checked_add_signed(dx), row.checked_add_signed(dy)) {
        (Some(c), Some(r)) if c < grid.width && r < grid.height => height.get(c, r),
        _ => f32::NAN,
    };
    let cell = grid.cell_m as f32;
    let east = mean_difference([-1, 0, 1].map(|d| (at(-1, d), at(0, d), at(1, d))));
    let south = mean_difference([-1, 0, 1].map(|d| (at(d, -1), at(d, 0), at(d, 1))));
    (east / cell, -south / cell)
}

/// Mean of the three differences (before, at, after), weighted 1, 2, 1, per step.
fn mean_difference(lines: [(f32, f32, f32); 3]) -> f32 {
    let weighted = lines.into_iter().zip([1.0, 2.0, 1.0]).filter_map(|(line, w)| Some((difference(line)?, w)));
    let (sum, weight) = weighted.fold((0.0, 0.0), |(s, t), (d, w)| (s + w * d, t + w));
    if weight > 0.0 { sum / weight } else { 0.0 }
}

/// Central difference per step, or the one-sided one; `None` without two values in a row.
fn difference((before, at, after): (f32, f32, f32)) -> Option<f32> {
    match (before.is_nan(), at.is_nan(), after.is_nan()) {
        (false, _, false) => Some(0.5 * (after - before)),
        (true, false, false) => Some(after - at),
        (false, false, true) => Some(at - before),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    fn terrain(grid: Grid, height: impl Fn(f64, f64) -> f64) -> Terrain {
        let data = (0..grid.len()).map(|i| grid.centre(i)).map(|p| height(p.x, p.y) as f32).collect();
        Terrain::new(Raster { grid, data }, &Run::silent()).unwrap()
    }

    #[test]
    fn a_plane_has_its_slope_and_aspect_everywhere_even_at_the_border() {
        let t = terrain(Grid::new(7, 5, 10.0), |x, y| 0.3 * x + 0.4 * y);
        for i in 0..t.grid().len() {
            assert!((t.slope.data[i] - 0.5).abs() < 1e-5);
            assert!((t.aspect.data[i] - libm::atan2f(-0.4, -0.3)).abs() < 1e-5);
        }
    }

    #[test]
    fn beside_cells_without_data_differences_are_one_sided() {
        let grid = Grid::new(6, 6, 2.0);
        let mut height = terrain(grid, |x, y| 0.25 * x - y).height;
        for hole in [14, 15, 20, 35, 0] {
            height.data[hole] = f32::NAN;
        }
        let t = Terrain::new(height, &Run::silent()).unwrap();
        for i in 0..grid.len() {
            if t.height.data[i].is_nan() {
                assert!(t.slope.data[i].is_nan() && t.aspect.data[i].is_nan());
            } else {
                assert!((t.slope.data[i] - 1.0625f32.sqrt()).abs() < 1e-5, "cell {i}: {}", t.slope.data[i]);
            }
        }
    }

    #[test]
    fn a_cone_falls_away_from_its_top_on_all_sides() {
        let grid = Grid::new(101, 101, 1.0);
        let t = terrain(grid, |x, y| -0.7 * libm::hypot(x - 50.5, y - 50.5));
        for i in 0..grid.len() {
            let p = grid.centre(i);
            let (dx, dy) = (p.x - 50.5, p.y - 50.5);
            if libm::hypot(dx, dy) > 10.0 {
                assert!((t.slope.data[i] - 0.7).abs() < 0.02);
                let turn = t.aspect.data[i] - libm::atan2(dy, dx) as f32;
                assert!((turn + PI).rem_euclid(2.0 * PI) - PI < 0.03);
            }
        }
    }

    #[test]
    fn one_cell_alone_and_infinite_heights_are_harmless() {
        let one = terrain(Grid::new(1, 1, 1.0), |_, _| 5.0);
        assert_eq!((one.slope.data[0], one.aspect.data[0]), (0.0, 0.0));
        let endless = terrain(Grid::new(3, 1, 1.0), |x, _| if x < 1.0 { f64::INFINITY } else { 0.0 });
        assert!(endless.height.data[0].is_nan());
        assert_eq!(endless.slope.data[1], 0.0);
    }

    #[test]
    fn a_south_slope_faces_south() {
        let t = terrain(Grid::new(4, 4, 1.0), |_, y| y);
        assert!((t.southness(5) - 1.0).abs() < 1e-6);
    }
}
