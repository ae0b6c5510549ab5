use super::contest::Contest;
use super::contest::Habitat;
use super::contest::Wanted;
use super::herds::herds_of;
use super::larder::Dish;
use super::larder::Larder;
use super::stocks::Stocks;
use crate::compute::ecosystem::rag::Node;
use crate::compute::ecosystem::rag::NodeOptions;
use crate::compute::ecosystem::rag::PlantGrowth;
use crate::compute::ecosystem::rag::Rag;
use crate::compute::ecosystem::rag::Resource;
use crate::compute::ecosystem::rag::Territory;
use crate::compute::ecosystem::rag::WayPoint;
use crate::compute::ecosystem::rag::field::Field;
use crate::compute::ecosystem::rag::field::Source;
use crate::compute::ecosystem::rag::level::LevelNodes;
use crate::compute::ecosystem::rag::level::Offer;
use crate::compute::ecosystem::rag::level::group_parts;
use crate::compute::ecosystem::rag::level::level_nodes;
use crate::compute::ecosystem::rag::pools::Pool;
use crate::compute::ecosystem::rag::way_point_nodes;
use crate::compute::ecosystem::regions::NOWHERE;
use crate::compute::ecosystem::regions::Regions;
use crate::compute::ecosystem::species::AnimalSpecies;
use crate::compute::ecosystem::species::Food;
use crate::compute::ecosystem::species::PlantSpecies;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;

/// The world that animals settle in.
#[derive(Clone, Copy)]
pub struct Habitable<'a> {
    /// Where each animal can go.
    pub regions: &'a Regions,
    /// Depth of water, m; animals drink in and beside cells where it is positive.
    pub water_depth: &'a Raster<f32>,
    /// The plants.
    pub plants: &'a [PlantSpecies],
    /// What grows of each plant in a year.
    pub growth: &'a dyn PlantGrowth,
    /// The animals, the same that `regions` was made for.
    pub animals: &'a [AnimalSpecies],
    /// Places that draw animals for their own sake.
    pub way_points: &'a [WayPoint],
}

/// How animals compete and how their resources are cut into nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct FaunaOptions {
    /// Seed of ties and herd sizes.
    pub seed: u64,
    /// With targets: how far from the wanted shares (half the sum of absolute differences) a unit
    /// may take the whole once the neediest species has no room. Default: 0.02, ours.
    pub proportion_tolerance: f64,
    /// With targets: go on until nothing fits. Default: false.
    pub fill: bool,
    /// The most individuals per km² that each animal bears beside its own kind (territoriality);
    /// animals beyond the list's end, and infinite numbers, have no such bound. Default: none.
    pub max_density_per_km2: Vec<f64>,
    /// Per plant, the share of each period of the year in what can be eaten of it; non-negative,
    /// normalised to sum 1, of one length for all. Plants beyond the list's end give the same in
    /// every period. Default: none, no seasons.
    pub plant_seasons: Vec<Vec<f64>>,
    /// How resources are cut into nodes.
    pub nodes: NodeOptions,
}

impl Default for FaunaOptions {
    fn default() -> Self {
        Self {
            seed: 0,
            proportion_tolerance: 0.02,
            fill: false,
            max_density_per_km2: Vec::new(),
            plant_seasons: Vec::new(),
            nodes: NodeOptions::default(),
        }
    }
}

/// Why no unit of a species was placed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Absence {
    /// The user wants none of it.
    NotWanted,
    /// No part of the terrain large enough is accessible to it.
    NoRegion,
    /// None of its regions holds water it can reach.
    NoWater,
    /// A unit needs more room than any of its regions has.
    NoRoom,
    /// No region feeds a unit in the leanest season.
    NoFood {
        /// What a unit eats, kg a year.
        needed_kg: f64,
        /// What its best region offers in the leanest season, as kg a year.
        found_kg: f64,
    },
    /// There was food for it, but other species took it, or the wanted shares left it out.
    Displaced,
}

/// Who lives where, and on what.
#[derive(Debug, Clone, PartialEq)]
pub struct Population {
    /// The graph, with the territories that are inhabited; travel times are still to be filled
    /// in ([`super::super::travel::Travel::fill_times`]).
    pub rag: Rag,
    /// What grew and what was eaten of every food.
    pub stocks: Stocks,
    /// Why a species is absent; `None` for those that settled.
    pub absent: Vec<Option<Absence>>,
}

