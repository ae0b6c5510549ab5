use super::Grid;

/// Square **tiles** of 2^shift × 2^shift cells that cover a grid, numbered row-major from the
/// north-west; those at the east and south borders stick out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tiling {
    /// The side of a tile is 2^shift cells.
    pub shift: u32,
    /// Tiles from west to east.
    pub columns: usize,
    /// Tiles from north to south.
    pub rows: usize,
}

impl Tiling {
    /// The tiles of this size; `shift` is at most 31.
    pub fn new(grid: &Grid, shift: u32) -> Self {
        Self { shift, columns: grid.width.div_ceil(1 << shift), rows: grid.height.div_ceil(1 << shift) }
    }

    /// The smallest tiles, of side 2^`least` or more, of which there are at most `most` (at least
    /// 1 is taken).
    pub fn of_at_most(grid: &Grid, most: usize, least: u32) -> Self {
        (least..31).map(|shift| Self::new(grid, shift)).find(|t| t.len() <= most.max(1)).unwrap_or(Self::new(grid, 31))
    }

    /// Number of tiles.
    pub const fn len(&self) -> usize {
        self.columns * self.rows
    }

    /// Whether there are no tiles.
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Cells on a side.
    pub const fn side(&self) -> usize {
        1 << self.shift
    }

    /// The tile that holds the cell in this column and row.
    pub const fn at(&self, column: usize, row: usize) -> usize {
        (row >> self.shift) * self.columns + (column >> self.shift)
    }

    /// The tile and up to eight around it, in row-major order.
    pub fn around(&self, tile: usize) -> impl Iterator<Item = usize> + use<> {
        let (column, row, all) = (tile % self.columns, tile / self.columns, self.columns);
        let rows = row.saturating_sub(1)..(row + 2).min(self.rows);
        let columns = column.saturating_sub(1)..(column + 2).min(self.columns);
        rows.flat_map(move |r| columns.clone().map(move |c| r * all + c))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_the_grid_and_have_up_to_eight_neighbours() {
        let grid = Grid::new(21, 10, 1.0);
        let tiling = Tiling::new(&grid, 2);
        assert_eq!((tiling.columns, tiling.rows, tiling.side()), (6, 3, 4));
        assert_eq!((tiling.at(0, 0), tiling.at(20, 9)), (0, 17));
        assert_eq!((tiling.around(0).count(), tiling.around(7).count(), tiling.around(17).count()), (4, 9, 4));
    }

    #[test]
    fn the_smallest_tiles_that_are_few_enough_are_found() {
        let grid = Grid::new(100, 100, 1.0);
        assert_eq!(Tiling::of_at_most(&grid, 10_000, 0).shift, 0);
        assert_eq!(Tiling::of_at_most(&grid, 9_999, 0).shift, 1);
        assert_eq!(Tiling::of_at_most(&grid, 1, 0).len(), 1);
        assert_eq!(Tiling::of_at_most(&grid, 10_000, 2).shift, 2);
    }
}
