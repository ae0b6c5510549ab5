//! New arrangements: they keep the curves, the look, the domain, and what was there.

use crate::science::distributions_exemplars as exemplars;
use biotope::compute::geometry::Bounds;
use biotope::compute::geometry::Point;
use biotope::compute::geometry::Polygon;
use biotope::compute::geometry::Region;
use biotope::compute::pcf;
use biotope::compute::pcf::AnalysisOptions;
use biotope::compute::pcf::BorderOptions;
use biotope::compute::pcf::Dependencies;
use biotope::compute::pcf::Element;
use biotope::compute::pcf::InpaintingOptions;
use biotope::compute::pcf::Known;
use biotope::compute::pcf::Metric;
use biotope::compute::pcf::PcfError;
use biotope::compute::pcf::Synthesis;
use biotope::compute::pcf::SynthesisOptions;
use biotope::compute::pcf::Target;
use biotope::compute::random::Purpose;
use biotope::compute::random::Stream;
use biotope::compute::raster::Grid;
use biotope::compute::raster::Raster;
use biotope::compute::run::Run;
use biotope::compute::run::StopFlag;
use exemplars::Exemplar;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::sync::Arc;
use std::sync::Mutex;

fn again(exemplar: &Exemplar, seed: u64) -> Synthesis {
    let options = SynthesisOptions { seed, ..SynthesisOptions::default() };
    pcf::synthesise(&exemplar.analysed(), &exemplar.target(), &options, &Run::silent()).unwrap()
}

fn of_class(elements: &[Element], class: usize) -> Vec<Element> {
    elements.iter().filter(|e| e.class == class).copied().collect()
}

#[test]
fn a_hexagonal_grid_ends_within_its_bound_with_no_two_points_on_top_of_each_other() {
    let grid = exemplars::hexagonal();
    let result = again(&grid, 1);
    let placed = result.elements.len();
    assert_eq!(placed + result.classes[0].missing, grid.elements.len());
    assert!(placed as f64 >= 0.95 * grid.elements.len() as f64);
    for (i, a) in result.elements.iter().enumerate() {
        assert!(result.elements[..i].iter().all(|b| a.centre.distance(b.centre) >= 0.5 - 1e-9));
    }
    let exemplar_curve = &grid.analysed().curves[0];
    assert!(result.classes[0].outside > 0 || result.curves[0].curve.rms_error(exemplar_curve) > 0.0);
}

#[test]
fn one_thread_and_two_give_the_same_elements() {
    let nested = exemplars::nested(2);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let options = SynthesisOptions { block_elements: 20, outlier_rounds: 1, ..SynthesisOptions::default() };
            pcf::synthesise(&nested.analysed(), &nested.target(), &options, &Run::silent()).unwrap().elements
        })
    };
    assert_eq!(with(1), with(2));
}

#[test]
fn fixed_elements_stay_and_count() {
    let forest = exemplars::forest(3);
    let analysis = forest.analysed();
    let fixed: Vec<Element> = forest.of_class(0).into_iter().take(30).collect();
    let target = Target { fixed: &fixed, ..forest.target() };
    let result = pcf::synthesise(&analysis, &target, &SynthesisOptions::default(), &Run::silent()).unwrap();
    assert_eq!(result.elements[..30], fixed[..]);
    assert_eq!(result.elements.len(), 460);
    let trees = of_class(&result.elements, 0);
    for (i, a) in trees.iter().enumerate() {
        for b in &trees[..i] {
            assert!(a.centre.distance(b.centre) > (a.radius + b.radius) * 0.9, "trees in trees");
        }
    }
}

