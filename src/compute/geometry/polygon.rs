use crate::compute::geometry::Point;
use geo::BooleanOps;
use geo::Validation;

/// The most vertices all polygons of one region may have together.
pub const MAX_VERTICES: usize = 200_000;

/// A polygon with holes. Rings are open (the first vertex is not repeated), of either direction.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Polygon {
    /// The outer ring.
    pub outer: Vec<Point>,
    /// The rings cut out of it.
    pub holes: Vec<Vec<Point>>,
}

/// Why polygons do not bound a region.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PolygonError {
    /// A ring needs three vertices.
    #[error("polygon {polygon}: a ring has {found} vertices, at least 3 are needed")]
    TooFewVertices {
        /// The polygon's place in the list.
        polygon: usize,
        /// Vertices found.
        found: usize,
    },
    /// A coordinate is infinite or not a number.
    #[error("polygon {polygon} has a coordinate that is not finite")]
    NotFinite {
        /// The polygon's place in the list.
        polygon: usize,
    },
    /// A ring crosses itself or another ring of its polygon.
    #[error("polygon {polygon} crosses itself: {how}")]
    Crossing {
        /// The polygon's place in the list.
        polygon: usize,
        /// Which rings cross.
        how: String,
    },
    /// More vertices than [`MAX_VERTICES`].
    #[error("{found} vertices, at most {MAX_VERTICES} are allowed")]
    TooManyVertices {
        /// Vertices found.
        found: usize,
    },
    /// The polygons enclose no area.
    #[error("the polygons enclose no area")]
    NoArea,
}

/// Twice the signed area of a ring: positive when it runs counter-clockwise.
pub fn ring_area_doubled(ring: &[Point]) -> f64 {
    let Some(origin) = ring.first() else { return 0.0 };
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(a, b)| (*a - *origin).cross(*b - *origin)).sum()
}

/// A ring cut where it touches itself, into rings that pass through each of their vertices once.
pub fn simple_rings(ring: &[Point]) -> Vec<Vec<Point>> {
    let mut places: Vec<usize> = (0..ring.len()).collect();
    places.sort_by(|a, b| ring[*a].x.total_cmp(&ring[*b].x).then(ring[*a].y.total_cmp(&ring[*b].y)).then(a.cmp(b)));
    let mut vertex_of = vec![0; ring.len()];
    for pair in places.windows(2) {
        vertex_of[pair[1]] = vertex_of[pair[0]] + usize::from(ring[pair[0]] != ring[pair[1]]);
    }
    let (mut rings, mut open, mut place_in_open) = (Vec::new(), Vec::new(), vec![None; ring.len()]);
    for vertex in vertex_of.iter().zip(ring) {
        if let Some(from) = place_in_open[*vertex.0] {
            let closed: Vec<(usize, Point)> = open.drain(from..).collect();
            closed.iter().for_each(|(v, _): &(usize, Point)| place_in_open[*v] = None);
            rings.push(closed.into_iter().map(|(_, p)| p).collect());
        }
        place_in_open[*vertex.0] = Some(open.len());
        open.push((*vertex.0, *vertex.1));
    }
    rings.push(open.into_iter().map(|(_, p)| p).collect());
    rings.retain(|ring: &Vec<Point>| ring.len() >= 3);
    rings
}

/// The union of `polygons` in normal form: outer rings counter-clockwise, holes clockwise, no
/// two polygons overlapping. A single polygon keeps its coordinates; several are overlaid on an
/// integer grid of about a billionth of their extent.
///
/// # Errors
/// Anything that keeps a polygon from bounding an area ([`PolygonError`]).
pub fn union(polygons: &[Polygon]) -> Result<Vec<Polygon>, PolygonError> {
    let found = polygons.iter().map(Polygon::vertices).sum();
    if found > MAX_VERTICES {
        return Err(PolygonError::TooManyVertices { found });
    }
    let valid = polygons.iter().enumerate().map(|(i, p)| p.checked(i)).collect::<Result<Vec<_>, _>>()?;
    match valid.as_slice() {
        [one] => Ok(from_geo(&geo::MultiPolygon(vec![one.clone()]))),
        several => Ok(from_geo(&geo::unary_union(several))),
    }
}

/// The part of `polygons` outside `others`; both in normal form.
pub fn difference(polygons: &[Polygon], others: &[Polygon]) -> Vec<Polygon> {
    from_geo(&to_geo(polygons).difference(&to_geo(others)))
}

