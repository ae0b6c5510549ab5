//! Animated herds keep the laws of motion at every step and reach their key-frames.

use super::herds_drawn::gap;
use super::herds_made::BODY;
use super::herds_made::exemplar;
use super::herds_made::herd;
use biotope::compute::geometry::CellGrid;
use biotope::compute::geometry::Ellipse;
use biotope::compute::geometry::Point;
use biotope::compute::herds::Obstacles;
use biotope::compute::herds::animation::Animation;
use biotope::compute::herds::animation::AnimationError;
use biotope::compute::herds::animation::AnimationOptions;
use biotope::compute::herds::animation::KeyFrame;
use biotope::compute::herds::animation::KeyPose;
use biotope::compute::herds::animation::Why;
use biotope::compute::herds::animation::animate;
use biotope::compute::herds::animation::faults;
use biotope::compute::herds::contact;
use biotope::compute::herds::contact::Footprint;
use biotope::compute::herds::key_herd::KeyHerdOptions;
use biotope::compute::herds::key_herd::Site;
use biotope::compute::herds::key_herd::key_herd;
use biotope::compute::random::Purpose;
use biotope::compute::random::Stream;
use biotope::compute::raster::Grid;
use biotope::compute::raster::Raster;
use biotope::compute::run::Run;
use biotope::compute::run::StopFlag;

fn hills(slope: f64) -> Raster<f32> {
    let grid = Grid::new(120, 120, 5.0);
    let height = |p: Point| slope * 60.0 * ((p.x / 60.0).sin() + (p.y / 45.0).cos());
    Raster { grid, data: (0..grid.len()).map(|i| height(grid.centre(i)) as f32).collect() }
}

fn at(time_s: f64, herd: Vec<Ellipse>) -> KeyFrame {
    KeyFrame { time_s, pose: KeyPose::Herd(herd) }
}

fn via(time_s: f64, x: f64, y: f64) -> KeyFrame {
    KeyFrame { time_s, pose: KeyPose::Position(Point::new(x, y)) }
}

fn wrapped(angle: f64) -> f64 {
    angle.sin().atan2(angle.cos())
}

fn body(animation: &Animation, step: usize, animal: usize) -> Ellipse {
    let pose = animation.tracks.pose(step, animal);
    Ellipse { centre: pose.place, a: BODY.0, b: BODY.1, theta: pose.heading }
}

/// Speed, turning rate, slip and overlap of every step, and obstacles.
fn keeps_the_laws(animation: &Animation, options: &AnimationOptions, obstacles: &Obstacles, held: f64) {
    let (tracks, gait) = (&animation.tracks, &options.gait);
    for step in 1..tracks.times_s.len() {
        let dt = tracks.times_s[step] - tracks.times_s[step - 1];
        for i in 0..tracks.animals {
            let (was, is) = (tracks.pose(step - 1, i), tracks.pose(step, i));
            let moved = is.place - was.place;
            let speed = moved.norm() / dt;
            assert!(speed <= gait.max_speed_m_per_s * (1.0 + 1e-9), "step {step} animal {i}: {speed} m/s");
            let along = moved.norm().hypot(is.z - was.z) / dt;
            assert!(along <= gait.max_speed_m_per_s * (1.0 + 1e-9), "step {step} animal {i}: {along} m/s uphill");
            let turn = wrapped(is.heading - was.heading).abs() / dt;
            assert!(turn <= gait.max_turn_rad_per_s * (1.0 + 1e-9), "step {step} animal {i}: {turn} rad/s");
            if moved.norm() > 1e-6 {
                let slip = wrapped(moved.angle() - is.heading).abs();
                assert!(slip <= gait.max_slip_rad + 1e-6, "step {step} animal {i}: sideways by {slip}");
            }
            assert!(!obstacles.hold(is.place), "step {step} animal {i} is in an obstacle");
        }
    }
    let allowed = held.max(0.1 * 2.0 * BODY.1) + 1e-4;
    for step in 0..tracks.times_s.len() {
        let places: Vec<Point> = (0..tracks.animals).map(|i| tracks.pose(step, i).place).collect();
        let bodies: Vec<Ellipse> = (0..tracks.animals).map(|i| body(animation, step, i)).collect();
        let prints: Vec<Footprint> = bodies.iter().map(Footprint::new).collect();
        let near = CellGrid::new(&places, 2.0);
        for i in 0..tracks.animals {
            near.for_each_near(places[i], 2.0 * BODY.0, |j| {
                // The footprints' depth is never less than the true one; brute force is exact.
                if j > i && (prints[i].depth(&prints[j]) > allowed || (step % 50 == 0 && near_by(places[i], places[j])))
                {
                    let depth = depth(&bodies[i], &bodies[j]);
                    assert!(depth <= allowed, "step {step}: {i} and {j} overlap by {depth}");
                }
            });
        }
    }
}

