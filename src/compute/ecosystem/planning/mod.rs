//! Stage 8: what each herd does all day (L 6.2 and Algorithm 3, T Algorithm 5).
//!
//! 1. `herds` – who they are, and which can get in each other's way
//! 2. `occupancy` – room at the nodes, at every moment of the day
//! 3. `reach` – travel times between the places of a territory
//! 4. `prey` – where prey can be met
//! 5. `day` – the day of one herd
//! 6. `motion` – its path in time
//! 7. `edit` – what users change
//!
//! The listing of Algorithm 3 adds the way after the stay and never frees room; here arrival is
//! departure + travel, and room is taken during the stay only. Levels are planned from the bottom
//! up, herds of a level in the order of their ids; those that share no room in parallel.

mod day;
mod edit;
mod herds;
mod motion;
mod occupancy;
mod prey;
mod reach;

pub use edit::Conflict;
pub use edit::Edit;
pub use edit::Edited;
pub use edit::edit;
pub use herds::Herd;
pub use herds::herds;
pub use motion::Pace;
pub use motion::Track;
pub use motion::tracks;
pub use occupancy::capacity;

use super::habitat::Habitat;
use super::presence::Drinking;
use super::rag::Resource;
use super::species::Food;
use super::species::Interval;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use day::Scene;
use occupancy::Occupancy;
use occupancy::Rooms;
use rayon::prelude::*;

/// Seconds in a day.
pub const DAY_S: f64 = 86_400.0;

/// How days are planned. Values outside their limits are moved to the nearest limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Drinks a day (mandatory where water can be reached), and the share of time they take.
    pub drinking: Drinking,
    /// Shortest and longest stay at a node, seconds, 600..=86 400. Default: 90–150 minutes, the
    /// authors'. Where in between follows from need and amount: long where a herd finds much more
    /// than it needs.
    pub stay_s: Interval,
    /// Shortest stay by prey that may move on, seconds. Default: 600 (ours).
    pub hunt_s: f64,
    /// How long a herd is at a way-point that it passes, seconds, 0..=86 400. Default: 600 (ours).
    pub pass_s: f64,
    /// How long a herd waits for room before it looks again, seconds, at least 300. Default:
    /// 1 800 (ours).
    pub wait_s: f64,
    /// Ground an individual takes at a node, m², at least 0.01; see [`capacity`]. Default: 25
    /// (ours: some body lengths apart).
    pub m2_each: f64,
    /// The seed.
    pub seed: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            drinking: Drinking::default(),
            stay_s: Interval::new(5400.0, 9000.0),
            hunt_s: 600.0,
            pass_s: 600.0,
            wait_s: 1800.0,
            m2_each: 25.0,
            seed: 0,
        }
    }
}

impl Options {
    fn within_limits(&self) -> Self {
        let min = self.stay_s.min.clamp(600.0, DAY_S);
        Self {
            stay_s: Interval::new(min, self.stay_s.max.clamp(min, DAY_S)),
            hunt_s: self.hunt_s.clamp(60.0, min),
            pass_s: self.pass_s.clamp(0.0, DAY_S),
            wait_s: self.wait_s.clamp(300.0, DAY_S),
            m2_each: self.m2_each.max(0.01),
            ..*self
        }
    }
}

/// What a herd does at a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Activity {
    /// Drinks.
    Drink,
    /// Eats plants.
    Feed,
    /// Is where its prey is.
    Hunt,
    /// Rests.
    Rest,
    /// Waits beside the node, where there is no room for it or nothing to do; takes no room.
    Wait,
    /// Passes a way-point; takes no room.
    Pass,
}

impl Activity {
    /// What is done with a resource.
    pub fn with(resource: Resource) -> Self {
        match resource {
            Resource::Water => Self::Drink,
            Resource::Food(Food::Plant(_)) => Self::Feed,
            Resource::Food(Food::Animal(_)) => Self::Hunt,
            Resource::WayPoint(_) => Self::Pass,
        }
    }
}

/// A stay: (v, t, t') of L 6.2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Visit {
    /// The node, index in [`super::rag::Rag::nodes`].
    pub node: usize,
    /// The cell the herd stays at: the node's, or where its prey stays.
    pub cell: usize,
    /// Arrival, seconds of the solar day on which the active day begins; may pass 86 400.
    pub arrive_s: f64,
    /// Departure, on the same clock.
    pub leave_s: f64,
    /// What is done there.
    pub activity: Activity,
    /// The herd that is hunted.
    pub prey: Option<usize>,
}

