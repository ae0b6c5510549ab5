//! Key-herds look like their exemplar and keep what is exact exact.

use super::herds_made::exemplar;
use biotope::compute::geometry::Bounds;
use biotope::compute::geometry::Ellipse;
use biotope::compute::geometry::Point;
use biotope::compute::geometry::Polygon;
use biotope::compute::geometry::Region;
use biotope::compute::herds::Obstacles;
use biotope::compute::herds::key_herd::DensitySource;
use biotope::compute::herds::key_herd::KeyHerd;
use biotope::compute::herds::key_herd::KeyHerdError;
use biotope::compute::herds::key_herd::KeyHerdOptions;
use biotope::compute::herds::key_herd::OrientationEdit;
use biotope::compute::herds::key_herd::Site;
use biotope::compute::herds::key_herd::key_herd;
use biotope::compute::pcf::AnalysisOptions;
use biotope::compute::pcf::Metric;
use biotope::compute::pcf::analyse_ellipses;
use biotope::compute::pcf::rms;
use biotope::compute::random::Purpose;
use biotope::compute::random::Stream;
use biotope::compute::raster::Grid;
use biotope::compute::raster::Raster;
use biotope::compute::run::Run;

fn open() -> Obstacles {
    Obstacles::default()
}

fn make(exemplar: &[Ellipse], obstacles: &Obstacles, options: &KeyHerdOptions) -> KeyHerd {
    key_herd(exemplar, Site { terrain: None, obstacles }, options, &Run::silent()).unwrap()
}

fn region(corners: &[Point]) -> Region {
    Region::from_polygons(&[Polygon { outer: corners.to_vec(), holes: Vec::new() }]).unwrap()
}

fn hull(ellipses: &[Ellipse]) -> Vec<Point> {
    let mut left: Vec<Point> = ellipses.iter().map(|e| e.centre).collect();
    left.sort_by(|p, q| p.x.total_cmp(&q.x));
    // Gift wrapping from the westernmost.
    let mut hull = vec![left[0]];
    loop {
        let from = hull[hull.len() - 1];
        let next = left
            .iter()
            .copied()
            .filter(|p| *p != from)
            .reduce(|best, p| if (best - from).cross(p - from) < 0.0 { p } else { best });
        match next {
            Some(p) if p != hull[0] => hull.push(p),
            _ => return hull,
        }
    }
}

fn angle_between(a: f64, b: f64) -> f64 {
    (a - b).sin().atan2((a - b).cos()).abs()
}

fn keeps_what_is_exact(herd: &KeyHerd, obstacles: &Obstacles, options: &KeyHerdOptions) {
    assert_eq!(herd.ellipses.len(), options.count);
    for e in &herd.ellipses {
        assert_eq!((e.a, e.b), options.body);
        assert!(!obstacles.touch(e.centre, e.b));
        let field = f64::from(herd.orientation.at(e.centre).unwrap());
        assert!(angle_between(e.theta, field) < 1f64.to_radians());
        assert!(herd.density.at(e.centre).unwrap() > 0.0);
    }
    let area = herd.density.grid.cell_area_m2();
    let integral: f64 = herd.density.data.iter().map(|d| f64::from(*d) * area).sum();
    assert!((integral / options.count as f64 - 1.0).abs() < 1e-3, "{integral}");
}

#[test]
fn number_sizes_obstacles_and_angles_are_exact_at_every_size() {
    let herd = exemplar(120, 1);
    let obstacles = Obstacles {
        disks: vec![(Point::new(3.0, 2.0), 4.0), (Point::new(-12.0, 1.0), 3.0)],
        areas: vec![Region::rectangle(Bounds::new(Point::new(8.0, -9.0), Point::new(14.0, -2.0))).unwrap()],
        mask: None,
    };
    for (count, direction) in [(1, 0.0), (2, 1.0), (5, 2.0), (40, -2.5), (120, 0.7), (400, 3.0)] {
        let options = KeyHerdOptions { count, direction, seed: 3, ..KeyHerdOptions::default() };
        keeps_what_is_exact(&make(&herd, &obstacles, &options), &obstacles, &options);
    }
}

