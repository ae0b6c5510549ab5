//! What a herd does where no place is free at once.

use crate::compute::ecosystem::planning::Activity;
use crate::compute::ecosystem::planning::Options;
use crate::compute::ecosystem::planning::Visit;
use crate::compute::ecosystem::planning::day::Day;
use crate::compute::ecosystem::planning::day::Duty;
use crate::compute::ecosystem::planning::day::Stop;
use crate::compute::run::Stopped;

impl Day<'_, '_> {
    /// Keeps a place for what is due, when none of `stops` has room for it: the first in time that
    /// there is at any of its nodes, for the shortest stay (ours: Algorithm 3 looks for room only
    /// when a herd comes by, and who comes late finds none all day). Says whether it did.
    pub(super) fn book(&mut self, stops: &[Stop], step: u64) -> Result<bool, Stopped> {
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
    pub(super) fn keep_booking(&mut self) -> Result<(), Stopped> {
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
    pub(super) fn shortest(&self, position: usize) -> f64 {
        let Options { stay_s, pass_s, .. } = self.scene.options;
        if self.activity(position) == Activity::Pass { *pass_s } else { stay_s.min }
    }

    /// Whether it makes sense to wait: something may be free, or prey come by, later.
    pub(super) fn can_wait(&mut self, stops: &[Stop]) -> Result<bool, Stopped> {
        let hunts = self.home.prey.iter().any(|prey| !prey.is_empty());
        let until = self.here().leave_s + self.scene.options.wait_s + self.scene.options.hunt_s;
        let deadline = self.deadline(self.here().cell)?;
        Ok((hunts || !stops.is_empty()) && until <= deadline)
    }

    pub(super) fn wait(&mut self, crowded: bool) {
        let wait = self.scene.options.wait_s;
        let (cell, now) = (self.here().cell, self.here().leave_s);
        *(if crowded { &mut self.crowded_s } else { &mut self.without_prey_s }) += wait;
        self.push(self.position_here(), cell, now..now + wait, (Activity::Wait, None));
        self.chase = None;
    }
}
