//! What each animal makes of a step, from what all were doing a moment ago.

use super::AnimationOptions;
use super::aim::Aim;
use super::aim::STILL;
use super::guides::Guides;
use super::guides::Posture;
use super::guides::Progress;
use super::motion::Gait;
use super::motion::Mover;
use super::motion::Wish;
use super::motion::wrapped;
use super::route::Ways;
use super::steering::Company;
use super::steering::Neighbour;
use super::terrain::Ground;
use super::traffic;
use super::traffic::TRIES;
use crate::compute::geometry::CellGrid;
use crate::compute::geometry::Point;
use crate::compute::herds::contact::Footprint;

/// An animal on its way round goes at least at this share of what it can (ours).
const DETOUR_PACE: f64 = 0.6;

/// A step up or down is shortened at most this often until it keeps V_max; on ground that is not
/// a cliff twice is enough.
const CUTS: usize = 8;

/// All that animals look at in a step; the same for all.
pub(super) struct Scene<'a> {
    pub progress: Progress,
    pub movers: &'a [Mover],
    velocities: Vec<Point>,
    pub guides: Vec<Point>,
    pub guide_velocities: Vec<Point>,
    /// The bodies as they are.
    pub prints: Vec<Footprint>,
    /// The animals by place.
    pub grid: CellGrid,
    posture: Posture<'a>,
    /// Whether the formation ahead is nearer than the one behind, and how much it counts.
    key: (bool, f64),
    pub step_s: f64,
    pub past: Past<'a>,
}

/// What animals know besides what they see.
#[derive(Clone, Copy)]
pub(super) struct Past<'a> {
    /// The ways round obstacles; `None` on open ground.
    pub ways: Option<&'a Ways>,
    /// Seconds for which each animal has been held up.
    pub stuck_s: &'a [f64],
}

/// A step as an animal would make it if it were alone on the road.
pub(super) struct Move {
    /// All of it, straight on without turning, and the turn alone.
    pub tries: [Mover; TRIES],
    /// An obstacle stood in its way.
    pub blocked: bool,
}

impl Move {
    /// How far any part of the body of `was`, with a semi-major axis of `a`, moves at most.
    pub(super) fn farthest(&self, was: &Mover, a: f64) -> f64 {
        let of = |to: &Mover| to.place.distance(was.place) + a * wrapped(to.heading - was.heading).abs();
        self.tries.iter().map(of).fold(0.0, f64::max)
    }
}

/// Chooses the animals' steps.
pub(super) struct Chooser<'a> {
    pub ground: &'a Ground<'a>,
    pub guides: &'a Guides<'a>,
    pub options: &'a AnimationOptions,
    /// The longest semi-major axis, in metres.
    pub longest: f64,
}