impl Population {
    /// Individuals of a species in one of its regions.
    pub fn individuals(&self, species: usize, region: usize) -> u64 {
        let here = self.rag.territories.iter().filter(|t| (t.species, t.region) == (species, region));
        here.map(Territory::individuals).sum()
    }

    /// Individuals of a species.
    pub fn total(&self, species: usize) -> u64 {
        self.rag.territories.iter().filter(|t| t.species == species).map(Territory::individuals).sum()
    }
}

/// Settles all animals, level by level.
///
/// Animals of a level eat plants and animals of lower levels; a diet item of the same or a higher
/// level is never there to eat. The result is the same on any number of threads.
pub fn populate(world: &Habitable<'_>, options: &FaunaOptions, run: &Run) -> Result<Population, Stopped> {
    let mut levels: Vec<usize> = world.animals.iter().map(|animal| animal.level).collect();
    levels.sort_unstable();
    levels.dedup();
    let stocks = Stocks::new(world.regions, world.plants, world.growth, world.animals, run)?;
    let mut state = Population { rag: Rag::default(), stocks, absent: vec![None; world.animals.len()] };
    for (i, level) in levels.iter().enumerate() {
        run.progress("animals.competition", i as u64, levels.len() as u64)?;
        settle_level(world, options, *level, &mut state, run)?;
    }
    state.rag.territories.sort_by_key(|t| (t.species, t.region));
    run.progress("animals.competition", levels.len() as u64, levels.len() as u64)?;
    Ok(state)
}

fn settle_level(
    world: &Habitable<'_>,
    options: &FaunaOptions,
    level: usize,
    state: &mut Population,
    run: &Run,
) -> Result<(), Stopped> {
    let species: Vec<usize> = (0..world.animals.len()).filter(|s| world.animals[*s].level == level).collect();
    let offers = offers(world, &species, state);
    let first = state.rag.nodes.len();
    let LevelNodes { mut nodes, pools } = level_nodes(&offers, world.regions, (level, first), &options.nodes, run)?;
    drop(offers);
    link_below(world.regions, &mut nodes, &state.rag);
    state.rag.nodes.append(&mut nodes);
    let passed = add_way_points(world, (level, &species), &mut state.rag);

    let larder = Larder::new(&pools, |pool| seasons(pool, options));
    let homes = habitats(world, options, &species, &pools);
    let mut contest = Contest::new(world.animals, homes, larder, options.seed);
    let reasons: Vec<Option<Absence>> = species.iter().map(|s| absence(world, &contest, *s)).collect();
    compete(world, options, (&species, &reasons), &mut contest, run)?;

    for (pool, kg) in pools.iter().zip(&contest.larder.eaten) {
        if let Resource::Food(food) = pool.resource
            && let Some(stock) = state.stocks.of_mut(food)
        {
            stock.eat(&pool.parts, *kg);
        }
    }
    for home in contest.habitats.iter().filter(|home| home.individuals > 0) {
        state.stocks.settle(world.regions, world.animals, (home.species, home.region), home.individuals);
        state.rag.territories.push(territory(world, options, home, (&pools, &passed)));
    }
    for (s, reason) in species.iter().zip(reasons) {
        let settled = contest.habitats.iter().any(|home| home.species == *s && home.individuals > 0);
        state.absent[*s] = if settled { None } else { reason.or(Some(Absence::Displaced)) };
    }
    Ok(())
}

/// The water and the food of a level's species.
fn offers<'a>(world: &Habitable<'a>, species: &[usize], state: &Population) -> Vec<Offer<'a>> {
    let drinkers: Vec<usize> = species.iter().copied().filter(|s| world.animals[*s].needs_water).collect();
    let mut foods: Vec<Food> = species.iter().flat_map(|s| eaten_by(&world.animals[*s])).collect();
    foods.sort_unstable();
    foods.dedup();
    let water = (!drinkers.is_empty()).then(|| Offer {
        resource: Resource::Water,
        field: Field {
            source: Source::Banks { depth: world.water_depth },
            share: vec![1.0; world.regions.parts()],
            group: group_parts(world.regions, &drinkers, |_| Some(0)),
        },
        users: drinkers,
    });
    let food = foods.into_iter().filter_map(|food| {
        let users: Vec<usize> =
            species.iter().copied().filter(|s| eaten_by(&world.animals[*s]).any(|f| f == food)).collect();
        let field = food_field(world, food, &users, state)?;
        Some(Offer { resource: Resource::Food(food), field, users })
    });
    water.into_iter().chain(food).collect()
}

