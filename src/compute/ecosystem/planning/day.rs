//! The day of one herd: Algorithm 3 of L, with the corrections named in the module above.

use super::Activity;
use super::Cause;
use super::DAY_S;
use super::Options;
use super::Planned;
use super::Planning;
use super::Reason;
use super::Visit;
use super::herds::Herd;
use super::herds::prey_at;
use super::occupancy::Occupancy;
use super::occupancy::Rooms;
use super::prey::PATIENCE_S;
use super::prey::meetings;
use super::reach::Reach;
use crate::compute::ecosystem::habitat::Habitat;
use crate::compute::ecosystem::presence::presence;
use crate::compute::ecosystem::presence::pull;
use crate::compute::ecosystem::rag::Node;
use crate::compute::ecosystem::rag::Rag;
use crate::compute::ecosystem::species::AnimalSpecies;
use crate::compute::random::Purpose;
use crate::compute::random::hash2;
use crate::compute::random::unit;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use std::collections::BTreeMap;
use std::ops::Range;

const REST: Purpose = Purpose::new("planning.rest");
const NEXT: Purpose = Purpose::new("planning.next");
const STAY: Purpose = Purpose::new("planning.stay");
const DUTY: Purpose = Purpose::new("planning.duty");
const QUARRY: Purpose = Purpose::new("planning.quarry");

/// Stays in a day, at most; with stays of ten minutes a day has no more.
const MOST_VISITS: u64 = 400;

/// How much stays of the same kind differ, as a share of their length (ours).
const SPREAD: f64 = 0.1;

/// Herds of one prey that a hunter keeps an eye on, at most (ours: bounds the work where thousands
/// of herds live in its territory).
const MOST_QUARRY: usize = 32;

/// What all herds share.
pub(crate) struct Scene<'a> {
    pub(crate) habitat: &'a Habitat<'a>,
    pub(crate) options: &'a Options,
    pub(crate) rooms: &'a Rooms,
    pub(crate) herds: &'a [Herd],
    /// The days of the levels below.
    pub(crate) days: &'a [Planning],
}

/// What the herds of one territory share.
pub(crate) struct Home<'a> {
    nodes: &'a [usize],
    /// P_s(v) of each.
    presence: Vec<f64>,
    /// The herds hunted at each.
    prey: Vec<Vec<usize>>,
    pub(crate) reach: Reach<'a>,
    /// What each node is for.
    activities: Vec<Activity>,
    /// The nearest node for an activity from a cell, and the way there in seconds; kept.
    nearest: BTreeMap<(usize, Activity), Option<(usize, f64)>>,
}

impl<'a> Home<'a> {
    pub(crate) fn new(scene: &Scene<'a>, territory: usize, run: &'a Run) -> Self {
        let Habitat { rag, animals, .. } = *scene.habitat;
        let home = &rag.territories[territory];
        let prey: Vec<Vec<usize>> = home.nodes.iter().map(|&n| prey_at(n, scene.herds, rag)).collect();
        let haunts = prey.iter().flatten().flat_map(|&h| scene.days[h].visits.iter().map(|visit| visit.cell));
        let mut haunts: Vec<usize> = haunts.collect();
        haunts.sort_unstable();
        haunts.dedup();
        let activities = home.nodes.iter().map(|&n| Activity::with(rag.nodes[n].resource)).collect();
        Self {
            activities,
            nearest: BTreeMap::new(),
            nodes: &home.nodes,
            presence: presence(rag, home, &animals[home.species], &scene.options.drinking),
            reach: Reach::new(scene.habitat, home, &haunts, run),
            prey,
        }
    }
}

