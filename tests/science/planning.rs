//! Daily plannings: room at every moment, times that add up, days that join, prey that is there.

use super::worlds::MEADOW;
use super::worlds::World;
use super::worlds::bison;
use super::worlds::deer;
use super::worlds::wolf;
use biotope::compute::ecosystem::habitat::Habitat;
use biotope::compute::ecosystem::planning::Activity;
use biotope::compute::ecosystem::planning::Cause;
use biotope::compute::ecosystem::planning::Conflict;
use biotope::compute::ecosystem::planning::DAY_S;
use biotope::compute::ecosystem::planning::Edit;
use biotope::compute::ecosystem::planning::Edited;
use biotope::compute::ecosystem::planning::Options;
use biotope::compute::ecosystem::planning::Pace;
use biotope::compute::ecosystem::planning::Planning;
use biotope::compute::ecosystem::planning::Plannings;
use biotope::compute::ecosystem::planning::Reason;
use biotope::compute::ecosystem::planning::Visit;
use biotope::compute::ecosystem::planning::capacity;
use biotope::compute::ecosystem::planning::edit;
use biotope::compute::ecosystem::planning::plannings;
use biotope::compute::ecosystem::planning::tracks;
use biotope::compute::ecosystem::rag;
use biotope::compute::ecosystem::rag::Resource;
use biotope::compute::ecosystem::trails::trails;
use biotope::compute::geometry::Point;
use biotope::compute::run::Run;
use biotope::compute::run::StopFlag;
use proptest::prelude::*;

/// The valley with deer and bison on both banks and wolves that hunt the deer.
fn valley(deer_herds: &[u32]) -> World {
    let world = World::valley().with_animal(deer()).with_animal(bison()).with_animal(wolf());
    [(8, 8), (20, 30), (10, 50), (60, 10), (70, 30), (62, 52)]
        .into_iter()
        .fold(world, |world, at| world.with_node(MEADOW, at, 2, 2e4))
        .with_node(Resource::Water, (37, 20), 1, 0.0)
        .with_node(Resource::Water, (43, 50), 1, 0.0)
        .settled(0, deer_herds)
        .settled(1, &[20, 25])
        .hunted(0, 3000.0)
        .settled(2, &[6, 5])
}

fn planned(world: &World, options: &Options) -> Plannings {
    plannings(&world.habitat(), options, &Run::silent()).unwrap()
}

/// What must be true of any planning; the first thing that is not.
fn flaw(world: &World, plans: &Plannings, options: &Options) -> Option<String> {
    (0..plans.days.len())
        .find_map(|herd| flaw_of_day(world, plans, herd).map(|what| format!("herd {herd}: {what}")))
        .or_else(|| crowded(world, plans, options))
}

fn flaw_of_day(world: &World, plans: &Plannings, herd: usize) -> Option<String> {
    let (day, animal) = (&plans.days[herd], &world.animals[plans.herds[herd].species]);
    let territory = &world.rag.territories[plans.herds[herd].territory];
    let (begin, end) = (animal.active_from_s, animal.active_from_s + animal.active_s);
    let (first, last) = (day.visits.first()?, day.visits.last()?);
    if (first.node, first.cell) != (last.node, last.cell) || first.leave_s != begin || last.leave_s != begin + DAY_S {
        return Some(format!("days do not join: {first:?} {last:?}"));
    }
    for (i, visit) in day.visits.iter().enumerate() {
        let ends_day = i + 1 == day.visits.len();
        if !territory.nodes.contains(&visit.node) || visit.leave_s < visit.arrive_s {
            return Some(format!("{visit:?} outside the territory or backwards"));
        }
        if visit.arrive_s < begin || visit.arrive_s > end + 1e-6 || (!ends_day && visit.leave_s > end + 1e-6) {
            return Some(format!("{visit:?} outside the active day"));
        }
    }
    day.visits
        .windows(2)
        .find_map(|w| {
            let way = world.ways_of(plans.herds[herd].species, w[0].cell, w[1].cell);
            let early = w[1].arrive_s < w[0].leave_s + way - 1e-3;
            let late = w[1].arrive_s > w[0].leave_s + way + 1.0 && w[1].prey.is_none();
            (early || late).then(|| format!("{:?} to {:?} takes {way}", w[0], w[1]))
        })
        .or_else(|| day.visits.iter().find_map(|visit| hunts_thin_air(plans, visit)))
}

