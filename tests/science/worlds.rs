//! Hand-made worlds with known answers, for the tests of any stage.
//!
//! A world is terrain, water and animals; [`World::with_node`] and [`World::settled`] make a small
//! Resource Access Graph by hand, with travel times by a plain exact search. So the later stages
//! can be tested without the earlier ones, and the earlier ones against it.

use biotope::compute::ecosystem::habitat::Habitat;
use biotope::compute::ecosystem::rag::Area;
use biotope::compute::ecosystem::rag::Node;
use biotope::compute::ecosystem::rag::Rag;
use biotope::compute::ecosystem::rag::Resource;
use biotope::compute::ecosystem::rag::Territory;
use biotope::compute::ecosystem::species::AnimalSpecies;
use biotope::compute::ecosystem::species::DietItem;
use biotope::compute::ecosystem::species::Food;
use biotope::compute::ecosystem::species::Mobility;
use biotope::compute::ecosystem::ways::Way;
use biotope::compute::ecosystem::ways::Ways;
use biotope::compute::geometry::Point;
use biotope::compute::raster::Grid;
use biotope::compute::raster::Raster;
use biotope::compute::run::Run;
use biotope::compute::run::Stopped;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Terrain, water and animals.
#[derive(Clone)]
pub struct World {
    /// Where the cells lie.
    pub grid: Grid,
    /// Height, metres.
    pub height: Raster<f32>,
    /// Depth of the water, metres; 0 on land.
    pub water_m: Raster<f32>,
    /// The species that live here.
    pub animals: Vec<AnimalSpecies>,
    /// What [`World::with_node`] and [`World::settled`] have made.
    pub rag: Rag,
}

impl World {
    /// Ground of the given height (metres, of the cell's centre), without water.
    pub fn of_height(grid: Grid, height: impl Fn(Point) -> f64) -> Self {
        let data = (0..grid.len()).map(|cell| height(grid.centre(cell)) as f32).collect();
        let height = Raster { grid, data };
        Self { grid, height, water_m: Raster::filled(grid, 0.0), animals: Vec::new(), rag: Rag::default() }
    }

    /// A flat plain of `side` × `side` cells of 10 m.
    pub fn plain(side: usize) -> Self {
        Self::of_height(Grid::new(side, side, 10.0), |_| 100.0)
    }

    /// A flat valley of 80 × 60 cells of 10 m, cut from north to south by a river 3 m deep in
    /// columns 39–41, with one ford 0.2 m deep in row 45.
    pub fn valley() -> Self {
        Self::of_height(Grid::new(80, 60, 10.0), |_| 100.0)
            .with_water(|column, row| if (39..=41).contains(&column) { if row == 45 { 0.2 } else { 3.0 } } else { 0.0 })
    }

    /// Two plains of 60 × 40 cells of 10 m, parted by a cliff with a slope of 0.9 between columns
    /// 29 and 31: passed by goats only.
    pub fn cliff() -> Self {
        Self::of_height(Grid::new(60, 40, 10.0), |p| 100.0 + 0.9 * (p.x - 295.0).clamp(0.0, 20.0))
    }

    /// A round hill, 60 m high with slopes up to 0.26, in the middle of 60 × 60 cells of 10 m.
    pub fn hill() -> Self {
        let middle = Point::new(300.0, 300.0);
        Self::of_height(Grid::new(60, 60, 10.0), move |p| {
            60.0 * libm::exp(-p.distance_sq(middle) / (2.0 * 140.0 * 140.0))
        })
    }

    /// An island with a radius of 12 cells amid water 5 m deep, in 40 × 40 cells of 10 m.
    pub fn island() -> Self {
        let far = |column: usize, row: usize| column.abs_diff(20).pow(2) + row.abs_diff(20).pow(2) > 144;
        Self::plain(40).with_water(|column, row| if far(column, row) { 5.0 } else { 0.0 })
    }

