//! Regions, the Resource Access Graph, travel times and the competition of animals: invariants
//! over random small worlds, and hand-made worlds with known answers.

use biotope::compute::ecosystem::fauna::FaunaOptions;
use biotope::compute::ecosystem::fauna::Habitable;
use biotope::compute::ecosystem::fauna::Population;
use biotope::compute::ecosystem::fauna::density_per_m2;
use biotope::compute::ecosystem::fauna::populate;
use biotope::compute::ecosystem::fauna::surplus_of_animal;
use biotope::compute::ecosystem::fauna::surplus_of_plant;
use biotope::compute::ecosystem::rag::Node;
use biotope::compute::ecosystem::rag::Resource;
use biotope::compute::ecosystem::rag::Territory;
use biotope::compute::ecosystem::rag::WayPoint;
use biotope::compute::ecosystem::rag::reached;
use biotope::compute::ecosystem::regions::Ground;
use biotope::compute::ecosystem::regions::NOWHERE;
use biotope::compute::ecosystem::regions::Passages;
use biotope::compute::ecosystem::regions::Place;
use biotope::compute::ecosystem::regions::RegionOptions;
use biotope::compute::ecosystem::regions::Regions;
use biotope::compute::ecosystem::species::AnimalSpecies;
use biotope::compute::ecosystem::species::DietItem;
use biotope::compute::ecosystem::species::Food;
use biotope::compute::ecosystem::species::Interval;
use biotope::compute::ecosystem::species::Mobility;
use biotope::compute::ecosystem::species::Need;
use biotope::compute::ecosystem::species::PlantSpecies;
use biotope::compute::ecosystem::species::Stratum;
use biotope::compute::ecosystem::travel::Travel;
use biotope::compute::ecosystem::travel::TravelOptions;
use biotope::compute::geometry::Point;
use biotope::compute::random::Purpose;
use biotope::compute::random::Stream;
use biotope::compute::raster::Grid;
use biotope::compute::raster::Raster;
use biotope::compute::run::Run;
use std::sync::OnceLock;

/// A terrain with water, trees and plants, and the animals that may live there.
struct World {
    height: Raster<f32>,
    slope: Raster<f32>,
    water: Raster<f32>,
    trees: Raster<f32>,
    growth: Vec<Raster<f32>>,
    plants: Vec<PlantSpecies>,
    animals: Vec<AnimalSpecies>,
    passages: Passages,
    way_points: Vec<WayPoint>,
    options: FaunaOptions,
}

/// What became of it.
struct Solved {
    regions: Regions,
    population: Population,
}

impl World {
    /// Flat, dry and bare, with 0.3 kg of grass per m² all over, and nobody there.
    fn meadow(grid: Grid) -> Self {
        let zero = Raster::filled(grid, 0.0f32);
        Self {
            height: zero.clone(),
            slope: zero.clone(),
            water: zero.clone(),
            trees: zero.clone(),
            growth: vec![Raster::filled(grid, (0.3 * grid.cell_area_m2()) as f32)],
            plants: vec![plant("grass", Stratum::Herb)],
            animals: Vec::new(),
            passages: Passages::default(),
            way_points: Vec::new(),
            options: FaunaOptions::default(),
        }
    }

    fn grid(&self) -> Grid {
        self.height.grid
    }

    /// Sets the heights, and the slopes that belong to them by central differences.
    fn with_height(mut self, height: impl Fn(Point) -> f64) -> Self {
        let grid = self.grid();
        self.height.data = (0..grid.len()).map(|i| height(grid.centre(i)) as f32).collect();
        let at = |column: usize, row: usize| f64::from(self.height.get(column, row));
        let slope = |i: usize| {
            let (c, w, h) = (grid.cell(i), grid.width - 1, grid.height - 1);
            let x = at((c.column + 1).min(w), c.row) - at(c.column.saturating_sub(1), c.row);
            let y = at(c.column, (c.row + 1).min(h)) - at(c.column, c.row.saturating_sub(1));
            (hypot(x, y) / (2.0 * grid.cell_m)) as f32
        };
        self.slope.data = (0..grid.len()).map(slope).collect();
        self
    }

