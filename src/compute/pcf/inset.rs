//! How far inside the border of its domain the outermost points of a pattern lie, learnt by
//! cutting the pattern along lines (ours; the text gives no margin).
//!
//! Points that keep apart come close to any line, groups leave bays along it. What a cut takes
//! from the area of the kept triangles, over the length of the cut on both its sides, is the
//! inset; the border of the domain cut the pattern in the same way.

use crate::compute::geometry::Point;
use crate::compute::geometry::ring_area_doubled;
use crate::compute::pcf::mesh::Limit;
use crate::compute::pcf::mesh::Mesh;
use rayon::prelude::*;

/// Cuts through the middle of the pattern, in directions evenly turned. Ours: a few hundred
/// points then tell the inset to about a tenth.
const CUTS: usize = 6;

/// The direction of the first cut, in turns between two: no domain's sides are likely to run so.
const FIRST: f64 = 0.37;

/// Fewer points than this on a side do not tell where their domain ends.
const LEAST: usize = 12;

/// What is expected before any cut, in spacings: the inset of independent points.
const EXPECTED: f64 = 0.4;

/// The length of cut, in spacings, that weighs as much as what is expected.
const TRUST: f64 = 10.0;

/// Parts of a cut nearer than this to its ends, in spacings, are left out: the corners there lose
/// more than a line does.
const CORNER: f64 = 1.5;

/// The inset in `spacing`s, √(A/n), where triangles within `limit` are part of the domain.
pub fn inset(mesh: &Mesh, spacing: f64, limit: Limit) -> f64 {
    let whole = Kept::of(mesh, limit);
    let cut =
        |turn: usize| Cut::of(mesh, Point::from_angle((turn as f64 + FIRST) * std::f64::consts::PI / CUTS as f64));
    let measure = |cut: Cut| {
        let spans = cut.spans(&whole, CORNER * spacing);
        let sides = cut.sides(mesh)?;
        let left = |side: &Mesh| cut.area_along(&Kept::of(side, limit), &spans);
        let lost = cut.area_along(&whole, &spans) - left(&sides[0]) - left(&sides[1]);
        Some((spans.iter().map(|(from, to)| to - from).sum::<f64>(), lost))
    };
    let measured: Vec<(f64, f64)> = (0..CUTS).into_par_iter().filter_map(|turn| measure(cut(turn))).collect();
    let length: f64 = measured.iter().map(|(length, _)| 2.0 * length / spacing).sum();
    let lost: f64 = measured.iter().map(|(_, lost)| lost / (spacing * spacing)).sum();
    ((EXPECTED * TRUST + lost) / (TRUST + length)).max(0.0)
}

/// The triangles of a mesh that are part of the domain.
struct Kept<'a> {
    mesh: &'a Mesh,
    kept: Vec<bool>,
}

impl<'a> Kept<'a> {
    fn of(mesh: &'a Mesh, limit: Limit) -> Self {
        Self { mesh, kept: mesh.kept(limit) }
    }

    fn triangles(&self) -> impl Iterator<Item = [Point; 3]> {
        let kept = self.mesh.triangles.iter().zip(&self.kept).filter(|(_, kept)| **kept);
        kept.map(|(corners, _)| corners.map(|v| self.mesh.points[v]))
    }
}

/// A line across a pattern.
struct Cut {
    /// Its unit normal.
    normal: Point,
    /// Places on it have this product with the normal.
    offset: f64,
}

impl Cut {
    /// With as many points on either side.
    fn of(mesh: &Mesh, normal: Point) -> Self {
        let mut along: Vec<f64> = mesh.points.iter().map(|p| p.dot(normal)).collect();
        let middle = along.len() / 2;
        let (below, above, _) = along.select_nth_unstable_by(middle, f64::total_cmp);
        let last = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        Self { normal, offset: 0.5 * (last + *above) }
    }

    /// How far a place lies past the line.
    fn past(&self, p: Point) -> f64 {
        p.dot(self.normal) - self.offset
    }

    /// How far along the line a place lies.
    fn along(&self, p: Point) -> f64 {
        p.cross(self.normal)
    }

    /// The points of either side by themselves; none when a side has too few, or all on a line.
    fn sides(&self, mesh: &Mesh) -> Option<[Mesh; 2]> {
        let (above, below): (Vec<Point>, Vec<Point>) = mesh.points.iter().partition(|p| self.past(**p) > 0.0);
        let enough = above.len().min(below.len()) >= LEAST;
        enough.then(|| Some([Mesh::of(&above).ok()?, Mesh::of(&below).ok()?])).flatten()
    }