    /// The [valley](Self::valley) with the ford taken away and water to drink on its west side
    /// only, for [`World::settled`]: the east is a region without water it can reach.
    pub fn dry_east() -> Self {
        let wall = |p: Point| if (390.0..420.0).contains(&p.x) { 100.0 } else { 0.0 };
        Self::of_height(Grid::new(80, 60, 10.0), wall)
    }

    /// The world with water of the given depth per (column, row).
    pub fn with_water(mut self, depth: impl Fn(usize, usize) -> f64) -> Self {
        for cell in 0..self.grid.len() {
            let at = self.grid.cell(cell);
            self.water_m.data[cell] = depth(at.column, at.row) as f32;
        }
        self
    }

    /// The world with one species more.
    pub fn with_animal(mut self, species: AnimalSpecies) -> Self {
        self.animals.push(species);
        self
    }

    /// The world with one resource more: the square of `2 reach + 1` cells around (column, row),
    /// cut at the border. `quantity_kg` is left out for water.
    pub fn with_node(
        mut self,
        resource: Resource,
        (column, row): (usize, usize),
        reach: usize,
        quantity_kg: f64,
    ) -> Self {
        let first = column.saturating_sub(reach);
        let end = (column + reach + 1).min(self.grid.width);
        let rows = row.saturating_sub(reach)..(row + reach + 1).min(self.grid.height);
        let area = Area { runs: rows.map(|r| (self.grid.index(first, r) as u32, (end - first) as u32)).collect() };
        let cell = self.grid.index(column, row);
        let infinite = resource == Resource::Water;
        self.rag.nodes.push(Node {
            level: 1,
            resource,
            area_m2: area.len() as f64 * self.grid.cell_area_m2(),
            area,
            cell,
            place: self.grid.centre(cell),
            quantity_kg: if infinite { f64::INFINITY } else { quantity_kg },
            draws: 0.0,
            below: Vec::new(),
        });
        self
    }

    /// The world with a way-point at (column, row) that draws a share of the moves of all species.
    pub fn with_way_point(mut self, at: (usize, usize), share: f64) -> Self {
        let number = self.rag.nodes.iter().filter(|n| n.draws > 0.0).count();
        self = self.with_node(Resource::WayPoint(number), at, 0, 0.0);
        if let Some(node) = self.rag.nodes.last_mut() {
            node.draws = share;
        }
        self
    }

    /// Puts `herds` of the species on the nodes it uses, in one territory per region it cannot
    /// leave; with a node for the species above where the herds can be hunted.
    pub fn settled(mut self, species: usize, herds: &[u32]) -> Self {
        let mut left: Vec<usize> = (0..self.rag.nodes.len()).filter(|&n| self.uses(species, n)).collect();
        let mut region = 0;
        while let Some(&first) = left.first() {
            let reach = |n: usize| self.search(species, self.rag.nodes[n].cell).0;
            let out = reach(first);
            let mutual = |n: usize| out[self.cell(n)].is_finite() && reach(n)[self.cell(first)].is_finite();
            let nodes: Vec<usize> = left.iter().copied().filter(|&n| mutual(n) || n == first).collect();
            left.retain(|n| !nodes.contains(n));
            let times_s = nodes.iter().flat_map(|&a| {
                let from_a = reach(a);
                nodes.iter().map(move |&b| (a, b)).map(|(_, b)| from_a[self.cell(b)] as f32).collect::<Vec<f32>>()
            });
            let times_s = times_s.collect();
            self.rag.territories.push(Territory { species, region, nodes, times_s, herds: herds.to_vec() });
            region += 1;
        }
        self
    }

