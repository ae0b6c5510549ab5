use super::sample::animal;
use super::*;
use crate::compute::ecosystem::rag::Resource;
use crate::compute::ecosystem::regions::Ground;
use crate::compute::ecosystem::regions::Passages;
use crate::compute::ecosystem::regions::RegionOptions;
use crate::compute::ecosystem::regions::Regions;
use crate::compute::ecosystem::species::AnimalSpecies;
use crate::compute::ecosystem::species::DietItem;
use crate::compute::ecosystem::species::Food;
use crate::compute::ecosystem::species::Interval;
use crate::compute::ecosystem::species::Need;
use crate::compute::ecosystem::species::PlantSpecies;
use crate::compute::ecosystem::species::Stratum;
use crate::compute::raster::Grid;
use crate::compute::raster::Raster;
use crate::compute::run::Run;

fn herb(offtake: f64) -> PlantSpecies {
    let need = Need { range: Interval::new(1.0, 9.0), consumption: 0.2 };
    PlantSpecies {
        name: "grass".into(),
        stratum: Stratum::Herb,
        illumination: need,
        temperature: need,
        moisture: need,
        texture: need,
        viability: [1.0; 5],
        survival_min_c: None,
        growth_kg_per_m2: 0.3,
        offtake,
        target: None,
    }
}

/// A plain of 100 × 50 cells of 10 m, 0.3 kg of grass per m², water in its west column.
struct Plain {
    zero: Raster<f32>,
    water: Raster<f32>,
    growth: Vec<Raster<f32>>,
    plants: Vec<PlantSpecies>,
}

impl Plain {
    fn new() -> Self {
        let grid = Grid::new(100, 50, 10.0);
        let zero = Raster::filled(grid, 0.0);
        let mut water = zero.clone();
        (0..50).for_each(|row| water.data[row * 100] = 5.0);
        Self { zero, water, growth: vec![Raster::filled(grid, 30.0)], plants: vec![herb(0.3)] }
    }

    fn solve(&self, animals: &[AnimalSpecies], options: &FaunaOptions) -> (Regions, Population) {
        let ground = Ground { height: &self.zero, slope: &self.zero, water_depth: &self.water, tree_cover: &self.zero };
        let run = Run::silent();
        let regions = Regions::new(&ground, &Passages::default(), animals, &RegionOptions::default(), &run).unwrap();
        let world = Habitable {
            regions: &regions,
            water_depth: &self.water,
            plants: &self.plants,
            growth: &self.growth,
            animals,
            way_points: &[],
        };
        let population = populate(&world, options, &run).unwrap();
        (regions, population)
    }
}

fn grazer(name: &str, group: u32, kg: f64, target: Option<f64>) -> AnimalSpecies {
    let diet = vec![DietItem { food: Food::Plant(0), preference: 1.0 }];
    AnimalSpecies {
        group_min: group,
        group_max: 3 * group,
        food_kg_per_year: kg,
        target,
        diet,
        needs_water: true,
        ..animal(name, 1)
    }
}

fn hunter(prey: usize, kg: f64) -> AnimalSpecies {
    let diet = vec![DietItem { food: Food::Animal(prey), preference: 1.0 }];
    AnimalSpecies { group_min: 1, group_max: 4, food_kg_per_year: kg, diet, ..animal("wolf", 2) }
}

/// The grass that may be eaten on the plain: 99 columns × 50 rows × 30 kg × 0.3.
const SPARE_KG: f64 = 99.0 * 50.0 * 30.0 * 0.3;

#[test]
fn one_grazer_fills_the_plain_to_the_last_unit_that_is_fed() {
    let (regions, population) = Plain::new().solve(&[grazer("deer", 5, 600.0, None)], &FaunaOptions::default());
    let units = (SPARE_KG / 3000.0).floor() as u64;
    assert_eq!(population.total(0), 5 * units);
    let stock = population.stocks.of(Food::Plant(0)).unwrap();
    let eaten: f64 = stock.eaten_kg.iter().sum();
    assert!((eaten - units as f64 * 3000.0).abs() < 1e-6);
    let surplus = surplus_of_plant(&population, &regions, &Plain::new().growth, 0);
    let total: f64 = surplus.data.iter().map(|x| f64::from(*x)).sum();
    assert!((total + eaten - 5000.0 * 30.0).abs() < 1.0, "{total} {eaten}");
    let density = density_per_m2(&population, &regions, 0);
    let sum: f64 = density.data.iter().map(|d| f64::from(*d) * 100.0).sum();
    assert!((sum - population.total(0) as f64).abs() < 1e-2);
}

#[test]
fn wanted_shares_count_individuals_whatever_the_size_of_groups() {
    let animals = [grazer("deer", 5, 300.0, Some(60.0)), grazer("bison", 3, 900.0, Some(40.0))];
    let (_, population) = Plain::new().solve(&animals, &FaunaOptions::default());
    let count = [population.total(0), population.total(1)];
    assert!(distance(&count, &[0.6, 0.4]) < 0.05, "{count:?}");
    let eaten: f64 = population.stocks.of(Food::Plant(0)).unwrap().eaten_kg.iter().sum();
    assert!(eaten <= SPARE_KG * (1.0 + 1e-12) && eaten > SPARE_KG - 5.0 * 2700.0);
}

