//! The herd-frame-guided simulation (T 4.3.2).

use super::AnimationError;
use super::AnimationOptions;
use super::Trajectory;
use super::choice::Chooser;
use super::choice::Move;
use super::choice::Past;
use super::guides::Guides;
use super::guides::Posture;
use super::guides::Progress;
use super::motion::Gait;
use super::motion::Mover;
use super::report;
use super::report::Arrival;
use super::report::Asked;
use super::report::Hindrance;
use super::report::Needed;
use super::report::Report;
use super::route::Ways;
use super::route::Width;
use super::terrain::Ground;
use super::tracks::Plan;
use super::tracks::Pose;
use super::tracks::Tracks;
use super::traffic;
use super::traffic::Bodies;
use super::traffic::TRIES;
use crate::compute::geometry::Point;
use crate::compute::herds::contact::Footprint;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;
use std::cmp::Ordering;

/// The guides never need more than this share of V_max, so that stragglers can catch up (ours).
const CRUISE: f64 = 0.9;

/// An animal this many body lengths from its guide is a straggler, and twice as many stop the
/// herd frame (ours).
const STRAGGLER_BODY_LENGTHS: f64 = 2.0;

/// Seconds for which the herd waits for the same straggler before it goes on without it (ours).
const PATIENCE_S: f64 = 8.0;

/// Up to this share of its top speed the herd frame waits for stragglers; above it less and less,
/// for it would be late itself (ours).
const UNHURRIED: f64 = 0.7;

/// Seconds that any herd is given to settle at a key-herd, and the most of the interval (ours).
const SETTLING_S: f64 = 4.0;
const SETTLING_SHARE: f64 = 0.2;

/// Ways round obstacles keep this far from them where they can (ours).
const ELBOW_BODY_LENGTHS: f64 = 1.5;

/// An animal no faster than this share of V_max that others let not do as it wishes is held up
/// (ours).
const CRAWL: f64 = 0.05;

/// Overlap allowed everywhere, as a share of a body's width.
const OVERLAP: f64 = 0.1;

/// Animals handled together by a thread.
const CHUNK: usize = 64;

/// A herd on the move.
pub struct Simulation<'a> {
    chooser: Chooser<'a>,
    ground: &'a Ground<'a>,
    trajectory: &'a Trajectory,
    guides: &'a Guides<'a>,
    options: &'a AnimationOptions,
    movers: Vec<Mover>,
    hindered: Vec<Hindrance>,
    /// Seconds for which each animal has been a straggler.
    straggling: Vec<f64>,
    /// Seconds for which others have held each animal up.
    stuck_s: Vec<f64>,
    /// The ways round obstacles to the end of an interval; none on open ground.
    ways: Option<(usize, Ways)>,
    progress: Progress,
    /// Speed of the herd frame as a share of the fastest that guides allow.
    pace: f64,
    /// Seconds from the key-frame behind to the one ahead.
    given_s: f64,
    waited_s: f64,
    longest: f64,
}

impl<'a> Simulation<'a> {
    /// A herd standing at its first key-frame.
    pub(super) fn new(
        ground: &'a Ground<'a>,
        trajectory: &'a Trajectory,
        guides: &'a Guides<'a>,
        options: &'a AnimationOptions,
    ) -> Self {
        let progress = Progress { interval: 0, share: 0.0 };
        let first = guides.posture(progress);
        let movers = (0..guides.len()).map(|i| Mover::standing(first.place(i), first.heading(i, false).angle()));
        let longest = guides.bodies.iter().map(|b| b.0).fold(0.0, f64::max);
        Self {
            chooser: Chooser { ground, guides, options, longest },
            ground,
            trajectory,
            guides,
            options,
            movers: movers.collect(),
            hindered: vec![Hindrance::default(); guides.len()],
            straggling: vec![0.0; guides.len()],
            stuck_s: vec![0.0; guides.len()],
            ways: None,
            progress,
            pace: 0.0,
            given_s: 0.0,
            waited_s: 0.0,
            longest,
        }
    }

