//! Correlation curves: 1 for independent patterns, spatstat's for points, independent of the
//! border.

use biotope::compute::geometry::Bounds;
use biotope::compute::geometry::Point;
use biotope::compute::geometry::Polygon;
use biotope::compute::geometry::Region;
use biotope::compute::pcf;
use biotope::compute::pcf::AnalysisOptions;
use biotope::compute::pcf::Axis;
use biotope::compute::pcf::Dependencies;
use biotope::compute::pcf::Element;
use biotope::compute::pcf::Metric;
use biotope::compute::random::Purpose;
use biotope::compute::random::Stream;
use biotope::compute::run::Run;
use rayon::prelude::*;
use serde_json::Value;

fn rectangle(x: f64, y: f64) -> Region {
    Region::rectangle(Bounds::new(Point::default(), Point::new(x, y))).unwrap()
}

fn polygon(places: &[(f64, f64)]) -> Region {
    let outer = places.iter().map(|(x, y)| Point::new(*x, *y)).collect();
    Region::from_polygons(&[Polygon { outer, holes: Vec::new() }]).unwrap()
}

fn l_shape() -> Region {
    polygon(&[(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)])
}

fn cross() -> Region {
    let (a, b, c) = (1.0, 2.0, 3.0);
    polygon(&[(a, 0.0), (b, 0.0), (b, a), (c, a), (c, b), (b, b), (b, c), (a, c), (a, b), (0.0, b), (0.0, a), (a, a)])
}

fn with_hole() -> Region {
    rectangle(2.0, 2.0).minus(&polygon(&[(0.6, 0.6), (1.4, 0.6), (1.4, 1.4), (0.6, 1.4)])).unwrap()
}

fn uniform(region: &Region, count: usize, random: &mut Stream) -> Vec<Point> {
    let b = region.bounds();
    std::iter::repeat_with(|| Point::new(random.range(b.min.x, b.max.x), random.range(b.min.y, b.max.y)))
        .filter(|p| region.contains(*p))
        .take(count)
        .collect()
}

fn stream(name: &'static str, seed: u64) -> Stream {
    Stream::new(seed, Purpose::new(name), 0)
}

fn points(places: &[Point]) -> Vec<Element> {
    places.iter().map(|p| Element { centre: *p, radius: 0.0, class: 0 }).collect()
}

