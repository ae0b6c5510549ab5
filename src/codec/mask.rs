//! Painted rasters: masks, densities and other maps that belong to a terrain.

use crate::codec::sheet::RasterError;
use crate::codec::sheet::Sheet;
use crate::compute::raster::Grid;
use crate::compute::raster::Raster;

/// How a raster of another size than the terrain is met.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Fit {
    /// It is refused.
    #[default]
    Exact,
    /// It is stretched over the terrain: bilinear for weights and values.
    Stretched,
}

/// The sheet as weights from 0 to 1 on the cells of `grid`; cells without data weigh 0.
///
/// Unsigned integers stand for shares of their highest value (255, 65,535), unless none is above
/// 1: then they are weights already, as in the masks of geographic information systems. Other
/// numbers must lie between 0 and 1.
///
/// # Errors
/// [`RasterError::SizeMismatch`], [`RasterError::OutOfRange`], [`RasterError::Infinite`].
pub fn weights(sheet: Sheet, grid: &Grid, fit: Fit) -> Result<Raster<f32>, RasterError> {
    let highest = sheet.values.iter().copied().fold(0.0, f32::max);
    let one = match sheet.levels {
        Some(levels) if highest > 1.0 => levels as f32,
        _ => 1.0,
    };
    let outside = sheet.values.iter().find(|v| !v.is_nan() && !(0.0..=1.0).contains(&(**v / one)));
    if let Some(found) = outside {
        return Err(RasterError::OutOfRange { min: 0.0, max: 1.0, found: f64::from(*found) });
    }
    let mut raster = values(sheet, grid, fit)?;
    raster.data.iter_mut().for_each(|v| *v = if v.is_nan() { 0.0 } else { *v / one });
    Ok(raster)
}

/// The sheet's own values on the cells of `grid`; NaN where there is no data.
///
/// # Errors
/// [`RasterError::SizeMismatch`], [`RasterError::Infinite`].
pub fn values(sheet: Sheet, grid: &Grid, fit: Fit) -> Result<Raster<f32>, RasterError> {
    let sheet = sheet.north_up();
    sheet.check_finite()?;
    let (expected, found) = ((grid.width, grid.height), (sheet.width, sheet.height));
    if expected == found {
        return Ok(Raster { grid: *grid, data: sheet.values });
    }
    match fit {
        Fit::Exact => Err(RasterError::SizeMismatch { expected, found }),
        Fit::Stretched => Ok(stretched(&sheet, *grid)),
    }
}

/// Every cell by the place of its centre within the whole.
fn stretched(sheet: &Sheet, grid: Grid) -> Raster<f32> {
    let scale = |n: usize, of: usize, i: usize| (i as f64 + 0.5) * n as f64 / of as f64;
    let cells = (0..grid.len()).map(|i| {
        let cell = grid.cell(i);
        sheet.bilinear(scale(sheet.width, grid.width, cell.column), scale(sheet.height, grid.height, cell.row))
    });
    Raster { grid, data: cells.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::sheet::SheetOptions;
    use crate::codec::sheet::geotiff::tests::tiff;
    use crate::codec::sheet::png::tests::png;
    use png::BitDepth;
    use png::ColorType;

    fn grey(size: (u32, u32), data: &[u8]) -> Sheet {
        Sheet::read(&png(size, ColorType::Grayscale, BitDepth::Eight, data), &SheetOptions::default()).unwrap()
    }

    #[test]
    fn levels_are_shares_of_the_highest_and_zeros_and_ones_are_weights() {
        let grid = Grid::new(3, 1, 2.0);
        assert_eq!(weights(grey((3, 1), &[0, 51, 255]), &grid, Fit::Exact).unwrap().data, [0.0, 0.2, 1.0]);
        assert_eq!(weights(grey((3, 1), &[0, 1, 1]), &grid, Fit::Exact).unwrap().data, [0.0, 1.0, 1.0]);
        let bytes = tiff((3, 1), (1, 8), &[0, 255, 51], Vec::new(), false);
        let sheet = Sheet::read(&bytes, &SheetOptions::default()).unwrap();
        assert_eq!(weights(sheet, &grid, Fit::Exact).unwrap().data, [0.0, 1.0, 0.2]);
        let bits = png((3, 1), ColorType::Grayscale, BitDepth::One, &[0b0100_0000]);
        let sheet = Sheet::read(&bits, &SheetOptions::default()).unwrap();
        assert_eq!(weights(sheet, &grid, Fit::Exact).unwrap().data, [0.0, 1.0, 0.0]);
    }

    #[test]
    fn numbers_outside_the_unit_range_are_no_weights() {
        let bytes: Vec<u8> = [0.5_f32, 1.5].iter().flat_map(|v| v.to_le_bytes()).collect();
        let sheet = Sheet::read(&tiff((2, 1), (3, 32), &bytes, Vec::new(), false), &SheetOptions::default()).unwrap();
        let error = weights(sheet.clone(), &Grid::new(2, 1, 1.0), Fit::Exact).unwrap_err();
        assert_eq!(error, RasterError::OutOfRange { min: 0.0, max: 1.0, found: 1.5 });
        assert_eq!(values(sheet, &Grid::new(2, 1, 1.0), Fit::Exact).unwrap().data, [0.5, 1.5]);
    }

    #[test]
    fn another_size_is_refused_with_both_sizes_unless_stretching_was_asked_for() {
        let grid = Grid::new(4, 2, 1.0);
        let error = weights(grey((2, 1), &[0, 255]), &grid, Fit::Exact).unwrap_err();
        assert_eq!(
            (error.code(), error.expected(), error.found()),
            ("SIZE_MISMATCH", "4 × 2 cells".into(), "2 × 1 cells".into())
        );
        let wide = weights(grey((2, 1), &[0, 255]), &grid, Fit::Stretched).unwrap();
        assert_eq!(wide.data, [0.0, 0.25, 0.75, 1.0, 0.0, 0.25, 0.75, 1.0]);
    }
}
