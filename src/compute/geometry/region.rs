use crate::compute::geometry::Bounds;
use crate::compute::geometry::Point;
use crate::compute::geometry::Polygon;
use crate::compute::geometry::PolygonError;
use crate::compute::geometry::Segment;
use crate::compute::geometry::Surroundings;
use crate::compute::geometry::polygon;
use crate::compute::geometry::segment_index::SegmentIndex;
use geo::Buffer;
use geo::algorithm::buffer::BufferStyle;
use geo::algorithm::buffer::LineJoin;

/// A part of the plane bounded by polygons with holes: where a pattern was observed, or where
/// elements may lie. Never empty.
///
/// Everything is exact: area, inside, distance to the border and the arcs of circles. Searches
/// visit only the border near by, so a border of many vertices (a raster mask) costs little.
#[derive(Debug, Clone)]
pub struct Region {
    polygons: Vec<Polygon>,
    segments: Vec<Segment>,
    bounds: Bounds,
    area: f64,
    index: SegmentIndex,
}

impl Region {
    /// The region of a rectangle.
    ///
    /// # Errors
    /// When its area is zero or its corners are not finite.
    pub fn rectangle(bounds: Bounds) -> Result<Self, PolygonError> {
        let (a, b) = (bounds.min, bounds.max);
        let outer = vec![a, Point::new(b.x, a.y), b, Point::new(a.x, b.y)];
        Self::from_polygons(&[Polygon { outer, holes: Vec::new() }])
    }

    /// The union of `polygons`.
    ///
    /// # Errors
    /// When a polygon is not one ([`PolygonError`]) or there is no area.
    pub fn from_polygons(polygons: &[Polygon]) -> Result<Self, PolygonError> {
        Self::from_normal_form(polygon::union(polygons)?)
    }

    /// The region of polygons known to be in normal form: valid, apart from each other, outer
    /// rings counter-clockwise and holes clockwise.
    ///
    /// # Errors
    /// [`PolygonError::NoArea`] when there is no area.
    pub fn from_normal_form(polygons: Vec<Polygon>) -> Result<Self, PolygonError> {
        let area = polygons.iter().flat_map(Polygon::rings).map(polygon::ring_area_doubled).sum::<f64>() / 2.0;
        let bounds = Bounds::of(polygons.iter().flat_map(|p| p.outer.iter().copied())).ok_or(PolygonError::NoArea)?;
        if !(area.is_finite() && area > 0.0) {
            return Err(PolygonError::NoArea);
        }
        let segments: Vec<Segment> = polygons.iter().flat_map(Polygon::rings).flat_map(ring_segments).collect();
        let index = SegmentIndex::new(&segments, bounds);
        Ok(Self { polygons, segments, bounds, area, index })
    }

    /// Area, positive.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// The smallest rectangle around the region.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The polygons in normal form.
    pub fn polygons(&self) -> &[Polygon] {
        &self.polygons
    }

    /// The border, piece by piece, the region on the left.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Whether `p` lies inside; on the border it may or may not.
    pub fn contains(&self, p: Point) -> bool {
        if !self.bounds.contains(p) {
            return false;
        }
        let to_the_east = Bounds::new(p, Point::new(self.bounds.max.x, p.y));
        let crossed = |i: &u32| {
            let Segment { from, to } = self.segments[*i as usize];
            (from.y <= p.y) != (to.y <= p.y) && p.x < from.x + (p.y - from.y) / (to.y - from.y) * (to.x - from.x)
        };
        self.index.near(&to_the_east).iter().filter(|i| crossed(i)).count() % 2 == 1
    }

    /// Whether `p` lies inside or within `tolerance` of the border.
    pub fn contains_within(&self, p: Point, tolerance: f64) -> bool {
        self.contains(p) || self.clearance(p, tolerance * 2.0) <= tolerance
    }

    /// Distance of `p` to the border, but never more than `at_most`.
    pub fn clearance(&self, p: Point, at_most: f64) -> f64 {
        let mut nearest_sq = at_most * at_most;
        self.index.for_each_run_near(&Bounds::new(p, p).grown(at_most), |run| {
            let distances = run.iter().map(|i| self.segments[*i as usize].distance_sq(p));
            nearest_sq = distances.fold(nearest_sq, f64::min);
        });
        nearest_sq.sqrt()
    }

    /// The border around `centre` up to `radius`, for arcs of circles around it.
    pub fn surroundings(&self, centre: Point, radius: f64) -> Surroundings {
        let near = self.index.near(&Bounds::new(centre, centre).grown(radius));
        let relative = near
            .iter()
            .map(|i| self.segments[*i as usize])
            .filter(|&s| s.distance_sq(centre) < radius * radius)
            .map(|s| Segment { from: s.from - centre, to: s.to - centre });
        Surroundings::new(relative.collect(), self.contains(centre))
    }

    /// The region without `other`; `None` when nothing is left.
    pub fn minus(&self, other: &Self) -> Option<Self> {
        Self::from_normal_form(polygon::difference(&self.polygons, &other.polygons)).ok()
    }

    /// What both regions share; `None` when they are apart.
    pub fn intersection(&self, other: &Self) -> Option<Self> {
        Self::from_normal_form(polygon::intersection(&self.polygons, &other.polygons)).ok()
    }

