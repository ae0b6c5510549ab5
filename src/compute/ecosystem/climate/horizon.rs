//! **Horizon angles**: how high the terrain stands in a direction, for every cell.
//!
//! V. Timonen, J. Westerholm, "Scalable height field self-shadowing", Computer Graphics Forum
//! 29 (2010): march along parallel lines away from the direction looked to, and keep the upper
//! convex hull of the ground passed; the horizon is the tangent to it. Each cell is passed once a
//! direction, and each hull point dropped once, so the cost is cells × directions.
//!
//! Beyond the map the ground is taken for flat and low; the curvature of the Earth is left out.

use crate::compute::raster::Grid;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::ops::Range;

/// Steps of the codes for horizon angles.
pub const CODES: usize = 256;

/// Horizons in directions spread evenly over the compass.
#[derive(Debug, Clone, PartialEq)]
pub struct Horizons {
    /// Where the cells lie.
    pub grid: Grid,
    /// For direction `s`, at 2π·s / number radians counter-clockwise from east, the [`code`] of
    /// the tangent of the horizon angle of every cell; 0 where there is no data.
    pub codes: Vec<Vec<u8>>,
}

/// The place on 0..=255 of a height angle with tangent `t` ≥ 0: 255·t / (1 + t). Finest, at a
/// quarter of a degree, near the horizon.
pub fn place(t: f32) -> f32 {
    (CODES - 1) as f32 * (t / (1.0 + t))
}

/// The code nearest to the [`place`] of a height angle with tangent `t`; 0 below the horizon.
pub fn code(t: f32) -> u8 {
    // The cast saturates, and takes what is not a number to 0.
    (place(t.max(0.0)) + 0.5) as u8
}

/// The middle of the height angles that share a code, in radians.
pub fn angle(code: usize) -> f64 {
    let part = code as f64 / (CODES - 1) as f64;
    libm::atan2(part, 1.0 - part)
}

/// The horizons of `height` (m, NaN for no data) in `directions` directions.
pub fn horizons(height: &Raster<f32>, directions: usize, run: &Run) -> Result<Horizons, Stopped> {
    let grid = height.grid;
    let lying = transposed(&height.data, grid.width);
    let codes: Result<Vec<Vec<u8>>, Stopped> = (0..directions)
        .into_par_iter()
        .map(|s| {
            let azimuth = 2.0 * PI * s as f64 / directions as f64;
            // In steps east and south.
            let (east, south) = (libm::cos(azimuth), -libm::sin(azimuth));
            if east.abs() >= south.abs() {
                let codes = Sweep::new(&lying, grid.height, (east, south), grid.cell_m).codes(run)?;
                return Ok(transposed(&codes, grid.height));
            }
            Sweep::new(&height.data, grid.width, (south, east), grid.cell_m).codes(run)
        })
        .collect();
    Ok(Horizons { grid, codes: codes? })
}

/// The rows of a map of rows of `width` as columns.
fn transposed<T: Copy + Default>(data: &[T], width: usize) -> Vec<T> {
    /// Side of the blocks that are turned at a time, for the cache.
    const BLOCK: usize = 32;
    let height = data.len() / width;
    let mut turned = vec![T::default(); data.len()];
    for top in (0..height).step_by(BLOCK) {
        for left in (0..width).step_by(BLOCK) {
            for column in left..(left + BLOCK).min(width) {
                for row in top..(top + BLOCK).min(height) {
                    turned[column * height + row] = data[row * width + column];
                }
            }
        }
    }
    turned
}

/// Lines that march side by side: the cells they pass at a step lie next to each other in memory.
const LINES: usize = 16;

/// Parallel lines over a map that advance one row of it a step, looking back.
struct Sweep<'a> {
    data: &'a [f32],
    width: usize,
    /// Column of the line through column 0 of row 0, at each row: the whole part …
    whole: Vec<isize>,
    /// … and what is left, −½..=½.
    rest: Vec<f32>,
    /// Rows in the order of the march: away from the direction looked to.
    backwards: bool,
    /// One over the length of a step, 1/m.
    per_metre: f32,
}

/// The upper hulls of the ground that [`LINES`] lines have passed, as (steps, height).
type Hulls = [Vec<(f32, f32)>; LINES];

impl<'a> Sweep<'a> {
    /// Looks to (`along`, `across`) in steps to the next row and column, |along| ≥ |across|.
    fn new(data: &'a [f32], width: usize, (along, across): (f64, f64), cell_m: f64) -> Self {
        let grade = across / along;
        let columns = (0..data.len() / width).map(|row| grade * row as f64);
        Self {
            data,
            width,
            whole: columns.clone().map(|x| x.round() as isize).collect(),
            rest: columns.map(|x| (x - x.round()) as f32).collect(),
            backwards: along > 0.0,
            per_metre: (1.0 / (cell_m * libm::hypot(1.0, grade))) as f32,
        }
    }

    /// The code of every cell. Line `k` passes through the cells `(row, k + whole[row])`, so each
    /// cell lies on one line.
    fn codes(&self, run: &Run) -> Result<Vec<u8>, Stopped> {
        let mut codes = vec![0; self.data.len()];
        let last = self.whole[self.whole.len() - 1];
        let mut hulls = Hulls::default();
        for line in (-last.max(0)..self.width as isize - last.min(0)).step_by(LINES) {
            run.check()?;
            hulls.iter_mut().for_each(Vec::clear);
            self.march(line, &mut hulls, &mut codes);
        }
        Ok(codes)
    }

