//! Seconds of extraction, key-herds, assignment and steps of an animation, beside scikit-image,
//! SciPy and pyrvo on the same tasks.
//!
//! `cargo bench --bench herds`. Peers run in a virtual environment that is made under
//! `target/peers` at the first run; without Python or a package index they are left out, with a
//! line that says so.

#![allow(missing_docs, reason = "a benchmark has no readers of its documentation")]
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark prints and may end where it stands")]

#[path = "../tests/science/herds_drawn.rs"]
mod herds_drawn;
#[path = "../tests/science/herds_made.rs"]
mod herds_made;

use std::collections::BTreeMap;
use std::path::Path;
use std::path::PathBuf;
use std::process::Command;
use std::sync::Arc;
use std::sync::Mutex;
use std::time::Instant;

use biotope::compute::geometry::Bounds;
use biotope::compute::geometry::Ellipse;
use biotope::compute::geometry::Point;
use biotope::compute::graph::assignment::assign;
use biotope::compute::herds::Obstacles;
use biotope::compute::herds::animation::AnimationOptions;
use biotope::compute::herds::animation::KeyFrame;
use biotope::compute::herds::animation::KeyPose;
use biotope::compute::herds::animation::animate;
use biotope::compute::herds::extraction::ExtractionOptions;
use biotope::compute::herds::extraction::Mark;
use biotope::compute::herds::extraction::Scribbles;
use biotope::compute::herds::extraction::extract;
use biotope::compute::herds::key_herd::KeyHerdOptions;
use biotope::compute::herds::key_herd::Site;
use biotope::compute::herds::key_herd::key_herd;
use biotope::compute::random::Purpose;
use biotope::compute::random::Stream;
use biotope::compute::raster::Grid;
use biotope::compute::raster::Raster;
use biotope::compute::run::Run;
use biotope::compute::run::StopFlag;
use herds_drawn::Scene;
use serde_json::Value;
use serde_json::json;

/// What the peers are asked to install.
const PEERS: [&str; 4] = ["numpy==2.4.6", "scikit-image==0.26.0", "scipy==1.17.1", "pyrvo==0.4.3"];

/// T table 4.1: seconds of the authors' own program, for exemplars of 1,054, 43 and 220 animals.
const TABLE_4_1: [(usize, [f64; 3]); 5] = [
    (5, [1.8, 0.5, 0.7]),
    (25, [1.9, 0.5, 0.8]),
    (100, [2.2, 5.1, 6.2]),
    (200, [3.5, 16.2, 15.4]),
    (500, [15.9, 73.4, 59.3]),
];

/// A task by name, and the seconds it took here.
type Figure = (String, f64);

fn main() {
    let folder = tempfile::tempdir().unwrap();
    let mut tasks = Vec::new();
    println!("{} threads", rayon::current_num_threads());
    key_herds();
    let mut ours: Vec<Figure> = Vec::new();
    for megapixels in [1, 8, 24] {
        ours.push(extraction(megapixels, folder.path(), &mut tasks));
    }
    for count in [500, 2000, 5000, 10_000] {
        ours.push(assignment(count, &mut tasks));
    }
    for (count, rocks) in [(1000, 0), (10_000, 0), (10_000, 300)] {
        ours.push(steps(count, rocks, &mut tasks));
    }
    std::fs::write(folder.path().join("tasks.json"), serde_json::to_vec(&tasks).unwrap()).unwrap();
    match peers(folder.path()) {
        Ok(theirs) => side_by_side(&ours, &theirs),
        Err(why) => {
            println!("peers are left out: {why}");
            side_by_side(&ours, &BTreeMap::new());
        }
    }
}

/// The shortest of three tries, in seconds.
fn best_of_three<T>(mut work: impl FnMut() -> T) -> f64 {
    let mut once = || {
        let start = Instant::now();
        std::hint::black_box(work());
        start.elapsed().as_secs_f64()
    };
    (0..3).map(|_| once()).fold(f64::INFINITY, f64::min)
}

