//! What is learnt from the animals of a photo: their domain, orientation field and density map
//! (T 4.2.2, 4.2.3).

use super::KeyHerdError;
use super::hull;
use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Point;
use spade::DelaunayTriangulation;
use spade::HasPosition;
use spade::Point2;
use spade::PositionInTriangulation;
use spade::Triangulation;
use std::f64::consts::TAU;

/// Whether the headings of an exemplar can be trusted, or only its axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Headings {
    /// Each animal looks where its ellipse says.
    #[default]
    Trusted,
    /// Only axes are known: angles are interpolated doubled, and all look towards the exemplar's
    /// own direction.
    Axes,
}

/// Below this length a mean of unit vectors has no direction (ours).
const VANISHING: f64 = 0.05;

/// An animal as a vertex of the triangulation.
struct Vertex {
    place: Point,
    index: usize,
}

impl HasPosition for Vertex {
    type Scalar = f64;
    fn position(&self) -> Point2<f64> {
        Point2::new(self.place.x, self.place.y)
    }
}

type Mesh = DelaunayTriangulation<Vertex>;

/// A herd to learn from, in the unit of its photo.
pub(super) struct Exemplar {
    /// The triangulation of the centres; `None` for a herd of one, two or in a line.
    mesh: Option<Mesh>,
    /// The convex hull of the centres, counter-clockwise.
    hull: Vec<Point>,
    /// Corners of the domain, counter-clockwise: the hull enlarged, or the fallback.
    pub corners: Vec<Point>,
    /// Unit vectors, doubled in angle when only axes are known.
    vectors: Vec<Point>,
    /// Animals per unit of area at each animal.
    densities: Vec<f64>,
    /// Where the herd is: the mean of the animals' centres.
    pub centre: Point,
    /// The direction it looks in: the mean heading.
    pub direction: Point,
    /// Mean area of an ellipse.
    pub mean_area: f64,
    headings: Headings,
}

impl Exemplar {
    /// Learns from `ellipses`.
    pub(super) fn new(ellipses: &[Ellipse], headings: Headings) -> Result<Self, KeyHerdError> {
        if ellipses.is_empty() {
            return Err(KeyHerdError::NoExemplar);
        }
        if let Some(index) = ellipses.iter().position(|e| !e.is_valid()) {
            return Err(KeyHerdError::BadEllipse { index });
        }
        let n = ellipses.len() as f64;
        let sum = ellipses.iter().fold(Point::default(), |s, e| s + e.heading());
        let mean_area = ellipses.iter().map(Ellipse::area).sum::<f64>() / n;
        let centres: Vec<Point> = ellipses.iter().map(|e| e.centre).collect();
        let rim = hull::convex(&centres);
        let wide = hull::is_wide(&rim, mean_area);
        let mesh = if wide { mesh(&centres) } else { None };
        let corners =
            if mesh.is_some() { hull::enlarged(&rim, ellipses.len()) } else { hull::around(&centres, mean_area) };
        let even = n / hull::area(&corners);
        Ok(Self {
            densities: mesh.as_ref().map_or_else(|| vec![even; ellipses.len()], |m| densities(m, ellipses.len())),
            vectors: ellipses.iter().map(|e| vector(e, headings)).collect(),
            mesh,
            hull: rim,
            corners,
            centre: centres.iter().fold(Point::default(), |s, c| s + *c) * (1.0 / n),
            direction: sum.normalised().unwrap_or_else(|| ellipses[0].heading()),
            mean_area,
            headings,
        })
    }

    /// Whether there is a hull, so that a curve and maps can be learnt.
    pub(super) fn is_wide(&self) -> bool {
        self.mesh.is_some()
    }

    /// Number of animals.
    pub(super) fn count(&self) -> usize {
        self.vectors.len()
    }