/// The part of `polygons` inside `others`; both in normal form.
pub fn intersection(polygons: &[Polygon], others: &[Polygon]) -> Vec<Polygon> {
    from_geo(&to_geo(polygons).intersection(&to_geo(others)))
}

impl Polygon {
    /// Vertices of all rings.
    pub fn vertices(&self) -> usize {
        self.outer.len() + self.holes.iter().map(Vec::len).sum::<usize>()
    }

    /// The outer ring, then the holes.
    pub fn rings(&self) -> impl Iterator<Item = &[Point]> {
        std::iter::once(self.outer.as_slice()).chain(self.holes.iter().map(Vec::as_slice))
    }

    fn checked(&self, polygon: usize) -> Result<geo::Polygon<f64>, PolygonError> {
        if let Some(found) = self.rings().map(distinct).find(|n| *n < 3) {
            return Err(PolygonError::TooFewVertices { polygon, found });
        }
        if self.rings().flatten().any(|p| !p.is_finite()) {
            return Err(PolygonError::NotFinite { polygon });
        }
        if self.rings().any(is_a_line) {
            return Err(PolygonError::NoArea);
        }
        let shape = to_geo_polygon(self);
        shape.check_validation().map_err(|e| PolygonError::Crossing { polygon, how: e.to_string() })?;
        Ok(shape)
    }
}

/// Whether all vertices lie on one line, which is no area; a ring that crosses itself may sum up
/// to none as well.
fn is_a_line(ring: &[Point]) -> bool {
    let farthest = ring.iter().max_by(|a, b| a.distance_sq(ring[0]).total_cmp(&b.distance_sq(ring[0])));
    farthest.is_none_or(|far| ring.iter().all(|p| (*far - ring[0]).cross(*p - ring[0]) == 0.0))
}

fn distinct(ring: &[Point]) -> usize {
    let closed = ring.len() > 1 && ring.first() == ring.last();
    ring.len() - usize::from(closed)
}

fn to_geo_ring(ring: &[Point]) -> geo::LineString<f64> {
    ring.iter().map(|p| geo::Coord { x: p.x, y: p.y }).collect()
}

fn to_geo_polygon(polygon: &Polygon) -> geo::Polygon<f64> {
    geo::Polygon::new(to_geo_ring(&polygon.outer), polygon.holes.iter().map(|h| to_geo_ring(h)).collect())
}

pub(super) fn to_geo(polygons: &[Polygon]) -> geo::MultiPolygon<f64> {
    geo::MultiPolygon(polygons.iter().map(to_geo_polygon).collect())
}

pub(super) fn from_geo(shapes: &geo::MultiPolygon<f64>) -> Vec<Polygon> {
    let polygon = |p: &geo::Polygon<f64>| Polygon {
        outer: from_geo_ring(p.exterior(), 1.0),
        holes: p.interiors().iter().map(|h| from_geo_ring(h, -1.0)).filter(|h| h.len() >= 3).collect(),
    };
    shapes.0.iter().map(polygon).filter(|p| p.outer.len() >= 3).collect()
}

/// An open ring whose area has the sign of `direction`.
fn from_geo_ring(ring: &geo::LineString<f64>, direction: f64) -> Vec<Point> {
    let mut points: Vec<Point> = ring.0.iter().map(|c| Point::new(c.x, c.y)).collect();
    if points.len() > 1 && points.first() == points.last() {
        points.pop();
    }
    if ring_area_doubled(&points) * direction < 0.0 {
        points.reverse();
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(places: &[(f64, f64)]) -> Vec<Point> {
        places.iter().map(|(x, y)| Point::new(*x, *y)).collect()
    }

    #[test]
    fn a_ring_that_touches_itself_is_an_outer_ring_and_a_hole_or_two_outer_rings() {
        // A square whose border dips into a pocket at its south-west corner.
        let pocket = ring(&[(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0), (0.0, 0.0), (1.0, 2.0), (2.0, 1.0)]);
        let areas = |rings: &[Vec<Point>]| rings.iter().map(|r| ring_area_doubled(r)).collect::<Vec<f64>>();
        assert_eq!(areas(&simple_rings(&pocket)), [32.0, -3.0]);
        let two =
            ring(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (2.0, 1.0), (2.0, 2.0), (1.0, 2.0), (1.0, 1.0), (0.0, 1.0)]);
        assert_eq!(areas(&simple_rings(&two)), [2.0, 2.0]);
        let simple = ring(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)]);
        assert_eq!(simple_rings(&simple), [simple]);
    }
}
