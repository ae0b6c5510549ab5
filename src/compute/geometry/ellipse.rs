use crate::compute::geometry::Point;

/// An oriented ellipse: an animal seen from above.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ellipse {
    /// Centre.
    pub centre: Point,
    /// Semi-major axis, at least `b`.
    pub a: f64,
    /// Semi-minor axis, positive.
    pub b: f64,
    /// Heading along the major axis, radians counter-clockwise from east.
    pub theta: f64,
}

impl Ellipse {
    /// How many times larger the ellipse would have to be for `p` to lie on its rim: 0 at the
    /// centre, 1 on the rim (T eq. 4.2, H eq. 2).
    pub fn scale_to(&self, p: Point) -> f64 {
        let local = (p - self.centre).rotated(-self.theta);
        ((local.x / self.a).powi(2) + (local.y / self.b).powi(2)).sqrt()
    }

    /// Area, πab.
    pub fn area(&self) -> f64 {
        std::f64::consts::PI * self.a * self.b
    }

    /// The unit vector along the heading.
    pub fn heading(&self) -> Point {
        Point::from_angle(self.theta)
    }

    /// The same ellipse facing the other way, its angle in (−π, π].
    pub fn flipped(self) -> Self {
        Self { theta: (-self.heading()).angle(), ..self }
    }

    /// Whether centre and axes are finite and the axes positive, `a` the longer one.
    pub fn is_valid(&self) -> bool {
        self.centre.is_finite() && self.theta.is_finite() && self.a.is_finite() && self.b > 0.0 && self.a >= self.b
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_is_one_on_the_rim_and_grows_in_proportion() {
        let e = Ellipse { centre: Point::new(3.0, -1.0), a: 4.0, b: 2.0, theta: 0.7 };
        let along = e.heading();
        let across = Point::new(-along.y, along.x);
        assert!((e.scale_to(e.centre + along * 4.0) - 1.0).abs() < 1e-12);
        assert!((e.scale_to(e.centre + across * 2.0) - 1.0).abs() < 1e-12);
        assert!((e.scale_to(e.centre + across * 5.0) - 2.5).abs() < 1e-12);
        assert_eq!(e.scale_to(e.centre), 0.0);
    }

    #[test]
    fn flipping_twice_gives_the_same_heading() {
        let e = Ellipse { centre: Point::default(), a: 2.0, b: 1.0, theta: 3.0 };
        assert!((e.flipped().theta - (3.0 - std::f64::consts::PI)).abs() < 1e-12);
        assert!((e.flipped().flipped().theta - 3.0).abs() < 1e-12);
    }
}
