//! The free-form border of a pattern, learnt from its points (T 3.2.1).

use crate::compute::geometry::Point;
use crate::compute::geometry::Polygon;
use crate::compute::geometry::Region;
use crate::compute::pcf::PcfError;
use crate::compute::pcf::inset::inset;
use crate::compute::pcf::maximal_spacing;
use crate::compute::pcf::mesh::Limit;
use crate::compute::pcf::mesh::Mesh;

/// Which Delaunay triangles are part of the domain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BorderRule {
    /// Those no larger than the pattern's own: of a circumradius up to [`LARGEST`] times the
    /// median over the area kept. Ours: that is 2 r_max for points that do not care for each
    /// other, less for those that keep apart, whose holes and bays it follows more closely, and
    /// more for groups, whose gaps it keeps.
    Typical,
    /// Those whose circumradius is at most this many r_max. At 2, uniform patterns keep their
    /// domain whole, and holes and bays a few spacings wide are found.
    Circumradius(f64),
    /// T's: an edge longer than this many times the shortest at either of its ends is dropped,
    /// and a triangle with it. T uses 3, which keeps a fifth of the area of a uniform pattern.
    EdgeRatio(f64),
}

/// How a border is learnt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BorderOptions {
    /// Which triangles are kept. Default: those no larger than the pattern's own.
    pub rule: BorderRule,
    /// The border is moved outwards by this many √(A/n), because the outermost points lie
    /// inside the domain they were drawn from. Default: as far as the points lie inside lines
    /// along which they are cut: about 0.45 for points that do not care for each other, a little
    /// less for those that keep apart, more for groups.
    pub margin: Option<f64>,
}

impl Default for BorderOptions {
    fn default() -> Self {
        Self { rule: BorderRule::Typical, margin: None }
    }
}

/// The largest circumradius over the pattern's own. Ours: it makes the limit of independent
/// points 2 r_max, as the sizes of their triangles are known (Miles 1970: the squared circumradius
/// of triangles drawn by area, times πn/A, has a gamma distribution of shape 3, median 2.674).
const LARGEST: f64 = 2.33;

/// The limit is at least and at most this many r_max, whatever the pattern. Ours: the first is
/// twice the circumradius in a hexagonal lattice; past the second, bays are bridged.
const BOUNDS: [f64; 2] = [1.15, 3.5];

/// Rounds in which the triangles kept and the sizes that follow from them are made to agree.
const ROUNDS: usize = 8;

/// The domain that `points` seem to have been drawn from. Points that no kept triangle holds
/// get a small patch of their own, so that every point lies inside.
///
/// # Errors
/// [`PcfError::NoBorder`] for fewer than three places or when all lie on one line.
pub fn learn_border(points: &[Point], options: &BorderOptions) -> Result<Region, PcfError> {
    // 1. Triangles, and which of them are part of the domain.
    let mesh = Mesh::of(points)?;
    let mut kept = vec![true; mesh.triangles.len()];
    let (hull, mut limit) = (mesh.area_of(&kept), Limit::Circumradius(f64::INFINITY));
    for _ in 0..ROUNDS {
        limit = options.rule.limit(&mesh, &kept, maximal_spacing(area(&mesh, &kept, hull), points.len()));
        let next = mesh.kept(limit);
        let settled = next == kept;
        kept = next;
        if settled {
            break;
        }
    }
    // 2. How far past the outermost points the domain goes on.
    let spacing = (area(&mesh, &kept, hull) / points.len() as f64).sqrt();
    let margin = options.margin.unwrap_or_else(|| inset(&mesh, spacing, limit)) * spacing;
    // 3. Their outline, so much wider.
    let mut polygons = mesh.outline(&kept);
    polygons.extend(mesh.lone_points(&kept).map(|p| patch(p, margin.max(1e-3 * spacing))));
    Ok(Region::from_polygons(&polygons)?.grown(margin))
}

/// The area kept, of which nothing may be left.
fn area(mesh: &Mesh, kept: &[bool], hull: f64) -> f64 {
    mesh.area_of(kept).max(hull * 1e-6)
}

impl BorderRule {
    fn limit(self, mesh: &Mesh, kept: &[bool], r_max: f64) -> Limit {
        match self {
            Self::Typical => {
                let own = LARGEST * mesh.median_circumradius(kept);
                Limit::Circumradius(own.clamp(BOUNDS[0] * r_max, BOUNDS[1] * r_max))
            }
            Self::Circumradius(most) => Limit::Circumradius(most * r_max),
            Self::EdgeRatio(most) => Limit::EdgeRatio(most),
        }
    }
}

/// A small square around a point that no triangle holds; growing makes it the usual size.
fn patch(p: Point, margin: f64) -> Polygon {
    let h = margin * 1e-3;
    let corner = |x: f64, y: f64| p + Point::new(x * h, y * h);
    Polygon { outer: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)], holes: vec![] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::random::Purpose;
    use crate::compute::random::Stream;

    fn uniform(count: usize, seed: u64, inside: impl Fn(Point) -> bool) -> Vec<Point> {
        let mut random = Stream::new(seed, Purpose::new("test.border"), 0);
        std::iter::repeat_with(|| Point::new(random.unit(), random.unit())).filter(|p| inside(*p)).take(count).collect()
    }

    #[test]
    fn a_wide_hole_is_found_and_every_point_is_inside() {
        let hole = |p: Point| p.distance(Point::new(0.5, 0.5)) < 0.25;
        let points = uniform(300, 1, |p| !hole(p));
        let region = learn_border(&points, &BorderOptions::default()).unwrap();
        assert!(!region.contains(Point::new(0.5, 0.5)));
        assert!(points.iter().all(|p| region.contains(*p)));
        assert!((region.area() - (1.0 - 0.0625 * std::f64::consts::PI)).abs() < 0.08, "{}", region.area());
    }

    #[test]
    fn points_far_from_all_others_get_a_patch() {
        let mut points = uniform(200, 2, |_| true);
        points.push(Point::new(5.0, 5.0));
        let region = learn_border(&points, &BorderOptions::default()).unwrap();
        assert!(region.contains(Point::new(5.0, 5.0)) && region.area() < 1.5);
    }

    #[test]
    fn too_few_places_and_lines_have_no_border() {
        let line: Vec<Point> = (0..9).map(|k| Point::new(f64::from(k), 2.0 * f64::from(k) + 1.0)).collect();
        assert!(matches!(learn_border(&line, &BorderOptions::default()), Err(PcfError::NoBorder { .. })));
        let twice = [Point::new(0.0, 0.0), Point::new(1.0, 0.0), Point::new(0.0, 0.0)];
        assert!(matches!(learn_border(&twice, &BorderOptions::default()), Err(PcfError::NoBorder { .. })));
    }

    #[test]
    fn the_rule_of_the_text_keeps_far_less_of_a_uniform_pattern() {
        let points = uniform(300, 3, |_| true);
        let area = |rule| learn_border(&points, &BorderOptions { rule, margin: Some(0.0) }).unwrap().area();
        assert!(area(BorderRule::EdgeRatio(3.0)) < 0.6 * area(BorderRule::Circumradius(2.0)));
    }
}
