use std::ops::{Add, Mul, Neg, Sub};

/// A point or vector in the plane: x east, y north, in metres unless its holder says otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Point {
    /// East.
    pub x: f64,
    /// North.
    pub y: f64,
}

impl Point {
    /// The point (x, y).
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }

    /// The unit vector at `angle` radians counter-clockwise from east.
    pub fn from_angle(angle: f64) -> Self {
        Self::new(libm::cos(angle), libm::sin(angle))
    }

    /// Radians counter-clockwise from east, in (−π, π]; 0 for the null vector.
    pub fn angle(self) -> f64 {
        libm::atan2(self.y, self.x)
    }

    /// Scalar product.
    pub fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y
    }

    /// The z component of the vector product: positive when `other` is to the left.
    pub fn cross(self, other: Self) -> f64 {
        self.x * other.y - self.y * other.x
    }

    /// Length.
    pub fn norm(self) -> f64 {
        self.norm_sq().sqrt()
    }

    /// Squared length.
    pub fn norm_sq(self) -> f64 {
        self.dot(self)
    }

    /// Distance to `other`.
    pub fn distance(self, other: Self) -> f64 {
        (self - other).norm()
    }

    /// Squared distance to `other`.
    pub fn distance_sq(self, other: Self) -> f64 {
        (self - other).norm_sq()
    }

    /// The vector turned by `angle` radians counter-clockwise.
    pub fn rotated(self, angle: f64) -> Self {
        let (s, c) = (libm::sin(angle), libm::cos(angle));
        Self::new(c * self.x - s * self.y, s * self.x + c * self.y)
    }

    /// The vector of length 1 in the same direction; `None` for the null vector.
    pub fn normalised(self) -> Option<Self> {
        let norm = self.norm();
        (norm > 0.0).then(|| self * (1.0 / norm))
    }

    /// The point at fraction `t` of the way to `other`.
    pub fn lerp(self, other: Self, t: f64) -> Self {
        self + (other - self) * t
    }

    /// Whether both coordinates are finite.
    pub fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite()
    }
}

impl Add for Point {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y)
    }
}

impl Sub for Point {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y)
    }
}

impl Mul<f64> for Point {
    type Output = Self;
    fn mul(self, k: f64) -> Self {
        Self::new(self.x * k, self.y * k)
    }
}

impl Neg for Point {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y)
    }
}
