//! What users change in a planning: visits added, dropped and pinned (L 6.2: "the user clicks on
//! resources to edit trajectories").

use super::Activity;
use super::DAY_S;
use super::Options;
use super::Planning;
use super::Plannings;
use super::Visit;
use super::day::Home;
use super::day::Scene;
use super::occupancy::Occupancy;
use super::occupancy::Rooms;
use super::prey::PATIENCE_S;
use super::prey::meetings;
use crate::compute::ecosystem::habitat::Habitat;
use crate::compute::run::Run;
use crate::compute::run::Stopped;

/// Times that differ by less are the same, seconds.
const SAME_S: f64 = 1e-6;

/// A change. `order` counts the visits of the planning as it was, from 0; the first and the last
/// are the rest that joins the days and cannot be changed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Edit {
    /// Visits a node of the herd's territory before the visit `order`.
    Add {
        /// The visit it comes before.
        order: usize,
        /// Index in [`crate::compute::ecosystem::rag::Rag::nodes`].
        node: usize,
        /// How long, seconds, positive.
        stay_s: f64,
    },
    /// Leaves a visit out.
    Drop {
        /// The visit.
        order: usize,
    },
    /// Holds a visit at these times; others make room for it.
    Pin {
        /// The visit.
        order: usize,
        /// Arrival, seconds, within the active day.
        arrive_s: f64,
        /// Departure, seconds, after the arrival.
        leave_s: f64,
    },
}

/// What could not be done as asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Conflict {
    /// There is no such visit, or it is a rest that joins the days, or its times make no sense.
    NoSuchVisit(usize),
    /// The node is not in the herd's territory, or cannot be reached from where the herd is.
    NotReached(usize),
    /// The pinned visit at this node begins later than asked by this many seconds.
    Late(usize, f64),
    /// There was no time for the visit at this node: it was left out.
    NoTime(usize),
    /// The prey is not met at this node: the visit was left out.
    PreyGone(usize),
    /// This many individuals too many are at this node at some moment of the visit, which stays.
    Crowded(usize, u32),
    /// A mandatory resource is no longer visited.
    Missed(Activity),
}

/// What came of an edit.
#[derive(Debug, Clone, PartialEq)]
pub struct Edited {
    /// The days that changed: that of the herd, and of the herds that hunt it; (herd, its day).
    pub days: Vec<(usize, Planning)>,
    /// (herd, conflict).
    pub conflicts: Vec<(usize, Conflict)>,
}

/// A visit that is wanted.
#[derive(Debug, Clone, Copy)]
struct Wish {
    visit: Visit,
    stay_s: f64,
    /// (arrival, departure).
    pinned: Option<(f64, f64)>,
}

/// Applies all `edits` to the day of `herd` at once and times it again: each arrival is the
/// departure before plus the travel time; visits that are not pinned are shortened, in the end left
/// out, for pinned ones and for the way back; a herd that would be early for a pinned visit stays
/// longer before it. Then the herds that hunt it follow it to where it is now. Room at nodes is
/// checked, not enforced: the user's word stands, and the conflict says how many are too many.
///
/// # Errors
/// [`Stopped`] when the run was asked to stop. Whatever else cannot be done is a [`Conflict`].
pub fn edit(
    habitat: &Habitat,
    (plannings, options): (&Plannings, &Options),
    (herd, edits): (usize, &[Edit]),
    run: &Run,
) -> Result<Edited, Stopped> {
    let options = options.within_limits();
    let rooms = Rooms::new(habitat.rag, habitat.grid.cell_m, options.m2_each);
    let mut days = plannings.days.clone();
    let mut edited = Edited { days: Vec::new(), conflicts: Vec::new() };
    if days.get(herd).is_none_or(|day| day.visits.len() < 2) {
        return Ok(edited);
    }
    let mut waiting = vec![herd];
    let mut next = 0;
    while let Some(&changed) = waiting.get(next) {
        next += 1;
        let scene = Scene { habitat, options: &options, rooms: &rooms, herds: &plannings.herds, days: &days };
        let mut retimer = Retimer::new(&scene, changed, run);
        let wishes = retimer.wishes(if changed == herd { edits } else { &[] });
        let day = retimer.timed(wishes)?;
        retimer.check(&day);
        edited.conflicts.extend(retimer.conflicts.into_iter().map(|conflict| (changed, conflict)));
        days[changed] = day.clone();
        edited.days.push((changed, day));
        let hunts = |h: &usize| days[*h].visits.iter().any(|visit| visit.prey == Some(changed));
        let hunters: Vec<usize> = (0..days.len()).filter(|h| hunts(h) && !waiting.contains(h)).collect();
        waiting.extend(hunters);
    }
    Ok(edited)
}

