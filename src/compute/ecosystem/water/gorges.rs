//! **Breaching** of depressions behind gorges that are narrower than a cell.
//!
//! On a coarse height map a river's way through a ridge closes, and the valley above it would
//! fill to a lake that is not there. J. B. Lindsay and I. F. Creed ("Removal of artifact
//! depressions from digital elevation models: towards a minimum impact approach", Hydrological
//! Processes 19, 2005): cut a trench through the barrier where that changes the terrain less than
//! filling the depression does.

use crate::compute::ecosystem::water::depressions;
use crate::compute::ecosystem::water::depressions::Depression;
use crate::compute::ecosystem::water::flood::Flooded;
use crate::compute::ecosystem::water::flood::OUTLET;
use crate::compute::raster::Raster;
use crate::compute::raster::compass::Compass;
use crate::compute::run::Run;
use crate::compute::run::Stopped;

/// Which barriers are taken for gorges that the map does not show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GorgeRule {
    /// Smallest cells of a map that may hide gorges, m.
    pub min_cell_m: f64,
    /// The longest barrier cut through, in cells of the depression's full depth: a barrier half
    /// as high above the bottom may be twice as long.
    pub max_length_cells: f64,
}

impl Default for GorgeRule {
    /// Cells of 10 m, barriers of 20 cells (ours).
    fn default() -> Self {
        Self { min_cell_m: 10.0, max_length_cells: 20.0 }
    }
}

/// `height` with a trench through every barrier that `rule` takes for a gorge; `None` when there
/// is none. Trenches run from the lowest cell of a depression along its way out, as deep as that
/// cell, down to the first cell below it.
pub fn breached(
    height: &Raster<f32>,
    flooded: &Flooded,
    rule: GorgeRule,
    run: &Run,
) -> Result<Option<Raster<f32>>, Stopped> {
    if height.grid.cell_m < rule.min_cell_m {
        return Ok(None);
    }
    let mut cut: Option<Raster<f32>> = None;
    depressions::each(height, flooded, run, |depression| {
        if let Some(trench) = trench(height, flooded, depression, rule.max_length_cells) {
            let bottom = height.data[depression.lowest];
            let cut = cut.get_or_insert_with(|| height.clone());
            trench.into_iter().for_each(|cell| cut.data[cell] = cut.data[cell].min(bottom));
        }
    })?;
    Ok(cut)
}

/// The cells to cut so that `depression` drains, if that moves less ground than filling it and
/// its barrier is short enough.
fn trench(height: &Raster<f32>, flooded: &Flooded, depression: &Depression, max_length: f64) -> Option<Vec<usize>> {
    let compass = Compass::new(height.grid);
    let level = flooded.level.data[depression.lowest];
    let bottom = height.data[depression.lowest];
    let fill: f64 = depression.cells.iter().map(|c| f64::from(level - height.data[*c])).sum();
    let (mut dug, mut barrier) = (0.0, 0.0);
    let mut cells = Vec::new();
    let mut cell = depression.lowest;
    // Each step leads to a cell that the flood passed earlier, so the walk ends.
    while flooded.way_out[cell] < OUTLET {
        cell = compass.step(cell, usize::from(flooded.way_out[cell]));
        let above = f64::from(height.data[cell] - bottom);
        if above < 0.0 {
            break;
        }
        dug += above;
        let in_depression = flooded.level.data[cell] == level && height.data[cell] < level;
        barrier += if in_depression { 0.0 } else { above / f64::from(depression.depth_m) };
        if dug >= fill || barrier > max_length {
            return None;
        }
        cells.push(cell);
    }
    Some(cells)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::ecosystem::water::flood::flood;
    use crate::compute::raster::Grid;

    /// A valley open to the west, with a ridge of `thick` columns across it.
    fn dammed(thick: usize, cell_m: f64) -> (Raster<f32>, Flooded) {
        let grid = Grid::new(60, 9, cell_m);
        let height = |i: usize| {
            let cell = grid.cell(i);
            let ridge = if (20..20 + thick).contains(&cell.column) { 20.0 } else { 0.0 };
            let rim = if cell.row.is_multiple_of(8) || cell.column == 59 { 100.0 } else { 0.0 };
            0.2 * cell.column as f32 + 5.0 * cell.row.abs_diff(4) as f32 + ridge + rim
        };
        let height = Raster { grid, data: (0..grid.len()).map(height).collect() };
        let flooded = flood(&height, &Run::silent()).unwrap();
        (height, flooded)
    }

    #[test]
    fn a_thin_barrier_is_cut_and_a_thick_one_dams_a_lake() {
        for (thick, opens) in [(2, true), (25, false)] {
            let (height, flooded) = dammed(thick, 90.0);
            let cut = breached(&height, &flooded, GorgeRule::default(), &Run::silent()).unwrap();
            assert_eq!(cut.is_some(), opens, "{thick}");
            if let Some(cut) = cut {
                let open = flood(&cut, &Run::silent()).unwrap();
                let behind = height.grid.index(30, 4);
                assert!(open.level.data[behind] < flooded.level.data[behind] - 5.0);
                assert_eq!(open.level.data[behind], height.data[behind]);
            }
        }
    }

    #[test]
    fn a_fine_map_shows_its_gorges_itself() {
        let (height, flooded) = dammed(2, 1.0);
        assert_eq!(breached(&height, &flooded, GorgeRule::default(), &Run::silent()).unwrap(), None);
    }
}
