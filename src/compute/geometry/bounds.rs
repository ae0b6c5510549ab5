use super::Point;

/// An axis-parallel rectangle, borders included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// South-west corner.
    pub min: Point,
    /// North-east corner.
    pub max: Point,
}

impl Bounds {
    /// The rectangle between two corners; `min` must not exceed `max`.
    pub const fn new(min: Point, max: Point) -> Self {
        Self { min, max }
    }

    /// The smallest rectangle that holds all `points`; `None` when there are none.
    pub fn of(points: impl IntoIterator<Item = Point>) -> Option<Self> {
        points.into_iter().fold(None, |bounds, p| {
            let b = bounds.unwrap_or(Self::new(p, p));
            Some(Self::new(
                Point::new(b.min.x.min(p.x), b.min.y.min(p.y)),
                Point::new(b.max.x.max(p.x), b.max.y.max(p.y)),
            ))
        })
    }

    /// East-west extent.
    pub fn width(&self) -> f64 {
        self.max.x - self.min.x
    }

    /// North-south extent.
    pub fn height(&self) -> f64 {
        self.max.y - self.min.y
    }

    /// Area.
    pub fn area(&self) -> f64 {
        self.width() * self.height()
    }

    /// Whether the rectangle holds `p`, borders included.
    pub fn contains(&self, p: Point) -> bool {
        (self.min.x..=self.max.x).contains(&p.x) && (self.min.y..=self.max.y).contains(&p.y)
    }

    /// The part of the rectangle within `other`; the nearest edge of `other` when they are apart.
    pub fn within(&self, other: Self) -> Self {
        let clamp = |p: Point| Point::new(p.x.clamp(other.min.x, other.max.x), p.y.clamp(other.min.y, other.max.y));
        Self::new(clamp(self.min), clamp(self.max))
    }

    /// The rectangle grown by `margin` on every side.
    pub fn grown(&self, margin: f64) -> Self {
        let m = Point::new(margin, margin);
        Self::new(self.min - m, self.max + m)
    }
}
