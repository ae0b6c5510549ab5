use super::Mark;
use super::watershed::Regions;
use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Point;
use crate::compute::raster::Cell;
use crate::compute::raster::Grid;

/// A region by its moments up to the second order, in columns and rows.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Shape {
    n: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl Shape {
    /// Adds one pixel.
    pub(super) fn add(&mut self, cell: Cell) {
        let (x, y) = (cell.column as f64, cell.row as f64);
        self.n += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
        self.yy += y * y;
    }

    /// Both regions as one.
    pub(super) fn united(&self, other: &Self) -> Self {
        Self {
            n: self.n + other.n,
            x: self.x + other.x,
            y: self.y + other.y,
            xx: self.xx + other.xx,
            xy: self.xy + other.xy,
            yy: self.yy + other.yy,
        }
    }

    /// Number of pixels.
    pub(super) fn area(&self) -> f64 {
        self.n
    }

    /// Variances along x and y (up) and their covariance; a pixel is a square of variance 1/12.
    fn covariance(&self) -> (f64, f64, f64) {
        let (mx, my) = (self.x / self.n, self.y / self.n);
        let xx = self.xx / self.n - mx * mx + 1.0 / 12.0;
        let yy = self.yy / self.n - my * my + 1.0 / 12.0;
        (xx, yy, -(self.xy / self.n - mx * my))
    }

    /// The ellipse with the same centre and second moments: semi-axes twice the root of the
    /// principal variances (T 4.2.1).
    pub(super) fn ellipse(&self, grid: Grid) -> Ellipse {
        let (xx, yy, xy) = self.covariance();
        let (mean, half) = ((xx + yy) / 2.0, (xx - yy) / 2.0);
        let spread = (half * half + xy * xy).sqrt();
        Ellipse {
            centre: Point::new(self.x / self.n + 0.5, grid.height as f64 - self.y / self.n - 0.5),
            a: 2.0 * (mean + spread).sqrt(),
            b: 2.0 * (mean - spread).max(1.0 / 12.0).sqrt(),
            theta: 0.5 * libm::atan2(xy, half),
        }
    }

    /// Pixels over the area of the ellipse of equal second moments: 1 for an ellipse, less for
    /// every other shape.
    pub(super) fn fill(&self) -> f64 {
        let (xx, yy, xy) = self.covariance();
        self.n / (4.0 * std::f64::consts::PI * (xx * yy - xy * xy).max(1e-9).sqrt())
    }
}

/// Which regions lie under a mark of an animal.
pub(super) fn marked(regions: &Regions, marks: &[Mark]) -> Vec<bool> {
    let mut marked = vec![false; regions.shapes.len()];
    for (label, mark) in regions.labels.iter().zip(marks) {
        if *label > 0 && *mark == Mark::Animal {
            marked[*label as usize - 1] = true;
        }
    }
    marked
}

/// Median area in pixels of the marked regions, or, when none is, the size of the region in which
/// the middle animal pixel lies; `None` without regions.
pub(super) fn typical_area(regions: &Regions, marked: &[bool]) -> Option<f64> {
    let sorted = |mut areas: Vec<f64>| {
        areas.sort_by(f64::total_cmp);
        areas
    };
    let areas = sorted(regions.shapes.iter().zip(marked).filter(|(_, m)| **m).map(|(s, _)| s.area()).collect());
    if !areas.is_empty() {
        return areas.get(areas.len() / 2).copied();
    }
    let areas = sorted(regions.shapes.iter().map(Shape::area).collect());
    let half = areas.iter().sum::<f64>() / 2.0;
    let mut sum = 0.0;
    areas.into_iter().find(|area| {
        sum += area;
        sum >= half
    })
}

/// The ellipse turned by half a turn when that brings it nearer to `direction`.
pub(super) fn facing(ellipse: Ellipse, direction: Point) -> Ellipse {
    if ellipse.heading().dot(direction) < 0.0 { ellipse.flipped() } else { ellipse }
}
