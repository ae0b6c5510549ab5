//! Guides: where each animal should be while the herd frame is somewhere between two key-frames
//! (T 4.3.2). They move straight in the herd frame, x along the trajectory.

use super::AnimationError;
use super::PairingMetric;
use super::Trajectory;
use super::frames;
use super::frames::KeyFrame;
use super::pairing::pair;
use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Point;
use crate::compute::herds::contact;
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

/// Before a key-herd the formation is complete at this share of the interval (ours): animals that
/// cannot go sideways make up what they lack across the path while they still walk along it.
const MORPHED_BY: f64 = 0.8;

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

    /// Where the herd frame is.
    pub(super) fn frame_at(&self, progress: Progress) -> HerdFrame {
        self.frame(self.arc_length(progress))
    }

    fn arc_length(&self, progress: Progress) -> f64 {
        let (from, to) = (self.trajectory.key(progress.interval), self.trajectory.key(progress.interval + 1));
        from + (to - from) * progress.share
    }

    fn blend(&self, progress: Progress) -> (&Formation, &Formation, f64) {
        let interval = self.intervals[progress.interval];
        let (w0, w1) = interval.weights;
        let morphed = if interval.herds.1 { (progress.share / MORPHED_BY).min(1.0) } else { progress.share };
        (&self.formations[interval.from], &self.formations[interval.to], w0 + (w1 - w0) * morphed)
    }

    /// Where the guide of `animal` is, in metres.
    pub(super) fn place(&self, frame: HerdFrame, progress: Progress, animal: usize) -> Point {
        let (from, to, weight) = self.blend(progress);
        frame.to_world(from.places[animal].lerp(to.places[animal], weight))
    }

    /// The heading of `animal` in the formation that lies behind (`false`) or ahead (`true`).
    pub(super) fn key_heading(&self, frame: HerdFrame, interval: usize, (animal, ahead): (usize, bool)) -> Point {
        let i = self.intervals[interval];
        let local = self.formations[if ahead { i.to } else { i.from }].headings[animal];
        frame.to_world(local) - frame.origin
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
        let weight = |share: f64| {
            let t = (1.0 - share * length / reach_m.max(1e-9)).clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t)
        };
        let from = if behind { weight(progress.share) } else { 0.0 };
        let to = if ahead { weight(1.0 - progress.share) } else { 0.0 };
        (to >= from, to.max(from))
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
        }
    }

    fn reordered(&self, order: &[usize]) -> Self {
        Self {
            places: order.iter().map(|i| self.places[*i]).collect(),
            headings: order.iter().map(|i| self.headings[*i]).collect(),
            depth: self.depth,
        }
    }
}