    /// The world with the herds of a territory as a resource for the level above.
    pub fn hunted(mut self, territory: usize, quantity_kg: f64) -> Self {
        let prey = &self.rag.territories[territory];
        let below = prey.nodes.clone();
        let mut cells: Vec<usize> = below.iter().flat_map(|&n| self.rag.nodes[n].area.cells()).collect();
        cells.sort_unstable();
        cells.dedup();
        let resource = Resource::Food(Food::Animal(prey.species));
        let cell = self.cell(below[0]);
        self.rag.nodes.push(Node {
            level: self.animals[prey.species].level + 1,
            resource,
            area: Area { runs: cells.iter().map(|&c| (c as u32, 1)).collect() },
            cell,
            place: self.grid.centre(cell),
            area_m2: cells.len() as f64 * self.grid.cell_area_m2(),
            quantity_kg,
            draws: 0.0,
            below,
        });
        self
    }

    /// What the trail and planning stages take.
    pub fn habitat(&self) -> Habitat<'_> {
        Habitat { grid: &self.grid, rag: &self.rag, animals: &self.animals, ways: self, paths: None }
    }

    fn cell(&self, node: usize) -> usize {
        self.rag.nodes[node].cell
    }

    fn uses(&self, species: usize, node: usize) -> bool {
        let (animal, node) = (&self.animals[species], &self.rag.nodes[node]);
        let eaten = animal.diet.iter().any(|item| Resource::Food(item.food) == node.resource);
        (eaten || node.resource == Resource::Water || node.draws > 0.0) && self.open(species, node.cell)
    }

    /// Exact travel times from a cell to all, and the cell each was reached from.
    fn search(&self, species: usize, from: usize) -> (Vec<f64>, Vec<usize>) {
        let mut best = vec![f64::INFINITY; self.grid.len()];
        let mut before = vec![usize::MAX; self.grid.len()];
        let mut queue = BinaryHeap::from([Reverse((0u64, from))]);
        best[from] = 0.0;
        while let Some(Reverse((bits, cell))) = queue.pop() {
            if f64::from_bits(bits) > best[cell] {
                continue;
            }
            for (next, _) in self.grid.neighbours(cell) {
                let reached = best[cell] + self.step_s(species, cell, next);
                if reached < best[next] {
                    (best[next], before[next]) = (reached, cell);
                    queue.push(Reverse((reached.to_bits(), next)));
                }
            }
        }
        (best, before)
    }
}

impl Ways for World {
    fn ways(&self, species: usize, from: usize, to: &[usize], run: &Run) -> Result<Vec<Option<Way>>, Stopped> {
        run.check()?;
        let (best, before) = self.search(species, from);
        let trace = |goal: usize| {
            let mut cells = vec![goal as u32];
            let mut cell = goal;
            while cell != from {
                cell = before[cell];
                cells.push(cell as u32);
            }
            cells.reverse();
            Way { cells, seconds: best[goal] }
        };
        Ok(to.iter().map(|&goal| best[goal].is_finite().then(|| trace(goal))).collect())
    }

    /// Tobler's hiking function (1993), scaled to the species' speed on flat ground.
    fn step_s(&self, species: usize, from: usize, to: usize) -> f64 {
        if !self.open(species, from) || !self.open(species, to) {
            return f64::INFINITY;
        }
        let run = self.grid.centre(from).distance(self.grid.centre(to));
        let slope = f64::from(self.height.data[to] - self.height.data[from]) / run;
        let legs = &self.animals[species].mobility;
        let steep = slope > legs.max_slope_up || -slope > legs.max_slope_down;
        let ease = libm::exp(-3.5 * ((slope + 0.05).abs() - 0.05));
        if steep { f64::INFINITY } else { run / (legs.speed_m_per_s * ease) }
    }

    fn open(&self, species: usize, cell: usize) -> bool {
        let depth = f64::from(self.water_m.data[cell]);
        !self.height.data[cell].is_nan() && depth <= self.animals[species].mobility.ford_depth_m
    }
}