#[test]
fn a_painted_density_is_followed_and_bars_its_zeros() {
    let mut random = Stream::new(1, Purpose::new("test.painted"), 0);
    let mut place = || Point::new(random.range(0.0, 10.0), random.range(0.0, 10.0));
    let elements: Vec<Element> = (0..200).map(|_| Element { centre: place(), radius: 0.0, class: 0 }).collect();
    let domain = exemplars::rectangle(10.0, 10.0);
    let graph = Dependencies::new(1, &[]).unwrap();
    let options = AnalysisOptions::of(Metric::Point);
    let analysis = pcf::analyse(&elements, &domain, (&graph, &options), &Run::silent()).unwrap();
    // Three strips of densities 0, 1 and 3.
    let grid = Grid::new(30, 30, 1.0 / 3.0);
    let paint = |i: usize| [0.0_f32, 1.0, 3.0][grid.cell(i).column / 10];
    let painted = Raster::from_data(grid, (0..grid.len()).map(paint).collect()).unwrap();
    let target = Target { domain: &domain, room: None, density: Some(&painted), fixed: &[], counts: vec![400] };
    let result = pcf::synthesise(&analysis, &target, &SynthesisOptions::default(), &Run::silent()).unwrap();
    let between = |a: f64, b: f64| result.elements.iter().filter(|e| (a..b).contains(&e.centre.x)).count();
    assert_eq!(result.elements.len(), 400);
    assert!(between(0.0, 3.1) == 0, "{} in the barred strip", between(0.0, 3.1));
    let share = between(6.8, 10.0) as f64 / 400.0;
    assert!((share - 0.75).abs() < 0.06, "{share}");
    let nothing = Raster::filled(grid, 0.0_f32);
    let barred = Target { density: Some(&nothing), ..target };
    let refused = pcf::synthesise(&analysis, &barred, &SynthesisOptions::default(), &Run::silent());
    assert!(matches!(refused, Err(PcfError::BadDensity { .. })));
}

#[test]
fn holes_are_filled_and_what_was_there_stays() {
    let forest = exemplars::forest(4);
    let hole = |e: &&Element| e.centre.distance(Point::new(55.0, 50.0)) >= 25.0;
    let left: Vec<Element> = forest.elements.iter().filter(hole).copied().collect();
    let options = InpaintingOptions {
        known: Known::Learnt(BorderOptions::default()),
        analysis: AnalysisOptions::of(Metric::Disk),
        synthesis: SynthesisOptions::default(),
    };
    let result = pcf::inpaint(&left, &forest.domain, (&forest.graph, &options), &Run::silent()).unwrap();
    assert_eq!(result.synthesis.elements[..left.len()], left[..]);
    let new = &result.synthesis.elements[left.len()..];
    let missing = forest.elements.len() - left.len();
    assert!((new.len() as f64 - missing as f64).abs() < 0.35 * missing as f64, "{} for {missing}", new.len());
    assert!(new.iter().all(|e| !result.known.contains(e.centre)));
    let filled = new.iter().filter(|e| e.centre.distance(Point::new(55.0, 50.0)) < 25.0).count();
    assert!(filled as f64 > 0.7 * new.len() as f64, "{filled} of {}", new.len());
}

#[test]
fn what_keeps_to_the_rim_of_trees_does_so_in_holes_and_at_the_border() {
    // A round hole, in which trees are laid out too, and a strip along the border with hardly any of
    // them, where those that are cut off could stand outside.
    let forest = exemplars::forest(1);
    let strip = Region::rectangle(Bounds::new(Point::new(95.0, 0.0), Point::new(100.0, 100.0))).unwrap();
    let hole = disk_region(Point::new(45.0, 50.0), 16.0);
    let known = forest.domain.minus(&strip).and_then(|rest| rest.minus(&hole)).unwrap();
    let left: Vec<Element> = forest.elements.iter().filter(|e| known.contains(e.centre)).copied().collect();
    let inpaint = |seed: u64| {
        let options = InpaintingOptions {
            known: Known::Region(known.clone()),
            analysis: AnalysisOptions::of(Metric::Disk),
            synthesis: SynthesisOptions { seed, ..SynthesisOptions::default() },
        };
        pcf::inpaint(&left, &forest.domain, (&forest.graph, &options), &Run::silent()).unwrap().synthesis
    };
    let (mut error, mut astray, mut in_hole, mut new) = (0.0, 0, 0, 0);
    for result in (1..=6).into_par_iter().map(inpaint).collect::<Vec<Synthesis>>() {
        let trees = of_class(&result.elements, 0);
        let is_astray = |e: &&Element| trees.iter().all(|t| (t.centre.distance(e.centre) - t.radius).abs() > 1.5);
        let mushrooms = of_class(&result.elements[left.len()..], 2);
        astray += mushrooms.iter().filter(is_astray).count();
        in_hole += mushrooms.iter().filter(is_astray).filter(|e| hole.contains(e.centre)).count();
        new += mushrooms.len();
        error += result.curves.iter().find(|c| (c.curve.child, c.curve.parent) == (2, 0)).unwrap().after / 6.0;
    }
    println!("{error:.2}, {astray} of {new} astray, {in_hole} of them in the hole");
    assert!(error < 0.8 && astray * 4 < new && in_hole <= 3, "{error}: {astray} of {new}, {in_hole} in the hole");
}