    fn with_water(mut self, depth: impl Fn(usize, usize) -> f32) -> Self {
        let grid = self.grid();
        self.water.data = (0..grid.len()).map(|i| depth(grid.cell(i).column, grid.cell(i).row)).collect();
        for (kg, water) in self.growth.iter_mut().flat_map(|map| map.data.iter_mut().zip(&self.water.data)) {
            if *water > 0.0 {
                *kg = 0.0;
            }
        }
        self
    }

    fn with_animals(mut self, animals: impl IntoIterator<Item = AnimalSpecies>) -> Self {
        self.animals = animals.into_iter().collect();
        self
    }

    fn ground(&self) -> Ground<'_> {
        Ground { height: &self.height, slope: &self.slope, water_depth: &self.water, tree_cover: &self.trees }
    }

    fn solve(&self) -> Solved {
        let run = Run::silent();
        let regions =
            Regions::new(&self.ground(), &self.passages, &self.animals, &RegionOptions::default(), &run).unwrap();
        let world = Habitable {
            regions: &regions,
            water_depth: &self.water,
            plants: &self.plants,
            growth: &self.growth,
            animals: &self.animals,
            way_points: &self.way_points,
        };
        let mut population = populate(&world, &self.options, &run).unwrap();
        let way = (self.ground(), &self.passages);
        let travel = Travel::new(way, &regions, &self.animals, &TravelOptions::default(), &run).unwrap();
        travel.fill_times(&mut population.rag, &run).unwrap();
        drop(travel);
        Solved { regions, population }
    }
}

fn hypot(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}

fn plant(name: &str, stratum: Stratum) -> PlantSpecies {
    let need = Need { range: Interval::new(1.0, 9.0), consumption: 0.2 };
    PlantSpecies {
        name: name.into(),
        stratum,
        illumination: need,
        temperature: need,
        moisture: need,
        texture: need,
        viability: [1.0; 5],
        survival_min_c: None,
        growth_kg_per_m2: 0.3,
        offtake: if stratum == Stratum::Herb { 0.3 } else { 0.1 },
        target: None,
    }
}

/// A grazer of 100 kg in groups of 5 to 12 that needs water.
fn grazer(name: &str) -> AnimalSpecies {
    AnimalSpecies {
        name: name.into(),
        level: 1,
        mass_kg: 100.0,
        group_min: 5,
        group_max: 12,
        diet: vec![DietItem { food: Food::Plant(0), preference: 1.0 }],
        food_kg_per_year: 600.0,
        needs_water: true,
        growth_per_year: 0.3,
        offtake: 0.5,
        mobility: Mobility {
            speed_m_per_s: 1.4,
            max_slope_up: 0.5,
            max_slope_down: 0.6,
            ford_depth_m: 0.5,
            max_tree_cover: 0.6,
        },
        active_from_s: 18_000.0,
        active_s: 64_800.0,
        target: None,
    }
}

fn hunter(name: &str, level: usize, prey: &[usize]) -> AnimalSpecies {
    let diet = prey.iter().map(|p| DietItem { food: Food::Animal(*p), preference: 1.0 }).collect();
    AnimalSpecies { level, group_min: 1, group_max: 3, mass_kg: 40.0, food_kg_per_year: 400.0, diet, ..grazer(name) }
}