struct Retimer<'a> {
    scene: &'a Scene<'a>,
    herd: usize,
    home: Home<'a>,
    begin: f64,
    end: f64,
    rest: Visit,
    conflicts: Vec<Conflict>,
}

impl<'a> Retimer<'a> {
    fn new(scene: &'a Scene<'a>, herd: usize, run: &'a Run) -> Self {
        let species = &scene.habitat.animals[scene.herds[herd].species];
        let visits = &scene.days[herd].visits;
        let begin = species.active_from_s;
        let end = begin + species.active_s.clamp(0.0, DAY_S);
        let home = Home::new(scene, scene.herds[herd].territory, run);
        Self { scene, herd, home, begin, end, rest: visits[visits.len() - 1], conflicts: Vec::new() }
    }

    /// The visits between the rests, with the edits applied.
    fn wishes(&mut self, edits: &[Edit]) -> Vec<Wish> {
        let visits = &self.scene.days[self.herd].visits;
        let resting = |v: &Visit| v.cell == self.rest.cell && v.activity == Activity::Wait && v.leave_s >= self.end;
        let last = visits.len() - 1 - usize::from(visits.len() > 2 && resting(&visits[visits.len() - 2]));
        let mut wishes: Vec<Option<Wish>> = visits.iter().map(Wish::as_is).map(Some).collect();
        let mut added: Vec<(usize, Wish)> = Vec::new();
        for edit in edits {
            let order = edit.order();
            let exists = if matches!(edit, Edit::Add { .. }) { 1..=last } else { 1..=last - 1 };
            if !exists.contains(&order) || !edit.makes_sense(self.begin, self.end) {
                self.conflicts.push(Conflict::NoSuchVisit(order));
                continue;
            }
            match *edit {
                Edit::Drop { .. } => wishes[order] = None,
                Edit::Pin { arrive_s, leave_s, .. } => {
                    if let Some(wish) = &mut wishes[order] {
                        wish.pinned = Some((arrive_s, leave_s));
                    }
                }
                Edit::Add { node, stay_s, .. } => added.extend(self.new_wish(node, stay_s).map(|wish| (order, wish))),
            }
        }
        let before = |order: usize| added.iter().filter(move |a| a.0 == order).map(|a| a.1);
        (1..=last).flat_map(|order| before(order).chain(wishes[order].filter(|_| order < last))).collect()
    }

    fn new_wish(&mut self, node: usize, stay_s: f64) -> Option<Wish> {
        let rag = self.scene.habitat.rag;
        let here = rag.territories[self.scene.herds[self.herd].territory].nodes.binary_search(&node);
        if here.is_err() {
            self.conflicts.push(Conflict::NotReached(node));
            return None;
        }
        let prey = super::herds::prey_at(node, self.scene.herds, rag).first().copied();
        let activity = Activity::with(rag.nodes[node].resource);
        let visit = Visit { node, cell: rag.nodes[node].cell, arrive_s: 0.0, leave_s: 0.0, activity, prey };
        Some(Wish { visit, stay_s, pinned: None })
    }

    fn timed(&mut self, wishes: Vec<Wish>) -> Result<Planning, Stopped> {
        let start = Visit { arrive_s: self.begin, leave_s: self.begin, ..self.rest };
        let mut visits = vec![start];
        for (i, wish) in wishes.iter().enumerate() {
            let next_pin = wishes[i + 1..].iter().find(|later| later.pinned.is_some());
            self.place(wish, next_pin, &mut visits)?;
        }
        let here = visits[visits.len() - 1];
        let arrive_s = here.leave_s + self.home.reach.seconds(here.cell, self.rest.cell)?;
        visits.push(Visit { arrive_s, leave_s: self.begin + DAY_S, ..self.rest });
        Ok(Planning { visits })
    }

