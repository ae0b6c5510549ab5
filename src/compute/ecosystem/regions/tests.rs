use super::*;
use crate::compute::ecosystem::fauna::sample::animal;
use crate::compute::geometry::Point;

struct World {
    height: Raster<f32>,
    slope: Raster<f32>,
    water: Raster<f32>,
    trees: Raster<f32>,
}

impl World {
    fn flat(width: usize, height: usize) -> Self {
        let zero = Raster::filled(Grid::new(width, height, 1.0), 0.0);
        Self { height: zero.clone(), slope: zero.clone(), water: zero.clone(), trees: zero }
    }

    fn ground(&self) -> Ground<'_> {
        Ground { height: &self.height, slope: &self.slope, water_depth: &self.water, tree_cover: &self.trees }
    }

    fn regions(&self, passages: &Passages, species: &[AnimalSpecies]) -> Regions {
        let options = RegionOptions { min_area_m2: 4.0, min_cells: 4 };
        Regions::new(&self.ground(), passages, species, &options, &Run::silent()).unwrap()
    }
}

#[test]
fn a_diagonal_stream_parts_the_land_and_a_shallow_one_does_not() {
    let mut world = World::flat(12, 12);
    (0..12).for_each(|i| world.water.data[i * 12 + i] = 0.5);
    let mut wader = animal("wader", 1);
    wader.mobility.ford_depth_m = 0.6;
    let mut shy = animal("shy", 1);
    shy.mobility.ford_depth_m = 0.4;
    let regions = world.regions(&Passages::default(), &[wader, shy]);
    assert_eq!((regions.count(0), regions.count(1)), (1, 2));
    assert_eq!(regions.parts(), 3);
    assert_eq!(regions.region_cells[1], vec![66, 66]);
    assert_eq!(regions.part_cells.iter().sum::<u32>(), 144);
}

#[test]
fn a_ford_joins_the_banks_and_leaves_no_trace_elsewhere() {
    let mut world = World::flat(15, 9);
    (0..9).for_each(|row| world.water.data[row * 15 + 7] = 3.0);
    let species = [animal("deer", 1)];
    assert_eq!(world.regions(&Passages::default(), &species).count(0), 2);
    let ford = Place { centre: Point::new(7.5, 4.5), radius_m: 0.4 };
    let joined = world.regions(&Passages { fords: vec![ford], ..Passages::default() }, &species);
    assert_eq!(joined.region_cells, vec![vec![15 * 9 - 8]]);
    let waypoint = Passages { waypoints: vec![ford], ..Passages::default() };
    assert_eq!(world.regions(&waypoint, &species).count(0), 2, "a way-point opens no water");
}

#[test]
fn a_waypoint_opens_a_cliff() {
    let mut world = World::flat(20, 6);
    for i in 0..world.height.data.len() {
        world.height.data[i] = if i % 20 < 10 { 0.0 } else { 8.0 };
        world.slope.data[i] = if (9..11).contains(&(i % 20)) { 4.0 } else { 0.0 };
    }
    let species = [animal("deer", 1)];
    assert_eq!(world.regions(&Passages::default(), &species).count(0), 2);
    let gap = Place { centre: Point::new(10.0, 3.5), radius_m: 1.6 };
    let open = Passages { waypoints: vec![gap], ..Passages::default() };
    assert_eq!(world.regions(&open, &species).count(0), 1);
}

#[test]
fn a_step_that_is_only_descended_does_not_connect() {
    let mut world = World::flat(10, 5);
    (0..50).for_each(|i| world.height.data[i] = if i % 10 < 5 { 0.0 } else { 0.55 });
    let mut deer = animal("deer", 1);
    (deer.mobility.max_slope_up, deer.mobility.max_slope_down) = (0.5, 0.6);
    assert_eq!(world.regions(&Passages::default(), std::slice::from_ref(&deer)).count(0), 2);
    deer.mobility.max_slope_up = 0.6;
    assert_eq!(world.regions(&Passages::default(), &[deer]).count(0), 1);
}

#[test]
fn small_regions_are_left_out_and_the_map_numbers_from_one() {
    let mut world = World::flat(9, 4);
    (0..4).for_each(|row| world.trees.data[row * 9 + 2] = 0.9);
    (0..4).for_each(|row| world.trees.data[row * 9] = 0.9);
    let mut deer = animal("deer", 1);
    deer.mobility.max_tree_cover = 0.3;
    let options = RegionOptions { min_area_m2: 5.0, min_cells: 1 };
    let regions = Regions::new(&world.ground(), &Passages::default(), &[deer], &options, &Run::silent()).unwrap();
    assert_eq!(regions.region_cells, vec![vec![24]]);
    assert_eq!(regions.map(0).data[..9], [0, 0, 0, 1, 1, 1, 1, 1, 1]);
    assert_eq!(regions.region(0, 1), None);
}

#[test]
fn cells_without_data_and_a_world_without_species_have_no_region() {
    let mut world = World::flat(6, 6);
    world.height.data.fill(f32::NAN);
    let regions = world.regions(&Passages::default(), &[animal("deer", 1)]);
    assert_eq!((regions.parts(), regions.count(0)), (0, 0));
    assert_eq!(World::flat(3, 3).regions(&Passages::default(), &[]).parts(), 0);
}
