//! The Delaunay triangles of points and the outline of those that are kept.

use crate::compute::geometry::Point;
use crate::compute::geometry::Polygon;
use crate::compute::geometry::Region;
use crate::compute::geometry::ring_area_doubled;
use crate::compute::geometry::simple_rings;
use crate::compute::pcf::PcfError;
use spade::DelaunayTriangulation;
use spade::Point2;
use spade::Triangulation;

/// Up to which size triangles are part of the domain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// Up to this circumradius, a length.
    Circumradius(f64),
    /// No edge longer than this many times the shortest at either of its ends.
    EdgeRatio(f64),
}

/// The Delaunay triangulation, as plain arrays.
pub struct Mesh {
    /// Its corners: the places, each once.
    pub points: Vec<Point>,
    /// Three corners each.
    pub triangles: Vec<[usize; 3]>,
    circumradii: Vec<f64>,
}

impl Mesh {
    /// Of at least three places that are not all on one line.
    pub fn of(points: &[Point]) -> Result<Self, PcfError> {
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

    /// Of the triangles that are `kept`.
    pub fn area_of(&self, kept: &[bool]) -> f64 {
        self.triangles.iter().zip(kept).filter(|(_, kept)| **kept).map(|(t, _)| self.area(t)).sum()
    }

    fn area(&self, triangle: &[usize; 3]) -> f64 {
        ring_area_doubled(&triangle.map(|v| self.points[v])).abs() / 2.0
    }

    /// The circumradius that half of the area that is `kept` lies in triangles up to; infinite
    /// when nothing is kept.
    pub fn median_circumradius(&self, kept: &[bool]) -> f64 {
        let mut sizes: Vec<(f64, f64)> = Vec::new();
        for ((triangle, radius), _) in self.triangles.iter().zip(&self.circumradii).zip(kept).filter(|(_, kept)| **kept)
        {
            sizes.push((*radius, self.area(triangle)));
        }
        sizes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let half = sizes.iter().map(|(_, area)| area).sum::<f64>() / 2.0;
        let mut sum = 0.0;
        let mut up_to = sizes.into_iter().skip_while(|(_, area)| {
            sum += area;
            sum < half
        });
        up_to.next().map_or(f64::INFINITY, |(radius, _)| radius)
    }

    /// Which triangles are within `limit`.
    pub fn kept(&self, limit: Limit) -> Vec<bool> {
        match limit {
            Limit::Circumradius(most) => self.circumradii.iter().map(|r| *r <= most).collect(),
            Limit::EdgeRatio(most) => {
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
    pub fn outline(&self, kept: &[bool]) -> Vec<Polygon> {
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

    /// Points that no kept triangle holds.
    pub fn lone_points(&self, kept: &[bool]) -> impl Iterator<Item = Point> {
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
