//! **Streams and rivers**: where enough land drains through a cell, and how wide and deep they
//! are there.

use crate::compute::raster::Raster;

/// Width and depth of a stream as powers of its drainage area: a **regional curve** of
/// **hydraulic geometry**.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HydraulicGeometry {
    /// Width in m of a stream that drains 1 km².
    pub width_m: f64,
    /// Exponent of the area in the width.
    pub width_exponent: f64,
    /// Depth in m of a stream that drains 1 km².
    pub depth_m: f64,
    /// Exponent of the area in the depth.
    pub depth_exponent: f64,
}

impl Default for HydraulicGeometry {
    /// The bankfull curve of humid temperate uplands, New York State east of the Hudson (C. I.
    /// Mulvihill, B. P. Baldigo, USGS Scientific Investigations Report 2007–5227): width
    /// 24.0·A^0.292 ft and mean depth 1.66·A^0.210 ft of A square miles, in metric units. Bankfull
    /// is the level of the yearly flood, so on most days the water is shallower.
    fn default() -> Self {
        const FOOT_M: f64 = 0.3048;
        const SQUARE_MILE_KM2: f64 = 2.589_988;
        Self {
            width_m: 24.0 * FOOT_M * libm::pow(SQUARE_MILE_KM2, -0.292),
            width_exponent: 0.292,
            depth_m: 1.66 * FOOT_M * libm::pow(SQUARE_MILE_KM2, -0.210),
            depth_exponent: 0.210,
        }
    }
}

impl HydraulicGeometry {
    /// Width in m of a stream that drains `area_m2`.
    pub fn width(&self, area_m2: f64) -> f64 {
        self.width_m * libm::pow(area_m2 * 1e-6, self.width_exponent)
    }

    /// Depth in m of a stream that drains `area_m2`.
    pub fn depth(&self, area_m2: f64) -> f64 {
        self.depth_m * libm::pow(area_m2 * 1e-6, self.depth_exponent)
    }
}

/// Where streams run and how large they are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StreamRule {
    /// A stream starts where so much land drains through a cell, m².
    pub min_drainage_m2: f64,
    /// Their size.
    pub geometry: HydraulicGeometry,
}

impl Default for StreamRule {
    /// 0.1 km²: channel heads lie between 0.01 and 1 km² (D. R. Montgomery, W. E. Dietrich 1988).
    fn default() -> Self {
        Self { min_drainage_m2: 100_000.0, geometry: HydraulicGeometry::default() }
    }
}

/// The water maps that streams are added to.
#[derive(Debug)]
pub struct Bed<'a> {
    /// Filled heights, m.
    pub level: &'a Raster<f32>,
    /// Depth of the water so far, m: lakes stay as they are.
    pub depth_m: &'a mut Raster<f32>,
    /// Width of the streams narrower than a cell, m.
    pub stream_width_m: &'a mut Raster<f32>,
}

impl Bed<'_> {
    /// Adds the streams that `rule` sees in `drainage` (m², by D8). One narrower than a cell is an
    /// attribute of its cell; a wider one covers the cells within half its width whose ground lies
    /// below its surface.
    pub fn add_streams(&mut self, drainage: &Raster<f32>, rule: StreamRule) {
        let cell_m = drainage.grid.cell_m;
        for (cell, area) in drainage.data.iter().map(|a| f64::from(*a)).enumerate() {
            // `area` is not a number where there is no data.
            if area >= rule.min_drainage_m2 {
                let (width, depth) = (rule.geometry.width(area), rule.geometry.depth(area));
                match width < cell_m {
                    true => self.narrow(cell, width, depth),
                    false => self.wide(cell, 0.5 * width / cell_m, depth as f32),
                }
            }
        }
    }

    fn narrow(&mut self, cell: usize, width: f64, depth: f64) {
        if self.depth_m.data[cell] == 0.0 {
            self.depth_m.data[cell] = depth as f32;
            self.stream_width_m.data[cell] = width as f32;
        }
    }

    fn wide(&mut self, cell: usize, radius: f64, depth: f32) {
        let grid = self.level.grid;
        let surface = self.level.data[cell] + depth;
        let reach = radius.floor() as isize;
        for dy in -reach..=reach {
            for dx in -reach..=reach {
                let within = ((dx * dx + dy * dy) as f64) <= radius * radius;
                let Some(n) = grid.offset(cell, dx, dy).filter(|_| within) else { continue };
                if self.level.data[n] < surface {
                    self.depth_m.data[n] = self.depth_m.data[n].max(depth);
                    self.stream_width_m.data[n] = 0.0;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::raster::Grid;

    #[test]
    fn the_curve_is_the_published_one() {
        let curve = HydraulicGeometry::default();
        let square_mile = 2.589_988e6;
        assert!((curve.width(square_mile) - 24.0 * 0.3048).abs() < 1e-3);
        assert!((curve.depth(100.0 * square_mile) - 1.66 * 0.3048 * libm::pow(100.0, 0.21)).abs() < 1e-3);
    }

    #[test]
    fn a_river_wider_than_a_cell_spreads_over_its_width_but_not_up_its_banks() {
        let grid = Grid::new(21, 21, 1.0);
        let mut level = Raster::filled(grid, 10.0f32);
        (0..grid.len()).filter(|i| grid.cell(*i).column >= 13).for_each(|i| level.data[i] = 20.0);
        let mut drainage = Raster::filled(grid, 1.0f32);
        (0..21).for_each(|row| drainage.data[grid.index(10, row)] = 10e6);
        let geometry = HydraulicGeometry { width_m: 8.0, width_exponent: 0.0, depth_m: 1.5, depth_exponent: 0.0 };
        let (mut depth_m, mut stream_width_m) = (Raster::filled(grid, 0.0), Raster::filled(grid, 0.0));
        Bed { level: &level, depth_m: &mut depth_m, stream_width_m: &mut stream_width_m }
            .add_streams(&drainage, StreamRule { min_drainage_m2: 1e6, geometry });
        let wet: Vec<usize> = (0..21).filter(|c| depth_m.get(*c, 10) > 0.0).collect();
        assert_eq!(wet, (6..13).collect::<Vec<_>>());
        assert!(stream_width_m.data.iter().all(|w| *w == 0.0));
    }
}
