//! What an animal heads for: its guide while it sees it, else a way past what is between.

use super::choice::Chooser;
use super::choice::Scene;
use super::motion::Mover;
use crate::compute::geometry::Point;

/// How far an animal looks past an obstacle, in which steps it turns to look, and how many of
/// them (ours).
const VIEW_BODY_LENGTHS: f64 = 5.0;
const VIEW_STEP_RAD: f64 = 0.26;
const VIEW_STEPS: i32 = 6;

/// How far along its way round obstacles an animal looks (ours).
const WAY_BODY_LENGTHS: f64 = 8.0;

/// A guide slower than this share of V_max stands still (ours).
pub(super) const STILL: f64 = 0.05;

/// An animal turns aside when its guide will be in an obstacle within twice its foresight, looked
/// at so many times in each half of it (ours): later it would have to turn sharply.
const LOOKS: u32 = 2;

/// How far ahead of a guide it is looked where it comes out of an obstacle, in steps of half a
/// body length (ours).
const MEETING_STEPS: u32 = 24;

/// The corner past an obstacle is looked for at these shares of the way to what is behind (ours).
const CORNERS: [f64; 4] = [0.25, 0.5, 0.75, 1.0];

/// A corner is found to within the step of a look over two to the power of this.
const HALVINGS: u32 = 4;

/// What an animal heads for.
#[derive(Debug, Clone, Copy)]
pub(super) enum Aim {
    /// Its guide, at this place.
    Guide(Point),
    /// A place beside what hides the guide or where that goes.
    Detour(Point),
    /// A place on the way to where the guide comes out of an obstacle, at this speed in metres a
    /// second: so they are there together.
    Meeting(Point, f64),
}

/// Where a guide comes out of an obstacle.
#[derive(Clone, Copy)]
struct Meeting {
    place: Point,
    /// Seconds until it is there.
    in_s: f64,
}