    /// Walks the whole plan.
    pub(super) fn walk(&mut self, plan: &Plan, run: &Run) -> Result<(Tracks, Report), AnimationError> {
        let n = self.guides.len();
        let mut tracks =
            Tracks { times_s: vec![plan.start_s], animals: n, poses: Vec::with_capacity(n * plan.kept.min(1 << 20)) };
        tracks.poses.extend(self.poses());
        let mut report = Report { path_m: self.trajectory.length(), ..Report::default() };
        let total: usize = plan.intervals.iter().map(|(steps, _)| steps).sum();
        let (mut done, mut start_s) = (0, plan.start_s);
        for (interval, &(steps, step_s)) in plan.intervals.iter().enumerate() {
            self.hindered.fill(Hindrance::default());
            self.given_s = steps as f64 * step_s;
            for step in 1..=steps {
                let left_s = (steps - step + 1) as f64 * step_s;
                self.find_ways(run)?;
                self.step(interval, left_s, step_s);
                done += 1;
                if done % 16 == 0 {
                    run.progress("animation.steps", done as u64, total as u64)?;
                }
                if done % plan.keep_every == 0 || step == steps {
                    tracks.times_s.push(start_s + step as f64 * step_s);
                    tracks.poses.extend(self.poses());
                }
            }
            start_s += self.given_s;
            report.arrivals.push(self.arrival(interval, start_s));
        }
        run.progress("animation.steps", total as u64, total as u64)?;
        report.waited_s = self.waited_s;
        Ok((tracks, report))
    }

    fn poses(&self) -> Vec<Pose> {
        let pose = |m: &Mover| Pose { place: m.place, z: self.ground.height(m.place), heading: m.heading };
        self.movers.par_iter().with_min_len(CHUNK).map(pose).collect()
    }

    /// The ways round obstacles to where the guides are at the end of the interval.
    fn find_ways(&mut self, run: &Run) -> Result<(), Stopped> {
        let (interval, clearance) = (self.progress.interval, self.ground.clearance());
        if clearance.is_open() || self.ways.as_ref().is_some_and(|(of, _)| *of == interval) {
            return Ok(());
        }
        let end = self.guides.straight(Progress { interval, share: 1.0 });
        let goals = (0..self.guides.len()).map(|i| end.place(i));
        let widest = self.guides.bodies.iter().map(|b| b.1).fold(0.0, f64::max);
        let width = Width { least_m: widest, ample_m: ELBOW_BODY_LENGTHS * 2.0 * self.longest };
        self.ways = Some((interval, Ways::new(clearance, goals, width, run)?));
        Ok(())
    }

    /// One step of `step_s`, with `left_s` until the key-frame that ends `interval`.
    fn step(&mut self, interval: usize, left_s: f64, step_s: f64) {
        // 1. The herd frame moves on, unless stragglers hold it.
        let before = self.progress;
        self.advance_frame(interval, left_s, step_s);
        // 2. Everybody chooses a step from what all were doing a moment ago.
        let past = Past { ways: self.ways.as_ref().map(|(_, ways)| ways), stuck_s: &self.stuck_s };
        let scene = self.chooser.scene(&self.movers, (before, self.progress), (step_s, past));
        let moves: Vec<Move> = (0..self.movers.len())
            .into_par_iter()
            .with_min_len(CHUNK)
            .map(|i| self.chooser.choose(i, &scene))
            .collect();
        // 3. Where two would collide, one makes less of its step.
        let bodies = &self.guides.bodies;
        let of = |(m, body): (&Move, &(f64, f64))| m.tries.map(|to| traffic::footprint(&to, *body));
        let tries: Vec<[Footprint; TRIES]> = moves.iter().zip(bodies).map(of).collect();
        let farthest = |(i, m): (usize, &Move)| m.farthest(&self.movers[i], bodies[i].0);
        let farthest: Vec<f64> = moves.iter().enumerate().map(farthest).collect();
        let narrowest = bodies.iter().map(|b| b.1).fold(f64::INFINITY, f64::min);
        let allowed = (2.0 * OVERLAP * narrowest).max(self.guides.depth_held(self.progress.interval));
        let gait = &self.options.gait;
        let step_m = (gait.max_speed_m_per_s + gait.max_turn_rad_per_s * self.longest) * step_s;
        let bodies = Bodies { old: &scene.prints, tries: &tries, moves: &farthest };
        let levels = traffic::settle(&bodies, (&scene.grid, 2.0 * (self.longest + step_m)), allowed);
        // 4. The rest moves.
        for (i, (chosen, level)) in moves.into_iter().zip(levels).enumerate() {
            let h = &mut self.hindered[i];
            h.obstacle += u32::from(chosen.blocked);
            h.crowding += u32::from(level > 0);
            let held = level > 0 && self.movers[i].speed <= CRAWL * self.options.gait.max_speed_m_per_s;
            self.stuck_s[i] = if held { self.stuck_s[i] + step_s } else { 0.0 };
            self.movers[i] = chosen.tries.get(usize::from(level)).copied().unwrap_or(self.movers[i].held());
        }
    }

