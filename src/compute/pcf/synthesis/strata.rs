//! The cells of a block by where darts may fail more or less often than elsewhere, which must not
//! change the density: by their distance from the edges of the block, seams to other blocks and the
//! border of the domain, where elements see fewer others; and by tiles as large as the exemplar, of
//! which its curves say nothing.

use super::patch::Patch;
use crate::compute::geometry::Point;
use crate::compute::random::Stream;

/// Where strata of cells begin, in r_max from the edges of a block (ours).
const EDGES: [f64; 6] = [0.5, 1.0, 1.5, 2.5, 4.0, 6.0];

/// The most tiles along a side of a block.
const MOST_TILES: usize = 64;

/// The strata of one block.
pub(super) struct Strata {
    /// The stratum of every cell.
    of_cell: Vec<usize>,
    /// For each stratum its cells, and Σ of the density over them up to each.
    cells: Vec<Vec<(usize, f64)>>,
}

impl Strata {
    /// Of the block of `patch`; of one that is all of the room one stratum, as its elements settle
    /// along the border by themselves.
    pub(super) fn of_block(patch: &Patch<'_>) -> Self {
        let is_undivided = patch.sampler.is_undivided();
        let edges: &[f64] = if is_undivided { &[] } else { &EDGES };
        let tiles = if is_undivided { (1, 1) } else { tiles(patch) };
        let count = (edges.len() + 1) * tiles.0 * tiles.1;
        let mut strata = Self { of_cell: Vec::new(), cells: vec![Vec::new(); count] };
        let mut before = 0.0;
        for (number, cell) in patch.block.cells().iter().enumerate() {
            let middle = patch.sampler.circle_around(cell).0;
            let depth = depth(patch, middle) / patch.scene.unit;
            let from_edge = edges.iter().filter(|edge| depth >= **edge).count();
            let stratum = from_edge * tiles.0 * tiles.1 + tile(patch, middle, tiles);
            let all = strata.cells[stratum].last().map_or(0.0, |(_, all)| *all);
            strata.cells[stratum].push((number, all + cell.up_to() - before));
            strata.of_cell.push(stratum);
            before = cell.up_to();
        }
        strata
    }

    /// The stratum of a cell of the block.
    pub(super) fn of(&self, cell: usize) -> usize {
        self.of_cell[cell]
    }

    /// The number of a cell of a stratum that has any, drawn by the density.
    pub(super) fn draw_cell(&self, stratum: usize, random: &mut Stream) -> usize {
        let cells = &self.cells[stratum];
        let at = random.unit() * cells.last().map_or(0.0, |(_, all)| *all);
        let found = cells.partition_point(|(_, up_to)| *up_to <= at).min(cells.len().saturating_sub(1));
        cells.get(found).map_or(0, |(cell, _)| *cell)
    }
}

/// Distance of `p` to the edges of the block, in metres, at most as far as the last stratum begins.
fn depth(patch: &Patch<'_>, p: Point) -> f64 {
    let bounds = patch.block.bounds;
    let (x, y) = ((p.x - bounds.min.x).min(bounds.max.x - p.x), (p.y - bounds.min.y).min(bounds.max.y - p.y));
    let farthest = EDGES.last().map_or(0.0, |edge| edge * patch.scene.unit);
    patch.scene.domain.clearance(p, farthest).min(x).min(y)
}

/// Columns and rows of the tiles of a block.
fn tiles(patch: &Patch<'_>) -> (usize, usize) {
    let side = patch.scene.exemplar_side * patch.scene.unit;
    let across = |extent: f64| ((extent / side).round() as usize).clamp(1, MOST_TILES);
    (across(patch.block.bounds.width()), across(patch.block.bounds.height()))
}

/// The number of the tile that holds `p`.
fn tile(patch: &Patch<'_>, p: Point, (columns, rows): (usize, usize)) -> usize {
    let bounds = patch.block.bounds;
    let at =
        |offset: f64, extent: f64, count: usize| ((offset / extent * count as f64).max(0.0) as usize).min(count - 1);
    at(p.y - bounds.min.y, bounds.height(), rows) * columns + at(p.x - bounds.min.x, bounds.width(), columns)
}
