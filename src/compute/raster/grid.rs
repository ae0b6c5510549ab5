use crate::compute::geometry::Bounds;
use crate::compute::geometry::Point;
use rayon::prelude::*;

/// A cell as (column from the west, row from the north).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Cell {
    /// Column, 0 at the west.
    pub column: usize,
    /// Row, 0 at the north.
    pub row: usize,
}

/// Where the cells of a map lie: square cells, row-major, row 0 at the north.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Columns, at least 1.
    pub width: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// Side of a cell in metres, positive.
    pub cell_m: f64,
    /// South-west corner of the south-west cell, in metres.
    pub origin: Point,
}

impl Grid {
    /// A grid with its south-west corner at (0, 0).
    pub const fn new(width: usize, height: usize, cell_m: f64) -> Self {
        Self { width, height, cell_m, origin: Point::new(0.0, 0.0) }
    }

    /// Number of cells.
    pub const fn len(&self) -> usize {
        self.width * self.height
    }

    /// Whether there are no cells.
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What the cells cover, in metres.
    pub fn bounds(&self) -> Bounds {
        let extent = Point::new(self.width as f64 * self.cell_m, self.height as f64 * self.cell_m);
        Bounds::new(self.origin, self.origin + extent)
    }

    /// Area of one cell in m².
    pub fn cell_area_m2(&self) -> f64 {
        self.cell_m * self.cell_m
    }

    /// The place of a cell in the row-major order.
    pub const fn index(&self, column: usize, row: usize) -> usize {
        row * self.width + column
    }

    /// The cell at a place in the row-major order.
    pub const fn cell(&self, index: usize) -> Cell {
        Cell { column: index % self.width, row: index / self.width }
    }

    /// Centre of the cell at `index`, in metres.
    pub fn centre(&self, index: usize) -> Point {
        let cell = self.cell(index);
        Point::new(
            self.origin.x + (cell.column as f64 + 0.5) * self.cell_m,
            self.origin.y + (self.height as f64 - cell.row as f64 - 0.5) * self.cell_m,
        )
    }

    /// The cell that holds `p`; `None` outside the map.
    pub fn at(&self, p: Point) -> Option<usize> {
        let column = ((p.x - self.origin.x) / self.cell_m).floor();
        let row = (self.height as f64 - (p.y - self.origin.y) / self.cell_m).ceil() - 1.0;
        let inside = column >= 0.0 && row >= 0.0 && column < self.width as f64 && row < self.height as f64;
        inside.then(|| self.index(column as usize, row as usize))
    }

    /// The cell at (`dx`, `dy`) columns east and rows **south** of `index`; `None` outside.
    pub fn offset(&self, index: usize, dx: isize, dy: isize) -> Option<usize> {
        let cell = self.cell(index);
        let column = cell.column.checked_add_signed(dx)?;
        let row = cell.row.checked_add_signed(dy)?;
        (column < self.width && row < self.height).then(|| self.index(column, row))
    }

    /// The up to eight neighbours of `index` with their distance in cells (1 or √2), in the
    /// fixed order W E N S NW NE SW SE.
    pub fn neighbours(&self, index: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        const STEPS: [(isize, isize); 8] = [(-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1)];
        STEPS.iter().filter_map(move |&(dx, dy)| {
            let distance = if dx != 0 && dy != 0 { std::f64::consts::SQRT_2 } else { 1.0 };
            self.offset(index, dx, dy).map(|n| (n, distance))
        })
    }
}

/// A value per cell of a [`Grid`].
#[derive(Debug, Clone, PartialEq)]
pub struct Raster<T> {
    /// Where the cells lie.
    pub grid: Grid,
    /// The values, row-major from the north-west; `data.len() == grid.len()`.
    pub data: Vec<T>,
}

impl<T: Copy> Raster<T> {
    /// A map with the same value everywhere.
    pub fn filled(grid: Grid, value: T) -> Self {
        Self { grid, data: vec![value; grid.len()] }
    }