/// A hunt where the prey is not.
fn hunts_thin_air(plans: &Plannings, hunt: &Visit) -> Option<String> {
    let prey = hunt.prey?;
    let there = (0..=20).all(|k| {
        let now = hunt.arrive_s + (hunt.leave_s - hunt.arrive_s) * f64::from(k) / 20.0;
        place(&plans.days[prey], now) == Some(hunt.cell)
    });
    (!there).then(|| format!("{hunt:?} is not where herd {prey} is"))
}

/// The cell at which a herd stays at a moment of any day.
fn place(day: &Planning, now: f64) -> Option<usize> {
    let stays = |v: &&Visit| {
        [-1.0, 0.0, 1.0].iter().any(|d| (v.arrive_s - 1e-3..=v.leave_s + 1e-3).contains(&(now + d * DAY_S)))
    };
    let stays: Vec<&Visit> = day.visits.iter().filter(stays).collect();
    stays.iter().find(|v| v.leave_s > v.arrive_s).map(|v| v.cell)
}

/// A sweep over all moments at which somebody arrives: too many at a node.
fn crowded(world: &World, plans: &Plannings, options: &Options) -> Option<String> {
    let mut stays: Vec<(usize, f64, f64, u32)> = Vec::new();
    for (day, herd) in plans.days.iter().zip(&plans.herds) {
        for v in day.visits.iter().filter(|v| v.activity != Activity::Wait && v.leave_s > v.arrive_s) {
            let shift = (v.arrive_s / DAY_S).floor() * DAY_S;
            let (from, to) = (v.arrive_s - shift, v.leave_s - shift);
            stays.extend([(v.node, from, to, herd.size), (v.node, from - DAY_S, to - DAY_S, herd.size)]);
        }
    }
    stays.iter().filter(|stay| stay.1 >= 0.0).find_map(|&(node, now, ..)| {
        // Just after the arrival: who leaves at that moment has left, whatever the rounding.
        let now = now + 1e-6;
        let there = stays.iter().filter(|s| s.0 == node && s.1 <= now && now < s.2);
        let sum: u32 = there.map(|s| s.3).sum();
        let capacity = capacity(&world.rag.nodes[node], world.grid.cell_m, options.m2_each);
        (sum > capacity).then(|| format!("{sum} of {capacity} at node {node} at {now}"))
    })
}

impl World {
    fn ways_of(&self, species: usize, from: usize, to: usize) -> f64 {
        self.habitat().ways.times_s(species, from, &[to], &Run::silent()).unwrap()[0]
    }
}

fn count(day: &Planning, activity: Activity) -> usize {
    day.visits.iter().filter(|visit| visit.activity == activity).count()
}

#[test]
fn plannings_of_the_valley_hold_together() {
    let world = valley(&[12, 8, 10]);
    let options = Options::default();
    let plans = planned(&world, &options);
    assert_eq!(plans.herds.len(), 7);
    assert_eq!(flaw(&world, &plans, &options), None);
    assert_eq!(plans.warnings, []);
}

#[test]
fn every_herd_drinks_as_often_as_it_should_and_eats() {
    let plans = planned(&valley(&[12, 8, 10]), &Options::default());
    for (day, herd) in plans.days.iter().zip(&plans.herds) {
        let meal = if herd.species == 2 { Activity::Hunt } else { Activity::Feed };
        assert!(count(day, Activity::Drink) >= 2 && count(day, meal) >= 1, "{day:?}");
        assert!(day.visits.len() >= 6, "{}", day.visits.len());
    }
}

