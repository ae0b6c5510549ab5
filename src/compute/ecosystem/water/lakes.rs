//! **Lakes**: depressions of the terrain that are deep and large enough to be more than errors of
//! the height map.

use crate::compute::ecosystem::water::depressions;
use crate::compute::ecosystem::water::flood::Flooded;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;

/// What counts as a lake.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LakeRule {
    /// The deepest place of a lake is at least so deep, m.
    pub min_depth_m: f32,
    /// A lake covers at least so much, m².
    pub min_area_m2: f64,
}

impl Default for LakeRule {
    /// 2 m and 1 ha (ours): above the usual vertical error of global height maps.
    fn default() -> Self {
        Self { min_depth_m: 2.0, min_area_m2: 10_000.0 }
    }
}

/// Depth of the lakes in m, 0 elsewhere: the depressions of `height` that meet `rule`, full to
/// their outlet.
pub fn lakes(height: &Raster<f32>, flooded: &Flooded, rule: LakeRule, run: &Run) -> Result<Raster<f32>, Stopped> {
    let cell_area_m2 = height.grid.cell_area_m2();
    let mut depth = Raster::filled(height.grid, 0.0f32);
    depressions::each(height, flooded, run, |lake| {
        if lake.depth_m >= rule.min_depth_m && lake.cells.len() as f64 * cell_area_m2 >= rule.min_area_m2 {
            lake.cells.iter().for_each(|c| depth.data[*c] = flooded.level.data[*c] - height.data[*c]);
        }
    })?;
    Ok(depth)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::ecosystem::water::flood::flood;
    use crate::compute::raster::Grid;

    #[test]
    fn only_deep_and_large_depressions_are_lakes() {
        let grid = Grid::new(30, 10, 10.0);
        let mut height = Raster::filled(grid, 50.0f32);
        let mut dig = |columns: std::ops::Range<usize>, depth: f32| {
            for column in columns {
                for row in 3..6 {
                    height.data[grid.index(column, row)] -= depth;
                }
            }
        };
        dig(2..8, 3.0); // 18 cells, deep: a lake
        dig(12..18, 0.5); // as large, shallow
        dig(22..24, 9.0); // deep, small
        let flooded = flood(&height, &Run::silent()).unwrap();
        let rule = LakeRule { min_depth_m: 1.0, min_area_m2: 1500.0 };
        let depth = lakes(&height, &flooded, rule, &Run::silent()).unwrap();
        let wet: Vec<usize> = (0..grid.len()).filter(|c| depth.data[*c] > 0.0).collect();
        assert_eq!(wet.len(), 18);
        assert!(wet.iter().all(|c| depth.data[*c] == 3.0 && (2..8).contains(&grid.cell(*c).column)));
    }
}
