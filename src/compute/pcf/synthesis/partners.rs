use crate::compute::geometry::Bounds;
use crate::compute::geometry::Point;

/// The most cells the search grid is given.
const MOST_CELLS: f64 = 4e6;

/// An element as another sees it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Partner {
    /// Centre in metres.
    pub(super) place: Point,
    /// Radius in r_max of the class that looks.
    pub(super) radius: f64,
    /// What it counts as: 1, or 1/(relative density).
    pub(super) weight: f64,
}

/// A growing set of partners, searched by square cells.
#[derive(Debug, Clone)]
pub(super) struct Partners {
    list: Vec<Partner>,
    bounds: Bounds,
    cell: f64,
    columns: usize,
    rows: usize,
    cells: Vec<Vec<u32>>,
    largest_radius: f64,
}

impl Partners {
    /// An empty set over `bounds`, in cells about `cell` metres wide.
    pub(super) fn new(bounds: Bounds, cell: f64) -> Self {
        let cell = cell.max((bounds.area() / MOST_CELLS).sqrt());
        let (columns, rows) = ((bounds.width() / cell) as usize + 1, (bounds.height() / cell) as usize + 1);
        let cells = vec![Vec::new(); columns * rows];
        Self { list: Vec::new(), bounds, cell, columns, rows, cells, largest_radius: 0.0 }
    }

    /// The partners within `bounds` that `keep` holds for, in order.
    pub(super) fn part(&self, bounds: Bounds, keep: impl Fn(usize) -> bool) -> Self {
        let bounds = bounds.within(self.bounds);
        let mut part = Self::new(bounds, self.cell);
        let kept = self.list.iter().enumerate().filter(|(i, p)| keep(*i) && bounds.contains(p.place));
        kept.for_each(|(_, p)| part.push(*p));
        part
    }

    pub(super) fn list(&self) -> &[Partner] {
        &self.list
    }

    pub(super) fn largest_radius(&self) -> f64 {
        self.largest_radius
    }

    pub(super) fn push(&mut self, partner: Partner) {
        let cell = self.cell_of(partner.place);
        self.cells[cell].push(self.list.len() as u32);
        self.largest_radius = self.largest_radius.max(partner.radius);
        self.list.push(partner);
    }

    /// Takes partner `i` out of the search; it keeps its number.
    pub(super) fn hide(&mut self, i: usize) {
        let cell = self.cell_of(self.list[i].place);
        self.cells[cell].retain(|other| *other as usize != i);
    }

    /// Puts partner `i`, hidden before, to another place.
    pub(super) fn put(&mut self, i: usize, partner: Partner) {
        let cell = self.cell_of(partner.place);
        self.cells[cell].push(i as u32);
        self.list[i] = partner;
    }

    fn cell_of(&self, p: Point) -> usize {
        self.row(p.y) * self.columns + self.column(p.x)
    }

    fn column(&self, x: f64) -> usize {
        (((x - self.bounds.min.x) / self.cell).max(0.0) as usize).min(self.columns - 1)
    }

    fn row(&self, y: f64) -> usize {
        (((y - self.bounds.min.y) / self.cell).max(0.0) as usize).min(self.rows - 1)
    }

    /// Calls `visit` with the index and partner of all within `radius` metres, and some beyond.
    pub(super) fn for_each_near(&self, p: Point, radius: f64, mut visit: impl FnMut(usize, &Partner)) {
        for row in self.row(p.y - radius)..=self.row(p.y + radius) {
            let first = row * self.columns;
            for cell in &self.cells[first + self.column(p.x - radius)..=first + self.column(p.x + radius)] {
                for i in cell {
                    visit(*i as usize, &self.list[*i as usize]);
                }
            }
        }
    }
}
