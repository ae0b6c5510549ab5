//! The day of one herd: Algorithm 3 of L, with the corrections named in the module above.

mod home;
mod next;
mod quarry;
mod rest;
mod waiting;
mod why;

use crate::compute::ecosystem::habitat::Habitat;
use crate::compute::ecosystem::planning::Activity;
use crate::compute::ecosystem::planning::DAY_S;
use crate::compute::ecosystem::planning::Options;
use crate::compute::ecosystem::planning::Planned;
use crate::compute::ecosystem::planning::Planning;
use crate::compute::ecosystem::planning::Reason;
use crate::compute::ecosystem::planning::Visit;
use crate::compute::ecosystem::planning::herds::Herd;
use crate::compute::ecosystem::planning::occupancy::Occupancy;
use crate::compute::ecosystem::planning::occupancy::Rooms;
use crate::compute::ecosystem::rag::Node;
use crate::compute::ecosystem::species::AnimalSpecies;
use crate::compute::random::Purpose;
use crate::compute::random::hash2;
use crate::compute::random::unit;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
pub(crate) use home::Home;
use quarry::quarry;
use std::collections::BTreeMap;
use std::ops::Range;

/// Stays in a day, at most; with stays of ten minutes a day has no more.
const MOST_VISITS: u64 = 400;

/// What all herds share.
pub(crate) struct Scene<'a> {
    pub(crate) habitat: &'a Habitat<'a>,
    pub(crate) options: &'a Options,
    pub(crate) rooms: &'a Rooms,
    pub(crate) herds: &'a [Herd],
    /// The days of the levels below.
    pub(crate) days: &'a [Planning],
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
