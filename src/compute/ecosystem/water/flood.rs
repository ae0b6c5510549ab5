//! **Depression filling** by priority-flood: the level to which water would stand if every
//! depression were full to its outlet.
//!
//! R. Barnes, C. Lehman, D. Mulla, "Priority-flood: An optimal depression-filling and
//! watershed-labeling algorithm for digital elevation models", Computers & Geosciences 62 (2014):
//! cells are flooded inwards from the outlets in ascending order of level; cells below the level
//! that reaches them go to a plain queue. Here the priority queue is one of buckets.

use crate::compute::raster::BucketQueue;
use crate::compute::raster::Raster;
use crate::compute::raster::compass::Compass;
use crate::compute::raster::compass::opposite;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use std::collections::VecDeque;

/// A height map without depressions.
#[derive(Debug, Clone, PartialEq)]
pub struct Flooded {
    /// The filled height, m: nowhere below the terrain, and from every cell a path that never
    /// rises leads to an outlet. NaN where there is no data.
    pub level: Raster<f32>,
    /// The direction from which the flood reached the cell, which is a way out that never rises;
    /// [`OUTLET`] at the outlets, [`UNREACHED`] where there is no data.
    pub way_out: Vec<u8>,
}

/// An outlet: a cell at the border of the map or beside one without data.
pub const OUTLET: u8 = 8;
/// A cell that the flood never reached.
pub const UNREACHED: u8 = u8::MAX;

/// Buckets of the queue (ours): many enough that few cells of the flood's front share one.
const BUCKETS: usize = 1 << 16;
/// Cells flooded between two looks at whether to stop.
const STRIDE: usize = 1 << 16;

/// Fills the depressions of `height` (m, NaN for no data). The border of the map and the cells
/// beside those without data are outlets. Time grows about linearly with the cells.
pub fn flood(height: &Raster<f32>, run: &Run) -> Result<Flooded, Stopped> {
    let (low, high) = range(&height.data);
    let mut front = Front {
        compass: Compass::new(height.grid),
        queue: BucketQueue::new(low, high, BUCKETS),
        pit: VecDeque::new(),
        level: height.data.clone(),
        way_out: vec![UNREACHED; height.grid.len()],
    };
    front.start();
    let total = height.grid.len() as u64;
    for flooded in 0usize.. {
        if flooded.is_multiple_of(STRIDE) {
            run.progress("water.flood", flooded as u64, total)?;
        }
        let Some(cell) = front.next() else { break };
        front.spread(cell);
    }
    Ok(Flooded { level: Raster { grid: height.grid, data: front.level }, way_out: front.way_out })
}

/// The cells that the flood has reached and not yet passed.
struct Front {
    compass: Compass,
    queue: BucketQueue,
    pit: VecDeque<u32>,
    level: Vec<f32>,
    way_out: Vec<u8>,
}

impl Front {
    fn start(&mut self) {
        for cell in 0..self.level.len() {
            if !self.level[cell].is_nan() && self.is_outlet(cell) {
                self.way_out[cell] = OUTLET;
                self.queue.push(self.level[cell], cell);
            }
        }
    }

    fn is_outlet(&self, cell: usize) -> bool {
        let mut beside_nothing = self.compass.at_border(cell);
        if !beside_nothing {
            self.compass.around(cell, |_, n| beside_nothing |= self.level[n].is_nan());
        }
        beside_nothing
    }

    /// The next cell to spread from. All cells that wait at one level start together, so that a
    /// flat with many outlets drains to the nearest.
    fn next(&mut self) -> Option<usize> {
        if self.pit.is_empty() {
            let (level, cell) = self.queue.pop()?;
            self.pit.push_back(cell as u32);
            while let Some(cell) = self.queue.pop_equal(level) {
                self.pit.push_back(cell as u32);
            }
        }
        self.pit.pop_front().map(|cell| cell as usize)
    }

    fn spread(&mut self, cell: usize) {
        let Self { compass, queue, pit, level, way_out } = self;
        let here = level[cell];
        compass.around(cell, |direction, n| {
            if way_out[n] != UNREACHED || level[n].is_nan() {
                return;
            }
            way_out[n] = opposite(direction) as u8;
            if level[n] <= here {
                level[n] = here;
                pit.push_back(n as u32);
            } else {
                queue.push(level[n], n);
            }
        });
    }
}

/// Least and greatest number among `values`; (0, 0) when there is none.
fn range(values: &[f32]) -> (f32, f32) {
    let numbers = values.iter().filter(|v| !v.is_nan());
    let (low, high) = numbers.fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    if low <= high { (low, high) } else { (0.0, 0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::raster::Grid;

    fn raster(width: usize, data: &[f32]) -> Raster<f32> {
        Raster { grid: Grid::new(width, data.len() / width, 1.0), data: data.to_vec() }
    }

    #[test]
    fn a_bowl_is_filled_to_its_lowest_rim() {
        #[rustfmt::skip]
        let bowl = raster(5, &[
            9.0, 9.0, 9.0, 9.0, 9.0,
            9.0, 2.0, 1.0, 3.0, 9.0,
            9.0, 5.0, 0.0, 4.0, 7.0,
            9.0, 9.0, 9.0, 9.0, 9.0,
        ]);
        let flooded = flood(&bowl, &Run::silent()).unwrap();
        for cell in [6, 7, 8, 11, 12, 13] {
            assert_eq!(flooded.level.data[cell], 7.0);
        }
        assert_eq!(flooded.level.data[14], 7.0);
        assert_eq!(flooded.level.data[0], 9.0);
    }

    #[test]
    fn a_hole_in_the_data_lets_the_water_out() {
        let mut data = vec![9.0; 25];
        data[12] = 1.0;
        let closed = flood(&raster(5, &data), &Run::silent()).unwrap();
        assert_eq!(closed.level.data[12], 9.0);
        data[13] = f32::NAN;
        let open = flood(&raster(5, &data), &Run::silent()).unwrap();
        assert_eq!(open.level.data[12], 1.0);
        assert!(open.level.data[13].is_nan());
        assert_eq!(open.way_out[13], UNREACHED);
    }

    #[test]
    fn a_plain_drains_to_its_nearest_border() {
        let plain = flood(&raster(9, &[3.0; 81]), &Run::silent()).unwrap();
        let compass = Compass::new(plain.level.grid);
        for start in 0..81usize {
            let (mut cell, mut steps) = (start, 0);
            while plain.way_out[cell] != OUTLET {
                cell = compass.step(cell, usize::from(plain.way_out[cell]));
                steps += 1;
            }
            let (column, row) = (start % 9, start / 9);
            assert_eq!(steps, column.min(row).min(8 - column).min(8 - row));
        }
    }

    #[test]
    fn nothing_at_all_and_one_cell_are_harmless() {
        assert_eq!(flood(&raster(2, &[f32::NAN; 4]), &Run::silent()).unwrap().way_out, vec![UNREACHED; 4]);
        assert_eq!(flood(&raster(1, &[3.0]), &Run::silent()).unwrap().level.data, vec![3.0]);
    }
}
