//! Trails: conserved traffic, open ground, main trails, and the wear they leave.

use super::worlds::MEADOW;
use super::worlds::World;
use super::worlds::bison;
use super::worlds::deer;
use super::worlds::goat;
use biotope::compute::ecosystem::presence::Drinking;
use biotope::compute::ecosystem::presence::onward;
use biotope::compute::ecosystem::presence::presence;
use biotope::compute::ecosystem::rag::Resource;
use biotope::compute::ecosystem::summary;
use biotope::compute::ecosystem::trails::Options;
use biotope::compute::ecosystem::trails::Stretch;
use biotope::compute::ecosystem::trails::Trail;
use biotope::compute::ecosystem::trails::Trails;
use biotope::compute::ecosystem::trails::carved;
use biotope::compute::ecosystem::trails::trails;
use biotope::compute::geometry::Point;
use biotope::compute::raster::Raster;
use biotope::compute::run::Run;
use biotope::compute::run::StopFlag;
use proptest::prelude::*;

/// The valley with meadows and water on both sides of the river.
fn valley() -> World {
    [(8, 8), (20, 30), (10, 50), (60, 10), (70, 30), (62, 52)]
        .into_iter()
        .fold(World::valley().with_animal(deer()).with_animal(bison()), |world, at| world.with_node(MEADOW, at, 3, 2e4))
        .with_node(Resource::Water, (37, 20), 0, 0.0)
        .with_node(Resource::Water, (43, 50), 0, 0.0)
        .settled(0, &[12, 8])
        .settled(1, &[20])
}

fn made(world: &World, options: &Options) -> Trails {
    trails(&world.habitat(), options, &Run::silent()).unwrap()
}

/// The sum of `of` × length over all stretches.
fn walked(trails: &Trails, of: impl Fn(&Stretch) -> f64) -> f64 {
    let length = |points: &[Point]| points.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>();
    let line =
        |line: &Trail| line.stretches.iter().map(|s| of(s) * length(&line.points[s.points.clone()])).sum::<f64>();
    trails.lines.iter().map(line).sum()
}

fn sum(map: &Raster<f32>) -> f64 {
    map.data.iter().map(|v| f64::from(*v)).sum::<f64>() * map.grid.cell_area_m2()
}