fn near_by(p: Point, q: Point) -> bool {
    p.distance(q) < 2.0 * BODY.0
}

/// The least move that parts two ellipses, by brute force over directions.
fn depth(one: &Ellipse, two: &Ellipse) -> f64 {
    let support = |e: &Ellipse, u: Point| {
        let local = u.rotated(-e.theta);
        (e.a * local.x).hypot(e.b * local.y)
    };
    (0..360)
        .map(|k| Point::from_angle(f64::from(k) * std::f64::consts::TAU / 360.0))
        .map(|u| support(one, u) + support(two, u) - (two.centre - one.centre).dot(u))
        .fold(f64::INFINITY, f64::min)
}

fn walk(terrain: &Raster<f32>, obstacles: &Obstacles, frames: &[KeyFrame], options: &AnimationOptions) -> Animation {
    animate(terrain, obstacles, frames, options, &Run::silent()).unwrap()
}

#[test]
fn with_half_as_much_time_again_as_needed_the_herd_is_in_place_on_open_ground() {
    let (flat, none, options) = (hills(0.0), Obstacles::default(), AnimationOptions::default());
    for (seed, count, turn) in [(1, 60, 0.0), (2, 150, 0.9), (3, 40, 2.4)] {
        let from = herd(count, Point::new(120.0, 150.0), (4.0, 0.2), seed);
        let to = herd(count, Point::new(300.0, 260.0), (3.4, turn), seed + 50);
        let probe = [at(0.0, from.clone()), via(500.0, 240.0, 160.0), at(1000.0, to.clone())];
        let needed: Vec<f64> = walk(&flat, &none, &probe, &AnimationOptions { step_s: 5.0, ..options.clone() })
            .report
            .arrivals
            .iter()
            .map(|a| a.needed_s)
            .collect();
        let held = contact::deepest(&from).max(contact::deepest(&to));
        let frames = [at(0.0, from), via(1.5 * needed[0], 240.0, 160.0), at(1.5 * (needed[0] + needed[1]), to)];
        let animation = walk(&flat, &none, &frames, &options);
        let arrival = animation.report.arrivals.last().unwrap();
        println!("{count} animals, turn {turn}: {:.3} on place, {:?}", arrival.on_place, arrival.late.first());
        assert!(arrival.on_place >= 0.95, "{count}: {} {:?}", arrival.on_place, arrival.late);
        assert_eq!(arrival.cannot_reach, 0);
        keeps_the_laws(&animation, &options, &none, held);
    }
}

/// Two key-herds of `count` animals as they are made, packed so that bodies touch, from exemplars
/// of these numbers.
fn chained(count: usize, exemplars: [usize; 2], seed: u64) -> [Vec<Ellipse>; 2] {
    let none = Obstacles::default();
    let places = [(Point::new(200.0, 200.0), 0.2), (Point::new(360.0, 300.0), 0.9)];
    [0, 1].map(|k| {
        let (centre, direction) = places[k];
        let options = KeyHerdOptions {
            count,
            centre,
            direction,
            seed: 2 * seed + k as u64,
            body: BODY,
            ..KeyHerdOptions::default()
        };
        let exemplar = exemplar(exemplars[k], k as u64);
        key_herd(&exemplar, Site { terrain: None, obstacles: &none }, &options, &Run::silent()).unwrap().ellipses
    })
}