    /// Orientation (a unit vector) and density (animals per unit of area) at a place of the
    /// domain; outside the hull of the centres those of its nearest place (T 4.2.3).
    pub(super) fn at(&self, p: Point) -> (Point, f64) {
        let Some(mesh) = &self.mesh else {
            return (self.direction, self.densities[0]);
        };
        let p = if hull::contains(&self.hull, p) { p } else { hull::nearest(&self.hull, p) };
        match mesh.locate(Point2::new(p.x, p.y)) {
            PositionInTriangulation::OnFace(face) => {
                let vertices = mesh.face(face).vertices().map(|v| (v.data().place, v.data().index));
                self.mixed(&barycentric(vertices, p))
            }
            PositionInTriangulation::OnEdge(edge) | PositionInTriangulation::OutsideOfConvexHull(edge) => {
                let [a, b] = mesh.directed_edge(edge).vertices().map(|v| (v.data().place, v.data().index));
                let t = hull::share_along((a.0, b.0), p);
                self.mixed(&[(a.1, 1.0 - t), (b.1, t)])
            }
            PositionInTriangulation::OnVertex(v) => self.mixed(&[(mesh.vertex(v).data().index, 1.0)]),
            PositionInTriangulation::NoTriangulation => (self.direction, 0.0),
        }
    }

    /// Mean of unit vectors and densities by weight; where the vectors cancel, the vector of the
    /// heaviest vertex, which is the nearest.
    fn mixed(&self, weights: &[(usize, f64)]) -> (Point, f64) {
        let density = weights.iter().map(|(i, w)| self.densities[*i] * w).sum();
        let sum = weights.iter().fold(Point::default(), |s, (i, w)| s + self.vectors[*i] * *w);
        let heaviest = weights.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(i, _)| *i);
        let mean = if sum.norm() > VANISHING { sum * (1.0 / sum.norm()) } else { self.vectors[heaviest] };
        (self.heading_of(mean), density)
    }

    /// Undoes the doubling of axes.
    fn heading_of(&self, mean: Point) -> Point {
        match self.headings {
            Headings::Trusted => mean,
            Headings::Axes => {
                let half = Point::from_angle(mean.angle() / 2.0);
                if half.dot(self.direction) < 0.0 { -half } else { half }
            }
        }
    }
}

fn vector(ellipse: &Ellipse, headings: Headings) -> Point {
    match headings {
        Headings::Trusted => ellipse.heading(),
        Headings::Axes => Point::from_angle(2.0 * ellipse.theta),
    }
}

fn mesh(centres: &[Point]) -> Option<Mesh> {
    let vertices = centres.iter().enumerate().map(|(index, place)| Vertex { place: *place, index }).collect();
    Mesh::bulk_load_stable(vertices).ok().filter(|mesh| mesh.num_inner_faces() > 0)
}

/// Triangles with an angle above this, 150 degrees, are slivers (ours): along the rim they close
/// the hull over bays, so that an animal there would seem to have its full ring of hardly any area.
const SLIVER_RAD: f64 = 2.618;

/// The density at each animal: the inverse of the area of its ring of triangles (T 4.2.3), times
/// three, for each triangle is in the rings of three animals. A vertex of the hull has a ring on
/// one side only: its area is scaled to the full turn (ours, so that rims are not twice as dense).
fn densities(mesh: &Mesh, count: usize) -> Vec<f64> {
    let mut all = vec![Ring::default(); count];
    let mut plump = all.clone();
    for face in mesh.inner_faces() {
        let corners = face.vertices().map(|v| (v.data().place, v.data().index));
        let seen = [0, 1, 2].map(|k| {
            let (u, v) = (corners[(k + 1) % 3].0 - corners[k].0, corners[(k + 2) % 3].0 - corners[k].0);
            Ring { area: u.cross(v).abs() / 2.0, angle: libm::atan2(u.cross(v).abs(), u.dot(v)) }
        });
        let is_sliver = seen.iter().any(|ring| ring.angle > SLIVER_RAD);
        for ((_, index), part) in corners.into_iter().zip(seen) {
            all[index].add(part);
            if !is_sliver {
                plump[index].add(part);
            }
        }
    }
    // Who stands among slivers only has no better ring.
    plump.iter().zip(&all).map(|(plump, all)| if plump.area > 0.0 { plump.density() } else { all.density() }).collect()
}