    /// From where to where the line lies in kept triangles, without `end` at either end of each.
    fn spans(&self, whole: &Kept, end: f64) -> Vec<(f64, f64)> {
        let mut chords: Vec<(f64, f64)> = whole.triangles().filter_map(|t| self.chord(t)).collect();
        chords.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut spans: Vec<(f64, f64)> = Vec::new();
        for (from, to) in chords {
            match spans.last_mut() {
                Some(last) if from <= last.1 + 1e-6 * end => last.1 = last.1.max(to),
                _ => spans.push((from, to)),
            }
        }
        spans.iter().map(|(from, to)| (from + end, to - end)).filter(|(from, to)| from < to).collect()
    }

    /// From where to where the line lies in a triangle.
    fn chord(&self, corners: [Point; 3]) -> Option<(f64, f64)> {
        let crossing = |a: Point, b: Point| {
            let (from, to) = (self.past(a), self.past(b));
            ((from > 0.0) != (to > 0.0)).then(|| self.along(a + (b - a) * (from / (from - to))))
        };
        let [a, b, c] = corners;
        let mut ends = [crossing(a, b), crossing(b, c), crossing(c, a)].into_iter().flatten();
        ends.next().zip(ends.next()).map(|(one, other)| (one.min(other), one.max(other)))
    }

    /// The kept area beside the `spans` of the line.
    fn area_along(&self, part: &Kept, spans: &[(f64, f64)]) -> f64 {
        let between = |t: [Point; 3]| {
            let mut along = t.map(|p| self.along(p));
            along.sort_by(f64::total_cmp);
            let area = ring_area_doubled(&t).abs() / 2.0;
            spans.iter().map(|(from, to)| area * (share_before(along, *to) - share_before(along, *from))).sum::<f64>()
        };
        part.triangles().map(between).sum()
    }
}

/// The share of a triangle before `at`, its corners at `along` in order.
fn share_before([first, middle, last]: [f64; 3], at: f64) -> f64 {
    if at <= first {
        0.0
    } else if at >= last {
        1.0
    } else if at <= middle {
        (at - first).powi(2) / ((middle - first) * (last - first))
    } else {
        1.0 - (last - at).powi(2) / ((last - middle) * (last - first))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::random::Purpose;
    use crate::compute::random::Stream;

    /// The inset where triangles up to so many spacings are part of the domain.
    fn measured(places: &[Point], most: f64) -> f64 {
        let mesh = Mesh::of(places).unwrap();
        let area = mesh.area_of(&vec![true; mesh.triangles.len()]);
        let spacing = (area / places.len() as f64).sqrt();
        inset(&mesh, spacing, Limit::Circumradius(most * spacing))
    }

    #[test]
    fn points_that_keep_apart_come_nearer_a_cut_than_independent_ones_and_those_nearer_than_groups() {
        let mut random = Stream::new(3, Purpose::new("test.inset"), 0);
        let mut any = || Point::new(random.unit(), random.unit());
        let independent: Vec<Point> = (0..900).map(|_| any()).collect();
        let lattice: Vec<Point> =
            (0..900).map(|k| Point::new(f64::from(k % 30), f64::from(k / 30)) + any() * 0.2).collect();
        let middles: Vec<Point> = (0..150).map(|_| any()).collect();
        let groups: Vec<Point> = (0..900).map(|k| middles[k % 150] + any() * 0.03).collect();
        let (lattice, independent, groups) =
            (measured(&lattice, 1.5), measured(&independent, 2.1), measured(&groups, 2.5));
        assert!(lattice < independent && independent + 0.1 < groups, "{lattice} {independent} {groups}");
        assert!((independent - 0.45).abs() < 0.05, "{independent}");
    }

    #[test]
    fn the_inset_of_too_few_points_is_what_is_expected() {
        let few: Vec<Point> = (0..20).map(|k| Point::new(f64::from(k * k % 7), f64::from(k))).collect();
        assert_eq!(measured(&few, 2.0), EXPECTED);
    }

    #[test]
    fn the_share_of_a_triangle_before_a_place_grows_from_none_to_all() {
        let along = [0.0, 1.0, 3.0];
        assert_eq!([-1.0, 0.0, 3.0, 4.0].map(|at| share_before(along, at)), [0.0, 0.0, 1.0, 1.0]);
        assert!((share_before(along, 1.0) - 1.0 / 3.0).abs() < 1e-12);
        assert_eq!(share_before([0.0, 0.0, 2.0], 1.0), 0.75);
    }
}