impl Chooser<'_> {
    /// What animal `i` heads for: its guide, while it sees it and where that will be; the place
    /// where it comes out of an obstacle, past one corner; else what it sees of the way round all
    /// obstacles, the nearest free direction past what is between, or the farthest place on the
    /// herd's path that it can see.
    pub(super) fn aim(&self, i: usize, scene: &Scene<'_>) -> Aim {
        let (mover, clearance, half) = (&scene.movers[i], self.ground.clearance(), self.guides.bodies[i].1);
        if clearance.is_open() {
            return Aim::Guide(scene.guides[i]);
        }
        let (place, velocity) = (mover.place, scene.guide_velocities[i]);
        let later = scene.guides[i] + velocity * self.options.steering.foresight_s;
        let (guide, soon) = (self.beside(scene.guides[i], half), self.beside(later, half));
        let room = clearance.at(place).min(half);
        let sees = |q: Point| clearance.sees(place, q, room.min(clearance.at(q)).max(0.0));
        // A guide that walks through an obstacle is not followed to its rim, but met behind it.
        let walks = velocity.norm() > STILL * self.options.gait.max_speed_m_per_s;
        let ahead = |k: u32| scene.guides[i].lerp(later, f64::from(k) / f64::from(LOOKS));
        let hidden = walks && (0..=2 * LOOKS).any(|k| clearance.at(ahead(k)) < half);
        if !hidden && sees(soon) && sees(guide) {
            return Aim::Guide(guide);
        }
        let meeting = if hidden { self.meeting(i, scene) } else { None };
        let with_room =
            |widths: f64| meeting.and_then(|meeting| self.past_a_corner(i, scene, (meeting, widths * half)));
        if let Some(aim) = with_room(2.0).or_else(|| with_room(1.0)) {
            return aim;
        }
        // Who is ahead of its guide only looks round what is between.
        let behind = scene.past.ways.filter(|ways| hidden || ways.is_behind(place, soon));
        let reach = WAY_BODY_LENGTHS * 2.0 * self.longest;
        let way = behind.and_then(|ways| ways.ahead(place, reach, sees));
        let way =
            way.or_else(|| self.detour(mover, soon, sees)).or_else(|| self.guides.rejoin(place, scene.progress, sees));
        way.map_or(Aim::Guide(guide), Aim::Detour)
    }

    /// A guide inside an obstacle stands beside it.
    fn beside(&self, mut guide: Point, half: f64) -> Point {
        let clearance = self.ground.clearance();
        for _ in 0..8 {
            let lack = 1.1 * half - clearance.at(guide);
            match clearance.away(guide) {
                Some(away) if lack > 0.0 => guide = guide + away * (lack + 0.1 * half),
                _ => break,
            }
        }
        guide
    }

    /// Where the guide of animal `i` comes out of the obstacle in its way, if it goes on as it
    /// does and comes out soon.
    fn meeting(&self, i: usize, scene: &Scene<'_>) -> Option<Meeting> {
        let (clearance, half) = (self.ground.clearance(), self.guides.bodies[i].1);
        let (guide, velocity) = (scene.guides[i], scene.guide_velocities[i]);
        let step_s = self.longest / velocity.norm();
        let at = |k: u32| guide + velocity * (f64::from(k) * step_s);
        let closed = |k: &u32| clearance.at(at(*k)) < half;
        let enters = (0..=MEETING_STEPS).find(closed)?;
        let leaves = (enters..=MEETING_STEPS).find(|k| !closed(k))?;
        // One step on, so that they meet clear of the rim.
        let leaves = if closed(&(leaves + 1)) { leaves } else { leaves + 1 };
        Some(Meeting { place: at(leaves), in_s: f64::from(leaves) * step_s })
    }

    /// The way to a meeting with `width` on either side: straight, or past one corner, whichever
    /// side turns less. `None` where one corner is not enough.
    fn past_a_corner(&self, i: usize, scene: &Scene<'_>, (meeting, width): (Meeting, f64)) -> Option<Aim> {
        let (mover, clearance) = (&scene.movers[i], self.ground.clearance());
        let (place, goal) = (mover.place, meeting.place);
        let room = clearance.at(place).min(width).max(0.0);
        let to = |place: Point, length: f64| Some(Aim::Meeting(place, length / meeting.in_s.max(scene.step_s)));
        let ray = goal - place;
        if ray.norm() < self.longest || clearance.sees(place, goal, room) {
            // Past the goal, so that it arrives in the guide's direction.
            let on = scene.guide_velocities[i].normalised().unwrap_or_default() * self.longest;
            return to(goal + on, ray.norm());
        }
        let corner = |turn: f64| {
            let at = |share: f64| place + ray.rotated(turn) * share;
            let is_corner =
                |q: &Point| clearance.sees(place, *q, room) && clearance.sees(*q, goal, width.min(clearance.at(goal)));
            CORNERS.into_iter().map(at).find(is_corner)
        };
        let (mut free, mut found) = turns(mover, ray).filter_map(|turn| Some((turn, corner(turn)?))).next()?;
        // As near the rim as there is room: a look in whole steps would make it waver.
        let mut blocked = free - VIEW_STEP_RAD.copysign(free);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (free + blocked);
            match corner(middle) {
                Some(q) => (free, found) = (middle, q),
                None => blocked = middle,
            }
        }
        to(found, place.distance(found) + found.distance(goal))
    }

    /// A place beside what stands between an animal and its guide: the free direction that turns
    /// least from the guide, the side it already looks to first.
    fn detour(&self, mover: &Mover, guide: Point, sees: impl Fn(Point) -> bool) -> Option<Point> {
        let to_guide = guide - mover.place;
        let ray = to_guide.normalised()? * to_guide.norm().min(VIEW_BODY_LENGTHS * 2.0 * self.longest);
        turns(mover, ray).map(|turn| mover.place + ray.rotated(turn)).find(|q| sees(*q))
    }
}

/// The turns from `ray` in which an animal looks, in radians: the least first, of both sides the
/// one it already looks to.
fn turns(mover: &Mover, ray: Point) -> impl Iterator<Item = f64> {
    let side = if ray.cross(Point::from_angle(mover.heading)) >= 0.0 { 1.0 } else { -1.0 };
    (1..=VIEW_STEPS).flat_map(move |k| [side, -side].map(|s| s * f64::from(k) * VIEW_STEP_RAD))
}
