use super::place::Placing;
use super::place::Way;
use crate::codec::sheet::Affine;
use crate::codec::sheet::Sheet;
use crate::compute::geometry::Point;
use crate::compute::raster::Grid;
use crate::compute::raster::Raster;
use rayon::prelude::*;

/// Columns between two points that are projected exactly; between them the way is straight. At
/// 90 m cells the error is below three thousandths of a cell (the test measures it).
const KNOTS: usize = 16;

/// The sheet's heights on the cells of the placing.
pub(super) fn onto(sheet: Sheet, placing: &Placing) -> Raster<f32> {
    let grid = placing.grid;
    match &placing.way {
        Way::Turned => Raster { grid, data: sheet.north_up().values },
        Way::Resampled(affine, projection) => {
            let middle = affine.x0 + (affine.a * sheet.width as f64 + affine.b * sheet.height as f64) / 2.0;
            let project = |p: Point| match projection {
                Some(projection) => projection.to_file_near(p, middle),
                None => Some(p),
            };
            resampled(&sheet, grid, |p| project(p).and_then(|q| cell(affine, q)))
        }
    }
}

/// Each cell of `grid` by bilinear interpolation at its centre; `find` gives the place in the
/// sheet, in cells from its outer corner.
fn resampled(sheet: &Sheet, grid: Grid, find: impl Fn(Point) -> Option<Point> + Sync) -> Raster<f32> {
    let mut data = vec![f32::NAN; grid.len()];
    data.par_chunks_mut(grid.width).enumerate().for_each(|(row, values)| {
        let centre = |column: usize| {
            let y = grid.origin.y + (grid.height as f64 - row as f64 - 0.5) * grid.cell_m;
            find(Point::new(grid.origin.x + (column as f64 + 0.5) * grid.cell_m, y))
        };
        for (n, values) in values.chunks_mut(KNOTS).enumerate() {
            let (Some(from), Some(to)) = (centre(n * KNOTS), centre((n + 1) * KNOTS)) else {
                continue;
            };
            for (i, value) in values.iter_mut().enumerate() {
                let p = from.lerp(to, i as f64 / KNOTS as f64);
                *value = sheet.bilinear(p.x, p.y);
            }
        }
    });
    Raster { grid, data }
}

/// The inverse of the affine map.
fn cell(t: &Affine, p: Point) -> Option<Point> {
    let area = t.a * t.e - t.b * t.d;
    let (x, y) = (p.x - t.x0, p.y - t.y0);
    Some(Point::new((x * t.e - y * t.b) / area, (y * t.a - x * t.d) / area)).filter(|p| p.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::terrain::projection::Projection;

    #[test]
    fn straight_ways_between_knots_stay_within_three_thousandths_of_a_cell() {
        let zone = Projection::between(None, 32616).unwrap();
        let cell = 90.0;
        let mut worst: f64 = 0.0;
        for start in
            [Point::new(200_000.0, 100_000.0), Point::new(730_000.0, 4_050_000.0), Point::new(800_000.0, 8_800_000.0)]
        {
            let at = |i: f64| zone.to_file(start + Point::new(i * cell, 0.0)).unwrap();
            let (from, to) = (at(0.0), at(KNOTS as f64));
            for i in 0..KNOTS {
                let straight = from.lerp(to, i as f64 / KNOTS as f64);
                let exact = at(i as f64);
                // One second of latitude is a third of a cell of 90 m.
                worst = worst.max((straight.y - exact.y).abs() * 3600.0 / 3.0);
                worst = worst.max((straight.x - exact.x).abs() * 3600.0 / 3.0 * exact.y.to_radians().cos());
            }
        }
        assert!(worst < 3e-3, "{worst} cells");
    }
}