#[test]
fn key_herds_as_they_are_made_are_reached_in_time() {
    let (flat, none, options) = (hills(0.0), Obstacles::default(), AnimationOptions::default());
    let mut on_place = Vec::new();
    for (count, exemplars, seed) in [
        (5, [220, 220], 0),
        (25, [220, 43], 1),
        (60, [220, 220], 0),
        (60, [43, 220], 1),
        (150, [220, 43], 0),
        (150, [220, 220], 2),
        (400, [220, 43], 1),
        (500, [220, 220], 2),
    ] {
        let [from, to] = chained(count, exemplars, seed);
        let held = contact::deepest(&from).max(contact::deepest(&to));
        let probe = [at(0.0, from.clone()), at(1000.0, to.clone())];
        let needed = walk(&flat, &none, &probe, &AnimationOptions { step_s: 5.0, ..options.clone() }).report.arrivals
            [0]
        .needed_s;
        let animation = walk(&flat, &none, &[at(0.0, from), at(1.5 * needed, to)], &options);
        let arrival = &animation.report.arrivals[0];
        println!(
            "{count} chained: {:.3} on place, waited {:.0} s of {:.0}",
            arrival.on_place, animation.report.waited_s, arrival.given_s
        );
        keeps_the_laws(&animation, &options, &none, held);
        assert_eq!(animation.report.waited_s, 0.0);
        on_place.push(arrival.on_place);
    }
    assert!(on_place.iter().all(|share| *share >= 0.95), "{on_place:?}");
}

#[test]
fn the_laws_hold_among_trees_and_on_hills() {
    let terrain = hills(0.3);
    let mut random = Stream::new(4, Purpose::new("test.trees"), 0);
    let disks: Vec<(Point, f64)> = (0..40)
        .map(|_| (Point::new(random.range(190.0, 330.0), random.range(130.0, 310.0)), random.range(1.0, 5.0)))
        .collect();
    let mut mask = Raster::filled(Grid::new(120, 120, 5.0), 0u8);
    (40..56).for_each(|row| mask.data[52 + 120 * row] = 1);
    let obstacles = Obstacles { disks, mask: Some(mask), ..Obstacles::default() };
    let options = AnimationOptions::default();
    let frames = [
        at(0.0, herd(60, Point::new(150.0, 150.0), (4.0, 0.5), 5)),
        at(260.0, herd(60, Point::new(380.0, 330.0), (4.0, 0.5), 6)),
    ];
    let animation = walk(&terrain, &obstacles, &frames, &options);
    keeps_the_laws(&animation, &options, &obstacles, 0.0);
    let arrival = &animation.report.arrivals[0];
    println!(
        "trees: needed {:.0} s, {:.3} on place, waited {:.0} s",
        arrival.needed_s, arrival.on_place, animation.report.waited_s
    );
    assert!(arrival.on_place >= 0.95, "{arrival:?}");
    assert!(animation.report.waited_s > 1.0, "who has to go round trees is waited for");
    let tracks = &animation.tracks;
    let last = tracks.times_s.len() - 1;
    for i in 0..tracks.animals {
        let pose = tracks.pose(last, i);
        assert!((pose.z - terrain.sample(pose.place).unwrap()).abs() < 1e-6);
    }
}

#[test]
fn overlaps_of_key_herds_are_allowed_but_none_deeper() {
    let (flat, none, options) = (hills(0.0), Obstacles::default(), AnimationOptions::default());
    let dense = herd(80, Point::new(120.0, 150.0), (1.9, 0.0), 7);
    let held = contact::deepest(&dense);
    assert!(held > 0.2, "{held}");
    let frames = [at(0.0, dense), at(60.0, herd(80, Point::new(220.0, 150.0), (3.5, 0.0), 8))];
    let animation = walk(&flat, &none, &frames, &options);
    keeps_the_laws(&animation, &options, &none, held);
    assert!(animation.report.arrivals[0].on_place > 0.9, "{:?}", animation.report.arrivals[0]);
}