#[test]
fn what_keeps_to_the_rim_of_trees_does_so_along_the_borders_of_another_domain() {
    // A hole to lie along, away from any tree: there circles are cut off, and who is alone is not.
    let forest = exemplars::forest(1);
    let corner = Region::rectangle(Bounds::new(Point::new(75.0, 75.0), Point::new(150.0, 150.0))).unwrap();
    let square = exemplars::rectangle(150.0, 150.0);
    let domain = square.minus(&corner).and_then(|l| l.minus(&disk_region(Point::new(40.0, 40.0), 18.0))).unwrap();
    let times = domain.area() / forest.domain.area();
    let counts = forest.counts().iter().map(|count| (*count as f64 * times) as usize).collect();
    let (analysis, target) = (forest.analysed(), Target { domain: &domain, counts, ..forest.target() });
    let lay_out = |seed: u64| {
        let options = SynthesisOptions { seed, ..SynthesisOptions::default() };
        pcf::synthesise(&analysis, &target, &options, &Run::silent()).unwrap()
    };
    let (mut astray, mut all) = (0, 0);
    for result in (1..=4).into_par_iter().map(lay_out).collect::<Vec<Synthesis>>() {
        let trees = of_class(&result.elements, 0);
        let is_astray = |e: &&Element| trees.iter().all(|t| (t.centre.distance(e.centre) - t.radius).abs() > 1.5);
        let mushrooms = of_class(&result.elements, 2);
        astray += mushrooms.iter().filter(is_astray).count();
        all += mushrooms.len();
    }
    println!("{astray} of {all} astray");
    assert!(astray * 100 < all, "{astray} of {all}");
}

fn disk_region(centre: Point, radius: f64) -> Region {
    let corner = |k: i32| centre + Point::from_angle(f64::from(k) * TAU / 48.0) * radius;
    let outer = (0..48).map(corner).collect();
    Region::from_polygons(&[Polygon { outer, holes: Vec::new() }]).unwrap()
}

#[test]
fn where_every_point_of_the_exemplar_has_company_hardly_any_of_the_output_is_alone() {
    // Pairs of any width: at every single distance most points have nobody.
    let mut random = Stream::new(5, Purpose::new("test.pairs"), 0);
    let mut elements: Vec<Element> = Vec::new();
    for _ in 0..60 {
        let first = Point::new(random.range(0.0, 10.0), random.range(0.0, 10.0));
        let second = first + Point::from_angle(random.range(0.0, TAU)) * random.range(0.05, 0.6);
        let inside = |p: &Point| (0.0..10.0).contains(&p.x) && (0.0..10.0).contains(&p.y);
        let pair = [first, second].into_iter().filter(inside).map(|centre| Element { centre, radius: 0.0, class: 0 });
        elements.extend(pair);
    }
    let pairs = Exemplar {
        name: "pairs".into(),
        elements,
        domain: exemplars::rectangle(10.0, 10.0),
        graph: Dependencies::new(1, &[]).unwrap(),
        metric: Metric::Point,
    };
    let alone = |elements: &[Element]| {
        let is_alone = |e: &&Element| {
            let clear = pairs.domain.clearance(e.centre, 1.0) > 0.9;
            clear && elements.iter().all(|o| o == *e || o.centre.distance(e.centre) > 0.9)
        };
        elements.iter().filter(is_alone).count()
    };
    assert_eq!(alone(&pairs.elements), 0);
    let outputs: Vec<Synthesis> = (1..=6).into_par_iter().map(|seed| again(&pairs, seed)).collect();
    let found: usize = outputs.iter().map(|o| alone(&o.elements)).sum();
    println!("{found} alone in six outputs");
    assert!(found <= 6, "{found}");
}

