use crate::compute::geometry::Point;
use crate::compute::geometry::Segment;
use std::f64::consts::FRAC_PI_2;
use std::f64::consts::PI;
use std::f64::consts::TAU;

/// Sums of crossing angles nearer than this to a whole turn are decided by a point test.
const WHOLE_TURN_TOLERANCE: f64 = 1e-9;

/// The same for angles by [`rough_angle`].
const ROUGH_WHOLE_TURN_TOLERANCE: f64 = 1e-6;

/// The arc tangent from 0 to 1 within 2·10⁻⁸: a polynomial in the square of its argument, lowest
/// power first (Abramowitz and Stegun 1964, 4.4.49).
const ARC_TANGENT: [f64; 9] = [
    1.0,
    -0.333_331_452_8,
    0.199_935_508_5,
    -0.142_088_994_4,
    0.106_562_639_3,
    -0.075_289_640_0,
    0.042_909_613_8,
    -0.016_165_736_7,
    0.002_866_225_7,
];

/// The border of a region seen from one place: how much of each circle around that place lies
/// inside (T eq. 3.8), exactly.
///
/// With the region on the left of every border segment, a circle walked counter-clockwise
/// enters where a segment leaves the disk and exits where one enters it. The angle inside is
/// the sum of exit angles minus the sum of entry angles, modulo a whole turn: no sorting, and
/// circles through vertices are no special case, because both segments at a vertex agree on
/// which side of the circle it lies.
#[derive(Debug, Clone)]
pub struct Surroundings {
    pieces: Vec<Piece>,
    inside: bool,
}

#[derive(Debug, Clone, Copy)]
struct Piece {
    segment: Segment,
    nearest_sq: f64,
    from_sq: f64,
    to_sq: f64,
}

impl Surroundings {
    /// From the border `segments` relative to the place, and whether the place is `inside`.
    /// All segments nearer than the largest circle asked for must be there.
    pub fn new(segments: Vec<Segment>, inside: bool) -> Self {
        let piece = |segment: Segment| Piece {
            segment,
            nearest_sq: segment.distance_sq(Point::default()),
            from_sq: segment.from.norm_sq(),
            to_sq: segment.to.norm_sq(),
        };
        let mut pieces: Vec<Piece> = segments.into_iter().map(piece).collect();
        pieces.sort_by(|a, b| a.nearest_sq.total_cmp(&b.nearest_sq));
        Self { pieces, inside }
    }

    /// The same border after `map`, which must be linear and keep the sense of rotation.
    pub fn mapped(&self, map: impl Fn(Point) -> Point) -> Self {
        let segment = |p: &Piece| Segment { from: map(p.segment.from), to: map(p.segment.to) };
        Self::new(self.pieces.iter().map(segment).collect(), self.inside)
    }

    /// Whether the place lies inside the region.
    pub fn is_inside(&self) -> bool {
        self.inside
    }

    /// Distance to the nearest border; infinite when none is near.
    pub fn clearance(&self) -> f64 {
        self.pieces.first().map_or(f64::INFINITY, |p| p.nearest_sq.sqrt())
    }

    /// The angle, 0 to 2π, of the circle of `radius` that lies inside the region.
    pub fn arc_inside(&self, radius: f64) -> f64 {
        self.arc_by(radius, (Point::angle, WHOLE_TURN_TOLERANCE))
    }

    /// The same within 10⁻⁶, several times as fast.
    pub fn arc_inside_roughly(&self, radius: f64) -> f64 {
        self.arc_by(radius, (rough_angle, ROUGH_WHOLE_TURN_TOLERANCE))
    }

    fn arc_by(&self, radius: f64, (angle_of, tolerance): (impl Fn(Point) -> f64, f64)) -> f64 {
        let radius_sq = radius * radius;
        let (mut sum, mut last) = (0.0, None);
        for piece in self.pieces.iter().take_while(|p| p.nearest_sq < radius_sq) {
            let (entry, exit) = piece.crossings(radius_sq);
            if let Some(p) = exit {
                let angle = angle_of(p);
                sum += angle;
                last = Some(angle);
            }
            if let Some(p) = entry {
                let angle = angle_of(p);
                sum -= angle;
                last = Some(angle);
            }
        }
        let turn = sum.rem_euclid(TAU);
        match last {
            Some(_) if turn > tolerance && turn < TAU - tolerance => turn,
            Some(angle) => self.whole_or_nothing(Point::from_angle(angle + PI) * radius),
            None => self.whole_or_nothing(Point::new(radius, 0.0)),
        }
    }

    fn whole_or_nothing(&self, on_circle: Point) -> f64 {
        if self.contains(on_circle) { TAU } else { 0.0 }
    }

    /// Whether `p`, nearer than all missing segments, is inside: the parity of the border
    /// crossings on the way there.
    fn contains(&self, p: Point) -> bool {
        let crossed = |s: &Segment| {
            let (a, b) = (p.cross(s.from), p.cross(s.to));
            if (a <= 0.0) == (b <= 0.0) {
                return false;
            }
            let along = (s.from + (s.to - s.from) * (a / (a - b))).dot(p);
            along > 0.0 && along < p.norm_sq()
        };
        self.inside ^ (self.pieces.iter().filter(|p| crossed(&p.segment)).count() % 2 == 1)
    }
}

