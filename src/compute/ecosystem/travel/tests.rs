use super::*;
use crate::compute::ecosystem::fauna::sample::animal;
use crate::compute::ecosystem::regions::Place;
use crate::compute::ecosystem::regions::RegionOptions;
use crate::compute::geometry::Point;
use crate::compute::raster::Grid;
use crate::compute::raster::Raster;

struct World {
    height: Raster<f32>,
    slope: Raster<f32>,
    water: Raster<f32>,
    trees: Raster<f32>,
    passages: Passages,
    options: TravelOptions,
}

impl World {
    fn new(grid: Grid, height: impl Fn(Point) -> f64) -> Self {
        let zero = Raster::filled(grid, 0.0);
        let height = Raster { grid, data: (0..grid.len()).map(|i| height(grid.centre(i)) as f32).collect() };
        Self {
            height,
            slope: zero.clone(),
            water: zero.clone(),
            trees: zero,
            passages: Passages::default(),
            options: TravelOptions::default(),
        }
    }

    fn ask<T>(&self, species: &[AnimalSpecies], question: impl FnOnce(&Regions, &Travel<'_>) -> T) -> T {
        let ground =
            Ground { height: &self.height, slope: &self.slope, water_depth: &self.water, tree_cover: &self.trees };
        let options = RegionOptions { min_area_m2: 0.0, min_cells: 1 };
        let regions = Regions::new(&ground, &self.passages, species, &options, &Run::silent()).unwrap();
        let travel = Travel::new((ground, &self.passages), &regions, species, &self.options, &Run::silent()).unwrap();
        question(&regions, &travel)
    }
}

fn way(travel: &Travel<'_>, from: usize, to: usize) -> Option<Way> {
    travel.ways(0, from, &[to], &Run::silent()).unwrap().remove(0)
}

#[test]
fn flat_ground_is_crossed_in_a_straight_line_within_the_stated_heading_error() {
    let grid = Grid::new(60, 50, 2.0);
    World::new(grid, |_| 5.0).ask(&[animal("deer", 1)], |_, travel| {
        let from = grid.index(30, 25);
        for to in (0..grid.len()).step_by(37).filter(|to| *to != from) {
            let seconds = grid.centre(from).distance(grid.centre(to)) / 1.25;
            let found = way(travel, from, to).unwrap().seconds;
            assert!(found > seconds * 0.9999 && found < seconds * 1.028, "{found} {seconds}");
        }
    });
}

#[test]
fn uphill_takes_longer_than_downhill_and_a_wall_of_rock_is_walked_around() {
    let grid = Grid::new(40, 40, 10.0);
    let mut world = World::new(grid, |p| 0.3 * p.x);
    (5..40).for_each(|row| world.slope.data[grid.index(20, row)] = 3.0);
    world.ask(&[animal("deer", 1)], |_, travel| {
        let (west, east) = (grid.index(10, 30), grid.index(30, 30));
        let (up, down) = (way(travel, west, east).unwrap(), way(travel, east, west).unwrap());
        assert!(up.seconds > 1.2 * down.seconds, "{} {}", up.seconds, down.seconds);
        assert!(up.cells.iter().any(|c| *c as usize / 40 < 5));
    });
}

#[test]
fn every_way_is_made_of_neighbouring_open_cells_whose_steps_can_be_walked() {
    let grid = Grid::new(50, 40, 5.0);
    let mut world = World::new(grid, |p| 12.0 * libm::sin(p.x / 23.0) * libm::cos(p.y / 31.0));
    (0..grid.len()).filter(|i| i % 11 == 3 && i % 7 != 2).for_each(|i| world.water.data[i] = 2.0);
    world.ask(&[animal("deer", 1)], |_, travel| {
        let from = grid.index(1, 1);
        let goals: Vec<usize> = (60..grid.len()).step_by(61).collect();
        let ways = travel.ways(0, from, &goals, &Run::silent()).unwrap();
        assert!(ways.iter().flatten().count() > 20);
        for way in ways.iter().flatten() {
            let steps = way.cells.windows(2).map(|w| travel.step_s(0, w[0] as usize, w[1] as usize));
            let sum: f64 = steps.sum();
            assert!(way.cells.iter().all(|c| travel.open(0, *c as usize)));
            assert!(sum > 0.95 * way.seconds && sum < 1.15 * way.seconds, "{sum} {}", way.seconds);
            assert_eq!(way.cells[0] as usize, from);
        }
    });
}

#[test]
fn the_banks_are_reached_through_the_ford_alone_and_islands_not_at_all() {
    let grid = Grid::new(41, 30, 4.0);
    let mut world = World::new(grid, |_| 0.0);
    (0..30).for_each(|row| world.water.data[grid.index(20, row)] = 2.0);
    let (west, east) = (grid.index(5, 28), grid.index(35, 28));
    world.ask(&[animal("deer", 1)], |_, travel| assert_eq!(way(travel, west, east), None));
    let ford = grid.index(20, 3);
    world.passages.fords.push(Place { centre: grid.centre(ford), radius_m: 1.0 });
    world.ask(&[animal("deer", 1)], |_, travel| {
        assert!(way(travel, west, east).unwrap().cells.contains(&(ford as u32)));
    });
}

/// Hills, cliffs, a river with one ford of a cell, and scattered boulders.
fn wild(side: usize) -> World {
    let grid = Grid::new(side, side - 20, 10.0);
    let hills = |p: Point| {
        60.0 * libm::sin(p.x / 310.0) * libm::cos(p.y / 270.0)
            + 25.0 * libm::sin(p.x / 95.0 + 1.0) * libm::sin(p.y / 120.0)
    };
    let mut world = World::new(grid, hills);
    for i in 0..grid.len() {
        let (p, cell) = (grid.centre(i), grid.cell(i));
        let river = 5.0 * side as f64 + 300.0 * libm::sin(p.y / 400.0);
        if (p.x - river).abs() < 25.0 {
            world.water.data[i] = 2.0;
        }
        if (i * 2_654_435_761) % 1000 < 60 || (cell.row > side / 3 && cell.column == side / 4) {
            world.slope.data[i] = 3.0;
        }
    }
    let row = side / 5;
    let river = 5.0 * side as f64 + 300.0 * libm::sin(grid.centre(grid.index(0, row)).y / 400.0);
    let ford = Place { centre: Point::new(river, grid.centre(grid.index(0, row)).y), radius_m: 26.0 };
    world.passages.fords.push(ford);
    world
}

/// Relative errors of the times over rooms, and of the ways' seconds, against the search by cells.
fn errors(side: usize, most_tiles: usize) -> (Vec<f64>, Vec<f64>) {
    let mut world = wild(side);
    world.options = TravelOptions { exact_cells: usize::MAX, most_tiles };
    let grid = world.height.grid;
    let species = [animal("deer", 1)];
    let open: Vec<usize> = world.ask(&species, |regions, _| {
        let largest = (0..regions.count(0)).max_by_key(|r| regions.region_cells[0][*r]);
        (0..grid.len()).filter(|i| regions.region(0, *i) == largest).collect()
    });
    let places: Vec<usize> = (0..14).map(|i| open[(i * 7919 + 13) * 101 % open.len()]).collect();
    let exact: Vec<Vec<f32>> = world.ask(&species, |_, travel| {
        places.iter().map(|from| travel.times_s(0, *from, &places, &Run::silent()).unwrap()).collect()
    });
    world.options.exact_cells = 0;
    let (mut times, mut ways) = (Vec::new(), Vec::new());
    world.ask(&species, |_, travel| {
        for (from, exact) in places.iter().zip(&exact) {
            let rooms = travel.times_s(0, *from, &places, &Run::silent()).unwrap();
            let found = travel.ways(0, *from, &places, &Run::silent()).unwrap();
            for ((room, way), exact) in rooms.iter().zip(found).zip(exact).filter(|(_, exact)| **exact > 0.0) {
                times.push(f64::from(*room) / f64::from(*exact) - 1.0);
                ways.push(way.unwrap().seconds / f64::from(*exact) - 1.0);
            }
        }
    });
    (times, ways)
}

#[test]
fn times_over_rooms_and_ways_in_corridors_keep_to_the_stated_error() {
    for (side, most_tiles) in [(150, 1600), (200, 200)] {
        let (mut times, ways) = errors(side, most_tiles);
        times.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
        let mean = |errors: &[f64]| errors.iter().map(|e| e.abs()).sum::<f64>() / errors.len() as f64;
        let (most, worst_way) = (times[times.len() * 99 / 100].abs(), ways.iter().fold(0.0, |a: f64, b| a.max(*b)));
        assert!(mean(&times) < 0.08 && most < 0.32, "times: mean {} and 99 % below {most}", mean(&times));
        assert!(mean(&ways) < 0.005 && worst_way < 0.2, "ways: mean {} and at most {worst_way}", mean(&ways));
        assert!(ways.iter().all(|e| *e > -1e-4), "no way is quicker than the best");
    }
}

#[test]
fn times_by_rooms_are_the_same_on_one_and_two_threads() {
    let mut world = wild(150);
    world.options = TravelOptions { exact_cells: 0, most_tiles: 1600 };
    let ask = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            world.ask(&[animal("deer", 1)], |_, travel| {
                travel.times_s(0, 40 * 150 + 3, &[9_000, 12_345, 17_777], &Run::silent()).unwrap()
            })
        })
    };
    assert_eq!(ask(1), ask(2));
}

#[test]
fn a_herd_never_leaves_its_region_even_where_it_could_climb_down() {
    // Two terraces that a step parts: down it can be jumped, up not, and at the far end the
    // other way round, so that a round trip exists that neither terrace holds.
    let grid = Grid::new(30, 12, 1.0);
    let terrace = |p: Point| if p.y > 6.0 { 0.7 - 1.4 * f64::from(u8::from(p.x > 15.0)) } else { 0.0 };
    let mut world = World::new(grid, terrace);
    (0..6).for_each(|row| world.water.data[grid.index(15, row)] = 3.0);
    let (a, b) = (grid.index(2, 2), grid.index(2, 9));
    world.ask(&[animal("deer", 1)], |regions, travel| {
        assert_ne!(regions.region(0, a), regions.region(0, b));
        assert_eq!((way(travel, a, b), way(travel, b, a)), (None, None));
        let (high, low) = (grid.index(2, 5), grid.index(2, 6));
        assert!(travel.step_s(0, high, low).is_infinite() && travel.open(0, high) && travel.open(0, low));
    });
}