#[test]
fn a_pattern_of_two_kinds_is_taken_apart() {
    // Tight clusters on the left, an even spread on the right (T figure 3.7).
    let mut random = Stream::new(3, Purpose::new("test.two-kinds"), 0);
    let mut elements: Vec<Element> = Vec::new();
    for _ in 0..15 {
        let centre = Point::new(random.range(0.5, 4.5), random.range(0.5, 9.5));
        for _ in 0..10 {
            let place = centre + Point::new(random.normal(), random.normal()) * 0.12;
            elements.push(Element { centre: place, radius: 0.0, class: 0 });
        }
    }
    for k in 0..150 {
        let place = Point::new(5.4 + f64::from(k % 10) * 0.5, 0.3 + f64::from(k / 10) * 0.65);
        let moved = place + Point::new(random.range(-0.1, 0.1), random.range(-0.1, 0.1));
        elements.push(Element { centre: moved, radius: 0.0, class: 0 });
    }
    let domain =
        pcf::learn_border(&elements.iter().map(|e| e.centre).collect::<Vec<Point>>(), &BorderOptions::default())
            .unwrap();
    let options = AnalysisOptions::of(Metric::Point);
    let found = pcf::decompose(&elements, &domain, (2, 7, &options), &Run::silent()).unwrap();
    let left = found.labels[..150].iter().filter(|l| **l == found.labels[0]).count();
    let agreeing = left + found.labels[150..].iter().filter(|l| **l != found.labels[0]).count();
    assert!(agreeing >= 270, "{agreeing} of 300");
    assert_eq!(found, pcf::decompose(&elements, &domain, (2, 7, &options), &Run::silent()).unwrap());
    for bad in [0, 301] {
        let refused = pcf::decompose(&elements, &domain, (bad, 7, &options), &Run::silent());
        assert!(matches!(refused, Err(PcfError::BadClusterCount { .. })));
    }
}

#[test]
fn a_larger_domain_of_many_blocks_shows_no_seams() {
    // Hard-core points: near the seams nothing may be nearer or farther than elsewhere.
    let exemplar = exemplars::hard_core(300, 5);
    let analysis = exemplar.analysed();
    let domain = exemplars::rectangle(40.0, 40.0);
    let target = Target { domain: &domain, room: None, density: None, fixed: &[], counts: vec![4800] };
    let options = SynthesisOptions { block_elements: 300, outlier_rounds: 1, ..SynthesisOptions::default() };
    let result = pcf::synthesise(&analysis, &target, &options, &Run::silent()).unwrap();
    assert_eq!(result.elements.len(), 4800);
    // Blocks are about 10 m wide, the last ones cut off.
    let to_seam = |p: Point| {
        let off = |v: f64| (v / 9.93 - (v / 9.93).round()).abs() * 9.93;
        off(p.x).min(off(p.y))
    };
    let nearest = |e: &Element| {
        let others = result.elements.iter().filter(|o| *o != e);
        others.map(|o| o.centre.distance(e.centre)).fold(f64::INFINITY, f64::min)
    };
    let is_inner = |p: Point| (1.0..38.5).contains(&p.x) && (1.0..38.5).contains(&p.y);
    let share_of = |near: &dyn Fn(f64) -> bool| {
        let places = (0..40_000).map(|k| Point::new(f64::from(k % 200) + 0.5, f64::from(k / 200) + 0.5) * 0.2);
        places.filter(|p| is_inner(*p) && near(to_seam(*p))).count() as f64
    };
    let at_seam = |d: f64| d < 0.4;
    let off_seam = |d: f64| d > 1.5;
    let of = |near: &dyn Fn(f64) -> bool| {
        let chosen = result.elements.iter().filter(|e| is_inner(e.centre) && near(to_seam(e.centre)));
        chosen.map(nearest).collect::<Vec<f64>>()
    };
    let mean = |list: &[f64]| list.iter().sum::<f64>() / list.len() as f64;
    let (at, off) = (of(&at_seam), of(&off_seam));
    let density = (at.len() as f64 / share_of(&at_seam)) / (off.len() as f64 / share_of(&off_seam));
    assert!((mean(&at) / mean(&off) - 1.0).abs() < 0.05, "{} {}", mean(&at), mean(&off));
    assert!((density - 1.0).abs() < 0.12, "{density}");
}

#[test]
fn blocks_are_as_dense_at_the_border_of_the_domain_as_within() {
    // Uniform points in four times their domain, by four blocks and then nine.
    let mut random = Stream::new(1, Purpose::new("test.border-strip"), 0);
    let mut place = || Point::new(random.range(0.0, 10.0), random.range(0.0, 10.0));
    let elements: Vec<Element> = (0..300).map(|_| Element { centre: place(), radius: 0.0, class: 0 }).collect();
    let (small, domain) = (exemplars::rectangle(10.0, 10.0), exemplars::rectangle(20.0, 20.0));
    let graph = Dependencies::new(1, &[]).unwrap();
    let options = AnalysisOptions { triplets: true, ..AnalysisOptions::of(Metric::Point) };
    let analysis = pcf::analyse(&elements, &small, (&graph, &options), &Run::silent()).unwrap();
    let target = Target { domain: &domain, room: None, density: None, fixed: &[], counts: vec![1200] };
    // After the darts, and at the end.
    for (outlier_rounds, seeds) in [(0, 1..5), (2, 1..4)] {
        let (width, runs) = (0.3, seeds.end - seeds.start);
        let in_strip = |seed: u64| {
            let options = SynthesisOptions { seed, block_elements: 300, outlier_rounds, ..SynthesisOptions::default() };
            let result = pcf::synthesise(&analysis, &target, &options, &Run::silent()).unwrap();
            result.elements.iter().filter(|e| domain.clearance(e.centre, 1.0) < width).count()
        };
        let found = seeds.map(in_strip).sum::<usize>() as f64;
        let expected = f64::from(runs as u32) * 1200.0 * (1.0 - (20.0 - 2.0 * width).powi(2) / 400.0);
        // Counts of independent points vary by their root.
        assert!((found - expected).abs() < 4.0 * expected.sqrt(), "{found} for {expected} after {outlier_rounds}");
    }
}

