use crate::compute::geometry::Bounds;
use crate::compute::geometry::Point;

/// A directed piece of a region's border; the region lies on its left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Where it begins.
    pub from: Point,
    /// Where it ends.
    pub to: Point,
}

impl Segment {
    /// Squared distance of `p` to the nearest point of the segment.
    pub fn distance_sq(&self, p: Point) -> f64 {
        let (along, to_p) = (self.to - self.from, p - self.from);
        let length_sq = along.norm_sq();
        let t = if length_sq > 0.0 { (to_p.dot(along) / length_sq).clamp(0.0, 1.0) } else { 0.0 };
        (to_p - along * t).norm_sq()
    }
}

/// Border segments sorted into square cells by their bounding boxes, so that a search visits
/// few of them. Below a few dozen segments there is one cell.
#[derive(Debug, Clone)]
pub(super) struct SegmentIndex {
    bounds: Bounds,
    cell: f64,
    columns: usize,
    rows: usize,
    starts: Vec<u32>,
    order: Vec<u32>,
}

impl SegmentIndex {
    pub(super) fn new(segments: &[Segment], bounds: Bounds) -> Self {
        let cells_wanted = if segments.len() < 48 { 1.0 } else { segments.len() as f64 };
        let longest = bounds.width().max(bounds.height()).max(f64::MIN_POSITIVE);
        let cell = (bounds.area() / cells_wanted).sqrt().max(longest / 2048.0);
        let columns = (bounds.width() / cell).floor() as usize + 1;
        let rows = (bounds.height() / cell).floor() as usize + 1;
        let mut index = Self { bounds, cell, columns, rows, starts: vec![0; columns * rows + 1], order: Vec::new() };
        for s in segments {
            index.for_each_cell(&Bounds::of([s.from, s.to]).unwrap_or(bounds), |index, c| index.starts[c + 1] += 1);
        }
        for c in 0..columns * rows {
            index.starts[c + 1] += index.starts[c];
        }
        let mut next = index.starts.clone();
        index.order = vec![0; index.starts[columns * rows] as usize];
        for (i, s) in segments.iter().enumerate() {
            index.for_each_cell(&Bounds::of([s.from, s.to]).unwrap_or(bounds), |index, c| {
                index.order[next[c] as usize] = i as u32;
                next[c] += 1;
            });
        }
        index
    }

    fn span(&self, from: f64, to: f64, cells: usize) -> std::ops::RangeInclusive<usize> {
        let clamp = |v: f64| (v.max(0.0) as usize).min(cells - 1);
        clamp(from / self.cell)..=clamp(to / self.cell)
    }

    fn for_each_cell(&mut self, bounds: &Bounds, mut visit: impl FnMut(&mut Self, usize)) {
        let columns = self.span(bounds.min.x - self.bounds.min.x, bounds.max.x - self.bounds.min.x, self.columns);
        for row in self.span(bounds.min.y - self.bounds.min.y, bounds.max.y - self.bounds.min.y, self.rows) {
            for column in columns.clone() {
                visit(self, row * self.columns + column);
            }
        }
    }

    /// The indices of all segments whose bounding box comes near `bounds`, ascending, each once.
    pub(super) fn near(&self, bounds: &Bounds) -> Vec<u32> {
        let mut found = Vec::new();
        self.for_each_run_near(bounds, |run| found.extend_from_slice(run));
        if self.columns * self.rows > 1 {
            found.sort_unstable();
            found.dedup();
        }
        found
    }

    /// Calls `visit` with these indices, cell by cell: a segment in several cells comes several times.
    pub(super) fn for_each_run_near(&self, bounds: &Bounds, mut visit: impl FnMut(&[u32])) {
        let columns = self.span(bounds.min.x - self.bounds.min.x, bounds.max.x - self.bounds.min.x, self.columns);
        for row in self.span(bounds.min.y - self.bounds.min.y, bounds.max.y - self.bounds.min.y, self.rows) {
            for column in columns.clone() {
                let c = row * self.columns + column;
                visit(&self.order[self.starts[c] as usize..self.starts[c + 1] as usize]);
            }
        }
    }
}