    /// A map over `data`; `None` when the counts differ.
    pub fn from_data(grid: Grid, data: Vec<T>) -> Option<Self> {
        (data.len() == grid.len()).then_some(Self { grid, data })
    }

    /// The value at (column, row).
    pub fn get(&self, column: usize, row: usize) -> T {
        self.data[self.grid.index(column, row)]
    }

    /// The value of the cell that holds `p`; `None` outside the map.
    pub fn at(&self, p: Point) -> Option<T> {
        self.grid.at(p).map(|i| self.data[i])
    }

    /// A map of `f` of every value.
    pub fn map<U: Send>(&self, f: impl Fn(T) -> U + Sync) -> Raster<U>
    where
        T: Sync,
    {
        Raster { grid: self.grid, data: self.data.par_iter().with_min_len(MIN_CELLS).map(|v| f(*v)).collect() }
    }
}

/// Cells of a map that are worth a thread of their own (ours).
const MIN_CELLS: usize = 4096;

impl Raster<f32> {
    /// Bilinear interpolation between the four cell centres around `p`, clamped at the border;
    /// cells that are not a number are left out; `None` outside the map or among such cells only.
    pub fn sample(&self, p: Point) -> Option<f64> {
        self.grid.at(p)?;
        let g = &self.grid;
        let u = ((p.x - g.origin.x) / g.cell_m - 0.5).clamp(0.0, (g.width - 1) as f64);
        let v = (g.height as f64 - (p.y - g.origin.y) / g.cell_m - 0.5).clamp(0.0, (g.height - 1) as f64);
        let (column, row) = (u.floor() as usize, v.floor() as usize);
        let (east, south) = ((column + 1).min(g.width - 1), (row + 1).min(g.height - 1));
        let (fu, fv) = (u - column as f64, v - row as f64);
        let corners = [
            (self.get(column, row), (1.0 - fu) * (1.0 - fv)),
            (self.get(east, row), fu * (1.0 - fv)),
            (self.get(column, south), (1.0 - fu) * fv),
            (self.get(east, south), fu * fv),
        ];
        let (sum, weight) = corners
            .iter()
            .filter(|(value, _)| !value.is_nan())
            .fold((0.0, 0.0), |(s, w), (value, weight)| (s + f64::from(*value) * weight, w + weight));
        (weight > 0.0).then(|| sum / weight)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_row_is_north_and_centres_find_their_cell() {
        let grid = Grid { width: 4, height: 3, cell_m: 10.0, origin: Point::new(100.0, 200.0) };
        assert_eq!(grid.centre(0), Point::new(105.0, 225.0));
        assert_eq!(grid.centre(11), Point::new(135.0, 205.0));
        for i in 0..grid.len() {
            assert_eq!(grid.at(grid.centre(i)), Some(i));
        }
        assert_eq!(grid.at(Point::new(100.0, 200.0)), Some(8));
        assert_eq!(grid.at(Point::new(99.9, 210.0)), None);
        assert_eq!(grid.at(Point::new(140.0, 210.0)), None);
    }

    #[test]
    fn corners_have_three_neighbours_and_inner_cells_eight() {
        let grid = Grid::new(3, 3, 1.0);
        assert_eq!(grid.neighbours(0).count(), 3);
        assert_eq!(grid.neighbours(4).count(), 8);
    }

    #[test]
    fn sampling_a_plane_gives_the_plane() {
        let grid = Grid::new(5, 4, 2.0);
        let plane = |p: Point| 3.0 + 0.5 * p.x - 0.25 * p.y;
        let raster = Raster { grid, data: (0..grid.len()).map(|i| plane(grid.centre(i)) as f32).collect() };
        for p in [Point::new(1.0, 1.0), Point::new(3.3, 4.1), Point::new(8.9, 6.9)] {
            assert!((raster.sample(p).unwrap() - plane(p)).abs() < 1e-5);
        }
        assert_eq!(raster.sample(Point::new(-0.1, 1.0)), None);
    }
}