/// A herbivore of level 1 that eats plant 0, climbs slopes of 0.5 and drinks.
pub fn deer() -> AnimalSpecies {
    AnimalSpecies {
        name: "Dama roberti".into(),
        level: 1,
        mass_kg: 55.0,
        group_min: 5,
        group_max: 14,
        diet: vec![DietItem { food: Food::Plant(0), preference: 1.0 }],
        food_kg_per_year: 700.0,
        needs_water: true,
        growth_per_year: 0.4,
        offtake: 0.5,
        mobility: Mobility {
            speed_m_per_s: 1.5,
            max_slope_up: 0.5,
            max_slope_down: 0.6,
            ford_depth_m: 0.5,
            max_tree_cover: 1.0,
        },
        active_from_s: 5.0 * 3600.0,
        active_s: 18.0 * 3600.0,
        target: None,
    }
}

/// The deer's heavy neighbour, in smaller numbers.
pub fn bison() -> AnimalSpecies {
    AnimalSpecies { name: "Bison priscus".into(), mass_kg: 850.0, food_kg_per_year: 6000.0, ..deer() }
}

/// A herbivore like the deer that climbs any slope up to 1.
pub fn goat() -> AnimalSpecies {
    let mobility = Mobility { max_slope_up: 1.0, max_slope_down: 1.0, ..deer().mobility };
    AnimalSpecies { name: "Hemitragus bonali".into(), mobility, ..deer() }
}

/// A carnivore of level 2 that hunts species 0, by night.
pub fn wolf() -> AnimalSpecies {
    AnimalSpecies {
        name: "Canis mosbachensis".into(),
        level: 2,
        mass_kg: 50.0,
        group_min: 5,
        group_max: 9,
        diet: vec![DietItem { food: Food::Animal(0), preference: 1.0 }],
        food_kg_per_year: 900.0,
        active_from_s: 16.0 * 3600.0,
        mobility: Mobility { speed_m_per_s: 2.2, ..deer().mobility },
        ..deer()
    }
}

/// A meadow of plant 0.
pub const MEADOW: Resource = Resource::Food(Food::Plant(0));

mod the_worlds {
    use super::*;

    fn seconds(world: &World, from: (usize, usize), to: (usize, usize)) -> Option<f64> {
        let cell = |(column, row): (usize, usize)| world.grid.index(column, row);
        world.ways(0, cell(from), &[cell(to)], &Run::silent()).unwrap().remove(0).map(|way| way.seconds)
    }

    #[test]
    fn on_the_plain_travel_time_is_distance_over_speed() {
        let world = World::plain(30).with_animal(deer());
        assert!((seconds(&world, (2, 2), (22, 2)).unwrap() - 200.0 / 1.5).abs() < 1e-6);
    }

    #[test]
    fn the_river_is_crossed_at_the_ford_only() {
        let world = World::valley().with_animal(deer());
        let cell = world.grid.index(60, 10);
        let way = world.ways(0, world.grid.index(20, 10), &[cell], &Run::silent()).unwrap().remove(0).unwrap();
        assert!(way.cells.contains(&(world.grid.index(40, 45) as u32)));
    }

    #[test]
    fn the_cliff_is_passed_by_goats_only() {
        assert!(seconds(&World::cliff().with_animal(goat()), (10, 20), (50, 20)).is_some());
        assert!(seconds(&World::cliff().with_animal(deer()), (10, 20), (50, 20)).is_none());
    }

    #[test]
    fn up_the_hill_takes_longer_than_down() {
        let world = World::hill().with_animal(deer());
        assert!(seconds(&world, (10, 30), (30, 30)).unwrap() > 1.1 * seconds(&world, (30, 30), (10, 30)).unwrap());
    }

    #[test]
    fn nobody_leaves_the_island_and_the_east_has_no_water() {
        assert!(seconds(&World::island().with_animal(deer()), (20, 20), (1, 1)).is_none());
        let dry = World::dry_east()
            .with_animal(deer())
            .with_node(Resource::Water, (10, 30), 1, 0.0)
            .with_node(MEADOW, (20, 30), 3, 1e4)
            .with_node(MEADOW, (60, 30), 3, 1e4)
            .settled(0, &[8]);
        assert_eq!(dry.rag.territories.iter().map(|t| t.nodes.clone()).collect::<Vec<_>>(), [vec![0, 1], vec![2]]);
    }
}