impl Chooser<'_> {
    /// The scene while the herd frame goes from one place on its way to the next.
    pub(super) fn scene<'m>(
        &'m self,
        movers: &'m [Mover],
        (before, now): (Progress, Progress),
        (step_s, past): (f64, Past<'m>),
    ) -> Scene<'m> {
        let (old, posture) = (self.guides.posture(before), self.guides.posture(now));
        let guides: Vec<Point> = (0..self.guides.len()).map(|i| posture.place(i)).collect();
        let velocity = |(i, g): (usize, &Point)| (*g - old.place(i)) * (1.0 / step_s);
        let places: Vec<Point> = movers.iter().map(|m| m.place).collect();
        Scene {
            progress: now,
            movers,
            guide_velocities: guides.iter().enumerate().map(velocity).collect(),
            guides,
            velocities: movers.iter().map(Mover::velocity).collect(),
            prints: movers.iter().zip(&self.guides.bodies).map(|(m, b)| traffic::footprint(m, *b)).collect(),
            grid: CellGrid::new(&places, self.neighbourhood() / 2.0),
            posture,
            key: self.guides.key_weight(now, self.options.gait.blend_body_lengths * 2.0 * self.longest),
            step_s,
            past,
        }
    }

    fn neighbourhood(&self) -> f64 {
        self.options.steering.neighbourhood_body_lengths * 2.0 * self.longest
    }

    /// The step that animal `i` would make if it were alone on the road.
    pub(super) fn choose(&self, i: usize, scene: &Scene<'_>) -> Move {
        let (mover, body, gait) = (&scene.movers[i], self.guides.bodies[i], &self.options.gait);
        // 1. Where to, and how fast the slope in that direction lets it go.
        let aim = self.aim(i, scene);
        let (Aim::Guide(target) | Aim::Detour(target) | Aim::Meeting(target, _)) = aim;
        let off = target - mover.place;
        let course = off.normalised().unwrap_or_else(|| Point::from_angle(mover.course));
        let factor = Gait::slope_factor(self.ground.slope(mover.place, course));
        let limit = factor * gait.max_speed_m_per_s;
        // 2. The five forces: guide, neighbours (three), obstacles.
        let steering = &self.options.steering;
        let follow = steering.follow(mover.place, scene.guides[i], scene.guide_velocities[i]);
        let wanted = match aim {
            Aim::Guide(place) => steering.follow(mover.place, place, scene.guide_velocities[i]),
            Aim::Detour(_) => course * follow.norm().clamp(DETOUR_PACE * limit, limit),
            Aim::Meeting(_, speed) => course * speed.min(limit),
        };
        let lost = (scene.guides[i].distance(mover.place) / (4.0 * body.0)).min(1.0);
        let company = self.company(i, scene);
        let social = company.forces(steering, mover, (limit, lost));
        let avoidance = steering.avoid(mover, self.ground, (course, body.1, limit));
        let sum = wanted + social + avoidance;
        // 3. What the body can make of it.
        let guide_speed = scene.guide_velocities[i].norm();
        let rests = is_at_rest(mover, off, guide_speed, (body.0, gait.max_speed_m_per_s));
        let velocity = if rests { Point::default() } else { sum * (limit / sum.norm().max(limit)) };
        let (ahead, key_weight) = scene.key;
        let key_heading = scene.posture.heading(i, ahead).angle();
        // Without room in front it can still turn.
        let wish = Wish { velocity, key_heading, key_weight, limit: limit.min(company.room_ahead()) };
        let step = |wish| self.admitted(mover, mover.stepped(wish, gait, scene.step_s), (body.1, scene.step_s));
        let (mut to, free) = step(wish);
        if !free && let Some(away) = self.ground.clearance().away(mover.place) {
            (to, _) = step(Wish { velocity: along_rim(velocity, away), ..wish });
        }
        let straight = led(mover, mover.straight(&to, gait), scene.step_s);
        // Who is held up far from its guide turns the other way every other second: two that keep
        // each other from turning would stand for ever.
        let gives_way = lost >= 1.0 && scene.past.stuck_s[i] % 2.0 >= 1.0;
        let turned = if gives_way { mover.turned_back(&to) } else { mover.turned(&to) };
        let straight = self.admitted(mover, straight, (body.1, scene.step_s)).0;
        Move {
            tries: [to, if gives_way && straight.speed == 0.0 { turned } else { straight }, turned],
            blocked: !free || !matches!(aim, Aim::Guide(_)),
        }
    }

    fn company(&self, i: usize, scene: &Scene<'_>) -> Company {
        let (own, reach) = (scene.movers[i].place, self.neighbourhood());
        let mut company = Company::new();
        scene.grid.for_each_near(own, reach, |j| {
            if j != i && scene.movers[j].place.distance_sq(own) <= reach * reach {
                let neighbour = Neighbour {
                    print: &scene.prints[j],
                    velocity: scene.velocities[j],
                    guides_apart: scene.guides[i].distance(scene.guides[j]),
                    // Who was there first in the list goes first: somebody has to.
                    yields: j > i,
                };
                company.meet(&scene.prints[i], &neighbour);
            }
        });
        company
    }

    /// The step as far as the ground admits it: whole, half, a quarter, or only the turn; and
    /// whether it was whole.
    fn admitted(&self, from: &Mover, to: Mover, (half_width, step_s): (f64, f64)) -> (Mover, bool) {
        let to = self.within_max_speed(from, to, step_s);
        for share in [1.0, 0.5, 0.25] {
            let shorter = led(from, Mover { speed: to.speed * share, ..to }, step_s);
            if shorter.speed == 0.0 || self.ground.admits(shorter.place, from.place, half_width) {
                return (shorter, share == 1.0);
            }
        }
        (Mover { place: from.place, speed: 0.0, course: to.heading, ..to }, false)
    }

    /// The step with its speed cut until V_max holds along the ground, rise and all: the slope was
    /// judged towards the aim, and forces may have led elsewhere.
    fn within_max_speed(&self, from: &Mover, to: Mover, step_s: f64) -> Mover {
        let most = self.options.gait.max_speed_m_per_s * step_s;
        let mut cut = to;
        for _ in 0..CUTS {
            let length = self.ground.distance(from.place, cut.place);
            if length <= most {
                return cut;
            }
            cut = led(from, Mover { speed: cut.speed * (most / length) * (1.0 - 1e-9), ..cut }, step_s);
        }
        led(from, Mover { speed: 0.0, course: to.heading, ..to }, step_s)
    }
}

/// `to` placed where its course and speed lead from `from` within a step.
fn led(from: &Mover, to: Mover, step_s: f64) -> Mover {
    Mover { place: from.place + Point::from_angle(to.course) * (to.speed * step_s), ..to }
}

/// What is left of a wish where an obstacle does not admit it: half of it, along the rim and a
/// little off it.
fn along_rim(wished: Point, away: Point) -> Point {
    let along = wished + away * -wished.dot(away);
    let side = along.normalised().unwrap_or(Point::new(-away.y, away.x));
    (side + away * 0.5) * (0.5 * wished.norm())
}

/// Whether an animal stays where it is: its guide (at `off`) stands still, near by, and not in
/// front, so that to get nearer it would have to turn round or go sideways.
fn is_at_rest(mover: &Mover, off: Point, guide_speed: f64, (half_length, max_speed): (f64, f64)) -> bool {
    let ahead = off.dot(Point::from_angle(mover.heading));
    guide_speed < STILL * max_speed && off.norm() < 0.4 * half_length && ahead < 0.05 * half_length
}