/// The single curve of a pattern of points.
fn point_curve(places: &[Point], domain: &Region) -> Vec<f64> {
    let graph = Dependencies::new(1, &[]).unwrap();
    let options = AnalysisOptions::of(Metric::Point);
    pcf::analyse(&points(places), domain, (&graph, &options), &Run::silent()).unwrap().curves[0].mean.clone()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn places(value: &Value) -> Vec<Point> {
    numbers(&value["x"]).into_iter().zip(numbers(&value["y"])).map(|(x, y)| Point::new(x, y)).collect()
}

/// spatstat's curve as ours: g(r)·2πr/M(r).
fn as_ours(g: &[f64]) -> Vec<f64> {
    let axis = Axis::default();
    let mass = pcf::mass::of_points(&axis);
    g.iter().enumerate().map(|(bin, g)| g * std::f64::consts::TAU * axis.r(bin) / mass[bin]).collect()
}

/// The largest difference, relative to the curve's larger values.
fn assert_close(ours: &[f64], theirs: &[f64], tolerance: f64, name: &str) {
    for (bin, (a, b)) in ours.iter().zip(theirs).enumerate() {
        let allowed = tolerance * b.max(1.0);
        assert!((a - b).abs() <= allowed, "{name}, place {bin}: {a} against {b}");
    }
}

/// spatstat sums its kernel over a grid of distances by a Fourier transform, which is where the
/// two differ: see the README for the largest difference found.
const SPATSTAT_TOLERANCE: f64 = 0.005;

#[test]
fn curves_of_five_generated_patterns_agree_with_spatstat() {
    let reference: Value = serde_json::from_str(include_str!("reference/pcf_reference.json")).unwrap();
    for (name, pattern) in reference.as_object().unwrap() {
        let window = numbers(&pattern["window"]);
        let bounds = Bounds::new(Point::new(window[0], window[1]), Point::new(window[2], window[3]));
        let domain = Region::rectangle(bounds).unwrap();
        let ours = match pattern.get("parents") {
            None => point_curve(&places(pattern), &domain),
            Some(parents) => cross_curve(&places(pattern), &places(parents), &domain),
        };
        assert_close(&ours, &as_ours(&numbers(&pattern["g"])), SPATSTAT_TOLERANCE, name);
    }
}

/// The curve of the `children` looking at the `parents`.
fn cross_curve(children: &[Point], parents: &[Point], domain: &Region) -> Vec<f64> {
    let mut elements = points(parents);
    elements.extend(children.iter().map(|p| Element { centre: *p, radius: 0.0, class: 1 }));
    let graph = Dependencies::new(2, &[(1, 0)]).unwrap();
    let options = AnalysisOptions::of(Metric::Point);
    let analysis = pcf::analyse(&elements, domain, (&graph, &options), &Run::silent()).unwrap();
    analysis.curve(1, 0).unwrap().mean.clone()
}

/// Curves of one class each: (its name in the reference, file, column and value of the class, window).
const STANDS: [(&str, &str, &str, [f64; 4]); 7] = [
    ("finpines", "finpines.csv", "", [-5.0, -8.0, 5.0, 2.0]),
    ("longleaf", "longleaf.csv", "", [0.0, 0.0, 200.0, 200.0]),
    ("cells", "cells.csv", "", [0.0, 0.0, 1.0, 1.0]),
    ("anemones", "anemones.csv", "", [0.0, 0.0, 280.0, 180.0]),
    ("lansing_hickory", "lansing.csv", "hickory", [0.0, 0.0, 1.0, 1.0]),
    ("lansing_maple", "lansing.csv", "maple", [0.0, 0.0, 1.0, 1.0]),
    ("lansing_blackoak", "lansing.csv", "blackoak", [0.0, 0.0, 1.0, 1.0]),
];

#[test]
fn curves_of_the_stands_agree_with_spatstat_where_the_stands_are_present() {
    let data = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let Ok(reference) = std::fs::read_to_string(data.join("ref/pcf_spatstat.json")) else { return };
    let reference: Value = serde_json::from_str(&reference).unwrap();
    for (name, file, class, window) in STANDS {
        let text = std::fs::read_to_string(data.join("stands").join(file)).unwrap();
        let row = |line: &str| {
            let fields: Vec<&str> = line.split(',').collect();
            let of_class = class.is_empty() || fields[2].trim_matches('"') == class;
            of_class.then(|| Point::new(fields[0].parse().unwrap(), fields[1].parse().unwrap()))
        };
        let places: Vec<Point> = text.lines().skip(1).filter_map(row).collect();
        let bounds = Bounds::new(Point::new(window[0], window[1]), Point::new(window[2], window[3]));
        let ours = point_curve(&places, &Region::rectangle(bounds).unwrap());
        assert_close(&ours, &as_ours(&numbers(&reference[name]["g"])), SPATSTAT_TOLERANCE, name);
    }
}

#[test]
fn a_border_learnt_from_300_points_has_the_area_and_the_curve_of_the_domain() {
    for (name, domain) in [("rectangle", rectangle(1.5, 1.0)), ("L", l_shape()), ("cross", cross())] {
        let mut area = 0.0;
        let mut mean = vec![0.0; 50];
        for seed in 0..60 {
            let places = uniform(&domain, 300, &mut stream("learnt", seed));
            let learnt = pcf::learn_border(&places, &pcf::BorderOptions::default()).unwrap();
            area += learnt.area() / domain.area() / 60.0;
            for (m, v) in mean.iter_mut().zip(point_curve(&places, &learnt)) {
                *m += v / 60.0;
            }
        }
        assert!((area - 1.0).abs() < 0.05, "{name}: area {area}");
        for (bin, value) in mean.iter().enumerate().skip(1) {
            assert!((value - 1.0).abs() < 0.05, "{name}, place {bin}: {value} (area {area})");
        }
    }
}

/// Patterns that are cut.
const CUT: [(&str, fn(&mut Stream) -> Vec<Point>); 4] =
    [("uniform", uniform_600), ("hard-core", hard_core), ("clustered", clustered), ("lattice", lattice)];

/// Patterns of each kind.
const CUTS: u64 = 48;

#[test]
fn a_pattern_cut_by_a_hole_or_a_cross_keeps_its_curve() {
    // As T figure 3.5: one pattern, whole or with a part cut away, its border learnt each time.
    let hole = |p: &Point| p.distance(Point::new(0.5, 0.5)) >= 0.22;
    let cross = |p: &Point| (0.3..=0.7).contains(&p.x) || (0.3..=0.7).contains(&p.y);
    let off = |(kind, draw): &(&str, fn(&mut Stream) -> Vec<Point>)| {
        let mut sums = [vec![0.0; 50], vec![0.0; 50], vec![0.0; 50]];
        for seed in 0..CUTS {
            let places = draw(&mut stream("cut", seed));
            let cut = [
                places.clone(),
                places.iter().copied().filter(hole).collect(),
                places.iter().copied().filter(cross).collect(),
            ];
            for (sum, places) in sums.iter_mut().zip(&cut) {
                let learnt = pcf::learn_border(places, &pcf::BorderOptions::default()).unwrap();
                sum.iter_mut().zip(point_curve(places, &learnt)).for_each(|(s, v)| *s += v / CUTS as f64);
            }
        }
        let [whole, hole, cross] = sums;
        let places = (0..50).flat_map(|bin| [("hole", bin, hole[bin]), ("cross", bin, cross[bin])]);
        let off = places.filter(|(_, bin, value)| (value - whole[*bin]).abs() >= 0.05);
        off.map(|(name, bin, value)| format!("{kind}, {name}, place {bin}: {value} of {}", whole[bin])).collect()
    };
    let failed: Vec<Vec<String>> = CUT.par_iter().map(off).collect();
    assert!(failed.iter().all(Vec::is_empty), "{failed:#?}");
}

fn unit_square() -> Region {
    rectangle(1.0, 1.0)
}

fn uniform_600(random: &mut Stream) -> Vec<Point> {
    uniform(&unit_square(), 600, random)
}

/// 600 points at least 0.7 of a spacing apart, by sequential inhibition.
fn hard_core(random: &mut Stream) -> Vec<Point> {
    let least = 0.7 / 600.0_f64.sqrt();
    let mut places: Vec<Point> = Vec::new();
    while places.len() < 600 {
        let p = Point::new(random.unit(), random.unit());
        if places.iter().all(|q| q.distance(p) >= least) {
            places.push(p);
        }
    }
    places
}

/// Some 600 points in groups of about six around uniform places, some of them outside.
fn clustered(random: &mut Stream) -> Vec<Point> {
    let mut places = Vec::new();
    for parent in uniform(&rectangle(1.4, 1.4), 200, random) {
        for _ in 0..random.below(13) {
            places.push(parent - Point::new(0.2, 0.2) + Point::new(random.normal(), random.normal()) * 0.04);
        }
    }
    places.retain(|p| unit_square().contains(*p));
    places
}

/// A hexagonal lattice of about 600 points, each a little off its place, laid anyhow.
fn lattice(random: &mut Stream) -> Vec<Point> {
    let spacing = pcf::maximal_spacing(1.0, 600);
    let (offset, turn) = (Point::new(random.unit(), random.unit()), Point::from_angle(random.range(0.0, 6.3)));
    let mut places = Vec::new();
    for row in -60..60 {
        for column in -60..60 {
            let jitter = Point::new(random.normal(), random.normal()) * 0.1;
            let column = f64::from(column) + 0.5 * f64::from(row % 2);
            let p = (Point::new(column, f64::from(row) * 0.75_f64.sqrt()) + offset + jitter) * spacing;
            places.push(Point::new(p.dot(turn), p.cross(turn)) + Point::new(0.5, 0.5));
        }
    }
    places.retain(|p| unit_square().contains(*p));
    places
}

#[test]
fn the_hexagonal_lattice_has_its_known_curve() {
    // Closed form of the infinite lattice smoothed with σ = 0.25: 1.867 at 1, 0.336 at 1.4, 1.510 at 1.8.
    let mut places = Vec::new();
    for row in 0..40 {
        for column in 0..40 {
            let x = f64::from(column) + 0.5 * f64::from(row % 2);
            places.push(Point::new(x + 0.25, (f64::from(row) + 0.5) * 3.0_f64.sqrt() / 2.0));
        }
    }
    let curve = point_curve(&places, &rectangle(40.0, 20.0 * 3.0_f64.sqrt()));
    for (bin, expected) in [(9, 1.867), (13, 0.336), (17, 1.510)] {
        assert!((curve[bin] - expected).abs() < 0.02, "{}: {} {expected}", bin + 1, curve[bin]);
    }
}

#[test]
fn one_thread_and_two_give_the_same_curves() {
    let domain = with_hole();
    let places = uniform(&domain, 200, &mut stream("threads", 1));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| point_curve(&places, &domain))
    };
    assert_eq!(with(1), with(2));
}