#[test]
fn nobody_walks_past_the_nearest_water_and_has_no_time_to_drink_again() {
    // Eight hours to each of the great lakes, minutes to the pond.
    let mut slow = deer();
    slow.mobility.speed_m_per_s = 0.02;
    let lakes = [(70, 10), (70, 30), (70, 50), (70, 70)];
    let world = lakes
        .into_iter()
        .fold(World::plain(80).with_animal(slow), |world, at| world.with_node(Resource::Water, at, 6, 0.0))
        .with_node(Resource::Water, (14, 40), 1, 0.0)
        .with_node(MEADOW, (10, 40), 4, 5e4)
        .with_node(MEADOW, (10, 30), 4, 5e4)
        .settled(0, &[5; 12]);
    let plans = planned(&world, &Options::default());
    assert_eq!(flaw(&world, &plans, &Options::default()), None);
    assert!(plans.days.iter().all(|day| count(day, Activity::Drink) >= 2), "{:?}", plans.warnings);
}

#[test]
fn herds_walk_on_the_trails_in_the_time_they_plan() {
    let world = valley(&[12, 10]);
    let trails = trails(&world.habitat(), &Default::default(), &Run::silent()).unwrap();
    let habitat = Habitat { paths: Some(&trails.paths), ..world.habitat() };
    let plans = plannings(&habitat, &Options::default(), &Run::silent()).unwrap();
    let deer: Vec<usize> = (0..plans.herds.len()).filter(|h| plans.herds[*h].species == 0).collect();
    let found = tracks(&habitat, &plans, &deer, Pace { step_s: 60.0, height: None }, &Run::silent()).unwrap();
    let lines: Vec<&[Point]> = trails.lines.iter().flat_map(|line| line.points.windows(2)).collect();
    let off = |p: Point| lines.iter().map(|w| to_segment(p, w[0], w[1])).fold(f64::INFINITY, f64::min);
    for (track, herd) in found.iter().zip(&deer) {
        assert!(track.places.iter().all(|p| off(*p) < 1.5 * world.grid.cell_m));
        let speed = world.animals[0].mobility.speed_m_per_s;
        let fastest = track.places.windows(2).map(|w| w[0].distance(w[1]) / 60.0).fold(0.0, f64::max);
        assert!(fastest < 1.05 * speed && fastest > 0.5 * speed, "{fastest} {speed}");
        assert!(plans.days[*herd].visits.len() > 3);
    }
}

