//! Extraction finds the animals that a test has drawn, and says so when it cannot.

use super::herds_drawn::Drawn;
use super::herds_drawn::Scene;
use super::herds_drawn::scribbles;
use biotope::compute::geometry::Ellipse;
use biotope::compute::geometry::Point;
use biotope::compute::herds::extraction::Corrections;
use biotope::compute::herds::extraction::Extraction;
use biotope::compute::herds::extraction::ExtractionError;
use biotope::compute::herds::extraction::ExtractionOptions;
use biotope::compute::herds::extraction::Mark;
use biotope::compute::herds::extraction::Photo;
use biotope::compute::herds::extraction::Scribbles;
use biotope::compute::herds::extraction::Stroke;
use biotope::compute::herds::extraction::Suspicion;
use biotope::compute::herds::extraction::extract;
use biotope::compute::run::Run;
use biotope::compute::run::StopFlag;

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

#[test]
fn corrections_of_a_first_run_are_input_to_a_second() {
    let drawn =
        Scene { width: 300, height: 240, animals: 14, b: (7.0, 9.0), touching: 0.0, noise: 8.0, seed: 8 }.draw();
    let first = run(&drawn, &ExtractionOptions::default());
    let new = Ellipse { centre: Point::new(150.0, 120.0), a: 9.0, b: 4.0, theta: 1.0 };
    let corrections = Corrections {
        remove: vec![first.animals[0].id],
        add: vec![new],
        flip: vec![first.animals[1].id],
        ..Corrections::default()
    };
    let second = run(&drawn, &ExtractionOptions { corrections, ..ExtractionOptions::default() });
    assert_eq!(second.animals.len(), first.animals.len());
    assert_eq!(second.animals.last().unwrap().ellipse, new);
    assert_eq!(second.animals[0].ellipse, first.animals[1].ellipse.flipped());
    assert_eq!(second.animals[1], first.animals[2]);
}

#[test]
fn all_animals_face_within_a_quarter_turn_of_the_direction_given() {
    let drawn =
        Scene { width: 500, height: 400, animals: 30, b: (7.0, 9.0), touching: 0.0, noise: 8.0, seed: 9 }.draw();
    for direction in [0.0, 2.0, -1.7] {
        let found = run(&drawn, &ExtractionOptions { direction, ..ExtractionOptions::default() });
        let to = Point::from_angle(direction);
        assert!(found.animals.iter().all(|a| a.ellipse.heading().dot(to) >= 0.0));
    }
}

#[test]
fn regions_of_outlying_size_are_flagged_and_kept() {
    let mut drawn =
        Scene { width: 600, height: 500, animals: 50, b: (7.0, 8.0), touching: 0.0, noise: 8.0, seed: 10 }.draw();
    // One animal is taken for ground by painting over all but a quarter of it.
    let hidden = drawn.animals[20];
    let grid = drawn.photo.grid();
    let mut rgb = drawn.photo.rgb().to_vec();
    for i in 0..grid.len() {
        let local = (grid.centre(i) - hidden.centre).rotated(-hidden.theta);
        if hidden.scale_to(grid.centre(i)) < 1.2 && local.x > -0.4 * hidden.a {
            rgb[3 * i..3 * i + 3].copy_from_slice(&[120, 118, 75]);
        }
    }
    drawn.photo = Photo::new(grid.width, grid.height, rgb).unwrap();
    let found = run(&drawn, &ExtractionOptions::default());
    let suspects: Vec<_> = found.animals.iter().filter(|a| !a.suspicions.is_empty()).collect();
    assert_eq!(found.animals.len(), 50);
    assert_eq!(suspects.len(), 1, "{suspects:?}");
    assert!(suspects[0].suspicions.contains(&Suspicion::Size));
    assert!(suspects[0].ellipse.centre.distance(hidden.centre) < hidden.a);
}

#[test]
fn scribbles_that_cannot_teach_are_refused_with_their_reason() {
    let drawn =
        Scene { width: 200, height: 150, animals: 8, b: (7.0, 8.0), touching: 0.0, noise: 8.0, seed: 11 }.draw();
    let Scribbles::Strokes(strokes) = scribbles(&drawn, 4) else { panic!("strokes were drawn") };
    let refuse = |strokes: Vec<Stroke>| {
        extract(&drawn.photo, &Scribbles::Strokes(strokes), &ExtractionOptions::default(), &Run::silent()).unwrap_err()
    };
    let animals: Vec<Stroke> = strokes.iter().filter(|s| s.mark == Mark::Animal).cloned().collect();
    assert_eq!(refuse(animals.clone()), ExtractionError::OneKindOnly { missing: "ground" });
    let mut outside = strokes.clone();
    outside[1].points[1] = Point::new(201.0, 20.0);
    assert!(matches!(refuse(outside), ExtractionError::OutsidePicture { stroke: 1, point: 1, .. }));
    let mut crossing = strokes.clone();
    crossing.push(Stroke { mark: Mark::Ground, ..animals[0].clone() });
    assert!(matches!(refuse(crossing), ExtractionError::Contradiction { .. }));
    let checkered: Vec<Mark> =
        (0..200 * 150).map(|i| if (i + i / 200) % 2 == 0 { Mark::Animal } else { Mark::Ground }).collect();
    let alike = extract(&drawn.photo, &Scribbles::Labels(checkered), &ExtractionOptions::default(), &Run::silent());
    assert!(matches!(alike.unwrap_err(), ExtractionError::SameColours { .. }));
}

#[test]
fn the_result_is_the_same_on_any_number_of_threads() {
    let drawn =
        Scene { width: 400, height: 300, animals: 40, b: (5.0, 8.0), touching: 0.2, noise: 15.0, seed: 12 }.draw();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&drawn, &ExtractionOptions::default()))
    };
    assert_eq!(on(1), on(2));
}

#[test]
fn a_stopped_extraction_ends_with_a_stop() {
    let drawn =
        Scene { width: 200, height: 150, animals: 8, b: (7.0, 8.0), touching: 0.0, noise: 8.0, seed: 13 }.draw();
    let flag = StopFlag::default();
    flag.stop();
    let stopped =
        extract(&drawn.photo, &scribbles(&drawn, 4), &ExtractionOptions::default(), &Run::stoppable(flag)).unwrap_err();
    assert!(matches!(stopped, ExtractionError::Stopped(_)));
}
