//! Where a herd could go next, how long it would stay, and the draw among these.

use crate::compute::ecosystem::planning::Activity;
use crate::compute::ecosystem::planning::day::Day;
use crate::compute::ecosystem::planning::day::Stop;
use crate::compute::ecosystem::presence::pull;
use crate::compute::random::Purpose;
use crate::compute::run::Stopped;

const NEXT: Purpose = Purpose::new("planning.next");
const DUTY: Purpose = Purpose::new("planning.duty");
const STAY: Purpose = Purpose::new("planning.stay");

/// How much stays of the same kind differ, as a share of their length (ours).
const SPREAD: f64 = 0.1;

impl Day<'_, '_> {
    /// Where the herd could go from here and be back in time, whether there is room or not.
    pub(super) fn stops(&mut self) -> Result<Vec<Stop>, Stopped> {
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
    pub(super) fn deadline(&mut self, cell: usize) -> Result<f64, Stopped> {
        let (next, due) = self.booked.map_or((self.rest_cell, self.end), |stop| (stop.cell, stop.arrive));
        Ok(due - self.home.reach.seconds(cell, next)?)
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
    pub(super) fn drawn(&mut self, stops: &[Stop], step: u64) -> Result<Option<Stop>, Stopped> {
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
    pub(super) fn leave(&self, stop: &Stop, step: u64) -> Option<f64> {
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
    pub(super) fn stay(&self, position: usize, step: u64) -> f64 {
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
}

/// The index that the number `random` in [0, 1) falls on when indices share it by weight.
pub(super) fn weighted(weights: &[f64], random: f64) -> Option<usize> {
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
