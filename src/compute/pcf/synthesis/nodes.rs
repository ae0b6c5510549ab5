use crate::compute::geometry::Bounds;
use crate::compute::geometry::Point;

/// A grid of places over a block, between which fields are bilinear.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nodes {
    origin: Point,
    /// Metres from one node to the next.
    pub(super) step: f64,
    pub(super) columns: usize,
    pub(super) rows: usize,
}

impl Nodes {
    /// Nodes `step` metres apart, as many as hold `bounds` between them.
    pub(super) fn over(bounds: Bounds, step: f64) -> Self {
        let size = |extent: f64| (extent / step) as usize + 2;
        Self { origin: bounds.min, step, columns: size(bounds.width()), rows: size(bounds.height()) }
    }

    /// Where a node is.
    pub(super) fn place(&self, column: usize, row: usize) -> Point {
        self.origin + Point::new(column as f64, row as f64) * self.step
    }

    /// The numbers, row by row, of the four nodes around `p` and their shares in a value there.
    pub(super) fn corners(&self, p: Point) -> [(usize, f64); 4] {
        let at = (p - self.origin) * (1.0 / self.step);
        let cell = |v: f64, count: usize| (v.max(0.0) as usize).min(count - 2);
        let (column, row) = (cell(at.x, self.columns), cell(at.y, self.rows));
        let (u, v) = ((at.x - column as f64).clamp(0.0, 1.0), (at.y - row as f64).clamp(0.0, 1.0));
        let corners = [(0, 0, (1.0 - u) * (1.0 - v)), (1, 0, u * (1.0 - v)), (0, 1, (1.0 - u) * v), (1, 1, u * v)];
        corners.map(|(x, y, share)| ((row + y) * self.columns + column + x, share))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_linear_is_read_as_it_is() {
        let nodes = Nodes::over(Bounds::new(Point::new(2.0, -1.0), Point::new(5.0, 4.0)), 0.7);
        let value = |p: Point| 3.0 * p.x - 2.0 * p.y + 1.0;
        for p in [Point::new(2.0, -1.0), Point::new(3.3, 0.2), Point::new(5.0, 4.0)] {
            let read: f64 = nodes
                .corners(p)
                .iter()
                .map(|(node, share)| share * value(nodes.place(node % nodes.columns, node / nodes.columns)))
                .sum();
            assert!((read - value(p)).abs() < 1e-12, "{p:?}: {read}");
        }
    }
}