impl Home<'_> {
    /// The cell of the nearest node for an activity, and the seconds from `cell` to there.
    fn nearest(&mut self, cell: usize, activity: Activity, rag: &Rag) -> Result<Option<(usize, f64)>, Stopped> {
        if let Some(known) = self.nearest.get(&(cell, activity)) {
            return Ok(*known);
        }
        let mut nearest: Option<(usize, f64)> = None;
        for position in (0..self.nodes.len()).filter(|p| self.activities[*p] == activity) {
            let goal = rag.nodes[self.nodes[position]].cell;
            let seconds = self.reach.seconds(cell, goal)?;
            if seconds.is_finite() && nearest.is_none_or(|(_, least)| seconds < least) {
                nearest = Some((goal, seconds));
            }
        }
        self.nearest.insert((cell, activity), nearest);
        Ok(nearest)
    }
}

/// The days of some herds, in their order; `taken` is the room that others have and they take.
pub(crate) fn days(scene: &Scene, herds: &[usize], taken: &mut Occupancy, run: &Run) -> Result<Vec<Planned>, Stopped> {
    let mut homes = BTreeMap::new();
    let mut days = Vec::with_capacity(herds.len());
    for &herd in herds {
        run.check()?;
        let territory = scene.herds[herd].territory;
        let home = homes.entry(territory).or_insert_with(|| Home::new(scene, territory, run));
        let (planning, reasons) = Day::new(scene, herd, home, taken).planned()?;
        days.push((herd, planning, reasons));
    }
    Ok(days)
}

/// The herds that a hunter may follow, of those that are prey at a node: drawn by hash.
fn quarry(scene: &Scene, hunter: &Herd, prey: &[usize]) -> Vec<usize> {
    let mut drawn: Vec<(u64, usize)> =
        prey.iter().map(|&h| (hash2(scene.options.seed, QUARRY, hunter.key(), scene.herds[h].key()), h)).collect();
    if drawn.len() > MOST_QUARRY {
        drawn.select_nth_unstable(MOST_QUARRY);
        drawn.truncate(MOST_QUARRY);
    }
    let mut herds: Vec<usize> = drawn.into_iter().map(|(_, herd)| herd).collect();
    herds.sort_unstable();
    herds
}

/// A node that could be next.
#[derive(Debug, Clone, Copy)]
struct Stop {
    position: usize,
    cell: usize,
    arrive: f64,
    /// When it must be left at the latest.
    until: f64,
    prey: Option<usize>,
    weight: f64,
}

/// A mandatory resource, and when it is due.
struct Duty {
    activity: Activity,
    due: f64,
}

/// A day in the making.
struct Day<'a, 'b> {
    scene: &'a Scene<'a>,
    herd: &'a Herd,
    species: &'a AnimalSpecies,
    home: &'b mut Home<'a>,
    taken: &'b mut Occupancy,
    visits: Vec<Visit>,
    duties: Vec<Duty>,
    /// The herds it may follow, by position of the node that names them.
    quarry: Vec<Vec<usize>>,
    /// A place that is kept for the herd where none was free at once.
    booked: Option<Stop>,
    /// The prey that is followed, the node that names it, and until when.
    chase: Option<(usize, usize, f64)>,
    end: f64,
    rest_cell: usize,
    crowded_s: f64,
    without_prey_s: f64,
}

impl<'a, 'b> Day<'a, 'b> {
    fn new(scene: &'a Scene<'a>, herd: usize, home: &'b mut Home<'a>, taken: &'b mut Occupancy) -> Self {
        let herd = &scene.herds[herd];
        let species = &scene.habitat.animals[herd.species];
        let quarry = home.prey.iter().map(|prey| quarry(scene, herd, prey)).collect();
        let end = species.active_from_s + species.active_s.clamp(0.0, DAY_S);
        let (visits, duties, chase, booked) = (Vec::new(), Vec::new(), None, None);
        let (rest_cell, crowded_s, without_prey_s) = (0, 0.0, 0.0);
        Self {
            scene,
            herd,
            species,
            home,
            taken,
            visits,
            duties,
            quarry,
            booked,
            chase,
            end,
            rest_cell,
            crowded_s,
            without_prey_s,
        }
    }

