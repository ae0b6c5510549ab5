//! The free-form border of a pattern, learnt from its points (T 3.2.1).

use crate::compute::geometry::Point;
use crate::compute::geometry::Polygon;
use crate::compute::geometry::Region;
use crate::compute::geometry::ring_area_doubled;
use crate::compute::geometry::simple_rings;
use crate::compute::pcf::PcfError;
use crate::compute::pcf::maximal_spacing;
use spade::DelaunayTriangulation;
use spade::Point2;
use spade::Triangulation;

/// Which Delaunay triangles are part of the domain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BorderRule {
    /// Those whose circumradius is at most this many r_max. Ours: on uniform patterns it keeps
    /// the domain whole and still finds holes and bays a few spacings wide.
    Circumradius(f64),
    /// T's: an edge longer than this many times the shortest at either of its ends is dropped,
    /// and a triangle with it. T uses 3, which keeps a fifth of the area of a uniform pattern.
    EdgeRatio(f64),
}

/// How a border is learnt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BorderOptions {
    /// Which triangles are kept. Default: circumradius up to 2 r_max.
    pub rule: BorderRule,
    /// The border is moved outwards by this many √(A/n), because the outermost points lie
    /// inside the domain they were drawn from. Default: 0.4 (see the tests on known domains).
    pub margin: f64,
}

impl Default for BorderOptions {
    fn default() -> Self {
        Self { rule: BorderRule::Circumradius(2.0), margin: 0.4 }
    }
}

/// Rounds in which r_max and the area it comes from are made to agree.
const AREA_ROUNDS: usize = 8;

/// The domain that `points` seem to have been drawn from. Points that no kept triangle holds
/// get a small patch of their own, so that every point lies inside.
///
/// # Errors
/// [`PcfError::NoBorder`] for fewer than three places or when all lie on one line.
pub fn learn_border(points: &[Point], options: &BorderOptions) -> Result<Region, PcfError> {
    let mesh = Mesh::of(points)?;
    let count = points.len() as f64;
    let mut kept = vec![true; mesh.triangles.len()];
    let mut area = mesh.area_of(&kept);
    for _ in 0..AREA_ROUNDS {
        let next = mesh.kept(options.rule, maximal_spacing(area, points.len()));
        let settled = next == kept;
        kept = next;
        area = mesh.area_of(&kept).max(mesh.area_of(&vec![true; kept.len()]) * 1e-6);
        if settled {
            break;
        }
    }
    let margin = options.margin * (area / count).sqrt();
    let mut polygons = mesh.outline(&kept);
    polygons.extend(mesh.lone_points(&kept).map(|p| patch(p, margin.max(1e-3 * (area / count).sqrt()))));
    Ok(Region::from_polygons(&polygons)?.grown(margin))
}

/// A small square around a point that no triangle holds; growing makes it the usual size.
fn patch(p: Point, margin: f64) -> Polygon {
    let h = margin * 1e-3;
    let corner = |x: f64, y: f64| p + Point::new(x * h, y * h);
    Polygon { outer: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)], holes: vec![] }
}

/// The Delaunay triangulation, as plain arrays.
struct Mesh {
    points: Vec<Point>,
    triangles: Vec<[usize; 3]>,
    circumradii: Vec<f64>,
}

impl Mesh {
    fn of(points: &[Point]) -> Result<Self, PcfError> {
        let mut places: Vec<Point> = points.to_vec();
        places.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        places.dedup();
        if places.len() < 3 {
            return Err(PcfError::NoBorder { reason: "fewer than three different places" });
        }
        let sites: Vec<Point2<f64>> = places.iter().map(|p| Point2::new(p.x, p.y)).collect();
        let failed = |_| PcfError::NoBorder { reason: "a coordinate that is not finite or too large" };
        let mesh: DelaunayTriangulation<Point2<f64>> =
            DelaunayTriangulation::bulk_load_stable(sites).map_err(failed)?;
        let triangles: Vec<[usize; 3]> = mesh.inner_faces().map(|f| f.vertices().map(|v| v.index())).collect();
        let circumradii = mesh.inner_faces().map(|f| f.circumcircle().1.sqrt()).collect();
        let mesh = Self { points: places, triangles, circumradii };
        let extent = mesh.points[mesh.points.len() - 1].distance(mesh.points[0]);
        if mesh.area_of(&vec![true; mesh.triangles.len()]) <= extent * extent * 1e-9 {
            return Err(PcfError::NoBorder { reason: "all points lie on one line" });
        }
        Ok(mesh)
    }

    fn area_of(&self, kept: &[bool]) -> f64 {
        let area = |t: &[usize; 3]| ring_area_doubled(&t.map(|v| self.points[v])).abs() / 2.0;
        self.triangles.iter().zip(kept).filter(|(_, kept)| **kept).map(|(t, _)| area(t)).sum()
    }

