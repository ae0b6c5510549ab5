//! What animals may not enter, and how far away it is.

use crate::compute::geometry::Bounds;
use crate::compute::geometry::Point;
use crate::compute::geometry::Region;
use crate::compute::raster::Grid;
use crate::compute::raster::Raster;
use crate::compute::raster::distance_to_zero;
use crate::compute::run::Run;
use crate::compute::run::Stopped;

/// Ground that animals may not enter: trees and rocks, closed areas, a mask; any may be empty.
#[derive(Debug, Clone, Default)]
pub struct Obstacles {
    /// Centre and radius in metres.
    pub disks: Vec<(Point, f64)>,
    /// Polygons with holes.
    pub areas: Vec<Region>,
    /// A map in which every cell that is not 0 is closed.
    pub mask: Option<Raster<u8>>,
}

impl Obstacles {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.disks.is_empty() && self.areas.is_empty() && self.mask.is_none()
    }

    /// Whether `p` lies in an obstacle.
    pub fn hold(&self, p: Point) -> bool {
        self.disks.iter().any(|(centre, radius)| centre.distance_sq(p) <= radius * radius)
            || self.areas.iter().any(|area| area.contains(p))
            || self.mask.as_ref().is_some_and(|mask| mask.at(p).is_some_and(|cell| cell != 0))
    }

    /// Whether an obstacle comes within `reach` metres of `p`; a mask is looked at in the eight
    /// main directions, so that `reach` should not be far above its cells.
    pub fn touch(&self, p: Point, reach: f64) -> bool {
        let around = |k: u32| p + Point::from_angle(f64::from(k) * std::f64::consts::FRAC_PI_4) * reach;
        let closed = |mask: &Raster<u8>, q: Point| mask.at(q).is_some_and(|cell| cell != 0);
        self.disks.iter().any(|(centre, radius)| centre.distance_sq(p) <= (radius + reach) * (radius + reach))
            || self.areas.iter().any(|area| area.contains_within(p, reach))
            || self.mask.as_ref().is_some_and(|mask| closed(mask, p) || (0..8).any(|k| closed(mask, around(k))))
    }

    /// The cells of `grid` that an obstacle touches (1), so that no obstacle is missed between
    /// cell centres; an area that passes a cell within half its diagonal counts as touching.
    pub fn cover(&self, grid: Grid, run: &Run) -> Result<Raster<u8>, Stopped> {
        let mut covered = Raster::filled(grid, 0u8);
        let reach = grid.cell_m * std::f64::consts::FRAC_1_SQRT_2;
        for &(centre, radius) in &self.disks {
            run.check()?;
            let r = Point::new(radius + reach, radius + reach);
            for_each_in(grid, Bounds::new(centre - r, centre + r), |cell| {
                if grid.centre(cell).distance(centre) <= radius + reach {
                    covered.data[cell] = 1;
                }
            });
        }
        for area in &self.areas {
            run.check()?;
            for_each_in(grid, area.bounds().grown(reach), |cell| {
                let centre = grid.centre(cell);
                if covered.data[cell] == 0 && area.contains_within(centre, reach) {
                    covered.data[cell] = 1;
                }
            });
        }
        if let Some(mask) = &self.mask {
            let half = mask.grid.cell_m / 2.0;
            for (cell, _) in mask.data.iter().enumerate().filter(|(_, closed)| **closed != 0) {
                let centre = mask.grid.centre(cell);
                // Just short of the rim, so that a closed cell does not close its neighbours.
                let h = Point::new(half, half) * (1.0 - 1e-9);
                for_each_in(grid, Bounds::new(centre - h, centre + h), |cell| covered.data[cell] = 1);
            }
            run.check()?;
        }
        Ok(covered)
    }
}

/// Calls `visit` with every cell of `grid` that `bounds` overlaps.
fn for_each_in(grid: Grid, bounds: Bounds, mut visit: impl FnMut(usize)) {
    let column = |x: f64| ((x - grid.origin.x) / grid.cell_m).floor();
    let row = |y: f64| (grid.height as f64 - (y - grid.origin.y) / grid.cell_m).floor();
    let (west, east) = (column(bounds.min.x).max(0.0), column(bounds.max.x).min(grid.width as f64 - 1.0));
    let (north, south) = (row(bounds.max.y).max(0.0), row(bounds.min.y).min(grid.height as f64 - 1.0));
    if west > east || north > south {
        return;
    }
    for row in north as usize..=south as usize {
        for column in west as usize..=east as usize {
            visit(grid.index(column, row));
        }
    }
}

/// Distance in metres to the nearest obstacle, negative inside: a map made once, asked often.
#[derive(Debug, Clone)]
pub struct Clearance {
    field: Raster<f32>,
    open: bool,
}

impl Clearance {
    /// The clearance over `grid`; accurate to about a cell, never more than is there.
    pub fn new(obstacles: &Obstacles, grid: Grid, run: &Run) -> Result<Self, Stopped> {
        Self::around(&obstacles.cover(grid, run)?, run)
    }

