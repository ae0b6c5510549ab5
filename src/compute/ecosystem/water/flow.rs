//! **Flow directions** over the filled surface and **flow accumulation**: the land that drains
//! through each cell.
//!
//! Two rules, for two uses. **D8** (J. F. O'Callaghan, D. M. Mark 1984): all water goes to the
//! steepest lower neighbour; it makes clean channels, one cell wide. **MFD** (P. Quinn, K. Beven,
//! P. Chevallier, O. Planchon 1991): water spreads to all lower neighbours in proportion to
//! slope × contour length (½ and √2/4 of a cell); it is smooth on hillslopes, where D8 draws
//! streaks. On a flat or in a filled depression both follow the way the flood came.

use crate::compute::ecosystem::water::flood::Flooded;
use crate::compute::raster::Raster;
use crate::compute::raster::compass::Compass;
use crate::compute::raster::compass::LENGTHS;
use crate::compute::raster::compass::opposite;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;

/// Cells between two looks at whether to stop.
const STRIDE: usize = 1 << 16;

/// Quinn's contour length over the length of the step, by direction: weight of a drop.
const DROP_WEIGHTS: [f32; 8] = [0.5, 0.5, 0.5, 0.5, 0.25, 0.25, 0.25, 0.25];

/// Where the water of each cell goes: one bit per direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Flow {
    receivers: Vec<u8>,
}

impl Flow {
    /// All water to the steepest lower neighbour (the first of equals); on flats the way out.
    pub fn steepest(flooded: &Flooded) -> Self {
        Self::by(flooded, |compass, level, cell| {
            let (mut best, mut receiver) = (0.0, 0);
            compass.around(cell, |d, n| {
                let fall = (level[cell] - level[n]) / LENGTHS[d];
                if fall > best {
                    (best, receiver) = (fall, 1 << d);
                }
            });
            receiver
        })
    }

    /// Water to every lower neighbour; on flats the way out.
    pub fn multiple(flooded: &Flooded) -> Self {
        Self::by(flooded, |compass, level, cell| {
            let mut receivers = 0;
            compass.around(cell, |d, n| receivers |= u8::from(level[n] < level[cell]) << d);
            receivers
        })
    }

    fn by(flooded: &Flooded, lower: impl Fn(&Compass, &[f32], usize) -> u8 + Sync) -> Self {
        let compass = Compass::new(flooded.level.grid);
        let receivers = (0..flooded.way_out.len()).into_par_iter().map(|cell| {
            let (way_out, down) = (flooded.way_out[cell], lower(&compass, &flooded.level.data, cell));
            if down == 0 && way_out < 8 { 1 << way_out } else { down }
        });
        Self { receivers: receivers.collect() }
    }

    /// The directions in which water leaves `cell`; none where it leaves the map.
    pub fn receivers(&self, cell: usize) -> impl Iterator<Item = usize> + use<> {
        let bits = self.receivers[cell];
        (0..8).filter(move |d| bits >> d & 1 == 1)
    }

    /// Number of neighbours that send water to each cell.
    fn donors(&self, compass: &Compass) -> Vec<u8> {
        let count = |cell| {
            let mut donors = 0;
            compass.around(cell, |d, n| donors += self.receivers[n] >> opposite(d) & 1);
            donors
        };
        (0..self.receivers.len()).into_par_iter().map(count).collect()
    }

    /// **Drainage area** in m²: each cell with data adds its own area to all that it drains
    /// through. Visits a cell once all its donors are done, following the water downhill.
    /// NaN where there is no data. A cell without data neither gives nor takes.
    pub fn accumulate(&self, flooded: &Flooded, run: &Run) -> Result<Raster<f32>, Stopped> {
        let grid = flooded.level.grid;
        let own = grid.cell_area_m2() as f32;
        let compass = Compass::new(grid);
        let mut missing = self.donors(&compass);
        let mut area: Vec<f32> = flooded.level.data.iter().map(|l| if l.is_nan() { f32::NAN } else { own }).collect();
        let mut ready = Vec::new();
        for source in 0..area.len() {
            if source.is_multiple_of(STRIDE) {
                run.check()?;
            }
            if missing[source] > 0 || area[source].is_nan() {
                continue;
            }
            // Marks the source done, so that a chain that ends here later does not start anew.
            missing[source] = u8::MAX;
            ready.push(source);
            while let Some(cell) = ready.pop() {
                self.send(cell, &compass, &flooded.level.data, &mut area, |n| {
                    missing[n] -= 1;
                    if missing[n] == 0 {
                        missing[n] = u8::MAX;
                        ready.push(n);
                    }
                });
            }
        }
        Ok(Raster { grid, data: area })
    }

