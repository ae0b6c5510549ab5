//! What trails and plannings ask of the stage that knows how animals travel.

use crate::compute::run::Run;
use crate::compute::run::Stopped;

/// A way over the terrain from one cell to another.
#[derive(Debug, Clone, PartialEq)]
pub struct Way {
    /// The cells in the order they are passed, both ends included; each is one of the eight
    /// neighbours of the one before.
    pub cells: Vec<u32>,
    /// Travel time, seconds.
    pub seconds: f64,
}

/// The eight neighbours of a cell as (columns east, rows south), in the order of
/// [`crate::compute::raster::Grid::neighbours`].
pub const AROUND: [(isize, isize); 8] = [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)];

/// Where each animal species can walk and how long it takes (L 5.1, 5.2).
///
/// `species` is the index of the animal species, cells are row-major indices of the terrain.
pub trait Ways: Sync {
    /// The quickest way from `from` to each of `to`, in that order; `None` where there is none.
    /// Asked source by source, so that one search can serve all targets.
    fn ways(&self, species: usize, from: usize, to: &[usize], run: &Run) -> Result<Vec<Option<Way>>, Stopped>;

    /// Travel time from `from` to each of `to`, seconds; infinite where there is no way. For when
    /// the course of the ways is not wanted.
    fn times_s(&self, species: usize, from: usize, to: &[usize], run: &Run) -> Result<Vec<f64>, Stopped> {
        let ways = self.ways(species, from, to, run)?;
        Ok(ways.into_iter().map(|way| way.map_or(f64::INFINITY, |way| way.seconds)).collect())
    }

    /// Seconds from a cell to one of its eight neighbours; infinite where the step is too steep
    /// or either cell is closed to the species.
    fn step_s(&self, species: usize, from: usize, to: usize) -> f64;

    /// [`Ways::step_s`] from a cell to the neighbours `to` (in the order of [`AROUND`], `None` off
    /// the map) and back, all at once.
    fn steps_s(&self, species: usize, from: usize, to: &[Option<usize>; 8]) -> [(f64, f64); 8] {
        to.map(|to| match to {
            Some(to) => (self.step_s(species, from, to), self.step_s(species, to, from)),
            None => (f64::INFINITY, f64::INFINITY),
        })
    }

    /// Whether the species can stand on the cell.
    fn open(&self, species: usize, cell: usize) -> bool;
}

#[cfg(test)]
pub(crate) mod sample {
    //! Flat ground with closed cells, walked at 1 m/s: ways whose answer is known.

    use super::{Way, Ways};
    use crate::compute::raster::Grid;
    use crate::compute::run::{Run, Stopped};
    use std::cmp::Reverse;
    use std::collections::BinaryHeap;

    pub(crate) struct Plain {
        pub(crate) grid: Grid,
        pub(crate) closed: Vec<bool>,
    }

    impl Plain {
        pub(crate) fn new(width: usize, height: usize, cell_m: f64) -> Self {
            let grid = Grid::new(width, height, cell_m);
            Self { grid, closed: vec![false; grid.len()] }
        }

        /// Closes a column but for one row: a river with a ford.
        pub(crate) fn with_river(mut self, column: usize, ford: usize) -> Self {
            for row in (0..self.grid.height).filter(|row| *row != ford) {
                let i = self.grid.index(column, row);
                self.closed[i] = true;
            }
            self
        }
    }

    impl Ways for Plain {
        fn ways(&self, species: usize, from: usize, to: &[usize], run: &Run) -> Result<Vec<Option<Way>>, Stopped> {
            run.check()?;
            let mut best = vec![f64::INFINITY; self.grid.len()];
            let mut before = vec![usize::MAX; self.grid.len()];
            let mut queue = BinaryHeap::from([Reverse((0u64, from))]);
            best[from] = 0.0;
            while let Some(Reverse((bits, cell))) = queue.pop() {
                if f64::from_bits(bits) > best[cell] {
                    continue;
                }
                for (next, _) in self.grid.neighbours(cell) {
                    let reached = best[cell] + self.step_s(species, cell, next);
                    if reached < best[next] {
                        (best[next], before[next]) = (reached, cell);
                        queue.push(Reverse((reached.to_bits(), next)));
                    }
                }
            }
            Ok(to.iter().map(|&goal| trace(&before, from, goal, best[goal])).collect())
        }

        fn step_s(&self, _: usize, from: usize, to: usize) -> f64 {
            let free = !self.closed[from] && !self.closed[to];
            if free { self.grid.centre(from).distance(self.grid.centre(to)) } else { f64::INFINITY }
        }

        fn open(&self, _: usize, cell: usize) -> bool {
            !self.closed[cell]
        }
    }

    fn trace(before: &[usize], from: usize, goal: usize, seconds: f64) -> Option<Way> {
        if !seconds.is_finite() {
            return None;
        }
        let mut cells = vec![goal as u32];
        let mut cell = goal;
        while cell != from {
            cell = before[cell];
            cells.push(cell as u32);
        }
        cells.reverse();
        Some(Way { cells, seconds })
    }
}
