//! The cells of a block by their distance from its edges: seams to other blocks and the border of
//! the domain. Elements see fewer others there, so darts fail less often, which must not draw them
//! there.

use super::patch::Patch;
use crate::compute::geometry::Point;
use crate::compute::random::Stream;

/// Where strata of cells begin, in r_max from the edges of a block (ours).
const EDGES: [f64; 6] = [0.5, 1.0, 1.5, 2.5, 4.0, 6.0];

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
        let edges: &[f64] = if patch.sampler.is_undivided() { &[] } else { &EDGES };
        let mut strata = Self { of_cell: Vec::new(), cells: vec![Vec::new(); edges.len() + 1] };
        let mut before = 0.0;
        for (number, cell) in patch.block.cells().iter().enumerate() {
            let depth = depth(patch, patch.sampler.circle_around(cell).0) / patch.scene.unit;
            let stratum = edges.iter().filter(|edge| depth >= **edge).count();
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
