use crate::compute::raster::Grid;

const ABSENT: u32 = u32::MAX;

/// Square **tiles** of 2^shift × 2^shift cells that cover a grid; those at the east and south
/// borders stick out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Tiling {
    pub(super) shift: u32,
    pub(super) columns: usize,
    pub(super) rows: usize,
}

impl Tiling {
    pub(super) fn new(grid: &Grid, shift: u32) -> Self {
        let up = |n: usize| (n + (1 << shift) - 1) >> shift;
        Self { shift, columns: up(grid.width), rows: up(grid.height) }
    }

    pub(super) fn len(&self) -> usize {
        self.columns * self.rows
    }

    pub(super) fn tile_at(&self, x: usize, y: usize) -> usize {
        (y >> self.shift) * self.columns + (x >> self.shift)
    }

    /// The tile and up to eight around it.
    pub(super) fn around(&self, tile: usize) -> impl Iterator<Item = usize> + '_ {
        let (column, row) = (tile % self.columns, tile / self.columns);
        let rows = row.saturating_sub(1)..(row + 2).min(self.rows);
        let columns = column.saturating_sub(1)..(column + 2).min(self.columns);
        rows.flat_map(move |r| columns.clone().map(move |c| r * self.columns + c))
    }
}

/// Some of the tiles of a grid, with their cells numbered from 0 so that a search needs memory
/// for these alone.
#[derive(Debug, Clone)]
pub(super) struct Corridor {
    tiling: Tiling,
    width: usize,
    height: usize,
    slot: Vec<u32>,
    tiles: Vec<u32>,
}

impl Corridor {
    pub(super) fn new(grid: &Grid, tiling: Tiling, tiles: impl IntoIterator<Item = usize>) -> Self {
        let mut corridor = Self {
            tiling,
            width: grid.width,
            height: grid.height,
            slot: vec![ABSENT; tiling.len()],
            tiles: Vec::new(),
        };
        for tile in tiles {
            if corridor.slot[tile] == ABSENT {
                corridor.slot[tile] = corridor.tiles.len() as u32;
                corridor.tiles.push(tile as u32);
            }
        }
        corridor
    }

    /// Numbers given out, some of them to cells that stick out of the map.
    pub(super) fn len(&self) -> usize {
        self.tiles.len() << (2 * self.tiling.shift)
    }

    /// The number of the cell in this column and row.
    pub(super) fn number(&self, x: usize, y: usize) -> Option<usize> {
        if x >= self.width || y >= self.height {
            return None;
        }
        let slot = self.slot[self.tiling.tile_at(x, y)];
        let (shift, mask) = (self.tiling.shift, (1usize << self.tiling.shift) - 1);
        (slot != ABSENT).then(|| (slot as usize) << (2 * shift) | (y & mask) << shift | (x & mask))
    }

    /// Column and row of the cell with this number.
    pub(super) fn place(&self, number: usize) -> (usize, usize) {
        let (shift, mask) = (self.tiling.shift, (1usize << self.tiling.shift) - 1);
        let tile = self.tiles[number >> (2 * shift)] as usize;
        let (column, row) = (tile % self.tiling.columns, tile / self.tiling.columns);
        (column << shift | (number & mask), row << shift | (number >> shift & mask))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_places_are_inverse_and_cells_outside_have_none() {
        let grid = Grid::new(21, 10, 1.0);
        let tiling = Tiling::new(&grid, 2);
        assert_eq!((tiling.columns, tiling.rows), (6, 3));
        let corridor = Corridor::new(&grid, tiling, [3, 0, 17, 3]);
        let named: Vec<usize> = (0..grid.len()).filter_map(|i| corridor.number(i % 21, i / 21)).collect();
        assert_eq!(named.len(), 16 + 16 + 2, "the last tile holds one column and two rows");
        for i in 0..grid.len() {
            if let Some(n) = corridor.number(i % 21, i / 21) {
                assert_eq!(corridor.place(n), (i % 21, i / 21));
            }
        }
        assert_eq!(corridor.number(21, 0), None);
        assert_eq!(tiling.around(0).count(), 4);
        assert_eq!(tiling.around(7).count(), 9);
    }
}