    /// Marches with the lines from `line` on.
    fn march(&self, line: isize, hulls: &mut Hulls, codes: &mut [u8]) {
        let rows = self.whole.len();
        for step in 0..rows {
            let row = if self.backwards { rows - 1 - step } else { step };
            let first = line + self.whole[row];
            let (left, right) = (first.max(0), (first + LINES as isize).min(self.width as isize));
            if left >= right {
                continue;
            }
            let (near, columns) = ((left - first) as usize, left as usize..right as usize);
            let mut seen = self.ground(row, columns.clone());
            for (z, hull) in seen[..columns.len()].iter_mut().zip(&mut hulls[near..]) {
                *z = rise(hull, step as f32, *z);
            }
            let start = row * self.width;
            let cells = &mut codes[start + columns.start..start + columns.end];
            cells.iter_mut().zip(seen).for_each(|(cell, seen)| *cell = code(seen * self.per_metre));
        }
    }

    /// Height of the lines where they pass nearest to the centres of these cells of a row, at most
    /// [`LINES`].
    fn ground(&self, row: usize, columns: Range<usize>) -> [f32; LINES] {
        let (cells, rest) = (&self.data[row * self.width..][..self.width], self.rest[row]);
        let mut ground = [0.0; LINES];
        for (ground, column) in ground.iter_mut().zip(columns) {
            let here = cells[column];
            let beside = if rest > 0.0 { column + 1 } else { column.wrapping_sub(1) };
            *ground = match cells.get(beside) {
                Some(beside) if !beside.is_nan() => here + rest.abs() * (beside - here),
                _ => here,
            };
        }
        ground
    }
}

/// Rise per step from the point at (`x`, `z`) to the hull of the points before it, ascending in
/// x; adds the point. NaN when it has no height, 0 when it is the first.
fn rise(hull: &mut Vec<(f32, f32)>, x: f32, z: f32) -> f32 {
    if z.is_nan() {
        return z;
    }
    let mut seen = 0.0;
    while let Some(&(x1, z1)) = hull.last() {
        if let Some(&(x2, z2)) = hull.len().checked_sub(2).map(|k| &hull[k])
            && (z1 - z) * (x - x2) <= (z2 - z) * (x - x1)
        {
            // The nearer of the two lies below the line to the farther: never seen again.
            hull.pop();
            continue;
        }
        seen = (z1 - z) / (x - x1);
        break;
    }
    hull.push((x, z));
    seen
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(grid: Grid, height: impl Fn(f64, f64) -> f64) -> Horizons {
        let data = (0..grid.len()).map(|i| grid.centre(i)).map(|p| height(p.x, p.y) as f32).collect();
        horizons(&Raster { grid, data }, 16, &Run::silent()).unwrap()
    }

    #[test]
    fn flat_ground_has_a_flat_horizon() {
        let flat = of(Grid::new(9, 13, 5.0), |_, _| 120.0);
        assert!(flat.codes.iter().flatten().all(|c| *c == 0));
    }

    #[test]
    fn a_wall_stands_as_high_as_its_distance_says() {
        // A wall of 20 m along the eastern border, seen from the west.
        let grid = Grid::new(60, 60, 1.0);
        let wall = of(grid, |x, _| if x > 59.0 { 20.0 } else { 0.0 });
        for column in 0..59 {
            let expected = libm::atan2(20.0, (59 - column) as f64);
            let found = angle(usize::from(wall.codes[0][grid.index(column, 30)]));
            assert!((found - expected).abs() < 0.006, "column {column}: {found} for {expected}");
        }
        assert_eq!(wall.codes[8][grid.index(30, 30)], 0, "to the west it is open");
    }

    #[test]
    fn a_tilted_plane_rises_by_its_slope_in_every_direction() {
        let grid = Grid::new(80, 70, 3.0);
        let plane = of(grid, |x, y| 0.4 * x + 0.3 * y);
        for (s, codes) in plane.codes.iter().enumerate() {
            let a = 2.0 * PI * s as f64 / 16.0;
            let expected = code((0.4 * libm::cos(a) + 0.3 * libm::sin(a)) as f32);
            let found = codes[grid.index(40, 35)];
            assert!(found.abs_diff(expected) <= 1, "direction {s}: {found} for {expected}");
        }
    }

    #[test]
    fn the_sweep_finds_what_looking_at_every_cell_finds() {
        let grid = Grid::new(31, 23, 10.0);
        let hills =
            |x: f64, y: f64| 40.0 * libm::sin(x / 37.0) * libm::cos(y / 29.0) + 25.0 * libm::sin((x + y) / 17.0);
        let swept = of(grid, hills);
        // To the east and to the north, lines run through cell centres.
        for cell in 0..grid.len() {
            let p = grid.centre(cell);
            let seen = |towards: fn(f64) -> (f64, f64)| {
                let rises =
                    (1..31).map(|k| (10.0 * f64::from(k), towards(10.0 * f64::from(k)))).map(|(d, (dx, dy))| {
                        let inside = grid.at(crate::compute::geometry::Point::new(p.x + dx, p.y + dy)).is_some();
                        if inside { (hills(p.x + dx, p.y + dy) - hills(p.x, p.y)) / d } else { 0.0 }
                    });
                code(rises.fold(0.0, f64::max) as f32)
            };
            assert!(swept.codes[0][cell].abs_diff(seen(|d| (d, 0.0))) <= 1);
            assert!(swept.codes[4][cell].abs_diff(seen(|d| (0.0, d))) <= 1);
        }
    }

    #[test]
    fn what_has_no_data_hides_nothing() {
        let grid = Grid::new(3, 1, 1.0);
        let raster = Raster { grid, data: vec![0.0, f32::NAN, 1.0] };
        let found = horizons(&raster, 4, &Run::silent()).unwrap();
        assert_eq!(found.codes[0], vec![code(0.5), 0, 0]);
    }
}
