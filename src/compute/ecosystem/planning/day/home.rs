//! What the herds of one territory share.

use crate::compute::ecosystem::habitat::Habitat;
use crate::compute::ecosystem::planning::Activity;
use crate::compute::ecosystem::planning::day::Scene;
use crate::compute::ecosystem::planning::herds::prey_at;
use crate::compute::ecosystem::planning::reach::Reach;
use crate::compute::ecosystem::presence::presence;
use crate::compute::ecosystem::rag::Rag;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use std::collections::BTreeMap;

/// What the herds of one territory share.
pub(crate) struct Home<'a> {
    pub(super) nodes: &'a [usize],
    /// P_s(v) of each.
    pub(super) presence: Vec<f64>,
    /// The herds hunted at each.
    pub(super) prey: Vec<Vec<usize>>,
    pub(crate) reach: Reach<'a>,
    /// What each node is for.
    pub(super) activities: Vec<Activity>,
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
    pub(super) fn nearest(
        &mut self,
        cell: usize,
        activity: Activity,
        rag: &Rag,
    ) -> Result<Option<(usize, f64)>, Stopped> {
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
