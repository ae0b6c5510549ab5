//! Guides: where each animal should be while the herd frame is somewhere between two key-frames
//! (T 4.3.2). They move straight in the herd frame, x along the trajectory.

use super::AnimationError;
use super::PairingMetric;
use super::Trajectory;
use super::frames;
use super::frames::KeyFrame;
use super::pairing::pair;
use crate::compute::geometry::CellGrid;
use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Point;
use crate::compute::herds::contact;
use crate::compute::herds::contact::Footprint;
use crate::compute::run::Run;

/// A place on the way: an interval between key-frames and the share of it that is behind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Progress {
    /// Index of the key-frame behind.
    pub interval: usize,
    /// From 0 at that key-frame to 1 at the next.
    pub share: f64,
}

/// The herd frame at a moment: where its origin is and which way its x axis points.
#[derive(Debug, Clone, Copy)]
pub(super) struct HerdFrame {
    origin: Point,
    along: Point,
}

impl HerdFrame {
    fn to_world(self, local: Point) -> Point {
        self.origin
            + Point::new(self.along.dot(Point::new(local.x, -local.y)), self.along.y * local.x + self.along.x * local.y)
    }

    fn to_local(self, world: Point) -> Point {
        let d = world - self.origin;
        Point::new(self.along.dot(d), self.along.cross(d))
    }
}

/// A key-herd in the herd frame, its animals in the order of the first key-herd.
#[derive(Debug, Clone)]
struct Formation {
    places: Vec<Point>,
    /// Headings relative to the herd frame's x axis.
    headings: Vec<Point>,
    /// How deep animals overlap in it, in metres.
    depth: f64,
    /// How many times larger it would have to be for animals to pass each other.
    spread: f64,
}

/// Where all guides are at a moment.
#[derive(Clone, Copy)]
pub(super) struct Posture<'a> {
    frame: HerdFrame,
    from: &'a Formation,
    to: &'a Formation,
    /// From 0 at the formation behind to 1 at the one ahead.
    weight: f64,
    /// How many times larger than the formations it is.
    spread: f64,
}

impl Posture<'_> {
    /// Where the guide of `animal` is, in metres.
    pub(super) fn place(&self, animal: usize) -> Point {
        self.frame.to_world(self.from.places[animal].lerp(self.to.places[animal], self.weight) * self.spread)
    }

    /// Whether an animal at `p` is behind its guide.
    pub(super) fn lags(&self, animal: usize, p: Point) -> bool {
        (self.place(animal) - p).dot(self.frame.along) > 0.0
    }

    /// The heading of `animal` in the formation that lies behind (`false`) or ahead (`true`).
    pub(super) fn heading(&self, animal: usize, ahead: bool) -> Point {
        let local = if ahead { self.to } else { self.from }.headings[animal];
        self.frame.to_world(local) - self.frame.origin
    }
}

/// How far a crowd has opened out, from 0 to 1, at a share of the way between two key-herds. It
/// closes ever faster along the way, and so ever slower in time (see [`Guides::rest`]).
fn opening(way: f64) -> f64 {
    smooth(way / OPENED_BY) * still_open(way)
}

/// From 1 until [`CLOSES_FROM`] to 0 at the key-herd ahead.
fn still_open(way: f64) -> f64 {
    let closed = 1.0 - ((1.0 - way) / (1.0 - CLOSES_FROM)).clamp(0.0, 1.0);
    1.0 - closed * closed * closed
}

/// From 0 to 1 without a jerk.
fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// What lies between two key-frames.
#[derive(Debug, Clone, Copy)]
struct Interval {
    from: usize,
    to: usize,
    /// Share of the way between the two formations at its beginning and end.
    weights: (f64, f64),
    /// Whether there is a key-herd at its beginning and at its end.
    herds: (bool, bool),
}

/// The formation ahead is complete at this share of the way between two key-herds (ours): animals
/// that cannot go sideways make up what they lack across the path while they still walk along it.
const MORPHED_BY: f64 = 0.7;

/// A crowd opens out until nearest neighbours are this many times as far apart as they would
/// touch, so that they can pass each other; at most to so many times its size (ours).
const ROOM_TO_PASS: f64 = 1.9;
const MAX_SPREAD: f64 = 1.7;

/// Shares of the way between two key-herds at which a crowd has opened out and begins to close
/// (ours).
const OPENED_BY: f64 = 0.2;
const CLOSES_FROM: f64 = 0.6;