fn eaten_by(animal: &AnimalSpecies) -> impl Iterator<Item = Food> + '_ {
    animal.diet.iter().filter(|item| item.preference > 0.0).map(|item| item.food)
}

fn food_field<'a>(world: &Habitable<'a>, food: Food, users: &[usize], state: &Population) -> Option<Field<'a>> {
    let regions = world.regions;
    let stock = state.stocks.of(food)?;
    Some(match food {
        Food::Plant(plant) => Field {
            source: Source::Plant { growth: world.growth, plant },
            share: (0..regions.parts()).map(|part| stock.left_share(part)).collect(),
            group: group_parts(regions, users, |_| Some(0)),
        },
        Food::Animal(prey) => Field {
            source: Source::Even,
            share: (0..regions.parts()).map(|p| stock.left_kg(p) / f64::from(regions.part_cells[p])).collect(),
            group: group_parts(regions, users, |part| regions.region_of_part(prey, part).map(|r| r as u32)),
        },
    })
}

/// Hierarchical edges: a node of prey points to the nodes that feed it.
fn link_below(regions: &Regions, nodes: &mut [Node], rag: &Rag) {
    let feeds = |n: &usize| !matches!(rag.nodes[*n].resource, Resource::WayPoint(_));
    for node in nodes {
        if let Resource::Food(Food::Animal(prey)) = node.resource {
            let region = regions.region(prey, node.cell);
            let home = rag.territories.iter().find(|t| t.species == prey && Some(t.region) == region);
            node.below = home.map(|t| t.nodes.iter().copied().filter(feeds).collect()).unwrap_or_default();
        }
    }
}

/// The node of a way-point, and the homes (species, region) that use it.
type Passed = (usize, Vec<(usize, usize)>);

/// Adds the nodes of the way-points that draw animals of the level.
fn add_way_points(world: &Habitable<'_>, (level, species): (usize, &[usize]), rag: &mut Rag) -> Vec<Passed> {
    let made = way_point_nodes(world.way_points, world.regions, (level, species));
    let mut passed = Vec::with_capacity(made.len());
    for (node, homes) in made {
        passed.push((rag.nodes.len(), homes));
        rag.nodes.push(node);
    }
    passed
}

fn seasons(pool: &Pool, options: &FaunaOptions) -> Vec<f64> {
    let periods = options.plant_seasons.iter().map(Vec::len).max().unwrap_or(1).max(1);
    let even = vec![1.0 / periods as f64; periods];
    let Resource::Food(Food::Plant(plant)) = pool.resource else { return even };
    let given = options.plant_seasons.get(plant).filter(|shares| shares.len() == periods);
    let shares: Vec<f64> = given.map(|s| s.iter().map(|x| x.max(0.0)).collect()).unwrap_or_default();
    let sum: f64 = shares.iter().sum();
    if sum > 0.0 && sum.is_finite() { shares.iter().map(|x| x / sum).collect() } else { even }
}

/// Every region of every species of the level, with the pools it reaches.
fn habitats(world: &Habitable<'_>, options: &FaunaOptions, species: &[usize], pools: &[Pool]) -> Vec<Habitat> {
    let mut homes = Vec::new();
    for s in species.iter().copied() {
        let animal = &world.animals[s];
        let most = options.max_density_per_km2.get(s).copied().filter(|d| *d >= 0.0).unwrap_or(f64::INFINITY);
        let first = homes.len();
        homes.extend((0..world.regions.count(s)).map(|region| Habitat {
            species: s,
            region,
            dishes: Vec::new(),
            banks: Vec::new(),
            room: most * world.regions.area_m2(s, region) * 1e-6,
            individuals: 0,
        }));
        for (p, pool) in pools.iter().enumerate() {
            let Some((_, region)) = pool.users.iter().find(|(user, _)| *user == s) else { continue };
            let home: &mut Habitat = &mut homes[first + region];
            match pool.resource {
                Resource::WayPoint(_) => {}
                Resource::Water => home.banks.push(p),
                Resource::Food(food) => {
                    let liked = animal.diet.iter().filter(|d| d.food == food && d.preference > 0.0);
                    home.dishes.extend(liked.take(1).map(|d| Dish { pool: p, preference: d.preference }));
                }
            }
        }
    }
    homes
}