#[test]
fn presence_sums_to_one_and_so_do_the_next_places() {
    let world = valley();
    for territory in &world.rag.territories {
        let species = &world.animals[territory.species];
        let at = presence(&world.rag, territory, species, &Drinking::default());
        assert!((at.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        for v in 0..at.len() {
            let next = onward(territory, &at, v);
            assert!((next.iter().sum::<f64>() - 1.0).abs() < 1e-12 && next[v] == 0.0);
        }
    }
}

#[test]
fn usage_times_area_is_traffic_times_length() {
    let world = valley();
    let trails = made(&world, &Options::default());
    assert!(trails.without_way == 0 && (trails.kept_share - 1.0).abs() < 1e-9);
    let traffic = walked(&trails, |s| s.kg_per_year);
    assert!((sum(&trails.usage) / traffic - 1.0).abs() < 1e-4, "{} {traffic}", sum(&trails.usage));
    let worn = walked(&trails, |s| s.width_m);
    assert!((sum(&trails.worn) / worn - 1.0).abs() < 1e-3);
    assert!((summary::trails(&trails).worn_m2 / worn - 1.0).abs() < 1e-3);
    let carved = walked(&trails, |s| s.width_m * s.depth_m);
    assert!((sum(&trails.carving_m) / carved - 1.0).abs() < 1e-3);
}

#[test]
fn lines_stay_on_ground_that_their_walkers_can_stand_on() {
    let world = valley();
    let trails = made(&world, &Options::default());
    for line in &trails.lines {
        for w in line.points.windows(2) {
            for k in 0..20 {
                let cell = world.grid.at(w[0].lerp(w[1], f64::from(k) / 19.0)).unwrap();
                assert!(world.water_m.data[cell] <= 0.5, "{:?}", world.grid.cell(cell));
            }
        }
    }
}

#[test]
fn all_that_crosses_the_river_makes_the_ford_the_busiest_place() {
    let world = valley();
    let trails = made(&world, &Options::default());
    let ford = trails.usage.get(40, 45);
    let busier = trails.usage.data.iter().filter(|v| **v > ford * 1.3).count();
    assert!(ford > 0.0 && busier < 20, "{busier}");
    let others: f32 = (0..60).filter(|row| *row != 45).map(|row| trails.usage.get(40, row)).sum();
    assert_eq!(others, 0.0);
}

#[test]
fn every_two_nodes_with_traffic_are_joined_by_the_lines() {
    let world = valley();
    let trails = made(&world, &Options::default());
    let near = |p: Point| trails.lines.iter().flat_map(|l| &l.points).any(|q| q.distance(p) < 1e-9);
    assert!(world.rag.nodes.iter().all(|node| near(node.place)));
    assert!(trails.lines.iter().flat_map(|l| &l.stretches).all(|s| {
        let shares: f64 = s.species.iter().map(|share| share.1).sum();
        (shares - 1.0).abs() < 1e-9 && s.kg_per_year > 0.0
    }));
}

#[test]
fn a_way_point_draws_its_share_of_the_traffic_to_it() {
    let land = |share: Option<f64>| {
        let world = [(20, 20), (35, 40), (20, 50)]
            .into_iter()
            .fold(World::plain(70).with_animal(deer()), |world, at| world.with_node(MEADOW, at, 3, 2e4))
            .with_node(Resource::Water, (28, 30), 0, 0.0);
        share.map_or(world.clone(), |share| world.with_way_point((66, 3), share)).settled(0, &[12, 8])
    };
    let at = |share: Option<f64>| {
        let trails = made(&land(share), &Options::default());
        assert!(trails.without_way == 0 && (trails.kept_share - 1.0).abs() < 1e-9);
        let traffic = walked(&trails, |s| s.kg_per_year);
        assert!((sum(&trails.usage) / traffic - 1.0).abs() < 1e-4);
        f64::from(trails.usage.get(66, 3))
    };
    let (none, some, more) = (at(None), at(Some(0.1)), at(Some(0.3)));
    assert!(none == 0.0 && some > 0.0 && more > 2.0 * some, "{none} {some} {more}");
}

#[test]
fn trails_of_many_meadows_share_main_trails() {
    let meadows = (0..12).map(|k| (50 + (k % 3) * 6, 6 + (k / 3) * 14));
    let world = meadows
        .fold(World::plain(70).with_animal(deer()), |world, at| world.with_node(MEADOW, at, 2, 1e4))
        .with_node(Resource::Water, (5, 30), 1, 0.0)
        .settled(0, &[12]);
    let length = |attraction: f64, detour: f64| {
        let trails = made(&world, &Options { attraction, detour, ..Options::default() });
        trails.lines.iter().map(|line| line.length_m()).sum::<f64>()
    };
    let (apart, drawn, shared) = (length(0.0, 1.0), length(0.6, 1.0), length(0.6, 1.2));
    assert!(drawn < 0.8 * apart, "{drawn} {apart}");
    assert!(shared < 0.8 * drawn, "{shared} {drawn}");
}

#[test]
fn only_goats_wear_a_trail_over_the_cliff() {
    let world = |species| {
        [(8, 10), (20, 30), (45, 12), (52, 28)]
            .into_iter()
            .fold(World::cliff().with_animal(species), |world, at| world.with_node(MEADOW, at, 2, 1e4))
            .settled(0, &[10])
    };
    let over = |world: &World| {
        let trails = made(world, &Options::default());
        (0..40).any(|row| trails.usage.get(30, row) > 0.0)
    };
    assert!(over(&world(goat())));
    assert!(!over(&world(deer())));
}

#[test]
fn trails_are_carved_and_cleared_in_proportion_to_their_width_in_the_cell() {
    let world = valley();
    let trails = made(&world, &Options::default());
    let lowered = carved(&world.height, &trails);
    for cell in 0..world.grid.len() {
        let depth = world.height.data[cell] - lowered.data[cell];
        assert!((depth - trails.carving_m.data[cell]).abs() < 1e-4 && depth <= 0.4 + 1e-4);
        assert_eq!(trails.usage.data[cell] > 0.0, trails.worn.data[cell] > 0.0);
        assert!(trails.worn.data[cell] < 0.8, "a 3 m trail never fills a cell of 10 m");
    }
}

#[test]
fn the_same_seed_gives_the_same_trails_on_one_and_two_threads() {
    let world = valley();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| made(&world, &Options { seed: 9, ..Options::default() }))
    };
    let (one, two) = (on(1), on(2));
    assert!(one == two);
    assert!(one.lines != made(&world, &Options { seed: 10, ..Options::default() }).lines);
}

#[test]
fn a_world_without_edges_has_no_trails_and_a_stopped_run_makes_none() {
    let lone = World::plain(20).with_animal(deer()).with_node(MEADOW, (5, 5), 2, 1e4).settled(0, &[5]);
    let none = made(&lone, &Options::default());
    assert!(none.lines.is_empty() && none.usage.data.iter().all(|v| *v == 0.0));
    let stop = StopFlag::default();
    stop.stop();
    assert!(trails(&valley().habitat(), &Options::default(), &Run::stoppable(stop)).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn on_random_ground_traffic_is_conserved_and_closed_ground_untouched(
        places in prop::collection::vec((0usize..30, 0usize..30), 3..8),
        lakes in prop::collection::vec((0usize..30, 0usize..30), 0..5),
        detour in 1.0..2.0f64,
    ) {
        let wet = |column: usize, row: usize| {
            lakes.iter().any(|l| l.0.abs_diff(column) + l.1.abs_diff(row) < 4)
        };
        let world = World::plain(30).with_water(|c, r| if wet(c, r) { 4.0 } else { 0.0 }).with_animal(deer());
        let world = places.iter().enumerate().fold(world, |world, (i, &at)| {
            world.with_node(if i == 0 { Resource::Water } else { MEADOW }, at, 1, 1e3)
        });
        let world = world.settled(0, &[9]);
        let trails = made(&world, &Options { detour, ..Options::default() });
        prop_assert!((trails.kept_share - 1.0).abs() < 1e-9 && trails.without_way == 0);
        let traffic = walked(&trails, |s| s.kg_per_year);
        prop_assert!((sum(&trails.usage) - traffic).abs() <= 1e-4 * traffic);
        for cell in 0..world.grid.len() {
            let at = world.grid.cell(cell);
            prop_assert!(!wet(at.column, at.row) || trails.usage.data[cell] == 0.0);
        }
    }
}