    /// Moves the herd frame so that it is at the next key-frame in time, no faster than guides
    /// can be followed, and slower or not at all while stragglers are behind (T 4.3.2).
    fn advance_frame(&mut self, interval: usize, left_s: f64, step_s: f64) {
        let wait = self.waiting(step_s);
        self.waited_s += if wait < 1.0 { step_s } else { 0.0 };
        let left_s = match self.progress.interval.cmp(&interval) {
            Ordering::Less => step_s,
            Ordering::Equal => left_s,
            Ordering::Greater => return,
        };
        let (rest, top) = (1.0 - self.progress.share, self.top_rate());
        let last = self.progress.interval + 1 == self.guides.intervals();
        // At a key-herd the frame brakes and the herd settles: it leaves that much earlier.
        let settles = self.guides.ends_in_herd(self.progress.interval);
        let spare_s = if settles { self.settling_s() + BRAKE_S * (0.5 * self.pace + 1.0) } else { 0.0 };
        let (whole, fall) = self.guides.rest(self.progress);
        let wanted = whole / fall / (left_s - spare_s).max(step_s);
        let braking = if settles { (2.0 * rest * top / BRAKE_S).sqrt() } else { f64::INFINITY };
        // Nobody is waited for when that would make all late.
        let haste = ((wanted / top - UNHURRIED) / (1.0 - UNHURRIED)).clamp(0.0, 1.0);
        let rate = (wanted * wait.max(haste)).min((self.pace + step_s / BRAKE_S) * top).min(braking).min(top);
        self.pace = if top > 0.0 { rate / top } else { 0.0 };
        self.progress.share += rate * step_s;
        if 1.0 - self.progress.share < 1e-6 {
            self.progress.share = 1.0;
            if !last {
                self.progress = Progress { interval: self.progress.interval + 1, share: 0.0 };
            }
        }
    }

    /// Seconds that the herd is given to settle at a key-herd.
    fn settling_s(&self) -> f64 {
        SETTLING_S.min(SETTLING_SHARE * self.given_s)
    }

    /// How freely the herd frame may go: 1 while all are near their guides, 0 when one that is
    /// waited for is two straggler's distances behind.
    fn waiting(&mut self, step_s: f64) -> f64 {
        let guides = self.guides.posture(self.progress);
        let far = STRAGGLER_BODY_LENGTHS * 2.0 * self.longest;
        let mut worst = 0f64;
        for (i, mover) in self.movers.iter().enumerate() {
            // Who is ahead of its guide, on its way round an obstacle, is not waited for.
            let lag = if guides.lags(i, mover.place) { mover.place.distance(guides.place(i)) / far } else { 0.0 };
            self.straggling[i] = if lag > 1.0 { self.straggling[i] + step_s } else { 0.0 };
            if self.straggling[i] < PATIENCE_S {
                worst = worst.max(lag);
            }
        }
        (2.0 - worst).clamp(0.0, 1.0)
    }

    /// The most shares of the interval a second at which every guide can be followed.
    fn top_rate(&self) -> f64 {
        const PROBE: f64 = 1e-3;
        let Progress { interval, share } = self.progress;
        let from = Progress { interval, share: share.min(1.0 - PROBE) };
        let to = Progress { interval, share: from.share + PROBE };
        let (here, ahead) = (self.guides.posture(from), self.guides.posture(to));
        let seconds = |i: usize| self.seconds_between(here.place(i), ahead.place(i));
        let slowest = (0..self.guides.len()).into_par_iter().with_min_len(CHUNK).map(seconds).max_by(f64::total_cmp);
        // No guide moves: any rate will do.
        CRUISE * PROBE / slowest.unwrap_or(0.0).max(1e-6 * PROBE)
    }

    /// Seconds from `p` to `q` at V_max on the slope between them.
    fn seconds_between(&self, p: Point, q: Point) -> f64 {
        let Some(along) = (q - p).normalised() else { return 0.0 };
        let factor = Gait::slope_factor(self.ground.slope(p, along));
        p.distance(q) / (factor * self.options.gait.max_speed_m_per_s)
    }

