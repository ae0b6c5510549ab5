//! The unevenness that no map shows.

use crate::compute::random::Purpose;
use crate::compute::random::hash2;
use crate::compute::random::unit;
use crate::compute::raster::Cell;
use crate::compute::raster::Grid;

const ROUGHNESS: Purpose = Purpose::new("trails.roughness");

/// Wavelengths, in cells, and their shares (ours).
const WAVES: [(f64, f64); 3] = [(60.0, 0.5), (24.0, 0.3), (9.0, 0.2)];

/// **Value noise** in 0..=1 over the cells of a grid: a function of the seed and the cell.
pub(crate) struct Unevenness {
    octaves: [Octave; WAVES.len()],
}

/// Random numbers at the corners of a square lattice.
struct Octave {
    length: f64,
    share: f64,
    columns: usize,
    corners: Vec<f32>,
}

impl Unevenness {
    pub(crate) fn new(grid: &Grid, seed: u64) -> Self {
        let octave = |(length, share): (f64, f64)| {
            let columns = (grid.width as f64 / length) as usize + 2;
            let rows = (grid.height as f64 / length) as usize + 2;
            let corner = |i: usize| unit(hash2(seed, ROUGHNESS, (i % columns) as u64, (i / columns) as u64)) as f32;
            Octave { length, share, columns, corners: (0..columns * rows).map(corner).collect() }
        };
        Self { octaves: WAVES.map(octave) }
    }

    pub(crate) fn at(&self, cell: Cell) -> f64 {
        self.octaves.iter().map(|octave| octave.share * octave.at(cell)).sum()
    }
}

impl Octave {
    fn at(&self, cell: Cell) -> f64 {
        let (x, y) = (cell.column as f64 / self.length, cell.row as f64 / self.length);
        let (column, row) = (x as usize, y as usize);
        let corner = |dx: usize, dy: usize| f64::from(self.corners[(row + dy) * self.columns + column + dx]);
        let ease = |t: f64| t * t * (3.0 - 2.0 * t);
        let (u, v) = (ease(x - column as f64), ease(y - row as f64));
        let north = corner(0, 0) + u * (corner(1, 0) - corner(0, 0));
        let south = corner(0, 1) + u * (corner(1, 1) - corner(0, 1));
        north + v * (south - north)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unevenness_is_smooth_within_its_limits_and_differs_by_seed() {
        let grid = Grid::new(200, 130, 1.0);
        let (first, other) = (Unevenness::new(&grid, 1), Unevenness::new(&grid, 2));
        let mut apart = 0.0f64;
        for cell in 0..grid.len() {
            let at = grid.cell(cell);
            let here = first.at(at);
            assert!((0.0..=1.0).contains(&here));
            apart = apart.max((here - other.at(at)).abs());
            if at.column + 1 < grid.width {
                let next = first.at(Cell { column: at.column + 1, ..at });
                assert!((next - here).abs() < 0.06, "{here} {next}");
            }
        }
        assert!(apart > 0.2);
    }
}