#[test]
fn what_one_pair_of_key_herds_holds_is_not_allowed_between_the_next() {
    let (flat, none, options) = (hills(0.0), Obstacles::default(), AnimationOptions::default());
    let dense = herd(60, Point::new(120.0, 150.0), (1.9, 0.0), 7);
    let held = contact::deepest(&dense);
    let loose = |x: f64, seed: u64| herd(60, Point::new(x, 150.0), (3.8, 0.0), seed);
    let frames = [at(0.0, dense), at(60.0, loose(200.0, 21)), at(110.0, loose(280.0, 22))];
    let animation = walk(&flat, &none, &frames, &options);
    keeps_the_laws(&animation, &options, &none, held);
    let tracks = &animation.tracks;
    let later = tracks.times_s.iter().position(|t| *t >= 60.0 - 1e-9).unwrap();
    for step in (later..tracks.times_s.len()).step_by(5) {
        let bodies: Vec<Ellipse> = (0..tracks.animals).map(|i| body(&animation, step, i)).collect();
        assert!(contact::deepest(&bodies) <= 0.1 * 2.0 * BODY.1 + 1e-4, "step {step}: {}", contact::deepest(&bodies));
    }
}

#[test]
fn who_is_late_is_told_why() {
    let (none, options) = (Obstacles::default(), AnimationOptions::default());
    let why = |terrain: &Raster<f32>, obstacles: &Obstacles, frames: &[KeyFrame]| -> Vec<Why> {
        let animation = walk(terrain, obstacles, frames, &options);
        keeps_the_laws(&animation, &options, obstacles, 0.0);
        animation.report.arrivals[0].late.iter().map(|late| late.why).collect()
    };
    let most = |found: &[Why], reason: Why| found.iter().filter(|w| **w == reason).count() * 2 > found.len();
    let from_to = |seconds: f64| {
        let start = at(0.0, herd(12, Point::new(100.0, 300.0), (4.0, 0.0), 31));
        [start, at(seconds, herd(12, Point::new(280.0, 300.0), (4.0, 0.0), 32))]
    };
    let far = why(&hills(0.0), &none, &from_to(40.0));
    assert!(far.len() == 12 && most(&far, Why::Distance), "{far:?}");
    let steep = why(&hills(0.6), &none, &from_to(65.0));
    assert!(!steep.is_empty() && most(&steep, Why::Slope), "{steep:?}");
    // A wall just before the places of half the herd: there is time for the way, not for the way round.
    let wall = Obstacles {
        disks: (0..40).map(|k| (Point::new(263.0, 304.0 + 2.0 * f64::from(k)), 1.5)).collect(),
        ..Obstacles::default()
    };
    let wide = |seconds: f64| {
        let start = at(0.0, herd(12, Point::new(100.0, 300.0), (14.0, 0.0), 31));
        [start, at(seconds, herd(12, Point::new(288.0, 300.0), (14.0, 0.0), 32))]
    };
    let needed = |frames: &[KeyFrame]| walk(&hills(0.0), &none, frames, &options).report.arrivals[0].needed_s;
    let walled = why(&hills(0.0), &wall, &wide(1.13 * needed(&wide(90.0))));
    assert!(!walled.is_empty() && walled.iter().all(|w| *w == Why::Obstacle), "{walled:?}");
    // Two packed herds of which the second lies across the first, and little time.
    let turned = |seconds: f64| {
        let start = at(0.0, herd(150, Point::new(150.0, 300.0), (2.6, 0.0), 41));
        [start, at(seconds, herd(150, Point::new(210.0, 300.0), (2.4, 1.2), 42))]
    };
    let jammed = turned(1.13 * needed(&turned(60.0)));
    let animation = walk(&hills(0.0), &none, &jammed, &options);
    let late: Vec<Why> = animation.report.arrivals[0].late.iter().map(|late| late.why).collect();
    assert!(!late.is_empty() && late.iter().all(|w| *w == Why::Crowding), "{late:?}");
}