fn to_segment(p: Point, a: Point, b: Point) -> f64 {
    let along = b - a;
    let share = if along.norm_sq() > 0.0 { ((p - a).dot(along) / along.norm_sq()).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(a.lerp(b, share))
}

#[test]
fn stays_and_ways_make_up_the_whole_day() {
    let plans = planned(&valley(&[12]), &Options::default());
    for day in &plans.days {
        let stays: f64 = day.visits.iter().map(|visit| visit.leave_s - visit.arrive_s).sum();
        let ways: f64 = day.visits.windows(2).map(|w| w[1].arrive_s - w[0].leave_s).sum();
        assert!((stays + ways - DAY_S).abs() < 1e-6 && ways > 0.0);
        assert!(day.visits.iter().all(|visit| visit.arrive_s <= visit.leave_s));
        assert!(day.visits.windows(2).all(|w| w[0].leave_s <= w[1].arrive_s));
    }
}

#[test]
fn wolves_meet_deer_and_stay_no_longer_than_they_do() {
    let world = valley(&[12, 8, 10]);
    let plans = planned(&world, &Options::default());
    let hunts: Vec<&Visit> = plans.days.iter().flat_map(|d| &d.visits).filter(|v| v.prey.is_some()).collect();
    assert!(hunts.len() >= 2);
    assert!(hunts.iter().all(|hunt| hunt.activity == Activity::Hunt && plans.herds[hunt.prey.unwrap()].species == 0));
}

#[test]
fn a_bank_holds_as_many_on_fine_cells_as_on_cells_as_wide_as_an_animal() {
    let world = valley(&[12, 8, 10]);
    let bank = world.rag.nodes.iter().find(|n| n.resource == Resource::Water).unwrap();
    let metres = |cell_m: f64| rag::Node { area_m2: 100.0 * cell_m, ..bank.clone() };
    for cell_m in [0.5, 1.0, 5.0] {
        assert_eq!(capacity(&metres(cell_m), cell_m, 25.0), 20, "{cell_m}");
    }
    assert_eq!(capacity(&metres(50.0), 50.0, 25.0), 200);
    let meadow = rag::Node { resource: MEADOW, area_m2: 100.0, ..bank.clone() };
    assert_eq!(capacity(&meadow, 1.0, 25.0), 4);
}

#[test]
fn where_there_is_room_for_one_herd_the_others_wait_and_say_so() {
    let world = World::plain(40)
        .with_animal(deer())
        .with_node(MEADOW, (10, 10), 0, 1e4)
        .with_node(MEADOW, (30, 10), 0, 1e4)
        .with_node(Resource::Water, (20, 30), 0, 0.0)
        .settled(0, &[30, 30, 30, 30, 30, 30]);
    let tight = Options { m2_each: 3.0, ..Options::default() };
    let plans = planned(&world, &tight);
    assert_eq!(flaw(&world, &plans, &tight), None);
    assert!(plans.warnings.iter().any(|w| matches!(w.reason, Reason::Crowded(s) if s > 0.0)), "{:?}", plans.warnings);
    let roomy = Options { m2_each: 0.1, ..Options::default() };
    assert_eq!(planned(&world, &roomy).warnings, []);
}

#[test]
fn a_herd_that_no_node_can_hold_stays_beside_one() {
    let world = World::plain(20).with_animal(deer()).with_node(MEADOW, (10, 10), 1, 1e4).settled(0, &[500]);
    let plans = planned(&world, &Options::default());
    assert!(plans.warnings.iter().any(|w| w.reason == Reason::NoRoomToRest));
    assert!(plans.warnings.iter().any(|w| w.reason == Reason::Missed(Activity::Feed, Cause::TooSmall)));
    assert_eq!(flaw(&world, &plans, &Options::default()), None);
}

#[test]
fn herds_pass_a_way_point_on_their_rounds_and_their_paths_lead_over_it() {
    let way_point = (30, 4);
    let land = |share: f64| {
        [(8, 8), (20, 30), (30, 18)]
            .into_iter()
            .fold(World::plain(40).with_animal(deer()), |world, at| world.with_node(MEADOW, at, 3, 2e4))
            .with_node(Resource::Water, (25, 22), 2, 0.0)
            .with_way_point(way_point, share)
            .settled(0, &[8, 9, 7, 10, 6, 8])
    };
    let passes = |plans: &Plannings| plans.days.iter().map(|day| count(day, Activity::Pass)).sum::<usize>();
    let (world, options) = (land(0.2), Options::default());
    let plans = planned(&world, &options);
    assert_eq!((flaw(&world, &plans, &options), plans.warnings.len()), (None, 0));
    assert!(passes(&plans) >= 3 && passes(&planned(&land(0.5), &options)) > passes(&plans));
    let herds: Vec<usize> = (0..6).filter(|h| count(&plans.days[*h], Activity::Pass) > 0).collect();
    let pace = Pace { step_s: 60.0, height: None };
    let place = world.grid.centre(world.grid.index(way_point.0, way_point.1));
    for track in tracks(&world.habitat(), &plans, &herds, pace, &Run::silent()).unwrap() {
        assert!(track.places.iter().any(|p| p.distance(place) < 1e-9));
        let day = &plans.days[track.herd];
        assert!(day.visits.iter().filter(|v| v.activity == Activity::Pass).all(|v| v.leave_s - v.arrive_s == 600.0));
        assert!(count(day, Activity::Drink) >= 2 && count(day, Activity::Feed) >= 1, "nobody lives on passing");
        let twice = |w: &[Visit]| w.iter().all(|v| v.activity == Activity::Pass);
        assert!(!day.visits.windows(2).any(twice), "there is one way-point, passed once at a time");
    }
}

#[test]
fn a_herd_with_one_meadow_does_not_run_to_and_fro_to_a_way_point() {
    let world = World::plain(60)
        .with_animal(deer())
        .with_node(MEADOW, (10, 10), 2, 1e4)
        .with_way_point((50, 50), 0.1)
        .settled(0, &[5]);
    let plans = planned(&world, &Options::default());
    assert_eq!(flaw(&world, &plans, &Options::default()), None);
    assert!(count(&plans.days[0], Activity::Pass) <= 3, "{:?}", plans.days[0]);
}

/// Why the first herd misses a drink, with the water at (column, row) and herds of these sizes.
fn why_it_does_not_drink(world: World, water: (usize, usize), herds: &[u32], m2_each: f64) -> Vec<Cause> {
    let world = world.with_node(MEADOW, (10, 10), 6, 1e6).with_node(Resource::Water, water, 0, 0.0).settled(0, herds);
    let options = Options { m2_each, ..Options::default() };
    let plans = planned(&world, &options);
    assert_eq!(flaw(&world, &plans, &options), None);
    let cause = |w: &biotope::compute::ecosystem::planning::Warning| match w.reason {
        Reason::Missed(Activity::Drink, cause) => Some(cause),
        _ => None,
    };
    plans.warnings.iter().filter_map(cause).collect()
}

#[test]
fn a_missed_drink_says_whether_room_or_time_was_missing() {
    let plain = || World::plain(60).with_animal(deer());
    // Two of the day's ninety minutes by the water have room for everybody.
    assert_eq!(why_it_does_not_drink(plain(), (20, 10), &[5, 5], 1.0), []);
    let mut slow = deer();
    slow.mobility.speed_m_per_s = 0.01;
    let far = why_it_does_not_drink(World::plain(60).with_animal(slow), (50, 50), &[5], 1.0);
    assert_eq!(far, [Cause::TooFar; 2]);
    // The bank holds ten.
    assert_eq!(why_it_does_not_drink(plain(), (20, 10), &[11], 10.0), [Cause::TooSmall; 2]);
    // It holds one of the herds at a time, and the day is twelve drinks long.
    let crowd = why_it_does_not_drink(plain(), (20, 10), &[10; 14], 10.0);
    assert!(crowd.len() >= 16 && crowd.iter().all(|c| matches!(c, Cause::NoRoom | Cause::NoTime)), "{crowd:?}");
    assert!(crowd.iter().filter(|c| **c == Cause::NoRoom).count() >= 8, "{crowd:?}");
}

#[test]
fn a_drink_that_no_way_leads_to_is_missed_for_want_of_a_way() {
    let mut world = World::plain(30)
        .with_animal(deer())
        .with_node(MEADOW, (10, 10), 2, 1e4)
        .with_node(Resource::Water, (20, 20), 0, 0.0)
        .settled(0, &[5]);
    world.rag.territories[0].times_s = vec![0.0, f32::INFINITY, f32::INFINITY, 0.0];
    let plans = planned(&world, &Options::default());
    assert!(plans.warnings.iter().any(|w| w.reason == Reason::Missed(Activity::Drink, Cause::NoWay)));
}

#[test]
fn a_herd_with_one_node_feeds_there_all_day() {
    let world = World::plain(20).with_animal(deer()).with_node(MEADOW, (10, 10), 2, 1e4).settled(0, &[5]);
    let plans = planned(&world, &Options::default());
    assert_eq!(flaw(&world, &plans, &Options::default()), None);
    let fed: f64 =
        plans.days[0].visits.iter().filter(|v| v.activity == Activity::Feed).map(|v| v.leave_s - v.arrive_s).sum();
    assert!(fed > 16.0 * 3600.0, "{fed}");
}

#[test]
fn wolves_without_prey_in_reach_wait_and_say_so() {
    let mut world = valley(&[12]);
    // The deer are moved to an island of their own.
    let cliff = world.grid.width * 5;
    for cell in 0..world.grid.len() {
        if cell >= cliff && cell < cliff + world.grid.width {
            world.water_m.data[cell] = 3.0;
        }
    }
    for visit_cell in [0usize, 1, 2, 3, 4, 5, 6, 7] {
        world.rag.nodes[visit_cell].cell = world.grid.index(10 + visit_cell, 2);
    }
    let plans = planned(&world, &Options::default());
    let wolves: Vec<usize> = (0..plans.herds.len()).filter(|&h| plans.herds[h].species == 2).collect();
    assert!(!wolves.is_empty());
    for wolf in wolves {
        let met = plans.days[wolf].visits.iter().any(|v| v.activity == Activity::Hunt);
        let said = plans.warnings.iter().any(|w| w.herd == wolf && matches!(w.reason, Reason::PreyOutOfReach(_)));
        assert!(met || said, "{:?}", plans.days[wolf]);
    }
}

#[test]
fn the_same_seed_gives_the_same_days_on_one_and_two_threads() {
    let world = valley(&[12, 8, 10]);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| planned(&world, &Options { seed: 4, ..Options::default() }))
    };
    assert!(on(1) == on(2));
    assert!(on(1).days != planned(&world, &Options { seed: 5, ..Options::default() }).days);
}