fn key_herds() {
    println!("\nkey-herd of N animals, seconds (in brackets those of T table 4.1)");
    println!("{:>6} {:>18} {:>18} {:>18}", "N", "exemplar of 1054", "of 43", "of 220");
    let exemplars = [1054, 43, 220].map(|count| herds_made::exemplar(count, 1));
    let obstacles = Obstacles::default();
    let site = Site { terrain: None, obstacles: &obstacles };
    for count in [5, 25, 100, 200, 500, 5000] {
        let cells = exemplars.iter().enumerate().map(|(i, exemplar)| {
            let options = KeyHerdOptions { count, ..KeyHerdOptions::default() };
            let seconds = best_of_three(|| key_herd(exemplar, site, &options, &Run::silent()).unwrap());
            match TABLE_4_1.iter().find(|(n, _)| *n == count) {
                Some((_, theirs)) => format!("{seconds:10.3} {:>7}", format!("({})", theirs[i])),
                None => format!("{seconds:10.3} {:>7}", ""),
            }
        });
        println!("{count:6} {}", cells.collect::<Vec<_>>().join(" "));
    }
}

fn extraction(megapixels: usize, folder: &Path, tasks: &mut Vec<Value>) -> Figure {
    let (width, height) = match megapixels {
        1 => (1225, 817),
        8 => (3464, 2310),
        _ => (6000, 4000),
    };
    let animals = 300 * megapixels;
    let drawn = Scene { width, height, animals, b: (6.0, 9.0), touching: 0.2, noise: 10.0, seed: 1 }.draw();
    let scribbles = herds_drawn::scribbles(&drawn, 12);
    let name = format!("extraction, {megapixels} MP, {} animals", drawn.animals.len());
    let photo = format!("photo-{megapixels}.ppm");
    let header = format!("P6 {width} {height} 255\n").into_bytes();
    std::fs::write(folder.join(&photo), [header.as_slice(), drawn.photo.rgb()].concat()).unwrap();
    let lines = |mark: Mark| match &scribbles {
        Scribbles::Strokes(strokes) => {
            let ends = |p: &Point| [p.x, p.y];
            let of_mark = strokes.iter().filter(|s| s.mark == mark);
            of_mark.map(|s| s.points.iter().map(ends).collect()).collect::<Vec<Vec<[f64; 2]>>>()
        }
        _ => Vec::new(),
    };
    tasks.push(json!({
        "kind": "extraction", "name": name, "photo": photo,
        "animal": lines(Mark::Animal), "ground": lines(Mark::Ground),
    }));
    let options = ExtractionOptions::default();
    let seconds = best_of_three(|| extract(&drawn.photo, &scribbles, &options, &Run::silent()).unwrap());
    (name, seconds)
}

/// Two herds of which the second is denser at one end.
fn assignment(count: usize, tasks: &mut Vec<Value>) -> Figure {
    let cloud = |seed: u64, crowding: f64| -> Vec<Point> {
        let mut random = Stream::new(seed, Purpose::new("bench.assignment"), count as u64);
        (0..count).map(|_| Point::new(random.unit().powf(crowding), random.unit())).collect()
    };
    let (from, to) = (cloud(1, 1.0), cloud(2, 1.3));
    let name = format!("assignment of {count}");
    let pairs = |places: &[Point]| places.iter().map(|p| [p.x, p.y]).collect::<Vec<_>>();
    if count <= 5000 {
        tasks.push(json!({"kind": "assignment", "name": name, "from": pairs(&from), "to": pairs(&to)}));
    }
    let seconds = best_of_three(|| assign(&from, &to, |distance_sq| distance_sq, &Run::silent()).unwrap());
    (name, seconds)
}

/// So many rocks in and around two herds, none on an animal.
fn rocks_among(count: usize, herds: [&[Ellipse]; 2]) -> Obstacles {
    let mut random = Stream::new(1, Purpose::new("bench.rocks"), count as u64);
    let animals = || herds.into_iter().flatten();
    let bounds = Bounds::of(animals().map(|e| e.centre)).unwrap().grown(20.0);
    let mut disks = Vec::new();
    while disks.len() < count {
        let centre = Point::new(random.range(bounds.min.x, bounds.max.x), random.range(bounds.min.y, bounds.max.y));
        let radius = random.range(0.5, 1.5);
        if animals().all(|e| e.centre.distance(centre) > radius + 0.6) {
            disks.push((centre, radius));
        }
    }
    Obstacles { disks, ..Obstacles::default() }
}

