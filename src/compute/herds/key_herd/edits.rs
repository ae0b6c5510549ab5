//! Edits of an orientation field (T 4.2.5): blend to a direction, rotate, smooth, add noise.

use super::KeyHerdError;
use crate::compute::geometry::Point;
use crate::compute::random::Purpose;
use crate::compute::random::Stream;
use crate::compute::raster::Grid;
use crate::compute::raster::Raster;
use rayon::prelude::*;

const NOISE: Purpose = Purpose::new("key-herd.orientation-noise");

/// A change of an orientation field; changes are made in the order given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OrientationEdit {
    /// Merges with a direction (T figure 4.7b): `weight` 0 keeps the field, 1 replaces it.
    Blend {
        /// Radians counter-clockwise from east.
        direction: f64,
        /// From 0 to 1.
        weight: f64,
    },
    /// Turns every orientation.
    Rotate {
        /// Radians counter-clockwise.
        angle: f64,
    },
    /// A mean over a disk.
    Smooth {
        /// Its radius in metres.
        radius_m: f64,
    },
    /// Adds smooth noise.
    Noise {
        /// Standard deviation in radians.
        deviation: f64,
        /// Size of its features in metres.
        size_m: f64,
    },
}

impl OrientationEdit {
    pub(super) fn check(&self) -> Result<(), KeyHerdError> {
        let rule = match *self {
            Self::Blend { weight, direction } if direction.is_finite() => {
                ("orientation_edits.weight", weight, (0.0..=1.0).contains(&weight), "from 0 to 1")
            }
            Self::Blend { direction, .. } => ("orientation_edits.direction", direction, false, "a finite angle"),
            Self::Rotate { angle } => ("orientation_edits.angle", angle, angle.is_finite(), "a finite angle"),
            Self::Smooth { radius_m } => {
                ("orientation_edits.radius_m", radius_m, (0.0..=1e6).contains(&radius_m), "from 0 to 1,000,000")
            }
            Self::Noise { deviation, .. } if !(0.0..=7.0).contains(&deviation) => {
                ("orientation_edits.deviation", deviation, false, "from 0 to 7")
            }
            Self::Noise { size_m, .. } => {
                ("orientation_edits.size_m", size_m, size_m > 0.0 && size_m <= 1e6, "above 0, to 1,000,000")
            }
        };
        match rule {
            (_, _, true, _) => Ok(()),
            (field, found, false, expected) => Err(KeyHerdError::BadOption { field, expected, found }),
        }
    }

    /// The field after the edit; `seed` and the edit's place in the list make the noise.
    pub(super) fn apply(&self, field: &Raster<Point>, (seed, index): (u64, u64)) -> Raster<Point> {
        match *self {
            Self::Blend { direction, weight } => {
                let to = Point::from_angle(direction);
                field.map(|v| (v * (1.0 - weight) + to * weight).normalised().unwrap_or(v))
            }
            Self::Rotate { angle } => field.map(|v| v.rotated(angle)),
            Self::Smooth { radius_m } => smoothed(field, radius_m / field.grid.cell_m),
            Self::Noise { deviation, size_m } => {
                let noise = Noise::new(field.grid, size_m, (seed, index));
                let turned = |i: usize| field.data[i].rotated(deviation * noise.at(field.grid.centre(i)));
                Raster { grid: field.grid, data: (0..field.data.len()).map(turned).collect() }
            }
        }
    }
}

/// Three box means of the vectors, whose widths make up a radius of `radius` cells.
fn smoothed(field: &Raster<Point>, radius: f64) -> Raster<Point> {
    let half = (radius / 3f64.sqrt()).round().min(field.grid.len() as f64) as usize;
    let mut data = field.data.clone();
    for _ in 0..3 {
        data = transposed(&box_mean(&data, field.grid.width, half), field.grid.width);
        data = transposed(&box_mean(&data, field.grid.height, half), field.grid.height);
    }
    let unit = |(mean, old): (Point, &Point)| if mean.norm() > 1e-6 { mean * (1.0 / mean.norm()) } else { *old };
    Raster { grid: field.grid, data: data.into_iter().zip(&field.data).map(unit).collect() }
}

/// The mean of each value and `half` values on either side of it in its row.
fn box_mean(data: &[Point], width: usize, half: usize) -> Vec<Point> {
    let row = |row: &[Point]| {
        let sums: Vec<Point> = std::iter::once(Point::default())
            .chain(row.iter().scan(Point::default(), |sum, v| {
                *sum = *sum + *v;
                Some(*sum)
            }))
            .collect();
        let mean = move |x: usize| {
            let (from, to) = (x.saturating_sub(half), (x + half + 1).min(sums.len() - 1));
            (sums[to] - sums[from]) * (1.0 / (to - from) as f64)
        };
        (0..row.len()).map(mean).collect::<Vec<_>>()
    };
    data.par_chunks(width).flat_map_iter(row).collect()
}