    /// Adds the visit of a wish, or says why not.
    fn place(&mut self, wish: &Wish, next_pin: Option<&Wish>, visits: &mut Vec<Visit>) -> Result<(), Stopped> {
        let here = visits[visits.len() - 1];
        let node = wish.visit.node;
        let Some((cell, arrive, met_until)) = self.arrival(wish, &here)? else {
            self.conflicts.push(match wish.visit.prey {
                Some(_) => Conflict::PreyGone(node),
                None => Conflict::NotReached(node),
            });
            return Ok(());
        };
        let mut deadline = met_until.min(self.end - self.home.reach.seconds(cell, self.rest.cell)?);
        let mut arrive = arrive;
        let mut leave = arrive + wish.stay_s;
        if let Some((from, to)) = wish.pinned {
            if arrive > from + SAME_S {
                self.conflicts.push(Conflict::Late(node, arrive - from));
            }
            // Who is early stays longer where it was; a hunter only as long as its prey is there.
            let early = (from - arrive).max(0.0);
            if visits.len() == 1 || here.prey.is_none() {
                let before = visits.len() - 1;
                visits[before].leave_s += early;
            }
            (arrive, leave) = (arrive + early, to.max(arrive + early));
        } else if let Some((pin, (from, _))) = next_pin.and_then(|pin| Some((pin, pin.pinned?))) {
            deadline = deadline.min(from - self.home.reach.seconds(cell, pin.visit.cell)?);
        }
        leave = leave.min(deadline);
        let shortest = wish.stay_s.min(self.scene.options.hunt_s);
        if leave - arrive < shortest - SAME_S {
            self.conflicts.push(Conflict::NoTime(node));
            return Ok(());
        }
        visits.push(Visit { cell, arrive_s: arrive, leave_s: leave, ..wish.visit });
        Ok(())
    }

    /// Where and when the herd comes to the place of a wish, and when it must leave.
    fn arrival(&mut self, wish: &Wish, here: &Visit) -> Result<Option<(usize, f64, f64)>, Stopped> {
        let reach = &mut self.home.reach;
        let Some(prey) = wish.visit.prey else {
            let arrive = here.leave_s + reach.seconds(here.cell, wish.visit.cell)?;
            return Ok(arrive.is_finite().then_some((wish.visit.cell, arrive, f64::INFINITY)));
        };
        // For a pinned time the prey is looked for where it is then.
        let wait = wish.pinned.map_or(0.0, |(from, _)| (from - here.leave_s).max(0.0));
        let (hunt_s, day) = (self.scene.options.hunt_s, &self.scene.days[prey]);
        let met = meetings(day, here.leave_s, (hunt_s, PATIENCE_S), |cell| {
            reach.seconds(here.cell, cell).map(|seconds| seconds.max(wait))
        })?;
        Ok(met.map(|met| (met.cell, met.from, met.until)))
    }

    /// Reports what is too crowded and what is no longer visited.
    fn check(&mut self, day: &Planning) {
        let others = self.others();
        let herd = &self.scene.herds[self.herd];
        for visit in day.visits.iter().filter(|visit| visit.activity != Activity::Wait) {
            let room = self.scene.rooms.of_node[visit.node];
            let there = others.peak(room, visit.arrive_s..visit.leave_s).saturating_add(herd.size);
            let over = there.saturating_sub(self.scene.rooms.capacity[room]);
            if over > 0 && visit.leave_s > visit.arrive_s {
                self.conflicts.push(Conflict::Crowded(visit.node, over));
            }
        }
        let does = |day: &Planning, activity| day.visits.iter().any(|visit| visit.activity == activity);
        let missed = [Activity::Drink, Activity::Feed, Activity::Hunt]
            .into_iter()
            .filter(|&activity| does(&self.scene.days[self.herd], activity) && !does(day, activity));
        self.conflicts.extend(missed.map(Conflict::Missed));
    }

    /// The room that all other herds take.
    fn others(&self) -> Occupancy {
        let mut taken = Occupancy::default();
        for (herd, day) in self.scene.days.iter().enumerate().filter(|(herd, _)| *herd != self.herd) {
            for visit in day.visits.iter().filter(|visit| visit.activity != Activity::Wait) {
                let room = self.scene.rooms.of_node[visit.node];
                taken.take(room, visit.arrive_s..visit.leave_s, self.scene.herds[herd].size);
            }
        }
        taken
    }
}

impl Wish {
    fn as_is(visit: &Visit) -> Self {
        Self { visit: *visit, stay_s: visit.leave_s - visit.arrive_s, pinned: None }
    }
}

impl Edit {
    fn order(&self) -> usize {
        match *self {
            Self::Add { order, .. } | Self::Drop { order } | Self::Pin { order, .. } => order,
        }
    }

    /// Whether its times are finite, in order, and within the active day.
    fn makes_sense(&self, begin: f64, end: f64) -> bool {
        match *self {
            Self::Add { stay_s, .. } => stay_s > 0.0 && stay_s.is_finite(),
            Self::Drop { .. } => true,
            Self::Pin { arrive_s, leave_s, .. } => begin <= arrive_s && arrive_s < leave_s && leave_s <= end,
        }
    }
}