impl Visit {
    /// Whether `next` only prolongs this stay.
    fn goes_on_as(&self, next: &Self) -> bool {
        let what = |v: &Self| (v.node, v.cell, v.activity, v.prey);
        what(self) == what(next) && self.leave_s == next.arrive_s
    }
}

/// **Daily planning** of a herd: a day that comes again and again.
///
/// It begins with a rest of no length when the active day begins, and ends with the rest until
/// the next one, at the same node: so days join up. Between a departure and the next arrival the
/// herd travels; who arrives before its prey lies in wait.
#[derive(Debug, Clone, PartialEq)]
pub struct Planning {
    /// The stays, in the order of time.
    pub visits: Vec<Visit>,
}

/// Why a planning is not as it should be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reason {
    /// No node had room, so the herd waited, this many seconds in all, at least
    /// [`Options::wait_s`].
    Crowded(f64),
    /// No node has room for the herd to rest all night: it rests beside one.
    NoRoomToRest,
    /// A mandatory resource was not visited as often as it should be, and why.
    Missed(Activity, Cause),
    /// No prey could be met, so the herd waited, this many seconds in all.
    PreyOutOfReach(f64),
}

/// Why a mandatory resource was missed: of all its nodes in the territory, what stood in the way at
/// the one where least did. Later ones are the lesser hindrances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Cause {
    /// There is no way from the resting place to it and back.
    NoWay,
    /// The way there and back and the shortest stay take longer than the active day.
    TooFar,
    /// It does not hold the whole herd, even when nobody else is there.
    TooSmall,
    /// Others leave too little room at every time of the day at which the herd could be there.
    NoRoom,
    /// There was room at some time of the day, but not when the herd came by.
    NoTime,
    /// The prey is not met.
    NoPrey,
}

/// A herd and what went wrong with its day.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Warning {
    /// Index in [`Plannings::herds`].
    pub herd: usize,
    /// What went wrong.
    pub reason: Reason,
}

/// The days of all herds.
#[derive(Debug, Clone, PartialEq)]
pub struct Plannings {
    /// The herds; the index is the id.
    pub herds: Vec<Herd>,
    /// The day of each.
    pub days: Vec<Planning>,
    /// By herd.
    pub warnings: Vec<Warning>,
}

/// A herd's day and what went wrong with it.
type Planned = (usize, Planning, Vec<Reason>);

/// Plans the day of every herd. Reports as `planning.herds`.
///
/// # Errors
/// [`Stopped`] when the run was asked to stop.
pub fn plannings(habitat: &Habitat, options: &Options, run: &Run) -> Result<Plannings, Stopped> {
    let options = options.within_limits();
    let herds = herds(habitat.rag);
    let rooms = Rooms::new(habitat.rag, habitat.grid.cell_m, options.m2_each);
    let mut days = vec![Planning { visits: Vec::new() }; herds.len()];
    let mut occupancy = Occupancy::default();
    let mut warnings = Vec::new();
    let mut done = 0;
    for level in herds::levels(&herds, habitat.animals) {
        let of_level = |herd: &Herd| habitat.animals[herd.species].level == level;
        let groups = herds::independent(&herds, habitat.rag, &rooms, of_level);
        let scene = Scene { habitat, options: &options, rooms: &rooms, herds: &herds, days: &days };
        let plan = |(herds, rooms): &(Vec<usize>, Vec<usize>)| {
            let mut taken = occupancy.of_rooms(rooms);
            Ok((day::days(&scene, herds, &mut taken, run)?, taken))
        };
        let planned: Vec<(Vec<Planned>, Occupancy)> = groups.par_iter().map(plan).collect::<Result<_, Stopped>>()?;
        for (group, taken) in planned {
            occupancy.update(taken);
            for (herd, day, reasons) in group {
                days[herd] = day;
                warnings.extend(reasons.into_iter().map(|reason| Warning { herd, reason }));
                done += 1;
            }
        }
        run.progress("planning.herds", done, herds.len() as u64)?;
    }
    warnings.sort_by_key(|warning| warning.herd);
    Ok(Plannings { herds, days, warnings })
}
