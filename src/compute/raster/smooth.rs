use crate::compute::raster::Raster;
use rayon::prelude::*;

/// The mean over the square of 2·`radius` + 1 cells a side around each cell, of the cells on the
/// map that are numbers. What is not a number stays so. Time does not depend on the radius.
pub fn box_mean(map: &Raster<f32>, radius: usize) -> Raster<f32> {
    if radius == 0 || map.grid.is_empty() {
        return map.clone();
    }
    let (width, height) = (map.grid.width, map.grid.height);
    let rows: Vec<(f64, u32)> = map.data.par_chunks(width).flat_map_iter(|row| row_sums(row, radius)).collect();
    let mut data = vec![f32::NAN; map.data.len()];
    let mut window = vec![(0.0f64, 0u32); width];
    let row = |r: usize| &rows[r * width..(r + 1) * width];
    for entering in 0..height + radius {
        if entering < height {
            window.iter_mut().zip(row(entering)).for_each(|(w, s)| *w = (w.0 + s.0, w.1 + s.1));
        }
        if let Some(leaving) = entering.checked_sub(2 * radius + 1) {
            window.iter_mut().zip(row(leaving)).for_each(|(w, s)| *w = (w.0 - s.0, w.1 - s.1));
        }
        let Some(centre) = entering.checked_sub(radius) else { continue };
        let cells = centre * width..(centre + 1) * width;
        let means = data[cells.clone()].iter_mut().zip(&map.data[cells]).zip(&window);
        means.filter(|((_, own), _)| !own.is_nan()).for_each(|((mean, _), w)| *mean = (w.0 / f64::from(w.1)) as f32);
    }
    Raster { grid: map.grid, data }
}

/// Sum and number of the numbers within `radius` cells of each cell of a row.
fn row_sums(row: &[f32], radius: usize) -> Vec<(f64, u32)> {
    let value = |v: f32| if v.is_nan() { (0.0, 0) } else { (f64::from(v), 1) };
    let mut window = (0.0, 0);
    let mut sums = Vec::with_capacity(row.len());
    for entering in 0..row.len() + radius {
        let (sum, number) = row.get(entering).map_or((0.0, 0), |v| value(*v));
        window = (window.0 + sum, window.1 + number);
        if let Some(leaving) = entering.checked_sub(2 * radius + 1) {
            let (sum, number) = value(row[leaving]);
            window = (window.0 - sum, window.1 - number);
        }
        if entering >= radius {
            sums.push(window);
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::raster::Grid;

    #[test]
    fn it_is_the_mean_of_the_square_around() {
        for (width, height, radius) in [(7, 5, 1), (7, 5, 2), (3, 9, 4), (1, 1, 3), (6, 1, 1)] {
            let grid = Grid::new(width, height, 1.0);
            let value = |i: usize| if i % 5 == 3 { f32::NAN } else { ((i * 37) % 11) as f32 };
            let map = Raster { grid, data: (0..grid.len()).map(value).collect() };
            let smooth = box_mean(&map, radius);
            for i in 0..grid.len() {
                let near = |j: usize| {
                    let (a, b) = (grid.cell(i), grid.cell(j));
                    a.column.abs_diff(b.column) <= radius && a.row.abs_diff(b.row) <= radius
                };
                let values: Vec<f32> =
                    (0..grid.len()).filter(|j| near(*j)).map(value).filter(|v| !v.is_nan()).collect();
                let expected = values.iter().sum::<f32>() / values.len() as f32;
                let found = smooth.data[i];
                assert!(if value(i).is_nan() { found.is_nan() } else { (found - expected).abs() < 1e-5 });
            }
        }
    }
}
