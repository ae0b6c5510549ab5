//! The path of the herd as a whole (T 4.3.1): a spline through the key-frames, round obstacles.

use super::AnimationError;
use super::route;
use super::route::Width;
use crate::compute::geometry::Point;
use crate::compute::herds::Clearance;
use crate::compute::run::Run;
use kurbo::CubicBez;
use kurbo::ParamCurve;

/// Points of the table per piece of spline.
const PER_PIECE: usize = 64;

/// How often a leg is mended before it follows the corners of its way without a curve.
const MENDINGS: usize = 3;

/// A path by arc length, with the places of the key-frames on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// Points along the path, in metres.
    points: Vec<Point>,
    /// Arc length at each point.
    lengths: Vec<f64>,
    /// Arc length at each key-frame.
    keys: Vec<f64>,
    /// Headings are those of a chord that reaches this far either way.
    reach_m: f64,
}

impl Trajectory {
    /// The path through `keys` in order, on open ground; headings are those of a chord that reaches
    /// `reach_m` either way. `None` without two different keys.
    pub fn on_open_ground(keys: &[Point], reach_m: f64) -> Option<Self> {
        let mut keys = keys.to_vec();
        keys.dedup();
        let legs: Vec<Vec<Point>> = keys.windows(2).map(|pair| pair.to_vec()).collect();
        (!legs.is_empty()).then(|| Self::through(&legs, reach_m))
    }

    /// Points along the path in metres, close enough to draw it.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// The path through `keys`, in order. `reach_m` is half the herd's extent: the herd frame
    /// turns as slowly as the herd is large.
    ///
    /// # Errors
    /// [`AnimationError::NoWay`] when obstacles cut it, or a stop.
    pub(super) fn new(keys: &[Point], clearance: &Clearance, width: Width, run: &Run) -> Result<Self, AnimationError> {
        let mut legs: Vec<Vec<Point>> = keys.windows(2).map(|pair| pair.to_vec()).collect();
        let mut path = Self::through(&legs, width.ample_m);
        for mending in 0..=MENDINGS {
            run.check()?;
            let cut: Vec<usize> = (0..legs.len()).filter(|leg| path.is_cut(*leg, clearance, width)).collect();
            if cut.is_empty() {
                return Ok(path);
            }
            for leg in cut {
                let narrow = clearance.at(keys[leg]).min(clearance.at(keys[leg + 1]));
                let width = Width { least_m: width.least_m.min(0.9 * narrow).max(0.0), ..width };
                legs[leg] = match mending {
                    0 => route::around(clearance, (leg, keys[leg], keys[leg + 1]), width, run)?,
                    _ => denser(&legs[leg]),
                };
            }
            path = Self::through(&legs, width.ample_m);
        }
        // A spline through ever denser points comes as near the straight way as one likes; what
        // is left is the way itself.
        for _ in 0..4 {
            legs.iter_mut().for_each(|leg| *leg = denser(leg));
        }
        Ok(Self::through(&legs, width.ample_m))
    }

    fn through(legs: &[Vec<Point>], reach_m: f64) -> Self {
        let corners: Vec<Point> = legs
            .iter()
            .flat_map(|leg| leg[..leg.len() - 1].iter())
            .chain(legs.last().and_then(|l| l.last()))
            .copied()
            .collect();
        let mut path = Self { points: vec![corners[0]], lengths: vec![0.0], keys: vec![0.0], reach_m };
        let mut corner = 0;
        for leg in legs {
            for _ in 1..leg.len() {
                path.extend(piece(&corners, corner));
                corner += 1;
            }
            path.keys.push(path.length());
        }
        path
    }

    fn extend(&mut self, piece: CubicBez) {
        for k in 1..=PER_PIECE {
            let p = piece.eval(k as f64 / PER_PIECE as f64);
            let p = Point::new(p.x, p.y);
            let (last, length) = (self.points[self.points.len() - 1], self.length());
            if p != last {
                self.points.push(p);
                self.lengths.push(length + p.distance(last));
            }
        }
    }

    fn is_cut(&self, leg: usize, clearance: &Clearance, width: Width) -> bool {
        if clearance.is_open() {
            return false;
        }
        let ends = clearance.at(self.at(self.keys[leg])).min(clearance.at(self.at(self.keys[leg + 1])));
        let least = width.least_m.min(0.9 * ends);
        let (from, to) = (self.keys[leg], self.keys[leg + 1]);
        let steps = ((to - from) / (0.5 * clearance.grid().cell_m)).ceil().clamp(1.0, 200_000.0);
        (0..=steps as usize).any(|k| clearance.at(self.at(from + (to - from) * k as f64 / steps)) < least)
    }

    /// Length in metres.
    pub fn length(&self) -> f64 {
        self.lengths[self.lengths.len() - 1]
    }

    /// Arc length at key-frame `key`.
    pub fn key(&self, key: usize) -> f64 {
        self.keys[key]
    }

    /// The place at arc length `s`, in metres; beyond the ends, the ends.
    pub fn at(&self, s: f64) -> Point {
        let next = self.lengths.partition_point(|l| *l < s).clamp(1, self.points.len().max(2) - 1);
        if self.points.len() < 2 {
            return self.points[0];
        }
        let (from, to) = (self.lengths[next - 1], self.lengths[next]);
        self.points[next - 1].lerp(self.points[next], ((s - from) / (to - from)).clamp(0.0, 1.0))
    }

