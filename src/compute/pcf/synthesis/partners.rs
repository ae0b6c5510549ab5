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

/// A set of partners, searched by square cells.
///
/// Stored as compressed rows: copies of all partners cell by cell, so that a search reads memory
/// in order, and where each cell begins. A partner added or moved shifts those behind it, which
/// for the few thousand of a block costs less than one trial.
#[derive(Debug, Clone)]
pub(super) struct Partners {
    list: Vec<Partner>,
    bounds: Bounds,
    cell: f64,
    per_cell: f64,
    columns: usize,
    rows: usize,
    starts: Vec<u32>,
    sorted: Vec<(Partner, u32)>,
    largest_radius: f64,
}

impl Partners {
    /// `list` in cells about `cell` metres wide over `bounds`.
    pub(super) fn new(list: Vec<Partner>, bounds: Bounds, cell: f64) -> Self {
        let cell = cell.max((bounds.area() / MOST_CELLS).sqrt());
        let (columns, rows) = ((bounds.width() / cell) as usize + 1, (bounds.height() / cell) as usize + 1);
        let largest_radius = list.iter().map(|p| p.radius).fold(0.0, f64::max);
        let starts = vec![0; columns * rows + 1];
        let mut partners = Self {
            list,
            bounds,
            cell,
            per_cell: 1.0 / cell,
            columns,
            rows,
            starts,
            sorted: Vec::new(),
            largest_radius,
        };
        let mut sorted: Vec<(usize, u32)> =
            partners.list.iter().enumerate().map(|(i, p)| (partners.cell_of(p.place), i as u32)).collect();
        sorted.sort_unstable();
        for (cell, _) in &sorted {
            partners.starts[cell + 1] += 1;
        }
        for cell in 0..columns * rows {
            partners.starts[cell + 1] += partners.starts[cell];
        }
        partners.sorted = sorted.iter().map(|(_, i)| (partners.list[*i as usize], *i)).collect();
        partners
    }

    /// The partners within `bounds` that `keep` holds for, in order.
    pub(super) fn part(&self, bounds: Bounds, keep: impl Fn(usize) -> bool) -> Self {
        let bounds = bounds.within(self.bounds);
        let mut kept: Vec<usize> = Vec::new();
        for row in self.row(bounds.min.y)..=self.row(bounds.max.y) {
            let near = self.row_of_cells(row, self.column(bounds.min.x), self.column(bounds.max.x)).iter();
            kept.extend(near.filter(|(p, _)| bounds.contains(p.place)).map(|(_, i)| *i as usize));
        }
        kept.retain(|i| keep(*i));
        kept.sort_unstable();
        Self::new(kept.into_iter().map(|i| self.list[i]).collect(), bounds, self.cell)
    }

    pub(super) fn list(&self) -> &[Partner] {
        &self.list
    }

    pub(super) fn largest_radius(&self) -> f64 {
        self.largest_radius
    }

    pub(super) fn push(&mut self, partner: Partner) {
        self.largest_radius = self.largest_radius.max(partner.radius);
        self.list.push(partner);
        self.insert(partner, self.list.len() - 1);
    }

    /// Moves partner `i` to another place.
    pub(super) fn put(&mut self, i: usize, partner: Partner) {
        let cell = self.cell_of(self.list[i].place);
        let (first, last) = (self.starts[cell] as usize, self.starts[cell + 1] as usize);
        if let Some(at) = self.sorted[first..last].iter().position(|(_, j)| *j as usize == i) {
            self.sorted.remove(first + at);
            self.starts[cell + 1..].iter_mut().for_each(|s| *s -= 1);
        }
        self.list[i] = partner;
        self.insert(partner, i);
    }

    fn insert(&mut self, partner: Partner, i: usize) {
        let cell = self.cell_of(partner.place);
        self.sorted.insert(self.starts[cell + 1] as usize, (partner, i as u32));
        self.starts[cell + 1..].iter_mut().for_each(|s| *s += 1);
    }

    fn cell_of(&self, p: Point) -> usize {
        self.row(p.y) * self.columns + self.column(p.x)
    }

    fn column(&self, x: f64) -> usize {
        (((x - self.bounds.min.x) * self.per_cell).max(0.0) as usize).min(self.columns - 1)
    }

    fn row(&self, y: f64) -> usize {
        (((y - self.bounds.min.y) * self.per_cell).max(0.0) as usize).min(self.rows - 1)
    }

    /// Those in the cells of `row` from column `west` to `east`.
    fn row_of_cells(&self, row: usize, west: usize, east: usize) -> &[(Partner, u32)] {
        let first = row * self.columns;
        &self.sorted[self.starts[first + west] as usize..self.starts[first + east + 1] as usize]
    }

    /// Calls `visit` with the index and partner of all within `radius` metres.
    pub(super) fn for_each_near(&self, p: Point, radius: f64, mut visit: impl FnMut(usize, &Partner)) {
        let radius_sq = radius * radius;
        let (west, east) = (self.column(p.x - radius), self.column(p.x + radius));
        for row in self.row(p.y - radius)..=self.row(p.y + radius) {
            for (partner, i) in self.row_of_cells(row, west, east) {
                if partner.place.distance_sq(p) <= radius_sq {
                    visit(*i as usize, partner);
                }
            }
        }
    }
}