    /// The region with its border moved outwards by `distance`, corners rounded coarsely (a
    /// chord spans at most a radian).
    pub fn grown(&self, distance: f64) -> Self {
        let style = BufferStyle::new(distance).line_join(LineJoin::Round(1.0));
        let grown = polygon::to_geo(&self.polygons).buffer_with_style(style);
        Self::from_normal_form(polygon::from_geo(&grown)).unwrap_or_else(|_| self.clone())
    }
}

fn ring_segments(ring: &[Point]) -> impl Iterator<Item = Segment> {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(a, b)| Segment { from: *a, to: *b })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::random::Purpose;
    use crate::compute::random::Stream;

    fn square(side: f64) -> Vec<Point> {
        vec![Point::new(0.0, 0.0), Point::new(side, 0.0), Point::new(side, side), Point::new(0.0, side)]
    }

    fn shifted(ring: Vec<Point>, by: Point) -> Vec<Point> {
        ring.into_iter().map(|p| p + by).collect()
    }

    fn frame() -> Region {
        let hole = shifted(square(4.0), Point::new(3.0, 3.0));
        Region::from_polygons(&[Polygon { outer: square(10.0), holes: vec![hole] }]).unwrap()
    }

    #[test]
    fn a_hole_is_outside_and_costs_area() {
        let frame = frame();
        assert!((frame.area() - 84.0).abs() < 1e-9);
        assert!(frame.contains(Point::new(1.0, 5.0)) && !frame.contains(Point::new(5.0, 5.0)));
        assert!(!frame.contains(Point::new(11.0, 5.0)));
        assert!((frame.clearance(Point::new(1.5, 5.0), 9.0) - 1.5).abs() < 1e-12);
        assert!((frame.clearance(Point::new(1.5, 5.0), 1.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn overlapping_polygons_are_counted_once() {
        let two = [
            Polygon { outer: square(2.0), holes: Vec::new() },
            Polygon { outer: shifted(square(2.0), Point::new(1.0, 0.0)), holes: Vec::new() },
        ];
        assert!((Region::from_polygons(&two).unwrap().area() - 6.0).abs() < 1e-6);
    }

    #[test]
    fn a_border_of_many_vertices_answers_as_a_plain_scan_does() {
        let ring: Vec<Point> = (0..400)
            .map(|i| {
                let angle = f64::from(i) * std::f64::consts::TAU / 400.0;
                Point::from_angle(angle) * (3.0 + (angle * 7.0).sin())
            })
            .collect();
        let region = Region::from_polygons(&[Polygon { outer: ring, holes: Vec::new() }]).unwrap();
        let mut random = Stream::new(5, Purpose::new("test.region"), 0);
        for _ in 0..500 {
            let p = Point::new(random.range(-4.5, 4.5), random.range(-4.5, 4.5));
            let inside = p.norm() < 3.0 + (p.angle() * 7.0).sin();
            let nearest = region.segments().iter().map(|s| s.distance_sq(p)).fold(f64::MAX, f64::min).sqrt();
            assert!(region.contains(p) == inside || nearest < 0.01);
            assert!((region.clearance(p, 0.5) - nearest.min(0.5)).abs() < 1e-12);
        }
    }

    #[test]
    fn bad_polygons_are_refused_with_the_reason() {
        let bow = vec![Point::new(0.0, 0.0), Point::new(2.0, 2.0), Point::new(2.0, 0.0), Point::new(0.0, 2.5)];
        let even_bow = vec![Point::new(0.0, 0.0), Point::new(2.0, 2.0), Point::new(2.0, 0.0), Point::new(0.0, 2.0)];
        let of = |outer: Vec<Point>| Region::from_polygons(&[Polygon { outer, holes: Vec::new() }]);
        assert!(matches!(of(bow), Err(PolygonError::Crossing { polygon: 0, .. })));
        assert!(matches!(of(even_bow), Err(PolygonError::Crossing { polygon: 0, .. })));
        assert!(matches!(of(square(1.0)[..2].to_vec()), Err(PolygonError::TooFewVertices { found: 2, .. })));
        assert!(matches!(of(vec![Point::new(f64::NAN, 0.0); 4]), Err(PolygonError::NotFinite { .. })));
        let flat = vec![Point::new(0.0, 0.0), Point::new(1.0, 1.0), Point::new(2.0, 2.0)];
        assert_eq!(of(flat).unwrap_err(), PolygonError::NoArea);
        assert_eq!(Region::from_polygons(&[]).unwrap_err(), PolygonError::NoArea);
    }

    #[test]
    fn growing_a_square_adds_its_sides_and_most_of_a_disk() {
        let grown = Region::rectangle(Bounds::new(Point::default(), Point::new(4.0, 4.0))).unwrap().grown(0.5);
        let exact = 16.0 + 4.0 * 4.0 * 0.5 + std::f64::consts::PI * 0.25;
        assert!((grown.area() - exact).abs() < 0.1, "{} {exact}", grown.area());
    }

    #[test]
    fn cutting_a_region_out_of_itself_leaves_nothing() {
        let frame = frame();
        assert!(frame.minus(&frame).is_none());
        let cut = frame.minus(&Region::rectangle(Bounds::new(Point::default(), Point::new(10.0, 3.0))).unwrap());
        assert!((cut.unwrap().area() - 54.0).abs() < 1e-5);
    }
}