/// A herd that crosses hills, among rocks or on open ground, and the seconds of one step.
fn steps(count: usize, rocks: usize, tasks: &mut Vec<Value>) -> Figure {
    let grid = Grid::new(300, 300, 5.0);
    let terrain = Raster { grid, data: (0..grid.len()).map(|i| (grid.centre(i).x as f32 * 0.02).sin()).collect() };
    let from = herds_made::herd(count, Point::new(400.0, 700.0), (3.5, 0.2), 1);
    let to = herds_made::herd(count, Point::new(440.0, 720.0), (3.4, 0.3), 2);
    let obstacles = rocks_among(rocks, [&from, &to]);
    let name = match rocks {
        0 => format!("a step of {count} animals"),
        _ => format!("a step of {count} among {rocks} rocks"),
    };
    if rocks == 0 {
        tasks.push(json!({
            "kind": "steps", "name": name, "steps": 50, "velocity": [2.0, 1.0],
            "places": from.iter().map(|e| [e.centre.x, e.centre.y]).collect::<Vec<_>>(),
        }));
    }
    let frames = [(0.0, from), (20.0, to)].map(|(time_s, herd)| KeyFrame { time_s, pose: KeyPose::Herd(herd) });
    let marks: Arc<Mutex<Vec<(u64, Instant)>>> = Arc::default();
    let seen = Arc::clone(&marks);
    let run = Run::new(StopFlag::default(), move |progress| {
        if progress.stage == "animation.steps" {
            seen.lock().unwrap().push((progress.done, Instant::now()));
        }
    });
    let options = AnimationOptions { keep_every: 10, ..AnimationOptions::default() };
    animate(&terrain, &obstacles, &frames, &options, &run).unwrap();
    let marks = marks.lock().unwrap();
    let (first, last) = (marks[0], marks[marks.len() - 1]);
    (name, (last.1 - first.1).as_secs_f64() / (last.0 - first.0) as f64)
}

/// The peers' names and seconds by task.
fn peers(folder: &Path) -> Result<BTreeMap<String, (String, f64)>, String> {
    let home = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = environment(&home.join("target/peers"))?;
    let script = home.join("benches/peers/herds.py");
    let told = output(Command::new(python).arg(script).arg(folder))?;
    let figure = |line: &str| {
        let told: Value = serde_json::from_str(line).ok()?;
        let text = |key: &str| told[key].as_str().map(str::to_owned);
        Some((text("name")?, (text("peer")?, told["seconds"].as_f64()?)))
    };
    Ok(told.lines().filter_map(figure).collect())
}

/// The Python of a virtual environment with the peers, made if it is not there.
fn environment(at: &Path) -> Result<PathBuf, String> {
    let python = at.join("bin/python");
    if !python.exists() {
        output(Command::new("python3").args(["-m", "venv"]).arg(at))?;
    }
    output(Command::new(&python).args(["-m", "pip", "install", "--quiet"]).args(PEERS))?;
    Ok(python)
}

fn output(command: &mut Command) -> Result<String, String> {
    let done = command.output().map_err(|e| e.to_string())?;
    if done.status.success() {
        return Ok(String::from_utf8_lossy(&done.stdout).into_owned());
    }
    let said = String::from_utf8_lossy(&done.stderr);
    Err(said.lines().last().unwrap_or("no reason given").to_owned())
}

fn side_by_side(ours: &[Figure], theirs: &BTreeMap<String, (String, f64)>) {
    println!("\n{:38} {:>10} {:>24} {:>8}", "", "seconds", "peer's", "ratio");
    for (name, seconds) in ours {
        match theirs.get(name) {
            Some((peer, took)) => {
                println!("{name:38} {seconds:10.4} {:>24} {:8.1}", format!("{peer} {took:.4}"), took / seconds);
            }
            None => println!("{name:38} {seconds:10.4}"),
        }
    }
    println!(
        "scikit-image tells animals by the nearest mean colour, without a support vector machine; pyrvo's agents are disks on open, flat ground."
    );
}
