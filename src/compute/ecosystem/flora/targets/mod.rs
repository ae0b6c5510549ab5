//! Competition with target proportions (L Algorithm 1, T Algorithm 3).
//!
//! Of the units that could be added, the one that brings the shares of the covered area nearest
//! the target grows, in the best cell for its species that still has room, light and moisture.
//! Equally near units go by species order; equally fit cells by hash.
//!
//! What the texts leave open (readings of ours): a species that fits nowhere on the terrain is
//! left out of the target and the others' shares are taken relative to each other. When a
//! species finds no more room, the others go on while the distance stays within
//! [`Wish::tolerance`] or falls; with [`Wish::fill`] until nothing fits.
//!
//! Units are added in **batches** that are a small part ([`FloraOptions::batch`] times the
//! tolerance) of what is there, so that a batch moves no share by more than that; in small worlds
//! a batch is one unit.

mod balance;
mod queue;

use crate::compute::ecosystem::fitness::Fitness;
use crate::compute::ecosystem::flora::FloraError;
use crate::compute::ecosystem::flora::FloraOptions;
use crate::compute::ecosystem::flora::rule::FULL_COVER;
use crate::compute::ecosystem::flora::rule::Rule;
use crate::compute::ecosystem::flora::sites::Sites;
use crate::compute::ecosystem::flora::stand::Stand;
use crate::compute::ecosystem::slabs;
use crate::compute::ecosystem::slabs::Slab;
use crate::compute::ecosystem::species::PlantSpecies;
use crate::compute::ecosystem::species::Stratum;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use balance::Attempt;
use balance::Balance;
use queue::Queue;

/// Cells visited between two reports.
const REPORT: u64 = 1 << 14;

/// How far the target was reached.
#[derive(Debug, Clone, PartialEq)]
pub struct Reached {
    /// Share of the covered area asked for each species; they sum to 1.
    pub asked: Vec<f64>,
    /// Share of the covered area that each species has; all 0 when nothing grows.
    pub reached: Vec<f64>,
    /// Euclidean distance between the two, species that fit nowhere left out and the others'
    /// targets taken relative to each other; infinite when nothing grows.
    pub distance: f64,
    /// Species asked for that fit nowhere on the terrain.
    pub left_out: Vec<usize>,
    /// Species that found no more room before the end.
    pub out_of_room: Vec<usize>,
    /// Whether units were held back to keep the proportions.
    pub held_back: bool,
}

/// What is wanted of the competition.
pub(super) struct Wish {
    /// Share of each species, summing to 1.
    pub asked: Vec<f64>,
    pub seed: u64,
    pub tolerance: f64,
    pub fill: bool,
    /// Area of a batch relative to the area covered; 0 for one unit at a time.
    pub batch: f64,
}

impl From<(Vec<f64>, &FloraOptions<'_>)> for Wish {
    fn from((asked, options): (Vec<f64>, &FloraOptions)) -> Self {
        let tolerance = options.proportion_tolerance.max(0.0);
        Self { asked, seed: options.seed, tolerance, fill: options.fill, batch: options.batch.max(0.0) * tolerance }
    }
}

/// The target shares, summing to 1; `None` when no species has a target.
pub(super) fn shares(species: &[PlantSpecies]) -> Result<Option<Vec<f64>>, FloraError> {
    if species.iter().all(|s| s.target.is_none()) {
        return Ok(None);
    }
    let targets: Vec<f64> = species.iter().map(|s| s.target.unwrap_or(0.0)).collect();
    let sum: f64 = targets.iter().sum();
    let valid = targets.iter().all(|t| *t >= 0.0) && sum > 0.0 && sum.is_finite();
    if valid { Ok(Some(relative(&targets))) } else { Err(FloraError::Targets { sum }) }
}

fn relative(targets: &[f64]) -> Vec<f64> {
    let sum: f64 = targets.iter().sum();
    targets.iter().map(|t| if sum > 0.0 { t / sum } else { 0.0 }).collect()
}

/// The covers that come nearest to what is wished.
pub(super) fn compete(
    run: &Run,
    rules: &[Rule],
    sites: &Sites,
    fitness: &Fitness,
    wish: &Wish,
) -> Result<(Vec<Raster<u16>>, Reached), Stopped> {
    let mut contest = Contest::new(run, (rules, sites, fitness), wish)?;
    while let Some(attempt) = contest.next_attempt() {
        contest.grow(run, attempt)?;
    }
    let reached = contest.reached();
    Ok((planes(run, sites, rules.len(), &contest.covers)?, reached))
}

struct Contest<'a> {
    rules: &'a [Rule],
    sites: &'a Sites<'a>,
    wish: &'a Wish,
    queues: Vec<Queue<'a>>,
    balance: Balance,
    /// Cover by cell, then species: a cell's plants lie side by side.
    covers: Vec<u16>,
    left_out: Vec<usize>,
    held_back: bool,
    visits: u64,
}

