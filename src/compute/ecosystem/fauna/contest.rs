//! The **competition** of the animals of one level for what the level below can spare (L 4.3).

use super::larder::Dish;
use super::larder::Larder;
use crate::compute::ecosystem::species::AnimalSpecies;
use crate::compute::random::Purpose;
use crate::compute::random::hash2;
use crate::compute::run::Run;
use crate::compute::run::Stopped;

const TIES: Purpose = Purpose::new("animals.ties");

/// Units are placed one by one until there are this many, then in batches that never exceed this
/// fraction of what is placed: the work grows with the logarithm of the population, and
/// proportions stay within a five-hundredth of those placed one by one.
const BATCH: u64 = 512;

/// Steps of the fitness that decide between species without targets: finer differences are ties
/// (ours: with 1 − need/q the smallest groups would otherwise take everything).
const LEVELS: f64 = 10.0;

/// A confinement region as a home for one species.
#[derive(Debug, Clone)]
pub(super) struct Habitat {
    pub(super) species: usize,
    pub(super) region: usize,
    /// The pools it can eat from.
    pub(super) dishes: Vec<Dish>,
    /// The pools it can drink from.
    pub(super) banks: Vec<usize>,
    /// Individuals it may hold by space alone.
    pub(super) room: f64,
    pub(super) individuals: u64,
}

/// The state of the competition at one level.
pub(super) struct Contest<'a> {
    animals: &'a [AnimalSpecies],
    pub(super) habitats: Vec<Habitat>,
    pub(super) larder: Larder,
    fitness: Vec<f64>,
    /// The habitats that draw from each pool.
    guests: Vec<Vec<usize>>,
    units: u64,
    seed: u64,
}

/// How the species of a level relate to what is wanted of them.
pub(super) struct Wanted {
    /// The species of the level that can settle somewhere.
    pub(super) species: Vec<usize>,
    /// Share of the individuals wanted of each, summing to 1.
    pub(super) shares: Vec<f64>,
    /// How far from the shares a unit may take the whole when the neediest species has no room.
    pub(super) tolerance: f64,
    /// Go on until nothing fits.
    pub(super) fill: bool,
}

impl<'a> Contest<'a> {
    pub(super) fn new(animals: &'a [AnimalSpecies], habitats: Vec<Habitat>, larder: Larder, seed: u64) -> Self {
        let mut guests = vec![Vec::new(); larder.eaten.len()];
        for (h, habitat) in habitats.iter().enumerate() {
            habitat.dishes.iter().for_each(|dish| guests[dish.pool].push(h));
        }
        let fitness = vec![0.0; habitats.len()];
        let mut contest = Self { animals, habitats, larder, fitness, guests, units: 0, seed };
        (0..contest.habitats.len()).for_each(|h| contest.fitness[h] = contest.fit(h, 1));
        contest
    }

    /// kg a unit of the species eats in a year.
    fn unit_kg(&self, species: usize) -> f64 {
        f64::from(self.animals[species].group_min.max(1)) * self.animals[species].food_kg_per_year.max(0.0)
    }

    /// **Fitness** (L 4.2) of a habitat for `units` more: the minimum over the resources, water
    /// being either there or not, room either left or not.
    fn fit(&self, habitat: usize, units: u64) -> f64 {
        let home = &self.habitats[habitat];
        let animal = &self.animals[home.species];
        let after = home.individuals + units * u64::from(animal.group_min.max(1));
        if (animal.needs_water && home.banks.is_empty()) || after as f64 > home.room {
            return 0.0;
        }
        self.larder.fitness(&home.dishes, units as f64 * self.unit_kg(home.species))
    }

    /// The fittest home of a species, the first of equals.
    pub(super) fn home(&self, species: usize) -> Option<usize> {
        let homes = (0..self.habitats.len()).filter(|h| self.habitats[*h].species == species && self.fitness[*h] > 0.0);
        homes.max_by(|a, b| self.fitness[*a].total_cmp(&self.fitness[*b]).then(b.cmp(a)))
    }

