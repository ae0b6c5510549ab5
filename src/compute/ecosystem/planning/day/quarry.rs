//! The herds that a hunter keeps an eye on, and where it would meet them.

use crate::compute::ecosystem::planning::Visit;
use crate::compute::ecosystem::planning::day::Day;
use crate::compute::ecosystem::planning::day::Scene;
use crate::compute::ecosystem::planning::day::Stop;
use crate::compute::ecosystem::planning::herds::Herd;
use crate::compute::ecosystem::planning::prey::PATIENCE_S;
use crate::compute::ecosystem::planning::prey::meetings;
use crate::compute::ecosystem::presence::pull;
use crate::compute::random::Purpose;
use crate::compute::random::hash2;
use crate::compute::run::Stopped;

const QUARRY: Purpose = Purpose::new("planning.quarry");

/// Herds of one prey that a hunter keeps an eye on, at most (ours: bounds the work where thousands
/// of herds live in its territory).
const MOST_QUARRY: usize = 32;

impl Day<'_, '_> {
    /// The stops where the herds of a prey are, which share the pull of their node by size; the one
    /// that was just hunted is let go.
    pub(super) fn meetings(&mut self, position: usize, share: f64, prey: &[usize]) -> Result<Vec<Stop>, Stopped> {
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

    /// A stop where a prey herd is.
    pub(super) fn meeting(&mut self, position: usize, prey: usize, share: f64) -> Result<Option<Stop>, Stopped> {
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
}

/// The herds that a hunter may follow, of those that are prey at a node: drawn by hash.
pub(super) fn quarry(scene: &Scene, hunter: &Herd, prey: &[usize]) -> Vec<usize> {
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