/// What the triangles around an animal cover.
#[derive(Debug, Clone, Copy, Default)]
struct Ring {
    area: f64,
    angle: f64,
}

impl Ring {
    fn add(&mut self, part: Self) {
        self.area += part.area;
        self.angle += part.angle;
    }

    /// An animal at the very place of another has no triangles of its own.
    fn density(&self) -> f64 {
        if self.area > 0.0 { 3.0 * self.angle / (TAU * self.area) } else { 0.0 }
    }
}

fn barycentric([a, b, c]: [(Point, usize); 3], p: Point) -> [(usize, f64); 3] {
    let whole = (b.0 - a.0).cross(c.0 - a.0);
    let (u, v) = ((b.0 - p).cross(c.0 - p) / whole, (c.0 - p).cross(a.0 - p) / whole);
    [(a.1, u), (b.1, v), (c.1, 1.0 - u - v)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ellipse(x: f64, y: f64, theta: f64) -> Ellipse {
        Ellipse { centre: Point::new(x, y), a: 2.0, b: 1.0, theta }
    }

    #[test]
    fn a_lattice_has_one_density_and_its_animals_headings() {
        let lattice: Vec<Ellipse> = (0..100)
            .map(|i| {
                ellipse(
                    f64::from(i % 10) * 5.0 + f64::from(i / 10) * 1e-3,
                    f64::from(i / 10) * 4.0,
                    0.02 * f64::from(i % 10),
                )
            })
            .collect();
        let exemplar = Exemplar::new(&lattice, Headings::Trusted).unwrap();
        for e in &lattice {
            let (heading, density) = exemplar.at(e.centre);
            assert!(heading.cross(e.heading()).abs() < 1e-6);
            assert!((density - 1.0 / 20.0).abs() < 0.026, "{density}");
        }
        let inner: f64 = (0..64)
            .map(|k| exemplar.at(Point::new(10.0 + f64::from(k % 8) * 3.1, 8.0 + f64::from(k / 8) * 2.7)).1)
            .sum();
        assert!((inner / 64.0 - 0.05).abs() < 0.002, "{}", inner / 64.0);
    }

    #[test]
    fn headings_across_the_cut_are_interpolated_the_short_way() {
        let herd =
            [ellipse(0.0, 0.0, 3.0), ellipse(10.0, 0.0, -3.0), ellipse(5.0, 30.0, 3.0), ellipse(5.0, -30.0, -3.0)];
        let exemplar = Exemplar::new(&herd, Headings::Trusted).unwrap();
        let (heading, _) = exemplar.at(Point::new(5.0, 0.0));
        assert!(heading.x < -0.98, "{heading:?}");
        let axes = Exemplar::new(&herd, Headings::Axes).unwrap();
        assert!(axes.at(Point::new(5.0, 0.0)).0.dot(axes.direction) > 0.98);
    }

    #[test]
    fn herds_without_a_hull_have_a_domain_all_the_same() {
        for herd in [
            vec![ellipse(3.0, 4.0, 1.0)],
            vec![ellipse(3.0, 4.0, 1.0), ellipse(9.0, 4.0, 1.0)],
            (0..6).map(|i| ellipse(f64::from(i) * 5.0, f64::from(i) * 2.0, 0.4)).collect(),
            vec![ellipse(1.0, 1.0, 0.0); 3],
        ] {
            let exemplar = Exemplar::new(&herd, Headings::Trusted).unwrap();
            assert!(!exemplar.is_wide() && hull::area(&exemplar.corners) > 0.0);
            assert!(herd.iter().all(|e| hull::contains(&exemplar.corners, e.centre)));
            assert!(exemplar.at(herd[0].centre).0.dot(herd[0].heading()) > 0.999);
        }
    }
}