/// To close a crowd takes as much time, if there is any to spare, as this share of the way (ours).
const CLOSING: f64 = 0.3;

/// All guides of an animation.
pub(super) struct Guides<'a> {
    trajectory: &'a Trajectory,
    formations: Vec<Formation>,
    intervals: Vec<Interval>,
    /// Semi-axes of each animal.
    pub bodies: Vec<(f64, f64)>,
}

impl<'a> Guides<'a> {
    pub(super) fn new(
        frames: &[KeyFrame],
        trajectory: &'a Trajectory,
        metric: PairingMetric,
        run: &Run,
    ) -> Result<Self, AnimationError> {
        let bodies = frames::first_herd(frames).iter().map(|e| (e.a, e.b)).collect();
        let mut guides = Self { trajectory, formations: Vec::new(), intervals: Vec::new(), bodies };
        let mut keys = Vec::new();
        for (key, herd) in frames.iter().enumerate().filter_map(|(key, f)| f.herd().map(|h| (key, h))) {
            let raw = Formation::new(herd, guides.frame(trajectory.key(key)));
            let next = match guides.formations.last() {
                None => raw,
                Some(last) => raw.reordered(&pair(metric, &last.places, &raw.places, run)?),
            };
            guides.formations.push(next);
            keys.push(key);
        }
        guides.intervals = (0..frames.len() - 1).map(|k| guides.interval(k, &keys)).collect();
        Ok(guides)
    }

    fn interval(&self, k: usize, keys: &[usize]) -> Interval {
        let after = keys.partition_point(|key| *key <= k);
        let (from, to) = (after.saturating_sub(1), after.min(keys.len() - 1));
        let herds = (keys.contains(&k), keys.contains(&(k + 1)));
        if from == to {
            return Interval { from, to, weights: (0.0, 0.0), herds };
        }
        let (start, end) = (self.trajectory.key(keys[from]), self.trajectory.key(keys[to]));
        let weight = |key: usize| match end - start {
            length if length > 0.0 => (self.trajectory.key(key) - start) / length,
            _ => (key - keys[from]) as f64 / (keys[to] - keys[from]) as f64,
        };
        Interval { from, to, weights: (weight(k), weight(k + 1)), herds }
    }

    /// Number of animals.
    pub(super) fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Number of intervals between key-frames.
    pub(super) fn intervals(&self) -> usize {
        self.intervals.len()
    }

    /// Whether there is a key-herd at the end of an interval.
    pub(super) fn ends_in_herd(&self, interval: usize) -> bool {
        self.intervals[interval].herds.1
    }

    fn frame(&self, s: f64) -> HerdFrame {
        HerdFrame { origin: self.trajectory.at(s), along: self.trajectory.heading(s) }
    }

    fn arc_length(&self, progress: Progress) -> f64 {
        let (from, to) = (self.trajectory.key(progress.interval), self.trajectory.key(progress.interval + 1));
        from + (to - from) * progress.share
    }

    /// The share of the way between the key-herds behind and ahead; 0 where there are not both.
    fn way(&self, progress: Progress) -> f64 {
        let (w0, w1) = self.intervals[progress.interval].weights;
        w0 + (w1 - w0) * progress.share
    }