#[test]
fn paths_stay_on_open_ground_and_keep_to_the_times() {
    let world = valley(&[12, 8]);
    let plans = planned(&world, &Options::default());
    let all: Vec<usize> = (0..plans.herds.len()).collect();
    let pace = Pace { step_s: 20.0, height: Some(&world.height) };
    let tracks = tracks(&world.habitat(), &plans, &all, pace, &Run::silent()).unwrap();
    for track in &tracks {
        let (herd, day) = (&plans.herds[track.herd], &plans.days[track.herd]);
        assert_eq!((track.places.len(), track.heights_m.len()), (4321, 4321));
        assert_eq!(track.places[0], track.places[4320], "days join up");
        let speed = world.animals[herd.species].mobility.speed_m_per_s;
        for w in track.places.windows(2) {
            assert!(w[0].distance(w[1]) <= 1.02 * speed * 20.0, "{}", w[0].distance(w[1]) / 20.0);
        }
        for (k, p) in track.places.iter().enumerate() {
            let cell = world.grid.at(*p).unwrap();
            assert!(world.water_m.data[cell] <= 0.5);
            let now = track.from_s + k as f64 * track.step_s;
            let stay = day.visits.iter().find(|v| v.arrive_s < now && now < v.leave_s);
            assert!(stay.is_none_or(|v| world.grid.centre(v.cell).distance(*p) < 1e-9));
        }
        assert!(track.heights_m.iter().all(|z| (z - 100.0).abs() < 1e-3));
    }
}