/// The exemplar's curve, the key-herd's and that of uniform darts in the same hull with the same
/// field: rms against the first.
fn errors(herd: &[Ellipse], seed: u64) -> (f64, f64) {
    let options = KeyHerdOptions { count: herd.len(), seed, body: (2.0, 0.825), ..KeyHerdOptions::default() };
    let made = make(herd, &open(), &options);
    let target = made.report.target.as_ref().unwrap();
    let ours = rms(&made.report.curve.as_ref().unwrap().mean, &target.mean);
    let domain = region(&hull(&made.ellipses));
    let mut random = Stream::new(seed, Purpose::new("test.uniform"), 0);
    let bounds = domain.bounds();
    let mut uniform = Vec::new();
    while uniform.len() < herd.len() {
        let centre = Point::new(random.range(bounds.min.x, bounds.max.x), random.range(bounds.min.y, bounds.max.y));
        if domain.contains(centre) {
            let theta = f64::from(made.orientation.at(centre).unwrap());
            uniform.push(Ellipse { centre, a: options.body.0, b: options.body.1, theta });
        }
    }
    let options = AnalysisOptions::of(Metric::Ellipse);
    let uniform = analyse_ellipses(&uniform, &domain, &options, &Run::silent()).unwrap();
    (ours, rms(&uniform.mean, &target.mean))
}

#[test]
fn the_curve_is_at_most_a_third_as_far_from_the_exemplar_as_uniform_darts() {
    for count in [43, 220] {
        let herd = exemplar(count, 2);
        let all: Vec<(f64, f64)> = (0..5).map(|seed| errors(&herd, seed)).collect();
        let mean = |f: fn(&(f64, f64)) -> f64| all.iter().map(f).sum::<f64>() / 5.0;
        let (ours, uniform) = (mean(|e| e.0), mean(|e| e.1));
        println!("{count}: rms {ours:.4} against {uniform:.4} of uniform darts");
        assert!(ours <= uniform / 3.0, "{count}: {ours} {uniform}");
    }
}

#[test]
fn the_field_extracted_again_agrees_with_the_exemplars() {
    let herd = exemplar(220, 3);
    let options = KeyHerdOptions { count: 220, direction: 1.1, seed: 1, ..KeyHerdOptions::default() };
    let first = make(&herd, &open(), &options);
    let again = make(&first.ellipses, &open(), &KeyHerdOptions { centre: mean_place(&first.ellipses), ..options });
    // Where animals stand the two agree by themselves: what counts is all the ground between.
    let ground = (0..first.orientation.grid.len()).filter(|cell| first.density.data[*cell] > 0.0);
    let angles: Vec<f64> = ground
        .filter_map(|cell| {
            let p = first.orientation.grid.centre(cell);
            let there = again.density.at(p).is_some_and(|density| density > 0.0);
            let (one, two) = (first.orientation.data[cell], again.orientation.at(p)?);
            there.then(|| angle_between(f64::from(one), f64::from(two)))
        })
        .collect();
    let mean = angles.iter().sum::<f64>() / angles.len() as f64;
    println!("field again: {:.2}° in the mean over {} cells", mean.to_degrees(), angles.len());
    assert!(angles.len() > 10_000 && mean.to_degrees() < 10.0, "{} {}", angles.len(), mean.to_degrees());
}

fn mean_place(herd: &[Ellipse]) -> Point {
    herd.iter().fold(Point::default(), |s, e| s + e.centre) * (1.0 / herd.len() as f64)
}