    /// The page of steps: a place to rest, stays until nothing fits the active day, and back.
    fn planned(mut self) -> Result<(Planning, Vec<Reason>), Stopped> {
        self.duties = self.mandatory();
        let (rest, roomy) = self.resting_place()?;
        self.begin(rest, roomy);
        for step in 0..MOST_VISITS {
            let mut stops = self.stops()?;
            if self.book(&stops, step)? {
                stops = self.stops()?;
            }
            match self.drawn(&stops, step)? {
                Some(stop) => self.visit(stop, step)?,
                None if self.can_wait(&stops)? => self.wait(!stops.is_empty()),
                None if self.booked.is_some() => self.keep_booking()?,
                None => break,
            }
        }
        self.keep_booking()?;
        self.go_to_rest(rest, roomy)?;
        let reasons = self.reasons(roomy)?;
        Ok((Planning { visits: self.visits }, reasons))
    }

    /// What the species needs every day, the most important first: food once, water as often as
    /// it drinks, in equal parts of the day.
    fn mandatory(&self) -> Vec<Duty> {
        let begin = self.species.active_from_s;
        let has = |activity: Activity| {
            (0..self.home.nodes.len()).any(|p| self.activity(p) == activity && self.home.presence[p] > 0.0)
        };
        let meal = [Activity::Feed, Activity::Hunt].into_iter().find(|a| has(*a));
        let drinks = if has(Activity::Drink) { self.scene.options.drinking.times_per_day } else { 0 };
        let drink = |k: u32| Duty {
            activity: Activity::Drink,
            due: begin + (self.end - begin) * f64::from(k) / f64::from(drinks.max(1)),
        };
        meal.map(|activity| Duty { activity, due: begin }).into_iter().chain((0..drinks).map(drink)).collect()
    }

    /// A node to rest at, drawn from P_s(v) among those with room for the night from which the
    /// mandatory resources can be reached and back; and whether it has room. Nodes with food
    /// first, so that nobody sleeps where others drink or pass.
    fn resting_place(&mut self) -> Result<(usize, bool), Stopped> {
        let night = self.end..self.species.active_from_s + DAY_S;
        let dry = |p: &usize| matches!(self.activity(*p), Activity::Feed | Activity::Hunt);
        let mut open: Vec<usize> = (0..self.home.nodes.len()).filter(dry).collect();
        if open.iter().all(|&p| self.home.presence[p] <= 0.0) {
            open = (0..self.home.nodes.len()).collect();
        }
        let fallback = open[0];
        let mut roomy = None;
        for step in 0..open.len() as u64 {
            let weights: Vec<f64> = open.iter().map(|&p| self.home.presence[p]).collect();
            let Some(k) = weighted(&weights, self.random(REST, step)) else { break };
            let position = open.remove(k);
            if self.has_room(position, night.clone()) {
                roomy = roomy.or(Some(position));
                if self.near_all_duties(position)? {
                    return Ok((position, true));
                }
            }
        }
        Ok(roomy.map_or((fallback, false), |position| (position, true)))
    }

