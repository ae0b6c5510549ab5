use crate::compute::geometry::Bounds;
use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Point;

/// Takes points of the world (metres, y up) to pixels (y down), without distortion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Pixels per metre.
    pub scale: f64,
    offset: Point,
}

impl View {
    /// Fits `world` into the rectangle `pixels`, centred, at the same scale in x and y. A world
    /// without extent is shown at one pixel a metre.
    pub fn fit(world: Bounds, pixels: Bounds) -> Self {
        let ratio = |have: f64, need: f64| if need > 0.0 { have / need } else { f64::INFINITY };
        let scale = ratio(pixels.width(), world.width()).min(ratio(pixels.height(), world.height()));
        let scale = if scale.is_finite() { scale } else { 1.0 };
        let (from, to) = ((world.min + world.max) * 0.5, (pixels.min + pixels.max) * 0.5);
        Self { scale, offset: Point::new(to.x - from.x * scale, to.y + from.y * scale) }
    }

    /// Where a point of the world lies, in pixels.
    pub fn at(&self, p: Point) -> Point {
        Point::new(self.offset.x + p.x * self.scale, self.offset.y - p.y * self.scale)
    }

    /// The point of the world at a place in pixels.
    pub fn world(&self, pixel: Point) -> Point {
        Point::new((pixel.x - self.offset.x) / self.scale, (self.offset.y - pixel.y) / self.scale)
    }

    /// Several points.
    pub fn all(&self, points: &[Point]) -> Vec<Point> {
        points.iter().map(|p| self.at(*p)).collect()
    }

    /// An ellipse of the world, in pixels.
    pub fn ellipse(&self, e: &Ellipse) -> Ellipse {
        Ellipse { centre: self.at(e.centre), a: e.a * self.scale, b: e.b * self.scale, theta: -e.theta }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn north_is_up_and_the_world_is_centred_undistorted() {
        let world = Bounds::new(Point::new(100.0, 200.0), Point::new(300.0, 300.0));
        let view = View::fit(world, Bounds::new(Point::new(0.0, 0.0), Point::new(400.0, 400.0)));
        assert_eq!(view.at(Point::new(100.0, 300.0)), Point::new(0.0, 100.0));
        assert_eq!(view.world(Point::new(0.0, 100.0)), Point::new(100.0, 300.0));
        assert_eq!(view.at(Point::new(300.0, 200.0)), Point::new(400.0, 300.0));
        assert_eq!(view.scale, 2.0);
        let e = Ellipse { centre: world.min, a: 3.0, b: 1.0, theta: 0.3 };
        let tip = view.ellipse(&e);
        assert!((view.at(e.centre + e.heading() * e.a)).distance(tip.centre + tip.heading() * tip.a) < 1e-9);
    }

    #[test]
    fn a_single_point_can_be_shown() {
        let p = Point::new(5.0, 5.0);
        let view = View::fit(Bounds::new(p, p), Bounds::new(Point::new(0.0, 0.0), Point::new(10.0, 20.0)));
        assert_eq!(view.at(p), Point::new(5.0, 10.0));
    }
}
