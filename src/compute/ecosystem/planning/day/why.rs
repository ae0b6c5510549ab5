//! Why a day lacks what the herd needs.

use crate::compute::ecosystem::planning::Activity;
use crate::compute::ecosystem::planning::Cause;
use crate::compute::ecosystem::planning::Reason;
use crate::compute::ecosystem::planning::day::Day;
use crate::compute::run::Stopped;

impl Day<'_, '_> {
    pub(super) fn reasons(&mut self, roomy: bool) -> Result<Vec<Reason>, Stopped> {
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
}
