//! How good new arrangements are: the refinement pays, nests stay nested, and on statistics that
//! were not optimised outputs stay within the exemplar's band.

use crate::science::distributions_exemplars as exemplars;
use biotope::compute::geometry::Point;
use biotope::compute::geometry::Region;
use biotope::compute::pcf;
use biotope::compute::pcf::AnalysisOptions;
use biotope::compute::pcf::Axis;
use biotope::compute::pcf::Element;
use biotope::compute::pcf::Metric;
use biotope::compute::pcf::Synthesis;
use biotope::compute::pcf::SynthesisOptions;
use biotope::compute::pcf::quality::Band;
use biotope::compute::pcf::quality::NearestDistances;
use biotope::compute::pcf::quality::overlaps_per_hundred;
use biotope::compute::random::Purpose;
use biotope::compute::random::Stream;
use biotope::compute::run::Run;
use exemplars::Exemplar;
use rayon::prelude::*;

fn again(exemplar: &Exemplar, seed: u64) -> Synthesis {
    let options = SynthesisOptions { seed, ..SynthesisOptions::default() };
    pcf::synthesise(&exemplar.analysed(), &exemplar.target(), &options, &Run::silent()).unwrap()
}

fn of_class(elements: &[Element], class: usize) -> Vec<Element> {
    elements.iter().filter(|e| e.class == class).copied().collect()
}

fn sorted_radii(elements: &[Element]) -> Vec<f64> {
    let mut radii: Vec<f64> = elements.iter().map(|e| e.radius).collect();
    radii.sort_by(f64::total_cmp);
    radii
}

/// Seeds of the checks that must hold on any.
const SEEDS: [u64; 3] = [1, 2, 3];

#[test]
fn refinement_pays_on_the_forest() {
    let forest = exemplars::forest(1);
    assert_eq!(forest.elements.len(), 460);
    // T's axis: 50 places from 0.1 to 5.
    let options = AnalysisOptions { axis: Axis::default(), triplets: true, ..AnalysisOptions::of(forest.metric) };
    let analysis = pcf::analyse(&forest.elements, &forest.domain, (&forest.graph, &options), &Run::silent()).unwrap();
    assert!(analysis.curves.iter().all(|c| c.mean.len() == 50));
    let synthesise = |seed: &u64| {
        let options = SynthesisOptions { seed: *seed, ..SynthesisOptions::default() };
        pcf::synthesise(&analysis, &forest.target(), &options, &Run::silent()).unwrap()
    };
    for result in SEEDS.par_iter().map(synthesise).collect::<Vec<Synthesis>>() {
        assert_eq!(result.curves.len(), 5);
        for report in &result.curves {
            let (name, before, after) = ((report.curve.child, report.curve.parent), report.before, report.after);
            println!("{name:?}: {before:.4} became {after:.4}");
            assert!(after <= before + 1e-9, "{name:?}: {before} became {after}");
            assert!(before <= 0.05 || after < before / 3.0, "{name:?}: {before} only became {after}");
        }
        for class in 0..3 {
            assert_eq!(sorted_radii(&of_class(&result.elements, class)), sorted_radii(&forest.of_class(class)));
        }
        assert!(result.elements.iter().all(|e| forest.domain.contains(e.centre)));
    }
}

#[test]
fn nests_of_nests_stay_nested() {
    // The over-constrained case of T figure 3.13: disks in disks in disks.
    let nested = exemplars::nested(1);
    for result in SEEDS.par_iter().map(|seed| again(&nested, *seed)).collect::<Vec<Synthesis>>() {
        let inside = |inner: usize, outer: usize| {
            let outer = of_class(&result.elements, outer);
            let inner = of_class(&result.elements, inner);
            let is_in = |e: &&Element| outer.iter().any(|o| o.centre.distance(e.centre) <= o.radius - e.radius + 0.02);
            inner.iter().filter(is_in).count() as f64 / inner.len() as f64
        };
        assert!(inside(1, 0) >= 0.9, "{}", inside(1, 0));
        assert!(inside(2, 1) >= 0.8, "{}", inside(2, 1));
    }
}

