//! The **depressions** of a terrain: where the filled level lies above the ground.

use crate::compute::ecosystem::water::flood::Flooded;
use crate::compute::raster::Raster;
use crate::compute::raster::compass::Compass;
use crate::compute::run::Run;
use crate::compute::run::Stopped;

/// Connected cells (over the eight neighbours) that fill to one level.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Depression {
    /// The cells, in the order in which a search from the first finds them.
    pub cells: Vec<usize>,
    /// The cell that lies lowest; the first of equals.
    pub lowest: usize,
    /// Depth there, m.
    pub depth_m: f32,
}

/// Shows `visit` each depression of `height` in the order of their first cells.
pub fn each(
    height: &Raster<f32>,
    flooded: &Flooded,
    run: &Run,
    mut visit: impl FnMut(&Depression),
) -> Result<(), Stopped> {
    let level = &flooded.level.data;
    let below = |cell: usize| level[cell] > height.data[cell];
    let compass = Compass::new(height.grid);
    let mut seen = vec![false; level.len()];
    let mut depression = Depression::default();
    for start in 0..level.len() {
        if start.is_multiple_of(1 << 16) {
            run.check()?;
        }
        if seen[start] || !below(start) {
            continue;
        }
        let cells = &mut depression.cells;
        cells.clear();
        cells.push(start);
        seen[start] = true;
        let mut next = 0;
        while next < cells.len() {
            compass.around(cells[next], |_, n| {
                if !seen[n] && below(n) && level[n] == level[start] {
                    seen[n] = true;
                    cells.push(n);
                }
            });
            next += 1;
        }
        let lower = |a: usize, b: usize| if height.data[b] < height.data[a] { b } else { a };
        depression.lowest = depression.cells.iter().copied().fold(start, lower);
        depression.depth_m = level[start] - height.data[depression.lowest];
        visit(&depression);
    }
    Ok(())
}