    /// The clearance of the cells that are not 0 in `closed`.
    pub fn around(closed: &Raster<u8>, run: &Run) -> Result<Self, Stopped> {
        let grid = closed.grid;
        if closed.data.iter().all(|c| *c == 0) {
            return Ok(Self { field: Raster::filled(grid, f32::MAX), open: true });
        }
        let outside = distance_to_zero(&closed.map(|c| 1 - c), run)?;
        let inside = distance_to_zero(closed, run)?;
        // Centres are a cell apart where the rim lies half a cell from either.
        let signed = |(o, i): (&f32, &f32)| (if *o > 0.0 { o - 0.5 } else { 0.5 - i }) * grid.cell_m as f32;
        let data = outside.data.iter().zip(&inside.data).map(signed).collect();
        Ok(Self { field: Raster { grid, data }, open: false })
    }

    /// Where the cells lie.
    pub fn grid(&self) -> Grid {
        self.field.grid
    }

    /// Whether there is no obstacle at all.
    pub fn is_open(&self) -> bool {
        self.open
    }

    /// Clearance of a cell in metres.
    pub fn of_cell(&self, cell: usize) -> f64 {
        f64::from(self.field.data[cell])
    }

    /// Clearance at `p` in metres; outside the map −1.
    pub fn at(&self, p: Point) -> f64 {
        if self.open {
            return if self.field.grid.at(p).is_some() { f64::from(f32::MAX) } else { -1.0 };
        }
        self.field.sample(p).unwrap_or(-1.0)
    }

    /// The direction in which the clearance grows fastest; `None` on open ground and at summits.
    pub fn away(&self, p: Point) -> Option<Point> {
        if self.open {
            return None;
        }
        let h = self.field.grid.cell_m;
        let along = |d: Point| self.at(p + d) - self.at(p - d);
        Point::new(along(Point::new(h, 0.0)), along(Point::new(0.0, h))).normalised()
    }

    /// Whether all of the way from `from` to `to` has at least `width` of clearance: by steps as
    /// long as the clearance allows.
    pub fn sees(&self, from: Point, to: Point, width: f64) -> bool {
        if self.open {
            return true;
        }
        let length = from.distance(to);
        let least = 0.5 * self.field.grid.cell_m;
        let mut gone = 0.0;
        while gone < length {
            let spare = self.at(from.lerp(to, gone / length)) - width;
            if spare < 0.0 {
                return false;
            }
            gone += spare.max(least);
        }
        self.at(to) >= width
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn obstacles() -> Obstacles {
        let square = Bounds::new(Point::new(60.0, 20.0), Point::new(70.0, 40.0));
        let mut mask = Raster::filled(Grid::new(10, 10, 10.0), 0u8);
        mask.data[mask.grid.index(2, 7)] = 1;
        Obstacles {
            disks: vec![(Point::new(30.0, 70.0), 5.0)],
            areas: vec![Region::rectangle(square).unwrap()],
            mask: Some(mask),
        }
    }

    #[test]
    fn the_clearance_is_the_distance_to_disks_areas_and_masks() {
        let clearance = Clearance::new(&obstacles(), Grid::new(200, 200, 0.5), &Run::silent()).unwrap();
        let near = |x: f64, y: f64, expected: f64| {
            let found = clearance.at(Point::new(x, y));
            assert!(found <= expected + 0.4 && found > expected - 1.1, "({x}, {y}): {found}, not {expected}");
        };
        near(30.0, 85.0, 10.0);
        near(30.0, 70.0, -5.0);
        near(80.0, 30.0, 10.0);
        near(25.0, 36.0, 6.0);
        assert!(clearance.at(Point::new(101.0, 3.0)) < 0.0);
        let away = clearance.away(Point::new(80.0, 30.0)).unwrap();
        assert!(away.x > 0.99);
    }

    #[test]
    fn a_view_is_blocked_by_what_lies_between() {
        let clearance = Clearance::new(&obstacles(), Grid::new(200, 200, 0.5), &Run::silent()).unwrap();
        assert!(!clearance.sees(Point::new(50.0, 30.0), Point::new(80.0, 30.0), 0.5));
        assert!(clearance.sees(Point::new(50.0, 50.0), Point::new(80.0, 50.0), 0.5));
        assert!(!clearance.sees(Point::new(50.0, 41.0), Point::new(80.0, 41.0), 3.0));
    }

    #[test]
    fn no_point_of_an_obstacle_lies_in_an_open_cell() {
        let (obstacles, grid) = (obstacles(), Grid::new(67, 67, 1.5));
        let covered = obstacles.cover(grid, &Run::silent()).unwrap();
        for k in 0..40_000 {
            let p = Point::new(f64::from(k % 200) * 0.5 + 0.1, f64::from(k / 200) * 0.5 + 0.1);
            assert!(!obstacles.hold(p) || covered.at(p) == Some(1), "{p:?}");
        }
    }
}