    /// Places a batch of units, as many as fit of those that are due.
    fn place(&mut self, habitat: usize) {
        let mut units = (self.units / BATCH).max(1);
        while units > 1 && self.fit(habitat, units) <= 0.0 {
            units /= 2;
        }
        let species = self.habitats[habitat].species;
        let dishes = self.habitats[habitat].dishes.clone();
        self.larder.take(&dishes, units as f64 * self.unit_kg(species));
        self.habitats[habitat].individuals += units * u64::from(self.animals[species].group_min.max(1));
        self.units += units;
        let mut touched: Vec<usize> = dishes.iter().flat_map(|d| self.guests[d.pool].iter().copied()).collect();
        touched.push(habitat);
        touched.sort_unstable();
        touched.dedup();
        touched.into_iter().for_each(|h| self.fitness[h] = self.fit(h, 1));
    }

    /// **Algorithm 1**: of the attempts to add a unit of each species, the one nearest the wanted
    /// shares is kept, and placed in its fittest home. Ends when nothing fits, or, unless
    /// `fill`, when the neediest species has no room and every other unit would take the whole
    /// past the tolerance.
    pub(super) fn with_shares(&mut self, wanted: &Wanted, run: &Run) -> Result<(), Stopped> {
        let mut count = vec![0u64; wanted.species.len()];
        loop {
            run.check()?;
            let homes: Vec<Option<usize>> = wanted.species.iter().map(|s| self.home(*s)).collect();
            let order = self.by_need(wanted, &count);
            let Some(&(distance, next)) = order.iter().find(|(_, i)| homes[*i].is_some()) else { return Ok(()) };
            let neediest = order[0].1 == next;
            if !neediest && !wanted.fill && distance > wanted.tolerance {
                return Ok(());
            }
            if let Some(home) = homes[next] {
                let before = self.habitats[home].individuals;
                self.place(home);
                count[next] += self.habitats[home].individuals - before;
            }
        }
    }

    /// The species by how near a unit more of each would bring the whole to the wanted shares.
    fn by_need(&self, wanted: &Wanted, count: &[u64]) -> Vec<(f64, usize)> {
        let attempt = |i: usize| {
            let mut tried = count.to_vec();
            tried[i] += u64::from(self.animals[wanted.species[i]].group_min.max(1));
            (distance(&tried, &wanted.shares), i)
        };
        let mut order: Vec<(f64, usize)> = (0..count.len()).map(attempt).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        order
    }

    /// **Algorithm 2**: each part of the finest common partition (given as the homes its species
    /// have there) in turn gets a unit of the species that fits best, until nothing fits.
    pub(super) fn without_shares(&mut self, parts: &[Vec<usize>], run: &Run) -> Result<(), Stopped> {
        for round in 0u64.. {
            run.check()?;
            let mut placed = false;
            for (part, homes) in parts.iter().enumerate() {
                let key = |h: usize| {
                    let place = (part as u64) << 32 | round;
                    (
                        (LEVELS * self.fitness[h]).ceil() as u64,
                        hash2(self.seed, TIES, place, self.habitats[h].species as u64),
                    )
                };
                let best = homes.iter().copied().filter(|h| self.fitness[*h] > 0.0).max_by_key(|h| key(*h));
                if let Some(home) = best {
                    self.place(home);
                    placed = true;
                }
            }
            if !placed {
                break;
            }
        }
        Ok(())
    }

    /// The food of the best provided home of a species in its leanest season, kg a year.
    pub(super) fn most_food_kg(&self, species: usize) -> f64 {
        let homes = self.habitats.iter().filter(|h| h.species == species && !h.dishes.is_empty());
        homes.map(|h| self.larder.leanest_kg(&h.dishes)).fold(0.0, f64::max)
    }
}

/// How far counts are from the wanted shares: half the sum of the absolute differences, 0..=1.
pub fn distance(count: &[u64], shares: &[f64]) -> f64 {
    let total = count.iter().sum::<u64>().max(1) as f64;
    0.5 * count.iter().zip(shares).map(|(n, share)| (*n as f64 / total - share).abs()).sum::<f64>()
}