impl<'a> Contest<'a> {
    fn new(
        run: &Run,
        (rules, sites, fitness): (&'a [Rule], &'a Sites, &'a Fitness),
        wish: &'a Wish,
    ) -> Result<Self, Stopped> {
        let lives = |s: usize| fitness.met[s].all > 0;
        let mut queues = Vec::with_capacity(rules.len());
        for (s, share) in wish.asked.iter().enumerate() {
            run.progress("plants.order", s as u64, rules.len() as u64)?;
            let levels = &fitness.levels[s].data;
            queues.push(if *share > 0.0 { Queue::new(wish.seed, s, levels) } else { Queue::empty(wish.seed, s) });
        }
        let possible: Vec<f64> =
            wish.asked.iter().enumerate().map(|(s, share)| if lives(s) { *share } else { 0.0 }).collect();
        let left_out = (0..rules.len()).filter(|s| wish.asked[*s] > 0.0 && !lives(*s)).collect();
        let covers = vec![0; sites.light.data.len() * rules.len()];
        let balance = Balance::new(relative(&possible));
        Ok(Self { rules, sites, wish, queues, balance, covers, left_out, held_back: false, visits: 0 })
    }

    /// The attempt that leads nearest to the target; `None` when nothing fits or it is to be
    /// held back.
    fn next_attempt(&mut self) -> Option<Attempt> {
        let batch = self.wish.batch * self.balance.total() as f64;
        let area = |s: usize| {
            let unit = u64::from(self.rules[s].unit);
            (batch as u64 / unit).max(1) * unit
        };
        let open = (0..self.rules.len()).filter(|s| !self.queues[*s].is_empty());
        let attempt = self.balance.nearest(open.map(|s| (s, area(s))))?;
        let strays = attempt.distance > self.wish.tolerance && attempt.distance >= self.balance.distance();
        self.held_back = strays && !self.wish.fill && !self.out_of_room().is_empty();
        (!self.held_back).then_some(attempt)
    }

    /// Species asked for and able to live here that have no cell left to try.
    fn out_of_room(&self) -> Vec<usize> {
        let asked = |s: &usize| self.wish.asked[*s] > 0.0 && !self.left_out.contains(s);
        (0..self.rules.len()).filter(asked).filter(|s| self.queues[*s].is_empty()).collect()
    }

    /// Adds the units of one attempt, as far as they fit, to the best cells of its species.
    fn grow(&mut self, run: &Run, attempt: Attempt) -> Result<(), Stopped> {
        let (species, mut wanted) = (attempt.species, attempt.area);
        while wanted > 0 {
            let Some(cell) = self.queues[species].best() else { return Ok(()) };
            self.report(run)?;
            match self.plant(species, cell, wanted.min(u64::from(FULL_COVER)) as u16) {
                0 => self.queues[species].give_up(),
                cover => wanted = wanted.saturating_sub(u64::from(cover)),
            }
        }
        Ok(())
    }

    /// Adds about so much cover of a species to a cell; gives what was added.
    fn plant(&mut self, species: usize, cell: usize, about: u16) -> u16 {
        let count = self.rules.len();
        let covers = &mut self.covers[cell * count..][..count];
        let mut stand = Stand::new(self.rules, self.sites.at(cell), covers);
        let cover = stand.units(species, about);
        if cover == 0 {
            return 0;
        }
        self.balance.area[species] += u64::from(cover);
        if self.rules[species].stratum == Stratum::Herb {
            stand.plant(species, cover);
            return cover;
        }
        let gave_way = stand.plant_telling(species, cover, |lower, lost| self.balance.area[lower] -= u64::from(lost));
        if gave_way {
            self.queues.iter_mut().for_each(|queue| queue.reopen(cell));
        }
        cover
    }

    fn report(&mut self, run: &Run) -> Result<(), Stopped> {
        self.visits += 1;
        if !self.visits.is_multiple_of(REPORT) {
            return Ok(());
        }
        let (done, total) = self.queues.iter().map(Queue::progress).fold((0, 0), |sum, p| (sum.0 + p.0, sum.1 + p.1));
        run.progress("plants.competition", done, total)
    }

    fn reached(&self) -> Reached {
        Reached {
            asked: self.wish.asked.clone(),
            reached: self.balance.reached(),
            distance: self.balance.distance(),
            left_out: self.left_out.clone(),
            out_of_room: if self.held_back { self.out_of_room() } else { Vec::new() },
            held_back: self.held_back,
        }
    }
}

/// One map a species out of the covers by cell.
fn planes(run: &Run, sites: &Sites, species: usize, covers: &[u16]) -> Result<Vec<Raster<u16>>, Stopped> {
    let grid = sites.light.grid;
    let mut maps = vec![Raster::filled(grid, 0_u16); species];
    let slabs = slabs::cut(maps.iter_mut().map(|map| map.data.as_mut_slice()), grid.len());
    slabs::each(run, "plants.maps", slabs, |slab: Slab<u16>| {
        for (s, map) in slab.maps.into_iter().enumerate() {
            map.iter_mut().zip(slab.cells.clone()).for_each(|(out, cell)| *out = covers[cell * species + s]);
        }
    })?;
    Ok(maps)
}