#[test]
fn elements_that_keep_apart_are_as_dense_at_the_border_of_the_domain_as_within() {
    // An element at the border keeps others off half as much ground, and so saves room.
    let (domain, seeds) = (exemplars::rectangle(20.0, 10.0), 1..4);
    for (metric, block_elements) in
        [(Metric::Point, 250), (Metric::Disk, 250), (Metric::Point, 2000), (Metric::Disk, 2000)]
    {
        let (mut found, mut expected) = (0.0, 0.0);
        for seed in seeds.clone() {
            let exemplar = exemplars::cut_out_of_more(metric, seed);
            let count = 2 * exemplar.elements.len();
            let target = Target { domain: &domain, room: None, density: None, fixed: &[], counts: vec![count] };
            let options = SynthesisOptions { seed, block_elements, outlier_rounds: 1, ..SynthesisOptions::default() };
            let result = pcf::synthesise(&exemplar.analysed(), &target, &options, &Run::silent()).unwrap();
            let width = 0.2 * pcf::maximal_spacing(domain.area(), count);
            found += result.elements.iter().filter(|e| domain.clearance(e.centre, 1.0) < width).count() as f64;
            expected += count as f64 * (1.0 - (1.0 - 2.0 * width / 20.0) * (1.0 - 2.0 * width / 10.0));
        }
        println!("{metric:?} by {block_elements}: {found} for {expected:.1}");
        // Counts of independent elements vary by their root, of these by less.
        assert!(
            (found - expected).abs() < 3.0 * expected.sqrt(),
            "{metric:?} by {block_elements}: {found} for {expected}"
        );
    }
}

#[test]
fn by_blocks_no_curve_ends_worse_than_it_began() {
    let (forest, nests, points) = (exemplars::forest(2), exemplars::nested(3), exemplars::hard_core(300, 2));
    for (exemplar, block_elements) in [(&forest, 60), (&nests, 25), (&points, 80)] {
        for seed in 1..3 {
            let options = SynthesisOptions { seed, block_elements, ..SynthesisOptions::default() };
            let result = pcf::synthesise(&exemplar.analysed(), &exemplar.target(), &options, &Run::silent()).unwrap();
            for report in &result.curves {
                let (name, before, after) = ((report.curve.child, report.curve.parent), report.before, report.after);
                println!("{} {name:?} seed {seed}: {before:.4} became {after:.4}", exemplar.name);
                assert!(after <= before + 1e-9, "{} {name:?}: {before} became {after}", exemplar.name);
            }
        }
    }
}

#[test]
fn in_a_larger_domain_by_small_blocks_no_curve_ends_worse_than_it_began() {
    // Every block meets the curve by itself and shifts what its neighbours see.
    let domain = exemplars::rectangle(26.0, 26.0);
    for exemplar in [exemplars::scattered(false, 3), exemplars::scattered(true, 3)] {
        let target = Target { domain: &domain, room: None, density: None, fixed: &[], counts: vec![2028] };
        for seed in 1..3 {
            let options = SynthesisOptions { seed, block_elements: 150, ..SynthesisOptions::default() };
            let result = pcf::synthesise(&exemplar.analysed(), &target, &options, &Run::silent()).unwrap();
            let (before, after) = (result.curves[0].before, result.curves[0].after);
            println!("{} seed {seed}: {before:.4} became {after:.4}", exemplar.name);
            assert!(after <= before, "{}: {before} became {after}", exemplar.name);
        }
    }
}

