//! Extraction finds the animals that a test has drawn, and says so when it cannot.

use super::herds_drawn::Drawn;
use super::herds_drawn::Scene;
use super::herds_drawn::scribbles;
use biotope::compute::geometry::Ellipse;
use biotope::compute::herds::extraction::Extraction;
use biotope::compute::herds::extraction::ExtractionOptions;
use biotope::compute::herds::extraction::extract;
use biotope::compute::run::Run;

struct Score {
    recall: f64,
    precision: f64,
    centre_px: f64,
    axis_degrees: f64,
}

/// One-to-one matching, nearest pairs first, within half the true minor axis (which is b).
fn score(truth: &[Ellipse], found: &[Ellipse]) -> Score {
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (i, t) in truth.iter().enumerate() {
        for (j, f) in found.iter().enumerate() {
            let d = t.centre.distance(f.centre);
            if d <= t.b {
                pairs.push((d, i, j));
            }
        }
    }
    pairs.sort_by(|p, q| p.0.total_cmp(&q.0));
    let (mut of_truth, mut of_found) = (vec![None; truth.len()], vec![false; found.len()]);
    for (d, i, j) in pairs {
        if of_truth[i].is_none() && !of_found[j] {
            of_truth[i] = Some((d, j));
            of_found[j] = true;
        }
    }
    let matched: Vec<(usize, f64, usize)> =
        (0..truth.len()).filter_map(|i| of_truth[i].map(|(d, j)| (i, d, j))).collect();
    let angle = |i: usize, j: usize| {
        let (t, f): (&Ellipse, &Ellipse) = (&truth[i], &found[j]);
        t.heading().cross(f.heading()).abs().min(1.0).asin().to_degrees()
    };
    let long = matched.iter().filter(|(i, _, _)| truth[*i].a >= 1.5 * truth[*i].b);
    Score {
        recall: matched.len() as f64 / truth.len() as f64,
        precision: matched.len() as f64 / found.len() as f64,
        centre_px: median(matched.iter().map(|m| m.1).collect()),
        axis_degrees: median(long.map(|(i, _, j)| angle(*i, *j)).collect()),
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn run(drawn: &Drawn, options: &ExtractionOptions) -> Extraction {
    extract(&drawn.photo, &scribbles(drawn, 8), options, &Run::silent()).unwrap()
}

fn ellipses(extraction: &Extraction) -> Vec<Ellipse> {
    extraction.animals.iter().map(|a| a.ellipse).collect()
}

fn check(scene: Scene, least: f64) {
    let drawn = scene.draw();
    let found = ellipses(&run(&drawn, &ExtractionOptions::default()));
    let s = score(&drawn.animals, &found);
    let line = format!(
        "seed {}: {} animals, recall {:.3} precision {:.3} centre {:.2} px axis {:.2}°",
        scene.seed,
        drawn.animals.len(),
        s.recall,
        s.precision,
        s.centre_px,
        s.axis_degrees
    );
    println!("{line}");
    assert!(s.recall >= least && s.precision >= least && s.centre_px < 2.0 && s.axis_degrees < 5.0, "{line}");
}

#[test]
fn animals_apart_are_found_where_they_were_drawn() {
    for (seed, b, noise) in [(1, (6.0, 9.0), 8.0), (2, (8.0, 14.0), 20.0), (3, (4.0, 6.0), 12.0)] {
        check(Scene { width: 900, height: 700, animals: 180, b, touching: 0.0, noise, seed }, 0.95);
    }
}

#[test]
fn animals_of_which_a_fifth_touch_are_parted() {
    for (seed, b, noise) in
        [(4, (6.0, 9.0), 8.0), (5, (8.0, 14.0), 16.0), (6, (4.0, 6.0), 10.0), (7, (7.0, 10.0), 12.0)]
    {
        check(Scene { width: 900, height: 700, animals: 160, b, touching: 0.2, noise, seed }, 0.9);
    }
}
