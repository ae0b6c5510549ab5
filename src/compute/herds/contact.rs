//! How deep two animals overlap.

use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Point;

/// Directions tried on either side of the line of centres.
const SIDES: usize = 6;

/// Angle between them.
const STEP: f64 = std::f64::consts::FRAC_PI_2 / SIDES as f64;

/// An ellipse made ready for many tests.
#[derive(Debug, Clone, Copy)]
pub struct Footprint {
    centre: Point,
    heading: Point,
    a_sq: f64,
    b_sq: f64,
    /// Semi-major axis.
    a: f64,
}

impl Footprint {
    /// The footprint of an ellipse.
    pub fn new(ellipse: &Ellipse) -> Self {
        Self::at(ellipse.centre, ellipse.heading(), (ellipse.a, ellipse.b))
    }

    /// The footprint of a body with semi-axes (a, b) at a place, heading along a unit vector.
    pub fn at(centre: Point, heading: Point, (a, b): (f64, f64)) -> Self {
        Self { centre, heading, a_sq: a * a, b_sq: b * b, a }
    }

    /// Centre.
    pub fn centre(&self) -> Point {
        self.centre
    }

    /// The unit vector along the heading.
    pub fn heading(&self) -> Point {
        self.heading
    }

    /// How far the ellipse reaches from its centre along the unit vector `u`.
    pub fn support(&self, u: Point) -> f64 {
        let (along, across) = (self.heading.dot(u), self.heading.cross(u));
        (self.a_sq * along * along + self.b_sq * across * across).sqrt()
    }

    /// How far apart the two would have to be moved to touch no more, in metres; negative when
    /// they are apart. The least over twelve directions around the line of centres, refined by
    /// parabolas: never less than the true depth, and within about 2 % of a body's width of it.
    pub fn depth(&self, other: &Self) -> f64 {
        let offset = other.centre - self.centre;
        let distance_sq = offset.norm_sq();
        let reach = self.a + other.a;
        if distance_sq > reach * reach {
            return -distance_sq.sqrt() + reach;
        }
        let line = offset.normalised().unwrap_or(Point::new(1.0, 0.0));
        let along = |u: Point| self.support(u) + other.support(u) - offset.dot(u);
        let first = along(line);
        if first <= 0.0 {
            return first;
        }
        let side = Point::new(-line.y, line.x);
        let mut depths = [first; 2 * SIDES + 1];
        for (i, depth) in depths.iter_mut().enumerate() {
            let (sin, cos) = TURNS[i.abs_diff(SIDES)];
            let sin = if i < SIDES { -sin } else { sin };
            *depth = along(line * cos + side * sin);
            if *depth <= 0.0 {
                return *depth;
            }
        }
        // The depth may have a valley on either side of the line of centres: each is refined.
        let is_valley = |i: usize| {
            let at = |j: Option<usize>| j.and_then(|j| depths.get(j)).is_none_or(|d| depths[i] <= *d);
            at(i.checked_sub(1)) && at(Some(i + 1))
        };
        let valleys = (0..depths.len()).filter(|i| is_valley(*i));
        valleys.fold(first, |least, i| {
            let start = (depths[i], i as i32 - SIDES as i32);
            least.min(refine(start, |angle| along(line * libm::cos(angle) + side * libm::sin(angle))))
        })
    }
}

/// Rounds of refinement; each looks a third as far aside as the one before.
const ROUNDS: i32 = 3;

/// The minimum near the best direction: the minimum of the parabola through it and its neighbours,
/// then of narrower ones.
fn refine((mut depth, k): (f64, i32), along: impl Fn(f64) -> f64) -> f64 {
    let (mut middle, mut step) = (f64::from(k) * STEP, STEP);
    for _ in 0..ROUNDS {
        let (left, right) = (along(middle - step), along(middle + step));
        let bend = left - 2.0 * depth + right;
        let shift = if bend > 0.0 { step * (0.5 * (left - right) / bend).clamp(-1.0, 1.0) } else { 0.0 };
        for (angle, found) in [(middle - step, left), (middle + step, right), (middle + shift, along(middle + shift))] {
            if found < depth {
                (depth, middle) = (found, angle);
            }
        }
        step /= 3.0;
    }
    depth
}

/// Sine and cosine of 0, 15, … 90 degrees.
const TURNS: [(f64, f64); SIDES + 1] = [
    (0.0, 1.0),
    (0.258_819_045_102_520_76, 0.965_925_826_289_068_3),
    (0.5, 0.866_025_403_784_438_6),
    (std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2),
    (0.866_025_403_784_438_6, 0.5),
    (0.965_925_826_289_068_3, 0.258_819_045_102_520_76),
    (1.0, 0.0),
];

/// The deepest overlap among `ellipses` in metres; 0 when none overlap.
pub fn deepest(ellipses: &[Ellipse]) -> f64 {
    let centres: Vec<Point> = ellipses.iter().map(|e| e.centre).collect();
    let largest = ellipses.iter().map(|e| e.a).fold(0.0, f64::max);
    let near = crate::compute::geometry::CellGrid::new(&centres, 2.0 * largest);
    let prints: Vec<Footprint> = ellipses.iter().map(Footprint::new).collect();
    let mut deepest = 0f64;
    for (i, one) in prints.iter().enumerate() {
        near.for_each_near(one.centre, one.a + largest, |j| {
            if j > i {
                deepest = deepest.max(one.depth(&prints[j]));
            }
        });
    }
    deepest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::random::Purpose;
    use crate::compute::random::Stream;

    fn ellipse(x: f64, y: f64, theta: f64) -> Ellipse {
        Ellipse { centre: Point::new(x, y), a: 2.0, b: 0.8, theta }
    }

    #[test]
    fn depths_of_simple_pairs_are_known() {
        let depth = |other: Ellipse| Footprint::new(&ellipse(0.0, 0.0, 0.0)).depth(&Footprint::new(&other));
        assert!((depth(ellipse(3.7, 0.0, 0.0)) - 0.3).abs() < 1e-9);
        assert!((depth(ellipse(0.0, 1.5, 0.0)) - 0.1).abs() < 1e-9);
        assert!((depth(ellipse(0.0, 2.7, std::f64::consts::FRAC_PI_2)) - 0.1).abs() < 1e-6);
        assert!(depth(ellipse(4.2, 0.0, 0.0)) < 0.0);
        assert!(depth(ellipse(1.9, 1.5, 0.0)) < 0.0);
    }

    #[test]
    fn the_depth_is_the_least_move_that_parts_the_two() {
        let mut random = Stream::new(1, Purpose::new("test.contact"), 0);
        for _ in 0..300 {
            let one = Ellipse { theta: random.range(-3.0, 3.0), ..ellipse(0.0, 0.0, 0.0) };
            let two = ellipse(random.range(-3.0, 3.0), random.range(-3.0, 3.0), random.range(-3.0, 3.0));
            let (p, q) = (Footprint::new(&one), Footprint::new(&two));
            let exact = (0..3600)
                .map(|k| Point::from_angle(f64::from(k) * std::f64::consts::PI / 1800.0))
                .map(|u| p.support(u) + q.support(u) - (two.centre - one.centre).dot(u))
                .fold(f64::INFINITY, f64::min);
            let found = p.depth(&q);
            if exact > 0.0 {
                assert!(found >= exact - 1e-5 && found < exact + 0.04, "{found} {exact}");
                assert!((found - q.depth(&p)).abs() < 1e-9);
            } else {
                assert!(found < 0.04, "{found} {exact}");
            }
        }
    }
}