#[test]
fn a_herd_finds_its_way_out_of_a_bay() {
    let (flat, options) = (hills(0.0), AnimationOptions::default());
    // A horseshoe of rocks, open to the herd, and a rock alone.
    let rim = |k: u32| Point::from_angle(-1.9 + 3.8 * f64::from(k) / 39.0) * 14.0 + Point::new(240.0, 300.0);
    let disks = (0..40).map(|k| (rim(k), 2.0)).chain([(Point::new(320.0, 306.0), 4.0)]).collect();
    let obstacles = Obstacles { disks, ..Obstacles::default() };
    let frames = [
        at(0.0, herd(100, Point::new(150.0, 300.0), (4.0, 0.0), 51)),
        at(200.0, herd(100, Point::new(400.0, 300.0), (4.0, 0.0), 52)),
    ];
    let animation = walk(&flat, &obstacles, &frames, &options);
    keeps_the_laws(&animation, &options, &obstacles, 0.0);
    let arrival = &animation.report.arrivals[0];
    assert!(arrival.on_place >= 0.95, "{} {:?}", arrival.on_place, arrival.late);
}

#[test]
fn holes_in_the_terrain_are_walked_round_whatever_the_mask() {
    let mut holed = hills(0.05);
    for i in 0..holed.data.len() {
        let p = holed.grid.centre(i);
        if (p.x - 200.0).abs() < 12.0 && p.y > 120.0 {
            holed.data[i] = f32::NAN;
        }
    }
    let pool = Raster { grid: Grid::new(600, 600, 1.0), data: vec![0u8; 360_000] };
    let obstacles = Obstacles { mask: Some(pool), ..Obstacles::default() };
    let frames = [
        at(0.0, herd(9, Point::new(150.0, 160.0), (4.0, 0.0), 33)),
        at(120.0, herd(9, Point::new(260.0, 160.0), (4.0, 0.0), 34)),
    ];
    let animation = walk(&holed, &obstacles, &frames, &AnimationOptions::default());
    keeps_the_laws(&animation, &AnimationOptions::default(), &obstacles, 0.0);
    assert!(animation.tracks.poses.iter().all(|p| holed.at(p.place).is_some_and(|z| !z.is_nan())));
    assert!(animation.report.arrivals[0].on_place > 0.9, "{:?}", animation.report.arrivals[0]);
}

#[test]
fn a_herd_of_one_walks() {
    let (terrain, none, options) = (hills(0.1), Obstacles::default(), AnimationOptions::default());
    let one = |x: f64, y: f64| vec![Ellipse { centre: Point::new(x, y), a: BODY.0, b: BODY.1, theta: 0.4 }];
    let frames = [at(10.0, one(100.0, 100.0)), via(40.0, 130.0, 140.0), at(80.0, one(200.0, 150.0))];
    let animation = walk(&terrain, &none, &frames, &options);
    keeps_the_laws(&animation, &options, &none, 0.0);
    assert_eq!(animation.report.arrivals[1].on_place, 1.0);
    assert_eq!(animation.tracks.times_s.first(), Some(&10.0));
    assert!((animation.tracks.times_s.last().unwrap() - 80.0).abs() < 1e-9);
    let last = animation.tracks.times_s.len() - 1;
    assert!(wrapped(animation.tracks.pose(last, 0).heading - 0.4).abs() < 0.4);
}

#[test]
fn a_key_frame_out_of_reach_says_how_long_it_takes() {
    let (flat, none, options) = (hills(0.0), Obstacles::default(), AnimationOptions::default());
    let frames = [
        at(0.0, herd(20, Point::new(100.0, 100.0), (4.0, 0.0), 9)),
        at(20.0, herd(20, Point::new(400.0, 100.0), (4.0, 0.0), 10)),
    ];
    let animation = walk(&flat, &none, &frames, &options);
    let arrival = &animation.report.arrivals[0];
    assert!(arrival.is_unreachable(20) && arrival.late.len() == 20);
    assert!(arrival.late.iter().all(|late| late.why == Why::Distance && late.distance_m > BODY.0));
    assert!((98.0..115.0).contains(&arrival.needed_s), "{}", arrival.needed_s);
    keeps_the_laws(&animation, &options, &none, 0.0);
}