#[test]
fn groups_by_blocks_leave_no_voids_and_draw_no_lines() {
    // Sixteen times the exemplar's square by nine blocks, in each of which groups are alike.
    let (side, across) = (40.0, 3.0);
    let exemplar = exemplars::scattered(true, 3);
    let domain = exemplars::rectangle(side, side);
    let target = Target { domain: &domain, room: None, density: None, fixed: &[], counts: vec![4800] };
    let options = SynthesisOptions { block_elements: 600, outlier_rounds: 1, ..SynthesisOptions::default() };
    let result = pcf::synthesise(&exemplar.analysed(), &target, &options, &Run::silent()).unwrap();
    // As many in every square of the exemplar's size, but for what independent groups of six vary by.
    let mut tiles = [0; 16];
    let tile = |v: f64| ((v / 10.0) as usize).min(3);
    result.elements.iter().for_each(|e| tiles[tile(e.centre.x) + 4 * tile(e.centre.y)] += 1);
    assert!(tiles.iter().all(|count| (175..425).contains(count)), "{tiles:?}");
    // And along the seams as many as elsewhere.
    let off = |v: f64| {
        let seam = (v * across / side).round().clamp(1.0, across - 1.0) * side / across;
        (v - seam).abs()
    };
    let near = |p: Point| off(p.x).min(off(p.y)) < 0.25;
    let found = result.elements.iter().filter(|e| near(e.centre)).count() as f64;
    let expected = 4800.0 * (1.0 - (1.0 - 2.0 * (across - 1.0) * 0.25 / side).powi(2));
    assert!((0.65..1.4).contains(&(found / expected)), "{found} for {expected} along seams");
    println!("{tiles:?}, {:.2} along seams", found / expected);
}

#[test]
fn progress_of_a_synthesis_by_blocks_is_fine_and_never_falls() {
    let exemplar = exemplars::hard_core(100, 1);
    let domain = exemplars::rectangle(30.0, 30.0);
    let target = Target { domain: &domain, room: None, density: None, fixed: &[], counts: vec![900] };
    let options = SynthesisOptions { block_elements: 50, outlier_rounds: 1, ..SynthesisOptions::default() };
    let told = Arc::new(Mutex::new(Vec::new()));
    let sink = Arc::clone(&told);
    let run = Run::new(StopFlag::default(), move |p| {
        if p.stage == "distribution.synthesis" {
            sink.lock().unwrap().push((p.done, p.total));
        }
    });
    pcf::synthesise(&exemplar.analysed(), &target, &options, &run).unwrap();
    let told = told.lock().unwrap();
    assert!(told.windows(2).all(|w| w[0].0 <= w[1].0 && w[0].1 == w[1].1), "{told:?}");
    assert!(told.windows(2).all(|w| (w[1].0 - w[0].0) * 20 <= w[0].1), "{told:?}");
    assert_eq!(told.last().map(|(done, total)| done == total), Some(true), "{told:?}");
}

#[test]
fn what_cannot_fit_or_has_no_room_is_refused_and_a_stop_is_heard() {
    let forest = exemplars::forest(5);
    let analysis = forest.analysed();
    let with = |counts: Vec<usize>| {
        let target = Target { counts, ..forest.target() };
        pcf::synthesise(&analysis, &target, &SynthesisOptions::default(), &Run::silent())
    };
    assert!(matches!(with(vec![400, 0, 0]), Err(PcfError::CannotFit { class: 0, asked: 400, .. })));
    assert!(matches!(with(vec![0, 2_000_000, 0]), Err(PcfError::TooManyElements { .. })));
    let stop = StopFlag::default();
    stop.stop();
    let stopped = pcf::synthesise(&analysis, &forest.target(), &SynthesisOptions::default(), &Run::stoppable(stop));
    assert!(matches!(stopped, Err(PcfError::Stopped(_))));
}

#[test]
fn a_count_that_finds_no_place_ends_with_what_fits() {
    // Lattice points keep half their spacing: ten times as many cannot all find room in a strip.
    let grid = exemplars::hexagonal();
    let analysis = grid.analysed();
    let strip = exemplars::rectangle(12.0, 0.3);
    let target = Target { domain: &grid.domain, room: Some(&strip), density: None, fixed: &[], counts: vec![168] };
    let options = SynthesisOptions { max_fails: 100, ..SynthesisOptions::default() };
    let result = pcf::synthesise(&analysis, &target, &options, &Run::silent()).unwrap();
    assert!(result.classes[0].missing > 100 && result.elements.len() < 60);
    assert_eq!(result.classes[0].missing + result.elements.len(), 168);
}