fn edited(world: &World, plans: &Plannings, herd: usize, edits: &[Edit]) -> Edited {
    edit(&world.habitat(), (plans, &Options::default()), (herd, edits), &Run::silent()).unwrap()
}

/// The plannings with the edited days in place.
fn after(plans: &Plannings, edited: &Edited) -> Plannings {
    let mut plans = plans.clone();
    edited.days.iter().for_each(|(herd, day)| plans.days[*herd] = day.clone());
    plans
}

#[test]
fn an_empty_edit_changes_nothing() {
    let world = valley(&[12, 8]);
    for (seed, herd) in (0..8).flat_map(|seed| (0..6).map(move |herd| (seed, herd))) {
        let plans = planned(&world, &Options { seed, ..Options::default() });
        let edited = edited(&world, &plans, herd, &[]);
        assert_eq!(edited.conflicts, [], "herd {herd}");
        for (changed, day) in edited.days {
            assert_eq!(day.visits.len(), plans.days[changed].visits.len());
            for (a, b) in day.visits.iter().zip(&plans.days[changed].visits) {
                let same = |a: f64, b: f64| (a - b).abs() < 1e-3;
                let kept = a.node == b.node && same(a.arrive_s, b.arrive_s) && same(a.leave_s, b.leave_s);
                assert!(kept, "{a:?} was {b:?}, of {:?}", plans.days[changed]);
            }
        }
    }
}

#[test]
fn dropping_and_adding_visits_times_the_day_again() {
    let world = valley(&[12]);
    let plans = planned(&world, &Options::default());
    let node = world.rag.territories[0].nodes[3];
    let edits = [Edit::Drop { order: 2 }, Edit::Add { order: 1, node, stay_s: 1800.0 }];
    let edited = edited(&world, &plans, 0, &edits);
    let new = after(&plans, &edited);
    assert_eq!(new.days[0].visits[1].node, node);
    assert!((new.days[0].visits[1].leave_s - new.days[0].visits[1].arrive_s - 1800.0).abs() < 1e-6);
    for herd in 0..new.days.len() {
        assert_eq!(flaw_of_day(&world, &new, herd), None);
    }
    assert!(edited.days.iter().any(|(herd, _)| plans.herds[*herd].species == 2), "wolves follow");
}