/// Gaussian blur with a standard deviation of `sigma` cells, by direct sums.
fn blurred(map: &Raster<f32>, sigma: f64) -> Vec<f64> {
    let (w, h) = (map.grid.width as isize, map.grid.height as isize);
    let reach = (3.0 * sigma).ceil() as isize;
    let weights: Vec<f64> = (-reach..=reach).map(|k| (-0.5 * (k as f64 / sigma).powi(2)).exp()).collect();
    let pass = |data: &[f64], dx: isize, dy: isize| -> Vec<f64> {
        (0..w * h)
            .map(|i| {
                let (x, y) = (i % w, i / w);
                (-reach..=reach)
                    .filter(|k| (0..w).contains(&(x + k * dx)) && (0..h).contains(&(y + k * dy)))
                    .map(|k| weights[(k + reach) as usize] * data[((y + k * dy) * w + x + k * dx) as usize])
                    .sum()
            })
            .collect()
    };
    let data: Vec<f64> = map.data.iter().map(|v| f64::from(*v)).collect();
    pass(&pass(&data, 1, 0), 0, 1)
}

#[test]
fn the_density_of_the_output_follows_the_density_map() {
    let herd = exemplar(220, 4);
    let mut painted = Raster::filled(Grid::new(60, 40, 1.0), 0f32);
    for i in 0..painted.data.len() {
        let p = painted.grid.centre(i);
        painted.data[i] = (1.0 + (p.x / 6.0).sin()).max(0.0) as f32 + if p.y > 20.0 { 1.0 } else { 0.1 };
    }
    for (name, density) in [("exemplar", DensitySource::Exemplar), ("painted", DensitySource::Painted(painted))] {
        let options = KeyHerdOptions { count: 220, density, seed: 2, ..KeyHerdOptions::default() };
        let made = make(&herd, &open(), &options);
        keeps_what_is_exact(&made, &open(), &options);
        let grid = made.density.grid;
        let mut counts = Raster::filled(grid, 0f32);
        made.ellipses.iter().for_each(|e| counts.data[grid.at(e.centre).unwrap()] += 1.0);
        let inside: Vec<usize> = (0..grid.len()).filter(|i| made.density.data[*i] > 0.0).collect();
        let spacing = (inside.len() as f64 / 220.0).sqrt();
        let (map, out) = (blurred(&made.density, 2.0 * spacing), blurred(&counts, 2.0 * spacing));
        let r = correlation(&inside.iter().map(|i| (map[*i], out[*i])).collect::<Vec<_>>());
        println!("density {name}: correlation {r:.3}");
        assert!(r > 0.8, "{name}: {r}");
    }
}

fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len() as f64;
    let (mx, my) = (pairs.iter().map(|p| p.0).sum::<f64>() / n, pairs.iter().map(|p| p.1).sum::<f64>() / n);
    let sum = |f: &dyn Fn(f64, f64) -> f64| pairs.iter().map(|p| f(p.0 - mx, p.1 - my)).sum::<f64>();
    sum(&|x, y| x * y) / (sum(&|x, _| x * x) * sum(&|_, y| y * y)).sqrt()
}

#[test]
fn maps_given_back_as_they_were_give_the_same_maps() {
    let herd = exemplar(80, 5);
    let options = KeyHerdOptions { count: 80, direction: 0.4, seed: 2, ..KeyHerdOptions::default() };
    let first = make(&herd, &open(), &options);
    let back = KeyHerdOptions {
        density: DensitySource::Painted(first.density.clone()),
        orientation: Some(first.orientation.clone()),
        ..options
    };
    let second = make(&herd, &open(), &back);
    let near = |a: &Raster<f32>, b: &Raster<f32>| a.data.iter().zip(&b.data).all(|(x, y)| (x - y).abs() < 1e-4);
    assert!(near(&first.density, &second.density) && near(&first.orientation, &second.orientation));
    keeps_what_is_exact(&second, &open(), &back);
}