    fn near_all_duties(&mut self, rest: usize) -> Result<bool, Stopped> {
        for activity in [Activity::Drink, Activity::Feed] {
            let due = self.duties.iter().any(|duty| duty.activity == activity);
            if due && !self.near(self.node(rest).cell, activity)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Whether some node for this activity can be visited from the cell and back in a day.
    fn near(&mut self, base: usize, activity: Activity) -> Result<bool, Stopped> {
        let fitting = (0..self.home.nodes.len()).filter(|&p| self.activity(p) == activity);
        let cells: Vec<usize> = fitting.map(|p| self.node(p).cell).collect();
        for cell in cells {
            let there = self.home.reach.seconds(base, cell)? + self.scene.options.stay_s.min;
            if there <= self.species.active_s && there + self.home.reach.seconds(cell, base)? <= self.species.active_s {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn begin(&mut self, rest: usize, roomy: bool) {
        let begin = self.species.active_from_s;
        self.rest_cell = self.node(rest).cell;
        self.push(rest, self.rest_cell, begin..begin, (if roomy { Activity::Rest } else { Activity::Wait }, None));
        if roomy {
            let room = self.room(rest);
            self.taken.take(room, self.end..begin + DAY_S, self.herd.size);
        }
    }

    /// Where the herd could go from here and be back in time, whether there is room or not.
    fn stops(&mut self) -> Result<Vec<Stop>, Stopped> {
        if let Some((position, prey, _)) = self.chase {
            let stop = self.meeting(position, prey, 1.0)?;
            if let Some(stop) = stop
                && self.leaves_time(&stop, stop.arrive + self.scene.options.hunt_s)?
            {
                return Ok(vec![stop]);
            }
            self.chase = None;
        }
        let mut stops = Vec::new();
        let mut alone = true;
        let first = self.visits.len() == 1;
        for position in 0..self.home.nodes.len() {
            let share = self.home.presence[position];
            if share <= 0.0 {
                continue;
            }
            let just_hunted = self.here().prey;
            alone &= self.home.prey[position].iter().all(|prey| Some(*prey) == just_hunted);
            let met = self.meetings(position, share, &self.quarry[position].clone())?;
            let is_part = self.quarry[position].len() < self.home.prey[position].len();
            if met.is_empty() && is_part {
                stops.extend(self.meetings(position, share, &self.home.prey[position].clone())?);
            }
            stops.extend(met);
            let elsewhere = self.home.nodes[position] != self.here().node && !self.just_passed(position);
            if self.activity(position) != Activity::Hunt && (elsewhere || first) {
                let cell = self.node(position).cell;
                let aside = self.activity(position) == Activity::Pass || self.is_idle(position);
                alone &= !elsewhere || aside || !self.home.reach.seconds(self.here().cell, cell)?.is_finite();
                stops.extend(self.stop(position, cell, share)?);
            }
        }
        if alone && !matches!(self.activity_here(), Activity::Hunt | Activity::Pass) {
            let position = self.position_here();
            stops.extend(self.stop(position, self.here().cell, 1.0)?);
        }
        Ok(stops)
    }

    /// Whether a way-point was passed since the last stay: nobody walks to and fro between two.
    fn just_passed(&self, position: usize) -> bool {
        let passes = self.visits.iter().rev().take_while(|visit| visit.activity == Activity::Pass);
        passes.into_iter().any(|visit| visit.node == self.home.nodes[position])
    }

    /// The stops where the herds of a prey are, which share the pull of their node by size; the one
    /// that was just hunted is let go.
    fn meetings(&mut self, position: usize, share: f64, prey: &[usize]) -> Result<Vec<Stop>, Stopped> {
        let just_hunted = self.here().prey;
        let size = |prey: usize| f64::from(self.scene.herds[prey].size);
        let all: f64 = prey.iter().map(|&prey| size(prey)).sum();
        let parts: Vec<(usize, f64)> = prey.iter().map(|&prey| (prey, share * size(prey) / all)).collect();
        let mut stops = Vec::new();
        for (prey, part) in parts.into_iter().filter(|(prey, _)| Some(*prey) != just_hunted) {
            stops.extend(self.meeting(position, prey, part)?);
        }
        Ok(stops)
    }

    /// A stop at a node that stays where it is.
    fn stop(&mut self, position: usize, cell: usize, share: f64) -> Result<Option<Stop>, Stopped> {
        let now = self.here().leave_s;
        let seconds = self.home.reach.seconds(self.here().cell, cell)?;
        if !seconds.is_finite() {
            return Ok(None);
        }
        let until = self.deadline(cell)?;
        let weight = if self.visits.len() == 1 { share } else { pull(share, seconds) };
        let stop = Stop { position, cell, arrive: now + seconds, until, prey: None, weight };
        Ok((stop.arrive + self.shortest(position) <= until).then_some(stop))
    }

    /// When a cell must be left at the latest: in time for the place that is booked, else for the
    /// night.
    fn deadline(&mut self, cell: usize) -> Result<f64, Stopped> {
        let (next, due) = self.booked.map_or((self.rest_cell, self.end), |stop| (stop.cell, stop.arrive));
        Ok(due - self.home.reach.seconds(cell, next)?)
    }

    /// Keeps a place for what is due, when none of `stops` has room for it: the first in time that
    /// there is at any of its nodes, for the shortest stay (ours: Algorithm 3 looks for room only
    /// when a herd comes by, and who comes late finds none all day). Says whether it did.
    fn book(&mut self, stops: &[Stop], step: u64) -> Result<bool, Stopped> {
        if self.booked.is_some() {
            return Ok(false);
        }
        let now = self.here().leave_s;
        let open: Vec<Activity> =
            stops.iter().filter(|s| self.leave(s, step).is_some()).map(|s| self.activity(s.position)).collect();
        let lacks = |duty: &Duty| duty.due <= now && duty.activity != Activity::Hunt && !open.contains(&duty.activity);
        let Some(which) = self.duties.iter().position(lacks) else { return Ok(false) };
        let mut first: Option<Stop> = None;
        for position in 0..self.home.nodes.len() {
            if self.activity(position) == self.duties[which].activity && self.home.presence[position] > 0.0 {
                let gap = self.gap(position)?;
                first = [first, gap].into_iter().flatten().min_by(|a, b| a.arrive.total_cmp(&b.arrive));
            }
        }
        let Some(stop) = first else { return Ok(false) };
        let room = self.room(stop.position);
        self.taken.take(room, stop.arrive..stop.until, self.herd.size);
        self.duties.remove(which);
        self.chase = None;
        self.booked = Some(stop);
        Ok(true)
    }

    /// The first time that there is room for the shortest stay at a node, going there from here.
    fn gap(&mut self, position: usize) -> Result<Option<Stop>, Stopped> {
        let (cell, shortest) = (self.node(position).cell, self.shortest(position));
        let from = self.here().leave_s + self.home.reach.seconds(self.here().cell, cell)?;
        let to = self.end - self.home.reach.seconds(cell, self.rest_cell)?;
        let room = self.room(position);
        let others = self.scene.rooms.capacity[room].checked_sub(self.herd.size);
        let Some(others) = others.filter(|_| from.is_finite() && to.is_finite() && from < to) else { return Ok(None) };
        let arrive = self.taken.first_gap(room, from..to, (shortest, others));
        Ok(arrive.map(|arrive| Stop { position, cell, arrive, until: arrive + shortest, prey: None, weight: 1.0 }))
    }

    /// Waits until it is time for the place that is booked, and goes there.
    fn keep_booking(&mut self) -> Result<(), Stopped> {
        let Some(stop) = self.booked.take() else { return Ok(()) };
        let Visit { cell, leave_s: now, .. } = *self.here();
        let leave = stop.arrive - self.home.reach.seconds(cell, stop.cell)?;
        if leave > now {
            self.crowded_s += leave - now;
            self.push(self.position_here(), cell, now..leave, (Activity::Wait, None));
        }
        let activity = self.activity(stop.position);
        self.push(stop.position, stop.cell, stop.arrive..stop.until, (activity, None));
        Ok(())
    }

    /// The shortest stay at a node, seconds.
    fn shortest(&self, position: usize) -> f64 {
        let Options { stay_s, pass_s, .. } = self.scene.options;
        if self.activity(position) == Activity::Pass { *pass_s } else { stay_s.min }
    }

    /// A stop where a prey herd is.
    fn meeting(&mut self, position: usize, prey: usize, share: f64) -> Result<Option<Stop>, Stopped> {
        let Visit { cell: here, leave_s: now, .. } = *self.here();
        let shortest = self.scene.options.hunt_s;
        let day = &self.scene.days[prey];
        let reach = &mut self.home.reach;
        let Some(met) = meetings(day, now, (shortest, PATIENCE_S), |cell| reach.seconds(here, cell))? else {
            return Ok(None);
        };
        let until = met.until.min(self.deadline(met.cell)?);
        let weight = if self.visits.len() == 1 { share } else { pull(share, met.from - now) };
        let stop = Stop { position, cell: met.cell, arrive: met.from, until, prey: Some(prey), weight };
        Ok((met.from + shortest <= until).then_some(stop))
    }

    /// Whether a node is for drinking and the herd has drunk as often as it should: it leaves the
    /// banks to others while there is anything else to do (ours; so drinking takes the share of
    /// the time that equation 1 gives it).
    fn is_idle(&self, position: usize) -> bool {
        let thirsty = self.duties.iter().any(|duty| duty.activity == Activity::Drink);
        self.activity(position) == Activity::Drink && !thirsty
    }

    /// The next stop, drawn by weight among those with room: of what is due, else of all but idle
    /// drinks, else of these; first of those that leave time for what is still mandatory, so that
    /// nobody walks past the nearest water and has no time to drink again.
    fn drawn(&mut self, stops: &[Stop], step: u64) -> Result<Option<Stop>, Stopped> {
        let mut open: Vec<(Stop, bool)> = Vec::new();
        for stop in stops {
            if let Some(leave) = self.leave(stop, step) {
                open.push((*stop, self.leaves_time(stop, leave)?));
            }
        }
        let now = self.here().leave_s;
        let due = self.duties.iter().filter(|duty| duty.due <= now).map(|duty| duty.activity);
        let mut due: Vec<Option<Activity>> = due.map(Some).collect();
        due.dedup();
        // Not all herds to the same at once: who eats first leaves room for who drinks first. Prey
        // moves on, water stays.
        if due.first() != Some(&Some(Activity::Hunt)) {
            let first = (self.random(DUTY, step) * due.len() as f64) as usize;
            due.rotate_left(first);
        }
        let kinds: Vec<Option<Activity>> = due.into_iter().chain([None]).collect();
        let random = self.random(NEXT, step);
        let draw = |kind: Option<Activity>, timely: bool, idle: bool| {
            let fits = |(stop, in_time): &&(Stop, bool)| {
                let wanted = kind.is_none_or(|activity| self.activity(stop.position) == activity);
                *in_time == timely && wanted && self.is_idle(stop.position) == idle
            };
            let fitting: Vec<Stop> = open.iter().filter(fits).map(|(stop, _)| *stop).collect();
            let weights: Vec<f64> = fitting.iter().map(|stop| stop.weight).collect();
            weighted(&weights, random).map(|k| fitting[k])
        };
        let by_kind = |timely: bool| kinds.iter().map(move |kind| (*kind, timely, false));
        let order = by_kind(true).chain(by_kind(false)).chain([(None, true, true), (None, false, true)]);
        Ok(order.into_iter().find_map(|(kind, timely, idle)| draw(kind, timely, idle)))
    }

    /// Whether the other mandatory resources can still be visited after leaving a stop, each at the
    /// node nearest to the one before, and the herd be back in time. Prey moves and is not looked
    /// for here.
    fn leaves_time(&mut self, stop: &Stop, leave: f64) -> Result<bool, Stopped> {
        let done = self.activity(stop.position);
        let mut left: Vec<Activity> = self.duties.iter().map(|duty| duty.activity).collect();
        if let Some(i) = left.iter().position(|activity| *activity == done) {
            left.remove(i);
        }
        let shortest = self.scene.options.stay_s.min;
        let (mut here, mut now) = (stop.cell, leave);
        for activity in left.into_iter().filter(|activity| *activity != Activity::Hunt) {
            if let Some((cell, seconds)) = self.home.nearest(here, activity, self.scene.habitat.rag)? {
                (here, now) = (cell, now + seconds + shortest);
            }
        }
        Ok(now <= self.deadline(here)?)
    }

    /// When the herd would leave the stop again; `None` when there is no room for it until then.
    fn leave(&self, stop: &Stop, step: u64) -> Option<f64> {
        let wanted = match self.chase {
            Some((_, _, until)) => (until - stop.arrive).max(self.scene.options.hunt_s),
            None => self.stay(stop.position, step),
        };
        let leave = (stop.arrive + wanted).min(stop.until);
        self.has_room(stop.position, stop.arrive..leave).then_some(leave)
    }

    /// t_s(v): between the shortest and the longest stay by how much more the herd finds there
    /// than it needs a day (ours: the text says "according to the species' needs and the amount of
    /// resource"); the shortest by water, which never runs out. Way-points are passed.
    fn stay(&self, position: usize, step: u64) -> f64 {
        if self.activity(position) == Activity::Pass {
            return self.scene.options.pass_s;
        }
        let range = self.scene.options.stay_s;
        let found = self.node(position).quantity_kg;
        let need = self.species.food_kg_per_year * f64::from(self.herd.size);
        let share = if found.is_finite() && found + need > 0.0 { found / (found + need) } else { 0.0 };
        let spread = 1.0 + SPREAD * (2.0 * self.random(STAY, step) - 1.0);
        ((range.min + share * (range.max - range.min)) * spread).clamp(range.min, range.max)
    }

    fn visit(&mut self, stop: Stop, step: u64) -> Result<(), Stopped> {
        let leave = self.leave(&stop, step).unwrap_or(stop.until);
        let activity = self.activity(stop.position);
        if activity != Activity::Pass {
            let room = self.room(stop.position);
            self.taken.take(room, stop.arrive..leave, self.herd.size);
        }
        if let Some(done) = self.duties.iter().position(|duty| duty.activity == activity) {
            self.duties.remove(done);
        }
        let budget = match self.chase {
            Some((_, _, until)) => until,
            None => stop.arrive + self.stay(stop.position, step),
        };
        let more = budget - leave >= self.scene.options.hunt_s;
        self.chase = stop.prey.filter(|_| more).map(|prey| (stop.position, prey, budget));
        self.push(stop.position, stop.cell, stop.arrive..leave, (activity, stop.prey));
        Ok(())
    }

    /// Whether it makes sense to wait: something may be free, or prey come by, later.
    fn can_wait(&mut self, stops: &[Stop]) -> Result<bool, Stopped> {
        let hunts = self.home.prey.iter().any(|prey| !prey.is_empty());
        let until = self.here().leave_s + self.scene.options.wait_s + self.scene.options.hunt_s;
        let deadline = self.deadline(self.here().cell)?;
        Ok((hunts || !stops.is_empty()) && until <= deadline)
    }

    fn wait(&mut self, crowded: bool) {
        let wait = self.scene.options.wait_s;
        let (cell, now) = (self.here().cell, self.here().leave_s);
        *(if crowded { &mut self.crowded_s } else { &mut self.without_prey_s }) += wait;
        self.push(self.position_here(), cell, now..now + wait, (Activity::Wait, None));
        self.chase = None;
    }

    /// Back to the resting place, beside it until the night where it is still full.
    fn go_to_rest(&mut self, rest: usize, roomy: bool) -> Result<(), Stopped> {
        let Visit { cell, leave_s, .. } = *self.here();
        let arrive = leave_s + self.home.reach.seconds(cell, self.rest_cell)?;
        let next = self.species.active_from_s + DAY_S;
        if !roomy {
            self.push(rest, self.rest_cell, arrive..next, (Activity::Wait, None));
        } else if self.has_room(rest, arrive..self.end) {
            let room = self.room(rest);
            self.taken.take(room, arrive..self.end, self.herd.size);
            self.push(rest, self.rest_cell, arrive..next, (Activity::Rest, None));
        } else {
            self.push(rest, self.rest_cell, arrive..self.end, (Activity::Wait, None));
            self.push(rest, self.rest_cell, self.end..next, (Activity::Rest, None));
        }
        Ok(())
    }

    fn reasons(&mut self, roomy: bool) -> Result<Vec<Reason>, Stopped> {
        let missed: Vec<Activity> = self.duties.iter().map(|duty| duty.activity).collect();
        let mut reasons = Vec::new();
        for activity in missed {
            reasons.push(Reason::Missed(activity, self.cause(activity)?));
        }
        let waited = self.crowded_s >= self.scene.options.wait_s;
        reasons.extend(waited.then_some(Reason::Crowded(self.crowded_s)));
        reasons.extend((self.without_prey_s > 0.0).then_some(Reason::PreyOutOfReach(self.without_prey_s)));
        reasons.extend((!roomy).then_some(Reason::NoRoomToRest));
        Ok(reasons)
    }

    /// Why nothing came of an activity: the least of what stood in the way at its nodes.
    fn cause(&mut self, activity: Activity) -> Result<Cause, Stopped> {
        if activity == Activity::Hunt {
            return Ok(Cause::NoPrey);
        }
        let mut cause = Cause::NoWay;
        for position in 0..self.home.nodes.len() {
            if self.activity(position) == activity && self.home.presence[position] > 0.0 {
                cause = cause.max(self.cause_at(position)?);
            }
        }
        Ok(cause)
    }

    /// What stands in the way of going from the resting place to a node and back.
    fn cause_at(&mut self, position: usize) -> Result<Cause, Stopped> {
        let (cell, shortest) = (self.node(position).cell, self.shortest(position));
        let there = self.home.reach.seconds(self.rest_cell, cell)?;
        let back = self.home.reach.seconds(cell, self.rest_cell)?;
        let (from, to) = (self.species.active_from_s + there, self.end - back);
        let room = self.room(position);
        let others = self.scene.rooms.capacity[room].checked_sub(self.herd.size);
        Ok(match others {
            _ if !(there + back).is_finite() => Cause::NoWay,
            _ if from + shortest > to => Cause::TooFar,
            None => Cause::TooSmall,
            Some(others) if self.taken.first_gap(room, from..to, (shortest, others)).is_none() => Cause::NoRoom,
            Some(_) => Cause::NoTime,
        })
    }

    /// Adds a stay, or prolongs the last one when nothing else changes.
    fn push(&mut self, position: usize, cell: usize, when: Range<f64>, (activity, prey): (Activity, Option<usize>)) {
        let node = self.home.nodes[position];
        let visit = Visit { node, cell, arrive_s: when.start, leave_s: when.end, activity, prey };
        let begun = self.visits.len() > 1;
        match self.visits.last_mut().filter(|last| begun && last.goes_on_as(&visit)) {
            Some(last) => last.leave_s = visit.leave_s,
            None => self.visits.push(visit),
        }
    }

    fn has_room(&self, position: usize, when: Range<f64>) -> bool {
        let room = self.room(position);
        let fits = |others: u32| others.saturating_add(self.herd.size) <= self.scene.rooms.capacity[room];
        when.end <= when.start || fits(self.taken.most(room)) || fits(self.taken.peak(room, when))
    }

    fn room(&self, position: usize) -> usize {
        self.scene.rooms.of_node[self.home.nodes[position]]
    }

    fn node(&self, position: usize) -> &'a Node {
        &self.scene.habitat.rag.nodes[self.home.nodes[position]]
    }

    fn activity(&self, position: usize) -> Activity {
        self.home.activities[position]
    }

    fn activity_here(&self) -> Activity {
        self.activity(self.position_here())
    }

    /// The last stay; there is one from [`Day::begin`] on.
    fn here(&self) -> &Visit {
        &self.visits[self.visits.len() - 1]
    }

    fn position_here(&self) -> usize {
        let node = self.here().node;
        self.home.nodes.iter().position(|n| *n == node).unwrap_or(0)
    }

    /// A number in [0, 1) by seed, herd and step.
    fn random(&self, purpose: Purpose, step: u64) -> f64 {
        unit(hash2(self.scene.options.seed, purpose, self.herd.key(), step))
    }
}

/// The index that the number `random` in [0, 1) falls on when indices share it by weight.
fn weighted(weights: &[f64], random: f64) -> Option<usize> {
    let total: f64 = weights.iter().sum();
    if !(total > 0.0 && total.is_finite()) {
        return None;
    }
    let mut left = random * total;
    let found = weights.iter().position(|weight| {
        left -= weight;
        left < 0.0
    });
    found.or_else(|| weights.iter().rposition(|weight| *weight > 0.0))
}