/// A small random world: hills, a winding river, a lake, woods, two plants, four animals of three
/// levels whose abilities, groups, diets, needs and wanted shares are drawn.
fn random_world(seed: u64) -> World {
    let mut draw = Stream::new(seed, Purpose::new("test.fauna.world"), 0);
    let grid = Grid::new(30 + draw.below(60), 25 + draw.below(50), draw.range(8.0, 40.0));
    let (w, h) = (grid.width as f64 * grid.cell_m, grid.height as f64 * grid.cell_m);
    let (relief, phase) = (draw.range(0.0, 0.25) * w, draw.range(0.0, 6.0));
    let hills = move |p: Point| relief * (3.0 * p.x / w + phase).sin() * (4.0 * p.y / h + 2.0 * phase).cos();
    let (river, width, depth) = (draw.unit(), draw.below(3), draw.range(0.2, 2.0) as f32);
    let mut world = World::meadow(grid).with_height(hills).with_water(|column, row| {
        let centre = grid.width as f64 * river + 4.0 * (row as f64 / 9.0).sin();
        if (column as f64 - centre).abs() <= width as f64 { depth } else { 0.0 }
    });
    let wood = draw.range(3.0, 12.0);
    let cover = |i: usize| ((grid.cell(i).column as f64 / wood).sin() * (grid.cell(i).row as f64 / wood).cos()) as f32;
    world.trees.data = (0..grid.len()).map(|i| cover(i).clamp(0.0, 1.0)).collect();
    world.growth.push(world.trees.map(|t| t * (0.2 * grid.cell_area_m2()) as f32));
    world.plants.push(plant("oak", Stratum::Tree));
    let with_targets = draw.unit() < 0.5;
    for s in 0..2 {
        let mut animal = grazer(["deer", "goat"][s]);
        animal.group_min = 1 + draw.below(12) as u32;
        animal.group_max = animal.group_min + draw.below(20) as u32;
        animal.food_kg_per_year = draw.range(100.0, 2000.0);
        animal.needs_water = draw.unit() < 0.8;
        animal.mobility.max_slope_up = draw.range(0.1, 1.0);
        animal.mobility.max_slope_down = draw.range(0.1, 1.0);
        animal.mobility.ford_depth_m = draw.range(0.0, 1.5);
        animal.mobility.max_tree_cover = draw.range(0.2, 1.0);
        animal.target = with_targets.then(|| draw.range(0.0, 10.0));
        animal.diet.push(DietItem { food: Food::Plant(1), preference: draw.range(0.1, 4.0) });
        world.animals.push(animal);
    }
    let mut wolf = hunter("wolf", 2, &[0, 1]);
    wolf.diet.extend((draw.unit() < 0.5).then_some(DietItem { food: Food::Plant(0), preference: 0.2 }));
    wolf.growth_per_year = 3.0;
    world.animals.extend([wolf, hunter("lion", 3, &[2, 0])]);
    world.options.seed = seed;
    world.options.fill = draw.unit() < 0.5;
    world.options.nodes.max_nodes = if draw.unit() < 0.4 { 400 } else { 1 + draw.below(40) };
    world.options.nodes.min_area_m2 = if draw.unit() < 0.4 { 0.0 } else { draw.range(0.0, 20_000.0) };
    if draw.unit() < 0.3 {
        world.options.plant_seasons = vec![vec![0.1, 0.4, 0.3, 0.2], vec![0.25; 4]];
    }
    world
}

/// Thirty random worlds, solved once for all tests.
fn worlds() -> impl Iterator<Item = &'static (World, Solved)> {
    static WORLDS: OnceLock<Vec<(World, Solved)>> = OnceLock::new();
    let solved = |seed: u64| {
        let world = random_world(seed);
        let solved = world.solve();
        (world, solved)
    };
    WORLDS.get_or_init(|| (0..30).map(solved).collect()).iter()
}

fn foods(world: &World) -> impl Iterator<Item = Food> {
    (0..world.plants.len()).map(Food::Plant).chain((0..world.animals.len()).map(Food::Animal))
}

fn is_inhabited(solved: &Solved) -> bool {
    solved.population.rag.territories.iter().any(|t| !t.herds.is_empty())
}

#[test]
fn nowhere_is_more_eaten_than_can_be_spared_and_all_that_is_eaten_is_needed() {
    let mut inhabited = 0;
    for (world, solved) in worlds() {
        inhabited += usize::from(is_inhabited(solved));
        let population = &solved.population;
        for food in foods(world) {
            let stock = population.stocks.of(food).unwrap();
            for part in 0..solved.regions.parts() {
                let spare = stock.growth_kg[part] * stock.offtake;
                assert!(stock.eaten_kg[part] <= spare * (1.0 + 1e-9) && stock.eaten_kg[part] >= 0.0);
                assert!((0.0..=1.0).contains(&stock.surplus_share(part)));
            }
        }
        let eaten: f64 = foods(world).flat_map(|f| population.stocks.of(f).unwrap().eaten_kg.clone()).sum();
        let needed: f64 =
            (0..world.animals.len()).map(|s| population.total(s) as f64 * world.animals[s].food_kg_per_year).sum();
        assert!((eaten - needed).abs() <= 1e-6 * needed, "{eaten} {needed}");
    }
    assert!(inhabited >= 18, "only {inhabited} of the worlds show anything");
}