#[test]
fn slopes_make_the_same_way_take_longer() {
    let (none, options) = (Obstacles::default(), AnimationOptions::default());
    let frames = [
        at(0.0, herd(9, Point::new(100.0, 100.0), (4.0, 0.0), 11)),
        at(60.0, herd(9, Point::new(220.0, 200.0), (4.0, 0.0), 12)),
    ];
    let needed = |slope: f64| walk(&hills(slope), &none, &frames, &options).report.arrivals[0].needed_s;
    assert!(needed(0.4) > 1.3 * needed(0.0));
}

#[test]
fn a_herd_climbs_slower_than_it_walks_on_level_ground() {
    let (none, options) = (Obstacles::default(), AnimationOptions::default());
    let ramp = |slope: f64| {
        let grid = Grid::new(120, 120, 5.0);
        Raster { grid, data: (0..grid.len()).map(|i| (slope * grid.centre(i).x) as f32).collect() }
    };
    let frames = [
        at(0.0, herd(9, Point::new(100.0, 300.0), (4.0, 0.0), 11)),
        at(30.0, herd(9, Point::new(300.0, 300.0), (4.0, 0.0), 12)),
    ];
    // Metres that the herd's middle comes in thirty seconds when it has to hurry.
    let way = |slope: f64| {
        let tracks = walk(&ramp(slope), &none, &frames, &options).tracks;
        let last = tracks.times_s.len() - 1;
        let middle = |step: usize| (0..9).map(|i| tracks.pose(step, i).place.x).sum::<f64>() / 9.0;
        middle(last) - middle(0)
    };
    // Tobler's function at rises of 0.2 and 0.4, and at a fall of 0.4, over its value on the level.
    for (slope, factor) in [(0.0, 1.0), (0.2, 0.497), (0.4, 0.247), (-0.4, 0.350)] {
        let (found, most) = (way(slope), 30.0 * 3.0 * factor);
        assert!(found <= 1.01 * most && found > 0.7 * most, "slope {slope}: {found} m of {most}");
    }
}

#[test]
fn everything_that_is_wrong_with_key_frames_and_options_is_told_at_once() {
    let flat = hills(0.0);
    let rock = Obstacles { disks: vec![(Point::new(200.0, 200.0), 10.0)], ..Obstacles::default() };
    let frames = [
        at(0.0, herd(4, Point::new(200.0, 200.0), (2.0, 0.0), 13)),
        via(-5.0, 700.0, 100.0),
        at(9.0, herd(3, Point::new(100.0, 100.0), (4.0, 0.0), 14)),
    ];
    let mut options = AnimationOptions { step_s: 9.0, ..AnimationOptions::default() };
    options.gait.max_speed_m_per_s = f64::NAN;
    let found = faults(&flat, &rock, &frames, &options);
    let of = |index: usize, animal: usize| {
        let is = |e: &AnimationError| matches!(e, AnimationError::InObstacle { index: i, animal: Some(a), .. } if (*i, *a) == (index, animal));
        found.iter().any(is)
    };
    assert!((0..4).all(|animal| of(0, animal)), "{found:?}");
    for expected in [
        |e: &AnimationError| matches!(e, AnimationError::TimesNotRising { index: 1, .. }),
        |e: &AnimationError| matches!(e, AnimationError::OffTerrain { index: 1, animal: None, .. }),
        |e: &AnimationError| matches!(e, AnimationError::NumbersDiffer { index: 2, expected: 4, found: 3 }),
        |e: &AnimationError| matches!(e, AnimationError::BadOption { field: "max_speed_m_per_s", .. }),
        |e: &AnimationError| matches!(e, AnimationError::BadOption { field: "step_s", .. }),
    ] {
        assert_eq!(found.iter().filter(|e| expected(e)).count(), 1, "{found:?}");
    }
    assert_eq!(found.len(), 9);
    // A whole herd in the rock is not a fault an animal.
    let lost = [at(0.0, herd(900, Point::new(-900.0, 0.0), (2.0, 0.0), 13)), via(9.0, 30.0, 30.0)];
    assert_eq!(faults(&flat, &rock, &lost, &AnimationOptions::default()).len(), 100);
}

