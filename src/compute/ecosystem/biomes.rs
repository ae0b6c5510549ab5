//! **Biomes**: plants grouped as the experts group them (T 5.7, figure 5.16; L 7.2).
//!
//! A biome's **density** in a cell is the sum of the covers of its species.

use crate::compute::ecosystem::flora::Flora;
use crate::compute::raster::Raster;
use rayon::prelude::*;

/// The value of a categorical biome map where no plant grows.
pub const NO_BIOME: u8 = u8::MAX;

/// The share of densest cells that the experts mark (T figure 5.16, L figure 8).
pub const DENSEST_SHARE: f64 = 0.05;

/// The density of one biome: the sum of the covers of the species that `of` puts in it.
pub fn density(flora: &Flora, of: &[usize], biome: usize) -> Raster<f32> {
    flora.total_map(|species| of.get(species) == Some(&biome))
}

/// The **dominant biome** of each cell: the one of greatest density, the first of equals,
/// [`NO_BIOME`] where nothing grows. `of` gives each species' biome, below 255.
pub fn dominant(flora: &Flora, of: &[usize]) -> Raster<u8> {
    let count = of.iter().map(|biome| biome + 1).max().unwrap_or(0).min(usize::from(NO_BIOME));
    let strongest = |cell: usize, sums: &mut Vec<u32>| {
        sums.fill(0);
        for (map, biome) in flora.covers.iter().zip(of) {
            if let Some(sum) = sums.get_mut(*biome) {
                *sum += u32::from(map.data[cell]);
            }
        }
        let (best, sum) = sums.iter().enumerate().fold((0, 0), |a, (i, s)| if *s > a.1 { (i, *s) } else { a });
        if sum > 0 { best as u8 } else { NO_BIOME }
    };
    let grid = flora.left_light.grid;
    let cells = (0..grid.len()).into_par_iter().with_min_len(4096);
    Raster { grid, data: cells.map_init(|| vec![0; count], |sums, cell| strongest(cell, sums)).collect() }
}

/// The `share` (0..=1) of the cells where `density` is highest, as a weight a cell: 1 above the
/// threshold, 0 below, and between cells that tie at the threshold the rest is shared evenly.
/// The weights sum to `share` of the cells that have data. Cells of zero density are no densest
/// cells, so that the sum is less where little grows.
pub fn densest(density: &Raster<f32>, share: f64) -> Raster<f32> {
    let mut values: Vec<f32> = density.data.iter().copied().filter(|v| !v.is_nan()).collect();
    let wanted = share.clamp(0.0, 1.0) * values.len() as f64;
    values.par_sort_unstable_by(|a, b| b.total_cmp(a));
    let last = values.get((wanted.ceil() as usize).saturating_sub(1)).copied().unwrap_or(f32::INFINITY);
    let above = values.partition_point(|v| *v > last);
    let tied = values.partition_point(|v| *v >= last) - above;
    let rest = ((wanted - above as f64) / tied.max(1) as f64).clamp(0.0, 1.0) as f32;
    density.map(|v| match v {
        v if !(v > 0.0) => 0.0,
        v if v > last => 1.0,
        v if v == last => rest,
        _ => 0.0,
    })
}

/// **Intersection over union** of two masks (L 7.2); `None` when both are empty or their sizes
/// differ.
pub fn intersection_over_union(ours: &Raster<bool>, theirs: &Raster<bool>) -> Option<f64> {
    if ours.data.len() != theirs.data.len() {
        return None;
    }
    let count = |f: fn(bool, bool) -> bool| ours.data.iter().zip(&theirs.data).filter(|(a, b)| f(**a, **b)).count();
    let (both, either) = (count(|a, b| a && b), count(|a, b| a || b));
    (either > 0).then(|| both as f64 / either as f64)
}

/// How well a map of dominant biomes agrees with an expert's: intersection over union for each
/// of `count` biomes, over the cells that the expert marked with any biome.
pub fn agreement(ours: &Raster<u8>, expert: &Raster<u8>, count: usize) -> Vec<Option<f64>> {
    let mask = |map: &Raster<u8>, biome: usize| {
        let marked = map.data.iter().zip(&expert.data).map(|(v, e)| usize::from(*v) == biome && *e != NO_BIOME);
        Raster { grid: map.grid, data: marked.collect() }
    };
    (0..count).map(|biome| intersection_over_union(&mask(ours, biome), &mask(expert, biome))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::raster::Grid;

    fn map<T: Copy>(data: &[T]) -> Raster<T> {
        Raster { grid: Grid::new(data.len(), 1, 1.0), data: data.to_vec() }
    }

    #[test]
    fn cells_that_tie_at_the_threshold_share_its_weight() {
        let weights = densest(&map(&[3.0, 2.0, 2.0, 2.0, 1.0, 0.0, 0.0, 0.0, f32::NAN, 0.5]), 0.2);
        let expected = [1.0, 0.8 / 3.0, 0.8 / 3.0, 0.8 / 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        for (w, e) in weights.data.iter().zip(expected) {
            assert!((w - e as f32).abs() < 1e-6, "{:?}", weights.data);
        }
    }

    #[test]
    fn bare_ground_is_never_among_the_densest() {
        assert_eq!(densest(&map(&[0.0, 0.0, 1.0, 0.0]), 0.5).data, [0.0, 0.0, 1.0, 0.0]);
        assert_eq!(densest(&map(&[0.0; 4]), 0.5).data, [0.0; 4]);
        assert_eq!(densest(&map::<f32>(&[f32::NAN]), 0.5).data, [0.0]);
    }

    #[test]
    fn agreement_is_one_with_itself_and_a_third_when_half_is_shifted() {
        let ours = map(&[0_u8, 0, 1, 1, NO_BIOME]);
        assert_eq!(agreement(&ours, &ours, 3), [Some(1.0), Some(1.0), None]);
        let expert = map(&[0_u8, 1, 1, 0, 1]);
        let found = agreement(&ours, &expert, 2);
        assert!((found[0].unwrap() - 1.0 / 3.0).abs() < 1e-12);
        assert!((found[1].unwrap() - 0.25).abs() < 1e-12);
    }
}