#[test]
fn a_species_that_cannot_settle_is_explained_and_the_others_share_its_place() {
    let mut plain = Plain::new();
    let mut hungry = grazer("mammoth", 50, 1e6, Some(30.0));
    let animals = [grazer("deer", 5, 300.0, Some(70.0)), hungry.clone()];
    let (_, population) = plain.solve(&animals, &FaunaOptions::default());
    assert!(population.total(0) > 0 && population.absent[0].is_none());
    let Some(Absence::NoFood { needed_kg, found_kg }) = population.absent[1] else { panic!("{:?}", population.absent) };
    assert!(needed_kg == 5e7 && (found_kg - SPARE_KG).abs() < 1e-6);
    plain.water.data.fill(0.0);
    let (_, dry) = plain.solve(&animals, &FaunaOptions::default());
    assert_eq!(dry.absent, vec![Some(Absence::NoWater); 2]);
    assert!(dry.rag.territories.is_empty());
    hungry.target = Some(0.0);
    assert_eq!(plain.solve(&[hungry], &FaunaOptions::default()).1.absent, vec![Some(Absence::NotWanted)]);
}

#[test]
fn without_targets_several_species_settle_together() {
    let animals = [grazer("deer", 5, 300.0, None), grazer("bison", 5, 700.0, None), grazer("horse", 4, 500.0, None)];
    let (_, population) = Plain::new().solve(&animals, &FaunaOptions::default());
    assert!((0..3).all(|s| population.total(s) > 0), "{:?}", population.rag.territories);
}

#[test]
fn wolves_live_on_half_of_the_young_and_their_food_knows_what_feeds_it() {
    let animals = [grazer("deer", 5, 600.0, None), hunter(0, 500.0)];
    let (_, population) = Plain::new().solve(&animals, &FaunaOptions::default());
    let deer = population.total(0) as f64;
    assert_eq!(population.total(1), (deer * 0.3 * 100.0 * 0.5 / 500.0).floor() as u64);
    let prey: Vec<_> = population.rag.nodes.iter().filter(|n| n.resource == Resource::Food(Food::Animal(0))).collect();
    assert_eq!(prey.len(), 1);
    assert!((prey[0].quantity_kg - deer * 15.0).abs() < 1e-6);
    assert_eq!(prey[0].below, population.rag.territories[0].nodes);
    assert_eq!((prey[0].level, prey[0].area.len()), (2, 99 * 50));
}

#[test]
fn the_leanest_season_and_the_room_a_species_needs_bound_the_herd() {
    let seasons = FaunaOptions { plant_seasons: vec![vec![0.25, 0.25, 0.4, 0.1]], ..FaunaOptions::default() };
    let animals = [grazer("deer", 5, 600.0, None)];
    let (_, lean) = Plain::new().solve(&animals, &seasons);
    assert_eq!(lean.total(0), 5 * (SPARE_KG * 0.4 / 3000.0).floor() as u64);
    let shy = FaunaOptions { max_density_per_km2: vec![20.0], ..FaunaOptions::default() };
    let (_, few) = Plain::new().solve(&animals, &shy);
    assert_eq!(few.total(0), 5, "49.5 ha at 20 a km² hold nine: one unit of five");
}

#[test]
fn nodes_cover_their_pool_and_stay_within_the_allowed_number() {
    for max_nodes in [1, 4, 9, 64] {
        let mut options = FaunaOptions::default();
        options.nodes.max_nodes = max_nodes;
        let (regions, population) = Plain::new().solve(&[grazer("deer", 5, 600.0, None)], &options);
        let nodes = &population.rag.nodes;
        assert!(nodes.len() <= max_nodes.max(2), "{} of {max_nodes}", nodes.len());
        let food: Vec<_> = nodes.iter().filter(|n| n.resource != Resource::Water).collect();
        if let Some(first) = food.first() {
            let sum: f64 = food.iter().map(|n| n.quantity_kg).sum();
            let cells: usize = food.iter().map(|n| n.area.len()).sum();
            assert!((sum - SPARE_KG).abs() < 1e-6 && cells == 99 * 50, "{sum}");
            assert_eq!(first.area.len() as f64 * 100.0, first.area_m2);
        }
        for node in nodes {
            assert!(node.area.cells().any(|c| c == node.cell));
            assert!(node.area.cells().all(|c| regions.region(0, c).is_some()));
        }
    }
}

#[test]
fn thousands_of_units_placed_in_batches_keep_the_shares_and_use_the_food() {
    let animals = [grazer("hare", 1, 4.0, Some(70.0)), grazer("deer", 2, 9.0, Some(30.0))];
    let (_, population) = Plain::new().solve(&animals, &FaunaOptions::default());
    let count = [population.total(0), population.total(1)];
    assert!(count[0] > 4000 && distance(&count, &[0.7, 0.3]) < 0.005, "{count:?}");
    let eaten: f64 = population.stocks.of(Food::Plant(0)).unwrap().eaten_kg.iter().sum();
    assert!(eaten > 0.995 * SPARE_KG && eaten <= SPARE_KG * (1.0 + 1e-12), "{eaten}");
}