#[test]
fn surplus_maps_hold_growth_less_what_was_eaten_and_never_less_than_nothing() {
    for (world, solved) in worlds().take(15) {
        let (regions, population) = (&solved.regions, &solved.population);
        for p in 0..world.plants.len() {
            let map = surplus_of_plant(population, regions, &world.growth, p);
            let sum = |data: &[f32]| data.iter().map(|x| f64::from(*x)).sum::<f64>();
            let eaten: f64 = population.stocks.of(Food::Plant(p)).unwrap().eaten_kg.iter().sum();
            let grown = sum(&world.growth[p].data);
            assert!(map.data.iter().all(|kg| *kg >= 0.0));
            assert!((sum(&map.data) - (grown - eaten)).abs() <= 1e-5 * grown.max(1.0));
        }
        for s in 0..world.animals.len() {
            let stock = population.stocks.of(Food::Animal(s)).unwrap();
            let left: f64 = stock.growth_kg.iter().sum::<f64>() - stock.eaten_kg.iter().sum::<f64>();
            let map: f64 = surplus_of_animal(population, regions, s).data.iter().map(|x| f64::from(*x)).sum();
            assert!((map - left).abs() <= 1e-4 * left.max(1.0), "{map} {left}");
            let head: f64 = density_per_m2(population, regions, s).data.iter().map(|x| f64::from(*x)).sum();
            let total = population.total(s) as f64;
            assert!((head * world.grid().cell_area_m2() - total).abs() <= 1e-4 * total.max(1.0));
        }
    }
}

#[test]
fn herds_have_the_sizes_of_groups_and_live_where_they_can_drink_and_eat() {
    for (world, solved) in worlds() {
        let rag = &solved.population.rag;
        for territory in &rag.territories {
            let animal = &world.animals[territory.species];
            assert!(!territory.herds.is_empty());
            assert!(territory.herds.iter().all(|n| (animal.group_min..=animal.group_max).contains(n)));
            let offers = |resource: Resource| territory.nodes.iter().any(|n| rag.nodes[*n].resource == resource);
            assert!(!animal.needs_water || offers(Resource::Water));
            assert!(animal.diet.iter().any(|item| offers(Resource::Food(item.food))));
            for node in territory.nodes.iter().map(|n| &rag.nodes[*n]) {
                let home = Some(territory.region);
                assert!(node.area.cells().all(|cell| solved.regions.region(territory.species, cell) == home));
                assert!(node.area.cells().any(|cell| cell == node.cell));
            }
        }
    }
}

#[test]
fn nodes_of_a_food_are_disjoint_and_add_up_to_what_can_be_eaten_in_the_region() {
    let mut whole = 0;
    for (world, solved) in worlds() {
        let rag = &solved.population.rag;
        for territory in rag.territories.iter().filter(|t| world.animals[t.species].level == 1) {
            assert!(territory.nodes.len() <= world.options.nodes.max_nodes.max(1));
            for plant in 0..world.plants.len() {
                let is_food = |n: &&Node| n.resource == Resource::Food(Food::Plant(plant));
                let nodes: Vec<&Node> = territory.nodes.iter().map(|n| &rag.nodes[*n]).filter(is_food).collect();
                let grown = |cells: &[usize]| {
                    cells.iter().map(|c| f64::from(world.growth[plant].data[*c])).sum::<f64>()
                        * world.plants[plant].offtake
                };
                for node in &nodes {
                    let (found, offered) = (grown(&node.area.cells().collect::<Vec<usize>>()), node.quantity_kg);
                    assert!((found - offered).abs() <= 1e-6 * found, "{found} {offered}");
                }
                let mut cells: Vec<usize> = nodes.iter().flat_map(|n| n.area.cells()).collect();
                let count = cells.len();
                cells.sort_unstable();
                cells.dedup();
                assert_eq!(count, cells.len());
                if world.options.nodes.max_nodes == 400 && world.options.nodes.min_area_m2 < world.grid().cell_area_m2()
                {
                    let home = Some(territory.region);
                    let all: Vec<usize> = (0..world.grid().len())
                        .filter(|c| solved.regions.region(territory.species, *c) == home)
                        .filter(|c| world.growth[plant].data[*c] > 0.0)
                        .collect();
                    assert!(cells == all, "q(r, C) counts every cell: {} of {}", cells.len(), all.len());
                    whole += 1;
                }
            }
        }
    }
    assert!(whole > 0);
}

