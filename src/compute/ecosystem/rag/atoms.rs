use super::field::Field;
use crate::compute::ecosystem::regions::Regions;
use crate::compute::raster::Tiling;
use crate::compute::run::Run;
use crate::compute::run::Stopped;

/// Tiles that the map is cut into at most: what lies within a tile is not told apart.
const MOST_TILES: usize = 128 * 128;

/// What one group of a resource has in one tile of the map: the grain that nodes are made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Atom {
    pub(super) tile: u32,
    pub(super) group: u32,
    pub(super) cells: u32,
    pub(super) kg: f64,
    /// Sums of the columns and of the rows of its cells.
    pub(super) columns: f64,
    pub(super) rows: f64,
}

impl Atom {
    /// Mean column and row.
    pub(super) fn centre(&self) -> (f64, f64) {
        let n = f64::from(self.cells);
        (self.columns / n, self.rows / n)
    }
}

/// All atoms of a resource, by tile, then group.
#[derive(Debug, Clone)]
pub(super) struct Atoms {
    pub(super) tiles: Tiling,
    pub(super) atoms: Vec<Atom>,
    /// Index of the first atom of each tile, and the number of all at the end.
    pub(super) first: Vec<u32>,
}

impl Atoms {
    pub(super) fn gather(field: &Field<'_>, regions: &Regions, run: &Run) -> Result<Self, Stopped> {
        let grid = regions.grid();
        let tiles = Tiling::of_at_most(&grid, MOST_TILES, 0);
        let mut buffer = vec![0.0; grid.width];
        let (mut atoms, mut first) = (Vec::new(), vec![0]);
        for band in 0..tiles.rows {
            run.check()?;
            let mut of_tile: Vec<Vec<Atom>> = vec![Vec::new(); tiles.columns];
            for row in band << tiles.shift..((band + 1) << tiles.shift).min(grid.height) {
                field.visit_row(regions, row, &mut buffer, |column, _, group, kg| {
                    let tile = column >> tiles.shift;
                    let atom = atom_of(&mut of_tile[tile], (band * tiles.columns + tile) as u32, group);
                    atom.cells += 1;
                    atom.kg += kg;
                    atom.columns += column as f64;
                    atom.rows += row as f64;
                });
            }
            for mut tile in of_tile {
                tile.sort_unstable_by_key(|atom| atom.group);
                atoms.append(&mut tile);
                first.push(atoms.len() as u32);
            }
        }
        Ok(Self { tiles, atoms, first })
    }

    /// The atom of a group in a tile.
    pub(super) fn find(&self, tile: usize, group: u32) -> Option<usize> {
        let (from, to) = (self.first[tile] as usize, self.first[tile + 1] as usize);
        (from..to).find(|i| self.atoms[*i].group == group)
    }
}

/// The atom of `group` among those of a tile, made when it is missing.
fn atom_of(tile: &mut Vec<Atom>, number: u32, group: u32) -> &mut Atom {
    let at = tile.iter().position(|atom| atom.group == group).unwrap_or_else(|| {
        tile.push(Atom { tile: number, group, cells: 0, kg: 0.0, columns: 0.0, rows: 0.0 });
        tile.len() - 1
    });
    &mut tile[at]
}