#[test]
fn key_frames_that_make_no_path_are_refused_with_their_reason() {
    let flat = hills(0.0);
    let rock = Obstacles { disks: vec![(Point::new(200.0, 200.0), 10.0)], ..Obstacles::default() };
    let start = || at(0.0, herd(4, Point::new(100.0, 100.0), (4.0, 0.0), 13));
    let refuse =
        |frames: &[KeyFrame]| animate(&flat, &rock, frames, &AnimationOptions::default(), &Run::silent()).unwrap_err();
    assert!(matches!(refuse(&[start()]), AnimationError::TooFewKeyFrames { frames: 1, herds: 1 }));
    assert!(matches!(
        refuse(&[via(0.0, 9.0, 9.0), via(1.0, 20.0, 9.0)]),
        AnimationError::TooFewKeyFrames { herds: 0, .. }
    ));
    assert!(matches!(refuse(&[start(), via(0.0, 120.0, 100.0)]), AnimationError::TimesNotRising { index: 1, .. }));
    assert!(matches!(refuse(&[start(), via(f64::NAN, 120.0, 100.0)]), AnimationError::TimesNotRising { index: 1, .. }));
    assert!(matches!(refuse(&[start(), via(9.0, 700.0, 100.0)]), AnimationError::OffTerrain { index: 1, .. }));
    assert!(matches!(
        refuse(&[start(), via(9.0, 205.0, 200.0)]),
        AnimationError::InObstacle { index: 1, animal: None, .. }
    ));
    let beside = at(9.0, herd(4, Point::new(212.0, 200.0), (8.0, 0.0), 14));
    assert!(matches!(refuse(&[start(), beside]), AnimationError::InObstacle { index: 1, animal: Some(_), .. }));
    let more = at(9.0, herd(5, Point::new(150.0, 100.0), (4.0, 0.0), 14));
    assert!(matches!(refuse(&[start(), more]), AnimationError::NumbersDiffer { index: 1, expected: 4, found: 5 }));
    let wall = Obstacles {
        disks: (0..301).map(|k| (Point::new(200.0, 2.0 * f64::from(k)), 3.0)).collect(),
        ..Obstacles::default()
    };
    let cut = animate(&flat, &wall, &[start(), via(90.0, 300.0, 100.0)], &AnimationOptions::default(), &Run::silent());
    match cut {
        Err(AnimationError::NoWay { from: 0, nearest }) => assert!((nearest.x - 196.0).abs() < 3.0, "{nearest:?}"),
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_tracks_are_the_same_on_any_number_of_threads() {
    let terrain = hills(0.2);
    let obstacles = Obstacles { disks: vec![(Point::new(170.0, 150.0), 6.0)], ..Obstacles::default() };
    let frames = [
        at(0.0, herd(150, Point::new(120.0, 150.0), (3.5, 0.0), 15)),
        at(40.0, herd(150, Point::new(220.0, 160.0), (3.0, 0.3), 16)),
    ];
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| walk(&terrain, &obstacles, &frames, &AnimationOptions::default()))
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn a_stopped_animation_ends_with_a_stop() {
    let flag = StopFlag::default();
    flag.stop();
    let frames = [
        at(0.0, herd(20, Point::new(100.0, 100.0), (4.0, 0.0), 9)),
        at(90.0, herd(20, Point::new(200.0, 100.0), (4.0, 0.0), 10)),
    ];
    let stopped =
        animate(&hills(0.0), &Obstacles::default(), &frames, &AnimationOptions::default(), &Run::stoppable(flag));
    assert!(matches!(stopped, Err(AnimationError::Stopped(_))));
}

#[test]
fn the_brute_force_depth_of_these_tests_agrees_with_rims() {
    let one = Ellipse { centre: Point::default(), a: BODY.0, b: BODY.1, theta: 0.3 };
    let apart = Ellipse { centre: Point::new(1.0, 1.6), ..one };
    let deep = Ellipse { centre: Point::new(0.5, 0.6), ..one };
    assert!(depth(&one, &apart) < 0.0 && gap(&one, &apart) > 0.0);
    assert!(depth(&one, &deep) > 0.0 && gap(&one, &deep) < 0.0);
}