#[test]
fn a_uniform_flow_is_one_edit_away() {
    let herd = exemplar(60, 6);
    let options = KeyHerdOptions {
        count: 60,
        orientation_edits: vec![OrientationEdit::Blend { direction: 2.0, weight: 1.0 }],
        ..KeyHerdOptions::default()
    };
    let made = make(&herd, &open(), &options);
    assert!(made.ellipses.iter().all(|e| angle_between(e.theta, 2.0) < 1e-6));
    let rotated = KeyHerdOptions { orientation_edits: vec![OrientationEdit::Rotate { angle: 1.0 }], ..options.clone() };
    let plain = KeyHerdOptions { orientation_edits: Vec::new(), ..options };
    let turns = make(&herd, &open(), &rotated).ellipses.into_iter().zip(make(&herd, &open(), &plain).ellipses);
    let first = turns.map(|(a, b)| angle_between(a.theta, b.theta)).next().unwrap();
    assert!((first - 1.0).abs() < 1e-5);
}

#[test]
fn the_herd_looks_along_its_trajectory() {
    let herd = exemplar(100, 7);
    for direction in [0.0, 1.3, -2.9] {
        let options = KeyHerdOptions { count: 100, direction, ..KeyHerdOptions::default() };
        let made = make(&herd, &open(), &options);
        let mean = made.ellipses.iter().fold(Point::default(), |s, e| s + e.heading()).angle();
        assert!(angle_between(mean, direction) < 0.15, "{mean} {direction}");
        assert!(mean_place(&made.ellipses).norm() < 6.0);
    }
}

#[test]
fn exemplars_without_a_hull_give_herds_all_the_same() {
    let e = |x: f64| Ellipse { centre: Point::new(x, 0.5 * x), a: 8.0, b: 3.0, theta: 0.4 };
    for herd in [vec![e(0.0)], vec![e(0.0), e(30.0)], (0..7).map(|k| e(25.0 * f64::from(k))).collect()] {
        for count in [1, 7, 60] {
            let options = KeyHerdOptions { count, direction: 1.0, ..KeyHerdOptions::default() };
            let made = make(&herd, &open(), &options);
            keeps_what_is_exact(&made, &open(), &options);
            assert!(made.report.target.is_none());
            assert!(made.report.deepest_m < 0.35, "{}: {}", herd.len(), made.report.deepest_m);
        }
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let herd = exemplar(30, 8);
    let refuse = |herd: &[Ellipse], obstacles: &Obstacles, terrain: Option<&Raster<f32>>, options: &KeyHerdOptions| {
        key_herd(herd, Site { terrain, obstacles }, options, &Run::silent()).unwrap_err()
    };
    let options = KeyHerdOptions::default();
    assert_eq!(refuse(&[], &open(), None, &options), KeyHerdError::NoExemplar);
    let none = KeyHerdOptions { count: 0, ..options.clone() };
    assert!(matches!(refuse(&herd, &open(), None, &none), KeyHerdError::BadOption { field: "count", .. }));
    let small = Raster::filled(Grid::new(4, 4, 2.0), 0f32);
    let there = KeyHerdOptions { centre: Point::new(4.0, 4.0), ..options.clone() };
    match refuse(&herd, &open(), Some(&small), &there) {
        KeyHerdError::NoRoom { wanted: 100, most } => assert!(most < 20, "{most}"),
        other => panic!("{other:?}"),
    }
    let black =
        KeyHerdOptions { density: DensitySource::Painted(Raster::filled(Grid::new(9, 9, 1.0), 0.0)), ..options };
    assert_eq!(refuse(&herd, &open(), None, &black), KeyHerdError::NoDensity);
}

#[test]
fn the_herd_is_the_same_on_any_number_of_threads() {
    let herd = exemplar(80, 9);
    let options = KeyHerdOptions { count: 90, seed: 5, ..KeyHerdOptions::default() };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| make(&herd, &open(), &options))
    };
    assert_eq!(on(1), on(3));
}
