//! **Height above the nearest water**: what decides how far its damp reaches.
//!
//! After the height above the nearest drainage of A. D. Nobre et al. (Journal of Hydrology 404,
//! 2011), but over the way that rises least instead of the D8 path, which is smooth where D8 paths
//! run side by side, and with a little for the length of the way.

use crate::compute::raster::BucketQueue;
use crate::compute::raster::Raster;
use crate::compute::raster::compass::Compass;
use crate::compute::raster::compass::LENGTHS;
use crate::compute::run::Run;
use crate::compute::run::Stopped;

/// The share of the way to the water that counts as height above it (ours: 50 m of level ground
/// count as a rise of 1 m).
pub const GRADE: f32 = 0.02;

/// Height above the water beyond which it is not felt (ours), m.
pub const REACH_M: f32 = 6.0;

/// Buckets of the queue (ours).
const BUCKETS: usize = 1 << 12;

/// How far one climbs from the nearest cell that `is_wet`, m: the rises along the way over
/// `level` (filled heights, NaN for no data), and [`GRADE`] of its length. 0 in the water,
/// infinite beyond [`REACH_M`] and where there is no data.
pub fn height_above_water(
    level: &Raster<f32>,
    is_wet: impl Fn(usize) -> bool,
    run: &Run,
) -> Result<Raster<f32>, Stopped> {
    let grid = level.grid;
    let compass = Compass::new(grid);
    let mut above = Raster::filled(grid, f32::INFINITY);
    let mut queue = BucketQueue::new(0.0, REACH_M, BUCKETS);
    for cell in (0..grid.len()).filter(|c| is_wet(*c)) {
        above.data[cell] = 0.0;
        queue.push(0.0, cell);
    }
    let metre = GRADE * grid.cell_m as f32;
    for step in 0usize.. {
        if step.is_multiple_of(1 << 16) {
            run.check()?;
        }
        let Some((here, cell)) = queue.pop() else { break };
        if here > above.data[cell] {
            continue;
        }
        compass.around(cell, |d, n| {
            let rise = (level.data[n] - level.data[cell]).max(0.0);
            let there = here + rise + metre * LENGTHS[d];
            // A height that is not a number never passes.
            if level.data[n].is_finite() && there < above.data[n] && there <= REACH_M {
                above.data[n] = there;
                queue.push(there, n);
            }
        });
    }
    Ok(above)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::raster::Grid;

    #[test]
    fn it_grows_with_the_way_and_the_rise_and_ends_at_its_reach() {
        let grid = Grid::new(100, 1, 2.0);
        let level = Raster { grid, data: (0..100).map(|c| if c < 50 { 0.0 } else { 0.5 * (c - 50) as f32 }).collect() };
        let above = height_above_water(&level, |c| c == 10, &Run::silent()).unwrap();
        assert_eq!(above.data[10], 0.0);
        assert!((above.data[0] - 0.4).abs() < 1e-4);
        assert!((above.data[54] - (44.0 * 0.04 + 2.0)).abs() < 1e-4);
        assert_eq!(above.data[99], f32::INFINITY);
    }

    #[test]
    fn going_down_costs_nothing_back() {
        let grid = Grid::new(9, 1, 1.0);
        let level = Raster { grid, data: vec![5.0, 5.0, 1.0, 1.0, 1.0, f32::NAN, 1.0, 1.0, 1.0] };
        let above = height_above_water(&level, |c| c == 0, &Run::silent()).unwrap();
        assert!((above.data[4] - 0.08).abs() < 1e-5);
        assert_eq!(above.data[6], f32::INFINITY);
    }
}