/// Why a species cannot settle anywhere, before anybody has; `None` if it can.
fn absence(world: &Habitable<'_>, contest: &Contest<'_>, s: usize) -> Option<Absence> {
    let animal = &world.animals[s];
    let mut homes = contest.habitats.iter().filter(|home| home.species == s).peekable();
    let unit = f64::from(animal.group_min.max(1));
    if animal.target == Some(0.0) {
        Some(Absence::NotWanted)
    } else if contest.home(s).is_some() {
        None
    } else if homes.peek().is_none() {
        Some(Absence::NoRegion)
    } else if homes.clone().all(|home| home.room < unit) {
        Some(Absence::NoRoom)
    } else if animal.needs_water && homes.all(|home| home.banks.is_empty()) {
        Some(Absence::NoWater)
    } else {
        let needed_kg = unit * animal.food_kg_per_year;
        Some(Absence::NoFood { needed_kg, found_kg: contest.most_food_kg(s) })
    }
}

/// Runs the competition: with wanted shares if any species has a target, among those that can
/// settle at all (their shares are renormalised).
fn compete(
    world: &Habitable<'_>,
    options: &FaunaOptions,
    (species, reasons): (&[usize], &[Option<Absence>]),
    contest: &mut Contest<'_>,
    run: &Run,
) -> Result<(), Stopped> {
    if species.iter().all(|s| world.animals[*s].target.is_none()) {
        return contest.without_shares(&homes_by_part(world.regions, species, contest), run);
    }
    let target = |s: usize| world.animals[s].target.filter(|t| t.is_finite()).unwrap_or(0.0).max(0.0);
    let able = species.iter().zip(reasons).filter(|(s, reason)| reason.is_none() && target(**s) > 0.0);
    let able: Vec<usize> = able.map(|(s, _)| *s).collect();
    let sum: f64 = able.iter().map(|s| target(*s)).sum();
    let shares = able.iter().map(|s| target(*s) / sum).collect();
    let tolerance = options.proportion_tolerance;
    contest.with_shares(&Wanted { species: able, shares, tolerance, fill: options.fill }, run)
}

/// For each part of the finest common partition of the level's species, the homes that lie there.
fn homes_by_part(regions: &Regions, species: &[usize], contest: &Contest<'_>) -> Vec<Vec<usize>> {
    let groups = group_parts(regions, species, |_| Some(0));
    let count = groups.iter().filter(|g| **g != NOWHERE).max().map_or(0, |g| *g as usize + 1);
    let first_part = |group: usize| groups.iter().position(|g| *g as usize == group);
    let is_there = |home: &Habitat, part: usize| regions.region_of_part(home.species, part) == Some(home.region);
    let homes = |part: usize| {
        (0..contest.habitats.len()).filter(|h| is_there(&contest.habitats[*h], part)).collect::<Vec<usize>>()
    };
    (0..count).filter_map(first_part).map(homes).collect()
}

fn territory(
    world: &Habitable<'_>,
    options: &FaunaOptions,
    home: &Habitat,
    (pools, passed): (&[Pool], &[Passed]),
) -> Territory {
    let used = home.banks.iter().copied().chain(home.dishes.iter().map(|dish| dish.pool));
    let here = passed.iter().filter(|(_, homes)| homes.contains(&(home.species, home.region)));
    let mut nodes: Vec<usize> =
        used.flat_map(|pool| pools[pool].nodes.clone()).chain(here.map(|(node, _)| *node)).collect();
    nodes.sort_unstable();
    let animal = &world.animals[home.species];
    let place = (home.species as u64) << 32 | home.region as u64;
    let herds = herds_of(home.individuals, (animal.group_min, animal.group_max), (options.seed, place));
    let times_s = vec![f32::INFINITY; nodes.len() * nodes.len()];
    Territory { species: home.species, region: home.region, nodes, times_s, herds }
}