    /// Hands the area of `cell` to its receivers and tells `sent` of each.
    #[inline]
    fn send(&self, cell: usize, compass: &Compass, level: &[f32], area: &mut [f32], mut sent: impl FnMut(usize)) {
        let (bits, given) = (self.receivers[cell], area[cell]);
        if bits.count_ones() == 1 {
            let n = compass.step(cell, bits.trailing_zeros() as usize);
            area[n] += given;
            return sent(n);
        }
        let mut weights = [0.0f32; 8];
        let mut total = 0.0;
        for direction in self.receivers(cell) {
            let fall = level[cell] - level[compass.step(cell, direction)];
            weights[direction] = fall.clamp(f32::MIN_POSITIVE, 1e30) * DROP_WEIGHTS[direction];
            total += weights[direction];
        }
        for direction in self.receivers(cell) {
            let n = compass.step(cell, direction);
            area[n] += given * (weights[direction] / total);
            sent(n);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::ecosystem::water::flood::flood;
    use crate::compute::raster::Grid;

    fn flooded(grid: Grid, height: impl Fn(f64, f64) -> f64) -> Flooded {
        let data = (0..grid.len()).map(|i| grid.centre(i)).map(|p| height(p.x, p.y) as f32).collect();
        flood(&Raster { grid, data }, &Run::silent()).unwrap()
    }

    /// Water that leaves the map, in cells.
    fn outflow(flow: &Flow, area: &Raster<f32>) -> f64 {
        let leaves = (0..area.data.len()).filter(|c| flow.receivers(*c).next().is_none());
        leaves.map(|c| f64::from(area.data[c])).filter(|a| !a.is_nan()).sum::<f64>() / area.grid.cell_area_m2()
    }

    #[test]
    fn on_a_plane_each_cell_drains_its_strip() {
        let flooded = flooded(Grid::new(5, 20, 10.0), |_, y| y);
        for flow in [Flow::steepest(&flooded), Flow::multiple(&flooded)] {
            let area = flow.accumulate(&flooded, &Run::silent()).unwrap();
            assert!((outflow(&flow, &area) - 100.0).abs() < 1e-3);
        }
        let area = Flow::steepest(&flooded).accumulate(&flooded, &Run::silent()).unwrap();
        for row in 0..20 {
            assert_eq!(area.get(2, row), 100.0 * (row + 1) as f32);
        }
    }

    #[test]
    fn all_water_leaves_the_map_whatever_the_terrain() {
        let rough = |x: f64, y: f64| (libm::sin(x * 1.7 + 0.3 * y) * 3.0 + libm::cos(y * 0.9) * 2.0).round();
        let mut flooded = flooded(Grid::new(61, 47, 1.0), rough);
        flooded.level.data[1000] = f32::NAN;
        let flooded = flood(&flooded.level, &Run::silent()).unwrap();
        for flow in [Flow::steepest(&flooded), Flow::multiple(&flooded)] {
            let area = flow.accumulate(&flooded, &Run::silent()).unwrap();
            assert!((outflow(&flow, &area) - (61.0 * 47.0 - 1.0)).abs() < 0.01);
        }
    }

    #[test]
    fn on_a_cone_multiple_flow_is_round_where_d8_is_a_star() {
        let grid = Grid::new(81, 81, 1.0);
        let flooded = flooded(grid, |x, y| -libm::hypot(x - 40.5, y - 40.5));
        let spread = |flow: Flow| {
            let area = flow.accumulate(&flooded, &Run::silent()).unwrap();
            let ring = (0..grid.len()).filter(|i| {
                let p = grid.centre(*i);
                (libm::hypot(p.x - 40.5, p.y - 40.5) - 30.0).abs() < 1.0
            });
            let values: Vec<f32> = ring.map(|i| area.data[i]).collect();
            let mean = values.iter().sum::<f32>() / values.len() as f32;
            (values.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / values.len() as f32).sqrt() / mean
        };
        let (multiple, steepest) = (spread(Flow::multiple(&flooded)), spread(Flow::steepest(&flooded)));
        assert!(multiple < 0.1 && steepest > 0.4, "{multiple} {steepest}");
    }
}
