use super::ExtractionError;
use crate::compute::raster::Grid;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use rayon::prelude::*;

/// Smooths the decision values by `passes` of a 3 × 3 binomial and keeps what stays positive.
pub(super) fn threshold(scores: Vec<i8>, grid: Grid, passes: u32, run: &Run) -> Result<Raster<u8>, ExtractionError> {
    let mut values: Vec<i16> = scores.into_iter().map(|s| i16::from(s) * 64).collect();
    for _ in 0..passes {
        run.check()?;
        values = smoothed(&values, grid);
    }
    Ok(Raster { grid, data: values.into_par_iter().map(|v| u8::from(v > 0)).collect() })
}

fn smoothed(values: &[i16], grid: Grid) -> Vec<i16> {
    let (width, height) = (grid.width, grid.height);
    let mut out = vec![0i16; values.len()];
    out.par_chunks_mut(width).enumerate().for_each_init(
        || vec![0i32; width],
        |sums, (y, out)| {
            let row = |y: usize| &values[y * width..(y + 1) * width];
            let (above, here, below) = (row(y.saturating_sub(1)), row(y), row((y + 1).min(height - 1)));
            for (sum, ((a, h), b)) in sums.iter_mut().zip(above.iter().zip(here).zip(below)) {
                *sum = i32::from(*a) + 2 * i32::from(*h) + i32::from(*b);
            }
            for x in 0..width {
                let (left, right) = (sums[x.saturating_sub(1)], sums[(x + 1).min(width - 1)]);
                out[x] = ((left + 2 * sums[x] + right) >> 4) as i16;
            }
        },
    );
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smoothing_takes_out_specks_and_keeps_straight_rims() {
        let grid = Grid::new(30, 30, 1.0);
        let mut scores: Vec<i8> = (0..grid.len()).map(|i| if grid.cell(i).column < 10 { 100 } else { -100 }).collect();
        scores[grid.index(20, 15)] = 100;
        scores[grid.index(4, 15)] = -100;
        let mask = threshold(scores, grid, 2, &Run::silent()).unwrap();
        for i in 0..grid.len() {
            assert_eq!(mask.data[i], u8::from(grid.cell(i).column < 10), "{:?}", grid.cell(i));
        }
    }
}