#[test]
fn every_herd_can_go_from_every_node_to_every_other_and_detours_never_pay_by_much() {
    for (_, solved) in worlds() {
        for territory in &solved.population.rag.territories {
            let n = territory.nodes.len();
            for i in 0..n {
                assert_eq!(territory.time_s(i, i), 0.0);
                for j in 0..n {
                    let direct = territory.time_s(i, j);
                    assert!(direct.is_finite() && direct >= 0.0);
                    let least = (0..n).map(|k| territory.time_s(i, k) + territory.time_s(k, j)).fold(direct, f64::min);
                    assert!(direct <= 1.001 * least + 0.1, "{direct} {least}");
                }
            }
        }
    }
}

#[test]
fn parts_and_regions_of_all_species_agree_with_one_another() {
    for (_, solved) in worlds().take(20) {
        let regions = &solved.regions;
        for species in 0..regions.species() {
            let map = regions.map(species);
            let mut cells = vec![0u32; regions.count(species) + 1];
            map.data.iter().for_each(|n| cells[*n as usize] += 1);
            assert_eq!(cells[1..], regions.region_cells[species][..]);
            for (cell, n) in map.data.iter().enumerate().filter(|(c, _)| regions.part.data[*c] != NOWHERE) {
                assert_eq!(regions.region(species, cell), (*n as usize).checked_sub(1));
            }
        }
    }
}

#[test]
fn the_result_is_the_same_on_one_and_on_two_threads() {
    for seed in 0..6 {
        let solve = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| random_world(seed).solve())
        };
        let (one, two) = (solve(1), solve(2));
        assert_eq!(one.regions, two.regions);
        assert_eq!(one.population, two.population);
    }
}

fn home(solved: &Solved, species: usize) -> Vec<&Territory> {
    solved.population.rag.territories.iter().filter(|t| t.species == species).collect()
}

#[test]
fn the_two_sides_of_a_river_are_joined_by_its_ford_alone() {
    let river = |column: usize, _: usize| if (39..=41).contains(&column) { 3.0 } else { 0.0 };
    let mut world = World::meadow(Grid::new(80, 60, 10.0)).with_water(river).with_animals([grazer("deer")]);
    let parted = world.solve();
    assert_eq!((parted.regions.count(0), home(&parted, 0).len()), (2, 2));
    let ford = Place { centre: Point::new(405.0, 155.0), radius_m: 16.0 };
    world.passages.fords.push(ford);
    let joined = world.solve();
    assert_eq!((joined.regions.count(0), home(&joined, 0).len()), (1, 1));
    let (parted, joined) = (parted.population.total(0), joined.population.total(0));
    assert!(joined.abs_diff(parted) <= 5 && joined > 0, "the same meadow feeds as many: {joined} {parted}");
}

#[test]
fn only_goats_pass_the_cliff_and_only_they_find_the_water_beyond_it() {
    let cliff = |p: Point| 100.0 + 0.9 * (p.x - 295.0).clamp(0.0, 40.0);
    let mut goat = grazer("goat");
    (goat.mobility.max_slope_up, goat.mobility.max_slope_down) = (1.0, 1.2);
    let lake = |column: usize, row: usize| if column > 50 && row > 30 { 2.0 } else { 0.0 };
    let world =
        World::meadow(Grid::new(60, 40, 10.0)).with_height(cliff).with_water(lake).with_animals([grazer("deer"), goat]);
    let solved = world.solve();
    assert_eq!((solved.regions.count(0), solved.regions.count(1)), (2, 1));
    let deer = home(&solved, 0);
    assert!(deer.iter().all(|t| t.region == 1), "west of the cliff there is no water");
    let map = density_per_m2(&solved.population, &solved.regions, 1);
    assert!(map.get(2, 20) > 0.0 && map.get(45, 20) == map.get(2, 20));
    let up_down = home(&solved, 1)[0];
    let asymmetric = (0..up_down.nodes.len())
        .flat_map(|i| (0..i).map(move |j| (i, j)))
        .filter(|(i, j)| (up_down.time_s(*i, *j) / up_down.time_s(*j, *i) - 1.0).abs() > 0.05);
    assert!(asymmetric.count() > 0, "the cliff takes longer up than down");
}