/// Outputs whose mean is taken: four times five, as the mean over five still varies by 0.05.
const OUTPUTS: u64 = 20;

/// What outputs score on statistics that were not optimised, and a uniform pattern's score.
struct Score {
    name: String,
    count: usize,
    ours: f64,
    uniform: f64,
}

fn uniform_like(members: &[Element], domain: &Region, seed: u64) -> Vec<Element> {
    let mut random = Stream::new(seed, Purpose::new("test.uniform-like"), 0);
    let b = domain.bounds();
    let mut place = || Point::new(random.range(b.min.x, b.max.x), random.range(b.min.y, b.max.y));
    members.iter().map(|e| Element { centre: place(), ..*e }).collect()
}

fn scores(exemplar: &Exemplar) -> Vec<Score> {
    let outputs: Vec<Synthesis> = (1..=OUTPUTS).into_par_iter().map(|seed| again(exemplar, seed)).collect();
    let mut scores = Vec::new();
    for class in 0..exemplar.counts().len() {
        let members = exemplar.of_class(class);
        let functions: [fn(&[Element], &Region) -> NearestDistances; 2] =
            [NearestDistances::between, NearestDistances::to_places];
        for (name, function) in ["G", "F"].iter().zip(functions) {
            let band = Band::of(&function(&members, &exemplar.domain), 0);
            let share =
                |elements: &[Element]| band.share_inside(&function(elements, &exemplar.domain)) / OUTPUTS as f64;
            scores.push(Score {
                name: format!("{} {class} {name}", exemplar.name),
                count: members.len(),
                ours: outputs.iter().map(|o| share(&of_class(&o.elements, class))).sum(),
                uniform: (1..=OUTPUTS).map(|s| share(&uniform_like(&members, &exemplar.domain, s))).sum(),
            });
        }
    }
    if exemplar.metric == Metric::Disk {
        check_overlaps(exemplar, &outputs);
    }
    scores
}

fn check_overlaps(exemplar: &Exemplar, outputs: &[Synthesis]) {
    let (nested, partly) = overlaps_per_hundred(&exemplar.elements);
    let count = exemplar.elements.len() as f64;
    for (k, (name, wanted)) in [("nested", nested), ("partly", partly)].into_iter().enumerate() {
        let found = |o: &Synthesis| [overlaps_per_hundred(&o.elements).0, overlaps_per_hundred(&o.elements).1][k];
        let mean = outputs.iter().map(found).sum::<f64>() / outputs.len() as f64;
        let allowed = (0.2 * wanted).max(2.0 * (wanted * count / 100.0).sqrt() * 100.0 / count);
        assert!((mean - wanted).abs() <= allowed, "{} {name}: {mean} for {wanted}", exemplar.name);
    }
}

fn check_stands(chosen: impl Fn(&str) -> bool) {
    let mut failed = Vec::new();
    for score in exemplars::stands().iter().filter(|e| chosen(&e.name)).flat_map(scores) {
        let Score { name, count, ours, uniform } = score;
        println!("{name} ({count}): {ours:.2}, uniform {uniform:.2}");
        let holds = ours >= 0.85 && (uniform >= 0.65 || ours >= uniform + 0.2);
        if count >= 100 && !holds {
            failed.push(format!("{name} ({count}): {ours:.2}, uniform {uniform:.2}"));
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn outputs_look_like_the_stands_where_those_are_present() {
    check_stands(|name| name != "lansing");
}

#[test]
#[ignore = "two minutes: six species, twenty outputs; .ci/run runs it"]
fn outputs_look_like_the_six_species_of_lansing_where_those_are_present() {
    check_stands(|name| name == "lansing");
}