fn transposed(data: &[Point], width: usize) -> Vec<Point> {
    let height = data.len() / width;
    (0..data.len()).map(|i| data[(i % height) * width + i / height]).collect()
}

/// Standard normal values on a lattice, interpolated smoothly.
struct Noise {
    origin: Point,
    size_m: f64,
    columns: usize,
    values: Vec<f64>,
}

impl Noise {
    fn new(grid: Grid, size_m: f64, (seed, index): (u64, u64)) -> Self {
        // No finer than the cells.
        let size_m = size_m.max(grid.cell_m);
        let across = |cells: usize| (cells as f64 * grid.cell_m / size_m) as usize + 3;
        let (columns, rows) = (across(grid.width), across(grid.height));
        let mut stream = Stream::new(seed, NOISE, index);
        let values = (0..columns * rows).map(|_| stream.normal()).collect();
        Self { origin: grid.origin, size_m, columns, values }
    }

    fn at(&self, p: Point) -> f64 {
        let d = (p - self.origin) * (1.0 / self.size_m);
        let (i, j) = (d.x.max(0.0) as usize, d.y.max(0.0) as usize);
        let ease = |t: f64| t * t * (3.0 - 2.0 * t);
        let (u, v) = (ease(d.x - i as f64), ease(d.y - j as f64));
        let value = |i: usize, j: usize| self.values[j * self.columns + i];
        let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
        let corners = [value(i, j), value(i + 1, j), value(i, j + 1), value(i + 1, j + 1)];
        let sum: f64 = weights.iter().zip(corners).map(|(w, c)| w * c).sum();
        // Mixing lowers the variance: this keeps it 1 everywhere.
        sum / weights.iter().map(|w| w * w).sum::<f64>().sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn swirl() -> Raster<Point> {
        let grid = Grid::new(60, 40, 0.5);
        let data = (0..grid.len()).map(|i| Point::from_angle(grid.centre(i).x * 0.3)).collect();
        Raster { grid, data }
    }

    fn apply(edit: OrientationEdit) -> Raster<Point> {
        edit.check().unwrap();
        edit.apply(&swirl(), (7, 0))
    }

    #[test]
    fn blending_and_rotating_do_what_they_say() {
        let field = swirl();
        let replaced = apply(OrientationEdit::Blend { direction: 0.5, weight: 1.0 });
        assert!(replaced.data.iter().all(|v| v.dot(Point::from_angle(0.5)) > 1.0 - 1e-12));
        assert_eq!(apply(OrientationEdit::Blend { direction: 0.5, weight: 0.0 }).data.len(), field.data.len());
        let turned = apply(OrientationEdit::Rotate { angle: 0.7 });
        assert!(turned.data.iter().zip(&field.data).all(|(a, b)| (b.rotated(0.7) - *a).norm() < 1e-12));
    }

    #[test]
    fn smoothing_keeps_an_even_field_and_evens_out_noise() {
        let even = Raster::filled(Grid::new(30, 20, 1.0), Point::from_angle(1.0));
        let smooth = OrientationEdit::Smooth { radius_m: 6.0 };
        assert!(smooth.apply(&even, (0, 0)).data.iter().all(|v| v.dot(even.data[0]) > 1.0 - 1e-9));
        let noisy = OrientationEdit::Noise { deviation: 0.8, size_m: 1.0 }.apply(&even, (3, 0));
        let spread = |f: &Raster<Point>| f.data.iter().map(|v| 1.0 - v.dot(even.data[0])).sum::<f64>();
        assert!(spread(&noisy) > 100.0 && spread(&smooth.apply(&noisy, (0, 0))) < 0.2 * spread(&noisy));
    }

    #[test]
    fn noise_has_the_deviation_asked_for() {
        let even = Raster::filled(Grid::new(300, 300, 1.0), Point::from_angle(0.0));
        let noisy = OrientationEdit::Noise { deviation: 0.3, size_m: 2.0 }.apply(&even, (3, 1));
        let variance = noisy.data.iter().map(|v| v.angle().powi(2)).sum::<f64>() / 90_000.0;
        assert!((variance.sqrt() - 0.3).abs() < 0.02, "{}", variance.sqrt());
    }
}