    fn kept(&self, rule: BorderRule, r_max: f64) -> Vec<bool> {
        match rule {
            BorderRule::Circumradius(most) => self.circumradii.iter().map(|r| *r <= most * r_max).collect(),
            BorderRule::EdgeRatio(most) => {
                let shortest = self.shortest_edges();
                let length = |a: usize, b: usize| self.points[a].distance(self.points[b]);
                let stays = |(a, b): (usize, usize)| length(a, b) <= most * shortest[a].min(shortest[b]);
                self.triangles.iter().map(|t| edges(t).into_iter().all(stays)).collect()
            }
        }
    }

    fn shortest_edges(&self) -> Vec<f64> {
        let mut shortest = vec![f64::INFINITY; self.points.len()];
        for (a, b) in self.triangles.iter().flat_map(edges) {
            let length = self.points[a].distance(self.points[b]);
            shortest[a] = shortest[a].min(length);
            shortest[b] = shortest[b].min(length);
        }
        shortest
    }

    /// The edges that belong to one kept triangle only, chained into rings and polygons.
    fn outline(&self, kept: &[bool]) -> Vec<Polygon> {
        let mut directed: Vec<(usize, usize)> = Vec::new();
        for (t, _) in self.triangles.iter().zip(kept).filter(|(_, kept)| **kept) {
            directed.extend(edges(t));
        }
        directed.sort_unstable();
        let is_border = |(a, b): &(usize, usize)| directed.binary_search(&(*b, *a)).is_err();
        let border: Vec<(usize, usize)> = directed.iter().copied().filter(is_border).collect();
        assemble(self.rings(border))
    }

    /// Chains edges with the domain on their left; where several leave a vertex, the sharpest
    /// left turn keeps parts of the domain apart that only meet there, and what is cut off by a
    /// ring that touches itself is a hole.
    fn rings(&self, border: Vec<(usize, usize)>) -> Vec<Vec<Point>> {
        let mut used = vec![false; border.len()];
        let mut rings = Vec::new();
        for start in 0..border.len() {
            if used[start] {
                continue;
            }
            let (mut edge, mut ring) = (start, Vec::new());
            loop {
                used[edge] = true;
                let (from, to) = border[edge];
                ring.push(self.points[from]);
                let first = border.partition_point(|e| *e < (to, 0));
                let leaving = (first..border.len()).take_while(|e| border[*e].0 == to).filter(|e| !used[*e]);
                let back = self.points[from] - self.points[to];
                let turn = |e: &usize| clockwise_angle(back, self.points[border[*e].1] - self.points[to]);
                match leaving.min_by(|a, b| turn(a).total_cmp(&turn(b))) {
                    Some(next) => edge = next,
                    None => break,
                }
            }
            rings.extend(simple_rings(&ring));
        }
        rings
    }

    fn lone_points(&self, kept: &[bool]) -> impl Iterator<Item = Point> {
        let mut held = vec![false; self.points.len()];
        for v in self.triangles.iter().zip(kept).filter(|(_, kept)| **kept).flat_map(|(t, _)| t) {
            held[*v] = true;
        }
        self.points.iter().zip(held).filter(|(_, held)| !held).map(|(p, _)| *p)
    }
}

fn edges(t: &[usize; 3]) -> [(usize, usize); 3] {
    [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]
}

/// How far one turns clockwise from direction `a` to direction `b`, in (0, 2π].
fn clockwise_angle(a: Point, b: Point) -> f64 {
    let angle = libm::atan2(b.cross(a), b.dot(a)).rem_euclid(std::f64::consts::TAU);
    if angle == 0.0 { std::f64::consts::TAU } else { angle }
}

/// Polygons of rings: counter-clockwise ones are outer, each clockwise one is a hole of the
/// smallest outer ring around it.
fn assemble(rings: Vec<Vec<Point>>) -> Vec<Polygon> {
    let (outer, holes): (Vec<_>, Vec<_>) = rings.into_iter().partition(|r| ring_area_doubled(r) > 0.0);
    let mut polygons: Vec<Polygon> = outer.into_iter().map(|outer| Polygon { outer, holes: Vec::new() }).collect();
    polygons.sort_by(|a, b| ring_area_doubled(&a.outer).total_cmp(&ring_area_doubled(&b.outer)));
    let regions: Vec<Option<Region>> = polygons
        .iter()
        .map(|p| Region::from_normal_form(vec![Polygon { outer: p.outer.clone(), holes: Vec::new() }]).ok())
        .collect();
    for hole in holes.into_iter().filter(|h| h.len() >= 3) {
        let inner = (hole[0] + hole[1]) * 0.5;
        let around = regions.iter().position(|r| r.as_ref().is_some_and(|r| r.contains(inner)));
        if let Some(polygon) = around {
            polygons[polygon].holes.push(hole);
        }
    }
    polygons
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
        let area = |rule| learn_border(&points, &BorderOptions { rule, margin: 0.0 }).unwrap().area();
        assert!(area(BorderRule::EdgeRatio(3.0)) < 0.6 * area(BorderRule::Circumradius(2.0)));
    }
}