    /// Unit vector along the path at arc length `s`: the chord over the herd's extent. East on a
    /// path without length.
    pub fn heading(&self, s: f64) -> Point {
        let reach = self.reach_m.max(1e-6 * self.length());
        let chord = |reach: f64| (self.at(s + reach) - self.at(s - reach)).normalised();
        chord(reach).or_else(|| chord(self.length())).unwrap_or(Point::new(1.0, 0.0))
    }
}

fn denser(way: &[Point]) -> Vec<Point> {
    let between = |pair: &[Point]| [pair[0], pair[0].lerp(pair[1], 0.5)];
    way.windows(2).flat_map(between).chain(way.last().copied()).collect()
}

/// The piece of a centripetal Catmull-Rom spline from corner `i` to the next, as a Bézier curve:
/// no cusps and no loops within a piece (Yuksel, Schaefer and Keyser 2011).
fn piece(corners: &[Point], i: usize) -> CubicBez {
    let (p1, p2) = (corners[i], corners[i + 1]);
    let p0 = i.checked_sub(1).map_or(p1 + (p1 - p2), |h| corners[h]);
    let p3 = corners.get(i + 2).copied().unwrap_or(p2 + (p2 - p1));
    let knot = |a: Point, b: Point| a.distance(b).sqrt().max(1e-9);
    let (d1, d2, d3) = (knot(p0, p1), knot(p1, p2), knot(p2, p3));
    let handle = |near: Point, far: Point, back: Point, d: f64| {
        // Barry and Goldman's tangents written as Bézier handles.
        let weight = 2.0 * d * d + 3.0 * d * d2 + d2 * d2;
        (far * (d * d) - back * (d2 * d2) + near * weight) * (1.0 / (3.0 * d * (d + d2)))
    };
    let (b1, b2) = (handle(p1, p2, p0, d1), handle(p2, p1, p3, d3));
    let k = |p: Point| kurbo::Point::new(p.x, p.y);
    CubicBez::new(k(p1), k(b1), k(b2), k(p2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::herds::Obstacles;
    use crate::compute::raster::Grid;

    const WIDTH: Width = Width { least_m: 0.5, ample_m: 5.0 };

    fn clearance(disks: &[(Point, f64)]) -> Clearance {
        let obstacles = Obstacles { disks: disks.to_vec(), ..Obstacles::default() };
        Clearance::new(&obstacles, Grid::new(300, 300, 0.5), &Run::silent()).unwrap()
    }

    fn path(keys: &[(f64, f64)], disks: &[(Point, f64)]) -> Result<Trajectory, AnimationError> {
        let keys: Vec<Point> = keys.iter().map(|&(x, y)| Point::new(x, y)).collect();
        Trajectory::new(&keys, &clearance(disks), WIDTH, &Run::silent())
    }

    #[test]
    fn the_path_goes_through_its_key_frames_at_even_speed() {
        let keys = [(20.0, 20.0), (60.0, 25.0), (70.0, 80.0), (130.0, 90.0)];
        let path = path(&keys, &[]).unwrap();
        for (k, (x, y)) in keys.into_iter().enumerate() {
            assert!(path.at(path.key(k)).distance(Point::new(x, y)) < 1e-9);
        }
        for k in 0..1000 {
            let s = path.length() * f64::from(k) / 1000.0;
            let step = path.at(s).distance(path.at(s + 0.1));
            assert!(step <= 0.1 + 1e-9 && step > 0.098, "{step}");
        }
    }

    #[test]
    fn points_on_a_line_give_the_line() {
        let path = path(&[(10.0, 10.0), (20.0, 10.0), (70.0, 10.0)], &[]).unwrap();
        assert!((path.length() - 60.0).abs() < 1e-9);
        assert!(path.points.iter().all(|p| (p.y - 10.0).abs() < 1e-9));
        assert!(path.heading(30.0).x > 0.999_999);
    }

    #[test]
    fn the_path_leads_round_an_obstacle() {
        let rock = (Point::new(75.0, 75.0), 20.0);
        let path = path(&[(20.0, 74.0), (130.0, 76.0)], &[rock]).unwrap();
        let clearance = clearance(&[rock]);
        let steps = (path.length() * 4.0) as usize;
        let least =
            (0..=steps).map(|k| path.at(f64::from(k as u32) * 0.25).distance(rock.0)).fold(f64::INFINITY, f64::min);
        assert!(least > 20.5, "{least}");
        assert!(path.length() > 115.0 && path.length() < 145.0, "{}", path.length());
        assert!(!path.is_cut(0, &clearance, WIDTH));
    }

    #[test]
    fn a_wall_without_a_gap_is_an_error_that_says_where() {
        let wall: Vec<(Point, f64)> = (0..76).map(|k| (Point::new(75.0, f64::from(k) * 2.0), 2.5)).collect();
        match path(&[(20.0, 74.0), (130.0, 76.0)], &wall) {
            Err(AnimationError::NoWay { from: 0, nearest }) => {
                assert!(nearest.x > 68.0 && nearest.x < 75.0 && (nearest.y - 75.0).abs() < 4.0, "{nearest:?}");
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn key_frames_in_one_place_are_a_path_without_length() {
        let path = path(&[(20.0, 20.0), (20.0, 20.0)], &[]).unwrap();
        assert_eq!(
            (path.length(), path.at(0.0), path.heading(0.0)),
            (0.0, Point::new(20.0, 20.0), Point::new(1.0, 0.0))
        );
    }
}
