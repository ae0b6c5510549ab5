//! The eight directions to the neighbours of a cell, and their opposites.

use crate::compute::raster::Grid;

/// The eight steps to the neighbours of a cell, as (columns east, rows south), in the order of
/// [`Grid::neighbours`]: W E N S NW NE SW SE. A **direction** is an index in this table.
pub const STEPS: [(isize, isize); 8] = [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)];

/// Length of each step, in cells.
pub const LENGTHS: [f32; 8] = {
    const D: f32 = std::f32::consts::SQRT_2;
    [1.0, 1.0, 1.0, 1.0, D, D, D, D]
};

/// The direction back.
pub const fn opposite(direction: usize) -> usize {
    [1, 0, 3, 2, 7, 6, 5, 4][direction]
}

/// Walks from cell to cell by directions; quick where a cell is not at the border.
#[derive(Debug, Clone, Copy)]
pub struct Compass {
    grid: Grid,
    offsets: [isize; 8],
}

impl Compass {
    /// The compass of a grid.
    pub fn new(grid: Grid) -> Self {
        Self { grid, offsets: STEPS.map(|(dx, dy)| dy * grid.width as isize + dx) }
    }

    /// The neighbour in `direction` of a cell known to have one.
    pub fn step(&self, cell: usize, direction: usize) -> usize {
        cell.wrapping_add_signed(self.offsets[direction])
    }

    /// Whether the cell lies at the border of the grid.
    pub fn at_border(&self, cell: usize) -> bool {
        let (column, row) = self.place(cell);
        column == 0 || row == 0 || column + 1 == self.grid.width || row + 1 == self.grid.height
    }

    /// Calls `visit` with each direction that stays on the grid and the neighbour there.
    #[inline]
    pub fn around(&self, cell: usize, mut visit: impl FnMut(usize, usize)) {
        if !self.at_border(cell) {
            for direction in 0..8 {
                visit(direction, self.step(cell, direction));
            }
            return;
        }
        for (direction, (dx, dy)) in STEPS.into_iter().enumerate() {
            if let Some(neighbour) = self.grid.offset(cell, dx, dy) {
                visit(direction, neighbour);
            }
        }
    }

    /// Column and row; cells are numbered in 32 bits, whose division is much the quicker.
    #[inline]
    fn place(&self, cell: usize) -> (usize, usize) {
        let (cell, width) = (cell as u32, self.grid.width as u32);
        ((cell % width) as usize, (cell / width) as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_compass_agrees_with_the_grid() {
        for grid in [Grid::new(4, 3, 1.0), Grid::new(1, 5, 1.0), Grid::new(5, 1, 1.0)] {
            let compass = Compass::new(grid);
            for cell in 0..grid.len() {
                let mut seen = Vec::new();
                compass.around(cell, |d, n| seen.push((n, f64::from(LENGTHS[d]))));
                let expected: Vec<_> = grid.neighbours(cell).collect();
                assert_eq!(seen.len(), expected.len());
                assert!(seen.iter().zip(&expected).all(|(a, b)| a.0 == b.0 && (a.1 - b.1).abs() < 1e-6));
                compass.around(cell, |d, n| assert_eq!(compass.step(n, opposite(d)), cell));
            }
        }
    }
}
