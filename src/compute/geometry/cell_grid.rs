use super::{Bounds, Point};

/// The most cells a grid is given, so that far-flung points cannot exhaust memory.
const MAX_CELLS_PER_POINT: usize = 4;

/// Points sorted into square cells, for "who is within this distance" in constant time.
///
/// Stored as compressed rows: the indices of all points, cell by cell, and where each cell
/// begins. Neighbours come cell by cell (row-major from the south-west) and by index within a
/// cell: an order that depends on the points only.
#[derive(Debug, Clone)]
pub struct CellGrid {
    bounds: Bounds,
    cell: f64,
    columns: usize,
    rows: usize,
    starts: Vec<u32>,
    order: Vec<u32>,
}

impl CellGrid {
    /// Sorts `points` into cells about `cell` wide (wider when that would make more than a few
    /// cells a point). All points must be finite and `cell` positive.
    pub fn new(points: &[Point], cell: f64) -> Self {
        let bounds = Bounds::of(points.iter().copied()).unwrap_or(Bounds::new(Point::default(), Point::default()));
        let most = (points.len() * MAX_CELLS_PER_POINT).max(16);
        let mut cell = cell.max(f64::MIN_POSITIVE);
        let size = |cell: f64| ((bounds.width() / cell).floor() + 1.0, (bounds.height() / cell).floor() + 1.0);
        while size(cell).0 * size(cell).1 > most as f64 {
            cell *= 1.5;
        }
        let (columns, rows) = (size(cell).0 as usize, size(cell).1 as usize);
        let mut grid =
            Self { bounds, cell, columns, rows, starts: vec![0; columns * rows + 1], order: vec![0; points.len()] };
        for p in points {
            let c = grid.cell_of(*p);
            grid.starts[c + 1] += 1;
        }
        for c in 0..columns * rows {
            grid.starts[c + 1] += grid.starts[c];
        }
        let mut next = grid.starts.clone();
        for (i, p) in points.iter().enumerate() {
            let c = grid.cell_of(*p);
            grid.order[next[c] as usize] = i as u32;
            next[c] += 1;
        }
        grid
    }

    fn column(&self, x: f64) -> usize {
        (((x - self.bounds.min.x) / self.cell).max(0.0) as usize).min(self.columns - 1)
    }

    fn row(&self, y: f64) -> usize {
        (((y - self.bounds.min.y) / self.cell).max(0.0) as usize).min(self.rows - 1)
    }

    fn cell_of(&self, p: Point) -> usize {
        self.row(p.y) * self.columns + self.column(p.x)
    }

    /// Calls `visit` with the index of every point in the cells that a disk of `radius` around
    /// `centre` touches: all points within `radius`, and some beyond. The caller tests distances.
    pub fn for_each_near(&self, centre: Point, radius: f64, mut visit: impl FnMut(usize)) {
        if !self.bounds.grown(radius).contains(centre) {
            return;
        }
        let columns = self.column(centre.x - radius)..=self.column(centre.x + radius);
        for row in self.row(centre.y - radius)..=self.row(centre.y + radius) {
            let first = self.starts[row * self.columns + columns.start()] as usize;
            let last = self.starts[row * self.columns + columns.end() + 1] as usize;
            for &i in &self.order[first..last] {
                visit(i as usize);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::random::{Purpose, Stream};

    #[test]
    fn every_point_within_the_radius_is_visited_once() {
        let mut random = Stream::new(1, Purpose::new("test.cell-grid"), 0);
        let points: Vec<Point> =
            (0..500).map(|_| Point::new(random.range(-3.0, 9.0), random.range(5.0, 6.0))).collect();
        let grid = CellGrid::new(&points, 0.5);
        for (centre, radius) in [(points[0], 0.3), (Point::new(100.0, 5.5), 1.0), (Point::new(-3.2, 5.0), 2.0)] {
            let mut seen = vec![0; points.len()];
            grid.for_each_near(centre, radius, |i| seen[i] += 1);
            for (p, n) in points.iter().zip(&seen) {
                assert!(*n <= 1);
                assert!(*n == 1 || p.distance(centre) > radius);
            }
        }
    }

    #[test]
    fn far_flung_points_do_not_exhaust_memory() {
        let points = [Point::new(0.0, 0.0), Point::new(1e12, 1e12)];
        let grid = CellGrid::new(&points, 1e-3);
        let mut near = Vec::new();
        grid.for_each_near(points[1], 1.0, |i| near.push(i));
        assert!(near.contains(&1));
    }
}