#[test]
fn a_pinned_visit_is_kept_and_what_stands_against_it_reported() {
    let world = valley(&[12]);
    let plans = planned(&world, &Options::default());
    let begin = world.animals[0].active_from_s;
    let pin =
        |order, from: f64, to: f64| Edit::Pin { order, arrive_s: begin + from * 3600.0, leave_s: begin + to * 3600.0 };
    let late = edited(&world, &plans, 0, &[pin(3, 9.0, 11.0)]);
    let new = after(&plans, &late);
    let pinned = new.days[0].visits.iter().find(|v| (v.arrive_s - begin - 9.0 * 3600.0).abs() < 1e-6);
    assert!(
        pinned
            .is_some_and(|v| v.node == plans.days[0].visits[3].node && (v.leave_s - v.arrive_s - 7200.0).abs() < 1e-6)
    );
    assert_eq!(flaw_of_day(&world, &new, 0), None);
    // At once after waking: what was before it goes, and it cannot be there in time.
    let early = edited(&world, &plans, 0, &[pin(3, 0.0, 1.0)]);
    let kinds = |c: &(usize, Conflict)| matches!(c.1, Conflict::Late(..) | Conflict::NoTime(_));
    assert!(early.conflicts.iter().any(kinds), "{:?}", early.conflicts);
    assert_eq!(flaw_of_day(&world, &after(&plans, &early), 0), None);
}

#[test]
fn edits_that_make_no_sense_are_reported_and_left_out() {
    let world = valley(&[12]);
    let plans = planned(&world, &Options::default());
    let edits = [
        Edit::Drop { order: 0 },
        Edit::Drop { order: 99 },
        Edit::Pin { order: 1, arrive_s: 5.0, leave_s: f64::NAN },
        Edit::Add { order: 1, node: 9999, stay_s: 600.0 },
    ];
    let edited = edited(&world, &plans, 0, &edits);
    let of_herd: Vec<Conflict> = edited.conflicts.iter().filter(|c| c.0 == 0).map(|c| c.1).collect();
    let no = Conflict::NoSuchVisit;
    assert_eq!(of_herd, [no(0), no(99), no(1), Conflict::NotReached(9999)]);
    assert!(self::edited(&world, &plans, 500, &[]).days.is_empty());
}

#[test]
fn a_stopped_run_plans_nothing() {
    let stop = StopFlag::default();
    stop.stop();
    let run = Run::stoppable(stop);
    assert!(plannings(&valley(&[12]).habitat(), &Options::default(), &run).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn on_random_ground_with_any_options_plannings_hold_together(
        places in prop::collection::vec((0usize..30, 0usize..30), 3..9),
        herds in prop::collection::vec(1u32..60, 1..6),
        m2_each in 1.0..60.0f64,
        hours in 3.0..24.0f64,
        begin in 0.0..24.0f64,
        seed in 0u64..1000,
    ) {
        let times = |mut species: biotope::compute::ecosystem::species::AnimalSpecies, shift: f64| {
            species.active_s = hours * 3600.0;
            species.active_from_s = (begin + shift) % 24.0 * 3600.0;
            species
        };
        let world = World::plain(30).with_animal(times(deer(), 0.0)).with_animal(times(bison(), 3.0)).with_animal(times(wolf(), 11.0));
        let world = places.iter().enumerate().fold(world, |world, (i, &at)| {
            world.with_node(if i % 3 == 0 { Resource::Water } else { MEADOW }, at, i % 3, 1e3 * i as f64)
        });
        let world = if seed % 2 == 0 { world.with_way_point(places[0], 0.3) } else { world };
        let world = world.settled(0, &herds).settled(1, &[15, 10]).hunted(0, 500.0).settled(2, &[5, 7]);
        let options = Options { m2_each, seed, ..Options::default() };
        let plans = planned(&world, &options);
        prop_assert_eq!(flaw(&world, &plans, &options), None);
    }
}