    /// How the key-frame at the end of `interval` was met.
    fn arrival(&self, interval: usize, time_s: f64) -> Arrival {
        let end = self.guides.posture(Progress { interval, share: 1.0 });
        let places: Vec<Point> = (0..self.guides.len()).map(|i| end.place(i)).collect();
        let needed = self.needed(interval);
        let asked = Asked { given_s: self.given_s, cruise: CRUISE, needed: &needed, hindered: &self.hindered };
        let late = report::late(&self.poses(), &places, &self.guides.bodies, &asked);
        Arrival {
            key_frame: interval + 1,
            time_s,
            given_s: self.given_s,
            needed_s: needed.iter().map(|n| n.slopes_s).fold(0.0, f64::max),
            cannot_reach: needed.iter().filter(|n| n.slopes_s > self.given_s).count(),
            on_place: 1.0 - late.len() as f64 / self.guides.len() as f64,
            late,
        }
    }

    /// Seconds each animal needs for its guide's way through an interval at V_max.
    fn needed(&self, interval: usize) -> Vec<Needed> {
        const SAMPLES: usize = 64;
        let at = |k: usize| self.guides.straight(Progress { interval, share: k as f64 / SAMPLES as f64 });
        let way: Vec<Posture<'_>> = (0..=SAMPLES).map(at).collect();
        let most = self.options.gait.max_speed_m_per_s;
        let seconds = |i: usize| {
            let legs = || way.windows(2).map(|leg| (leg[0].place(i), leg[1].place(i)));
            Needed {
                level_s: legs().map(|(p, q)| p.distance(q) / most).sum(),
                slopes_s: legs().map(|(p, q)| self.seconds_between(p, q)).sum(),
            }
        };
        (0..self.guides.len()).into_par_iter().map(seconds).collect()
    }
}

/// Seconds in which the herd frame reaches or leaves its full pace (ours).
const BRAKE_S: f64 = 1.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::geometry::Ellipse;
    use crate::compute::herds::Obstacles;
    use crate::compute::herds::animation::KeyFrame;
    use crate::compute::herds::animation::KeyPose;
    use crate::compute::herds::animation::PairingMetric;
    use crate::compute::herds::animation::frames;
    use crate::compute::raster::Grid;
    use crate::compute::raster::Raster;

    #[test]
    fn the_frame_waits_for_stragglers_but_not_for_ever() {
        let (terrain, none) = (Raster::filled(Grid::new(100, 100, 2.0), 0f32), Obstacles::default());
        let animal = |x: f64, y: f64| Ellipse { centre: Point::new(x, y), a: 1.2, b: 0.5, theta: 0.0 };
        let herd = |x: f64| (0..5).map(|i| animal(x, 90.0 + 5.0 * f64::from(i))).collect();
        let frames = [(0.0, 60.0), (60.0, 160.0)].map(|(time_s, x)| KeyFrame { time_s, pose: KeyPose::Herd(herd(x)) });
        let ground = Ground::new(&terrain, &none, &frames, &Run::silent()).unwrap();
        let path = Trajectory::on_open_ground(&frames::centres(&frames), 5.0).unwrap();
        let guides = Guides::new(&frames, &path, PairingMetric::Euclidean, &Run::silent()).unwrap();
        let options = AnimationOptions::default();
        let mut herd = Simulation::new(&ground, &path, &guides, &options);
        // As far as a straggler is, in metres.
        let far = STRAGGLER_BODY_LENGTHS * 2.4;
        let mut behind = |metres: f64| {
            herd.movers[2].place = Point::new(60.0 - metres, 100.0);
            herd.straggling.fill(0.0);
            herd.waiting(0.1)
        };
        assert_eq!((behind(0.0), behind(0.9 * far), behind(3.0 * far)), (1.0, 1.0, 0.0));
        assert!((behind(1.5 * far) - 0.5).abs() < 1e-9);
        assert_eq!(behind(-3.0 * far), 1.0, "who is ahead is not waited for");
        behind(1.8 * far);
        let waits = (0..200).take_while(|_| herd.waiting(0.1) < 1.0).count();
        assert!((75..82).contains(&waits), "{waits} steps of 0.1 s");
        // While it waits, the frame goes on only as far as it may.
        let gone = |metres: f64| {
            let mut herd = Simulation::new(&ground, &path, &guides, &options);
            herd.given_s = 60.0;
            herd.movers[2].place = Point::new(60.0 - metres, 100.0);
            (0..30).for_each(|_| herd.advance_frame(0, 60.0, 0.1));
            herd.progress.share
        };
        assert!(gone(0.0) > 0.02 && gone(4.0 * far) == 0.0, "{} {}", gone(0.0), gone(4.0 * far));
    }
}
