use crate::compute::raster::Grid;
use crate::compute::raster::Tiling;

const ABSENT: u32 = u32::MAX;

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
        let slot = self.slot[self.tiling.at(x, y)];
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
        let corridor = Corridor::new(&grid, tiling, [3, 0, 17, 3]);
        let named: Vec<usize> = (0..grid.len()).filter_map(|i| corridor.number(i % 21, i / 21)).collect();
        assert_eq!(named.len(), 16 + 16 + 2, "the last tile holds one column and two rows");
        for i in 0..grid.len() {
            if let Some(n) = corridor.number(i % 21, i / 21) {
                assert_eq!(corridor.place(n), (i % 21, i / 21));
            }
        }
        assert_eq!(corridor.number(21, 0), None);
    }
}