/// [`Point::angle`] within 3·10⁻⁸.
fn rough_angle(p: Point) -> f64 {
    let (x, y) = (p.x.abs(), p.y.abs());
    let ratio = x.min(y) / x.max(y).max(f64::MIN_POSITIVE);
    let square = ratio * ratio;
    let octant = ratio * ARC_TANGENT.iter().rev().fold(0.0, |sum, c| sum * square + c);
    let quadrant = if y > x { FRAC_PI_2 - octant } else { octant };
    let half = if p.x < 0.0 { PI - quadrant } else { quadrant };
    if p.y < 0.0 { -half } else { half }
}

impl Piece {
    /// Where a walk around the circle enters the region over this piece, and where it exits.
    fn crossings(&self, radius_sq: f64) -> (Option<Point>, Option<Point>) {
        let (from_out, to_out) = (self.from_sq >= radius_sq, self.to_sq >= radius_sq);
        if !from_out && !to_out {
            return (None, None);
        }
        let along = self.segment.to - self.segment.from;
        let (a, b) = (along.norm_sq(), self.segment.from.dot(along));
        let root = (b * b - a * (self.from_sq - radius_sq)).max(0.0).sqrt();
        let at = |t: f64| self.segment.from + along * t.clamp(0.0, 1.0);
        (to_out.then(|| at((root - b) / a)), from_out.then(|| at((-root - b) / a)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::geometry::Bounds;
    use crate::compute::geometry::Polygon;
    use crate::compute::geometry::Region;
    use crate::compute::random::Purpose;
    use crate::compute::random::Stream;

    fn unit_square() -> Region {
        Region::rectangle(Bounds::new(Point::default(), Point::new(1.0, 1.0))).unwrap()
    }

    #[test]
    fn arcs_in_a_rectangle_have_their_closed_form() {
        let region = unit_square();
        let middle_of_a_side = region.surroundings(Point::new(0.5, 0.0), 2.0);
        let corner = region.surroundings(Point::new(0.0, 0.0), 2.0);
        let centre = region.surroundings(Point::new(0.5, 0.5), 2.0);
        assert!((middle_of_a_side.arc_inside(0.3) - TAU / 2.0).abs() < 1e-9);
        assert!((corner.arc_inside(0.7) - TAU / 4.0).abs() < 1e-9);
        assert_eq!(centre.arc_inside(0.4), TAU);
        assert!((centre.arc_inside(0.6) - (TAU - 8.0 * (0.5_f64 / 0.6).acos())).abs() < 1e-9);
        assert_eq!(centre.arc_inside(0.8), 0.0);
    }

    #[test]
    fn arcs_in_a_region_with_a_hole_agree_with_counted_points_on_the_circle() {
        let hole = vec![Point::new(3.0, 3.0), Point::new(7.0, 3.5), Point::new(6.0, 7.0), Point::new(3.0, 6.0)];
        let outer = vec![
            Point::new(0.0, 0.0),
            Point::new(10.0, 0.0),
            Point::new(10.0, 4.0),
            Point::new(8.0, 5.0),
            Point::new(10.0, 10.0),
            Point::new(0.0, 9.0),
        ];
        let region = Region::from_polygons(&[Polygon { outer, holes: vec![hole] }]).unwrap();
        let mut random = Stream::new(1, Purpose::new("test.arcs"), 0);
        for _ in 0..300 {
            let centre = Point::new(random.range(-1.0, 11.0), random.range(-1.0, 11.0));
            let radius = random.range(0.05, 12.0);
            let n = 4000;
            let on = |k: i32| centre + Point::from_angle(TAU * (f64::from(k) + 0.5) / f64::from(n)) * radius;
            let counted = (0..n).filter(|k| region.contains(on(*k))).count() as f64 / f64::from(n) * TAU;
            let exact = region.surroundings(centre, 13.0).arc_inside(radius);
            assert!((exact - counted).abs() < 0.01, "{centre:?} {radius}: {exact} {counted}");
        }
    }

    #[test]
    fn rough_angles_and_arcs_are_near_the_exact_ones() {
        let mut random = Stream::new(2, Purpose::new("test.angles"), 0);
        for _ in 0..2000 {
            let p = Point::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0));
            assert!((rough_angle(p) - p.angle()).abs() < 3e-8, "{p:?}");
            let around = unit_square().surroundings(p, 2.0);
            let radius = random.range(0.0, 2.0);
            assert!((around.arc_inside_roughly(radius) - around.arc_inside(radius)).abs() < 2e-6, "{p:?} {radius}");
        }
        let axes = [Point::new(1.0, 0.0), Point::new(0.0, 1.0), Point::new(-1.0, 0.0), Point::new(0.0, -1.0)];
        assert!(axes.iter().all(|p| (rough_angle(*p) - p.angle()).abs() < 3e-8));
        assert_eq!(rough_angle(Point::default()), 0.0);
    }

    #[test]
    fn circles_through_vertices_and_along_borders_stay_within_a_turn() {
        let region = unit_square();
        for (centre, radius, expected) in [
            (Point::new(0.5, 0.5), 0.5, TAU),
            (Point::new(0.5, 0.5), 0.5_f64.sqrt(), 0.0),
            (Point::new(0.0, 0.0), 1.0, TAU / 4.0),
        ] {
            let arc = region.surroundings(centre, 2.0).arc_inside(radius);
            assert!((arc - expected).abs() < 1e-6, "{centre:?} {radius}: {arc}");
        }
    }

    #[test]
    fn in_the_frame_of_an_ellipse_the_ring_is_a_circle_and_the_region_a_polygon() {
        let around = unit_square().surroundings(Point::new(0.5, 0.0), 4.0);
        let half = around.mapped(|p| Point::new(p.x / 2.0, p.y / 0.5));
        assert!((half.arc_inside(0.2) - TAU / 2.0).abs() < 1e-9);
    }
}
