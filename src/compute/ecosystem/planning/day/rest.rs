//! Where a herd rests, and the way back there.

use crate::compute::ecosystem::planning::Activity;
use crate::compute::ecosystem::planning::DAY_S;
use crate::compute::ecosystem::planning::Visit;
use crate::compute::ecosystem::planning::day::Day;
use crate::compute::ecosystem::planning::day::next::weighted;
use crate::compute::random::Purpose;
use crate::compute::run::Stopped;

const REST: Purpose = Purpose::new("planning.rest");

impl Day<'_, '_> {
    /// A node to rest at, drawn from P_s(v) among those with room for the night from which the
    /// mandatory resources can be reached and back; and whether it has room. Nodes with food
    /// first, so that nobody sleeps where others drink or pass.
    pub(super) fn resting_place(&mut self) -> Result<(usize, bool), Stopped> {
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

    pub(super) fn begin(&mut self, rest: usize, roomy: bool) {
        let begin = self.species.active_from_s;
        self.rest_cell = self.node(rest).cell;
        self.push(rest, self.rest_cell, begin..begin, (if roomy { Activity::Rest } else { Activity::Wait }, None));
        if roomy {
            let room = self.room(rest);
            self.taken.take(room, self.end..begin + DAY_S, self.herd.size);
        }
    }

    /// Back to the resting place, beside it until the night where it is still full.
    pub(super) fn go_to_rest(&mut self, rest: usize, roomy: bool) -> Result<(), Stopped> {
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
}