    /// All guides while the herd frame is at `progress`.
    pub(super) fn posture(&self, progress: Progress) -> Posture<'_> {
        let straight = self.straight(progress);
        let most = straight.from.spread.max(straight.to.spread);
        Posture { spread: 1.0 + (most - 1.0) * opening(self.way(progress)), ..straight }
    }

    /// Likewise, of a herd that does not open out on the way: the least way there is.
    pub(super) fn straight(&self, progress: Progress) -> Posture<'_> {
        let Interval { from, to, .. } = self.intervals[progress.interval];
        let (from, to) = (&self.formations[from], &self.formations[to]);
        let weight = (self.way(progress) / MORPHED_BY).min(1.0);
        Posture { frame: self.frame(self.arc_length(progress)), from, to, weight, spread: 1.0 }
    }

    /// Whether the key-herd ahead is nearer than the one behind, and how much its headings count:
    /// 1 at a key-herd, falling smoothly to 0 at `reach_m` along the guides' way, 0 near
    /// position-only key-frames.
    pub(super) fn key_weight(&self, progress: Progress, reach_m: f64) -> (bool, f64) {
        let Interval { herds: (behind, ahead), .. } = self.intervals[progress.interval];
        let start = Progress { share: 0.0, ..progress };
        let end = Progress { share: 1.0, ..progress };
        let length = self.arc_length(end) - self.arc_length(start);
        // In an interval without length headings count throughout.
        let weight = |share: f64| smooth(1.0 - share * length / reach_m.max(1e-9));
        let from = if behind { weight(progress.share) } else { 0.0 };
        let to = if ahead { weight(1.0 - progress.share) } else { 0.0 };
        (to >= from, to.max(from))
    }

    /// What is left of an interval, as shares of it, and by how much it falls while the share
    /// rises by one: to close a crowd counts extra, so that it has more of the time.
    pub(super) fn rest(&self, progress: Progress) -> (f64, f64) {
        const PROBE: f64 = 1e-3;
        let Interval { from, to, weights: (w0, w1), .. } = self.intervals[progress.interval];
        let crowded = self.formations[from].spread.max(self.formations[to].spread) > 1.0;
        let extra = if crowded && from != to { CLOSING } else { 0.0 };
        let open = |share: f64| still_open(w0 + (w1 - w0) * share) - still_open(w1);
        let left = |share: f64| 1.0 - share + extra * open(share);
        let share = progress.share.min(1.0 - PROBE);
        (left(progress.share), (left(share) - left(share + PROBE)) / PROBE)
    }

    /// How deep animals overlap in the key-herds on either side of an interval, in metres.
    pub(super) fn depth_held(&self, interval: usize) -> f64 {
        let i = self.intervals[interval];
        self.formations[i.from].depth.max(self.formations[i.to].depth)
    }

    /// A place on the herd's path that can be seen from `p` with `width` of room and lies as far
    /// as possible towards `progress`: the way back to the herd for an animal cut off from its
    /// guide. `None` when no part of the path is in view.
    pub(super) fn rejoin(&self, p: Point, progress: Progress, sees: impl Fn(Point) -> bool) -> Option<Point> {
        const TRIES: usize = 24;
        let goal = self.arc_length(progress);
        let steps = (0..=TRIES).map(|k| goal * (1.0 - k as f64 / TRIES as f64));
        let nearest = self.nearest_before(p, goal);
        steps.take_while(|s| *s > nearest).chain([nearest]).map(|s| self.trajectory.at(s)).find(|q| sees(*q))
    }

    fn nearest_before(&self, p: Point, goal: f64) -> f64 {
        const SAMPLES: usize = 128;
        let s = |k: usize| goal * k as f64 / SAMPLES as f64;
        let distance = |k: &usize| self.trajectory.at(s(*k)).distance_sq(p);
        (0..=SAMPLES).min_by(|a, b| distance(a).total_cmp(&distance(b))).map_or(0.0, s)
    }
}

impl Formation {
    fn new(herd: &[Ellipse], frame: HerdFrame) -> Self {
        Self {
            places: herd.iter().map(|e| frame.to_local(e.centre)).collect(),
            headings: herd.iter().map(|e| frame.to_local(frame.origin + e.heading())).collect(),
            depth: contact::deepest(herd),
            spread: (ROOM_TO_PASS / room(herd)).clamp(1.0, MAX_SPREAD),
        }
    }

    fn reordered(&self, order: &[usize]) -> Self {
        Self {
            places: order.iter().map(|i| self.places[*i]).collect(),
            headings: order.iter().map(|i| self.headings[*i]).collect(),
            depth: self.depth,
            spread: self.spread,
        }
    }
}