#[test]
fn an_island_holds_what_it_feeds_and_a_land_without_water_nothing() {
    let sea = |column: usize, row: usize| {
        let far = column.abs_diff(30).pow(2) + row.abs_diff(30).pow(2) > 20 * 20;
        if far { 5.0 } else { 0.0 }
    };
    let island = World::meadow(Grid::new(61, 61, 10.0)).with_water(sea).with_animals([grazer("deer")]).solve();
    let land = island.regions.area_m2(0, 0);
    assert_eq!(island.population.total(0), 5 * (land * 0.3 * 0.3 / 3000.0).floor() as u64);
    let dry = World::meadow(Grid::new(61, 61, 10.0)).with_animals([grazer("deer")]).solve();
    assert!(dry.population.rag.territories.is_empty());
}

#[test]
fn each_level_feeds_the_next_and_the_biomass_thins_out_towards_the_top() {
    let brook = |column: usize, _: usize| if column == 20 { 0.3 } else { 0.0 };
    let mut wolf = hunter("wolf", 2, &[0]);
    wolf.growth_per_year = 2.0;
    let animals = [grazer("deer"), wolf, hunter("lion", 3, &[1])];
    let solved = World::meadow(Grid::new(100, 100, 30.0)).with_water(brook).with_animals(animals.clone()).solve();
    let mass: Vec<f64> = (0..3).map(|s| solved.population.total(s) as f64 * animals[s].mass_kg).collect();
    assert!(mass[0] > 5.0 * mass[1] && mass[1] > 5.0 * mass[2] && mass[2] > 0.0, "{mass:?}");
}

#[test]
fn a_way_point_is_a_node_of_those_that_reach_it_and_feeds_nobody() {
    let grid = Grid::new(60, 40, 20.0);
    let river = |column: usize, _: usize| if (29..=31).contains(&column) { 2.0 } else { 0.0 };
    let plain = World::meadow(grid).with_water(river).with_animals([
        grazer("deer"),
        grazer("goat"),
        hunter("wolf", 2, &[0, 1]),
    ]);
    let at = |column: usize, row: usize| Place { centre: grid.centre(grid.index(column, row)), radius_m: 30.0 };
    let way_point = |place: Place, species: &[usize]| WayPoint { place, share: 0.1, species: species.to_vec() };
    let mut world = plain;
    let before = world.solve();
    world.way_points = vec![
        way_point(at(57, 3), &[0]),
        way_point(at(3, 37), &[]),
        way_point(at(30, 20), &[]),
        WayPoint { share: 0.0, ..way_point(at(5, 5), &[]) },
    ];
    let after = world.solve();
    assert!((0..3).all(|s| before.population.total(s) == after.population.total(s) && after.population.total(s) > 0));
    assert_eq!(reached(&after.regions, 1, &world.way_points[2]), None, "amid the river");
    let rag = &after.population.rag;
    let mut users: Vec<(usize, usize, usize)> = Vec::new();
    for t in &rag.territories {
        for (i, &n) in t.nodes.iter().enumerate() {
            let Resource::WayPoint(number) = rag.nodes[n].resource else { continue };
            let node = &rag.nodes[n];
            users.push((number, t.species, node.level));
            assert_eq!((node.quantity_kg, node.draws, node.area.len()), (0.0, 0.1, 9));
            assert_eq!(after.regions.region(t.species, node.cell), Some(t.region));
            assert!((0..t.nodes.len()).all(|j| t.time_s(i, j).is_finite() && t.time_s(j, i).is_finite()));
        }
    }
    users.sort_unstable();
    assert_eq!(users, [(0, 0, 1), (1, 0, 1), (1, 1, 1), (1, 2, 2)]);
    let passed = |n: &usize| matches!(rag.nodes[*n].resource, Resource::WayPoint(_));
    assert!(rag.nodes.iter().all(|node| !node.below.iter().any(passed)), "prey is not made of way-points");
}