/// How far the nearest neighbour of an animal is, in times the distance at which they would touch:
/// the mean over the herd, counted up to [`ROOM_TO_PASS`].
fn room(herd: &[Ellipse]) -> f64 {
    let prints: Vec<Footprint> = herd.iter().map(Footprint::new).collect();
    let centres: Vec<Point> = herd.iter().map(|e| e.centre).collect();
    let reach = 2.0 * ROOM_TO_PASS * herd.iter().map(|e| e.a).fold(0.0, f64::max);
    let near = CellGrid::new(&centres, 0.5 * reach);
    let of = |i: usize| {
        let mut least = ROOM_TO_PASS;
        near.for_each_near(centres[i], reach, |j| {
            let offset = centres[j] - centres[i];
            if let (true, Some(u)) = (j != i, offset.normalised()) {
                least = least.min(offset.norm() / (prints[i].support(u) + prints[j].support(u)));
            }
        });
        least
    };
    let sum: f64 = (0..herd.len()).map(of).sum();
    (sum / herd.len().max(1) as f64).max(1.0 / MAX_SPREAD)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::herds::animation::KeyPose;

    fn ellipse(x: f64, y: f64, theta: f64) -> Ellipse {
        Ellipse { centre: Point::new(x, y), a: 1.2, b: 0.5, theta }
    }

    #[test]
    fn guides_go_straight_in_the_herd_frame_from_their_places_to_those_of_the_key_herd_ahead() {
        let from = vec![ellipse(0.0, 0.0, 0.0), ellipse(0.0, 9.0, 0.1), ellipse(6.0, 4.0, -0.2)];
        let to = vec![ellipse(100.0, 60.0, 1.0), ellipse(92.0, 66.0, 1.2), ellipse(104.0, 74.0, 0.8)];
        let frames = [
            KeyFrame { time_s: 0.0, pose: KeyPose::Herd(from.clone()) },
            KeyFrame { time_s: 50.0, pose: KeyPose::Position(Point::new(60.0, 10.0)) },
            KeyFrame { time_s: 90.0, pose: KeyPose::Herd(to.clone()) },
        ];
        let path = Trajectory::on_open_ground(&frames::centres(&frames), 5.0).unwrap();
        let guides = Guides::new(&frames, &path, PairingMetric::Euclidean, &Run::silent()).unwrap();
        assert_eq!((guides.len(), guides.intervals()), (3, 2));
        assert!(!guides.ends_in_herd(0) && guides.ends_in_herd(1));
        let (start, end) = (
            guides.straight(Progress { interval: 0, share: 0.0 }),
            guides.straight(Progress { interval: 1, share: 1.0 }),
        );
        let (first, last) = (guides.frame(0.0), guides.frame(path.length()));
        let mut ends = Vec::new();
        for (i, e) in from.iter().enumerate() {
            assert!(start.place(i).distance(e.centre) < 1e-9, "{i}");
            ends.extend(to.iter().position(|e| e.centre.distance(end.place(i)) < 1e-9));
            let (a, b) = (first.to_local(start.place(i)), last.to_local(end.place(i)));
            let mut gone = 0.0;
            for (interval, share) in [(0, 0.3), (0, 0.7), (0, 1.0), (1, 0.0), (1, 0.5), (1, 0.9)] {
                let progress = Progress { interval, share };
                let local = guides.frame(guides.arc_length(progress)).to_local(guides.straight(progress).place(i));
                let (along, whole) = ((local - a).dot(b - a), (b - a).dot(b - a));
                assert!((local - a).cross(b - a).abs() < 1e-9 * (1.0 + whole), "{i} strays at {progress:?}");
                assert!(along >= gone - 1e-9 && along <= whole * (1.0 + 1e-9), "{i} goes back at {progress:?}");
                gone = along;
            }
        }
        ends.sort_unstable();
        assert_eq!(ends, [0, 1, 2], "every place of the key-herd ahead is somebody's");
    }

    #[test]
    fn a_packed_herd_opens_out_on_the_way_and_a_loose_one_does_not() {
        let herd = |spacing: f64, x: f64| -> Vec<Ellipse> {
            (0..36).map(|i| ellipse(x + f64::from(i % 6) * 2.4 * spacing, f64::from(i / 6) * spacing, 0.0)).collect()
        };
        for (spacing, opens) in [(1.05, true), (2.2, false)] {
            let frames = [(0.0, 0.0), (90.0, 150.0)]
                .map(|(time_s, x)| KeyFrame { time_s, pose: KeyPose::Herd(herd(spacing, x)) });
            let path = Trajectory::on_open_ground(&frames::centres(&frames), 5.0).unwrap();
            let guides = Guides::new(&frames, &path, PairingMetric::Euclidean, &Run::silent()).unwrap();
            let wide = |share: f64| {
                let posture = guides.posture(Progress { interval: 0, share });
                posture.place(0).distance(posture.place(35))
            };
            assert!((wide(0.0) - wide(1.0)).abs() < 1e-9);
            assert_eq!(wide(0.5) > 1.2 * wide(0.0), opens, "{spacing}: {} {}", wide(0.0), wide(0.5));
        }
    }
}
