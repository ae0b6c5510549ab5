//! Seconds of analysis and synthesis at the sizes of T table 3.1 and at 10,000 and 100,000 disks,
//! and of a correlation curve side by side with R's spatstat.
//!
//! `cargo bench --bench distributions -- [MOST]` (default: 10000; larger sizes are left out).

use std::process::Command;
use std::time::Duration;
use std::time::Instant;

use biotope::compute::geometry::Bounds;
use biotope::compute::geometry::Point;
use biotope::compute::geometry::Region;
use biotope::compute::pcf;
use biotope::compute::pcf::AnalysisOptions;
use biotope::compute::pcf::Axis;
use biotope::compute::pcf::BorderOptions;
use biotope::compute::pcf::Dependencies;
use biotope::compute::pcf::Element;
use biotope::compute::pcf::Metric;
use biotope::compute::pcf::SynthesisOptions;
use biotope::compute::pcf::Target;
use biotope::compute::random::Purpose;
use biotope::compute::random::Stream;
use biotope::compute::run::Run;

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// Elements, classes and curves of T table 3.1 and of a forest of 4,140 disks, and the seconds
/// allowed on two cores.
const TABLE: [(usize, usize, usize, f64); 6] = [
    (460, 3, 5, 0.3),
    (800, 4, 10, 2.0),
    (224, 5, 11, 2.0),
    (1500, 12, 78, 2.0),
    (2300, 9, 45, 2.0),
    (4140, 3, 5, 3.0),
];

/// Runs of which the middle one counts.
const RUNS: usize = 3;

fn main() -> Outcome<()> {
    // Every job runs in a pool of its own.
    let pool = rayon::ThreadPoolBuilder::new().build()?;
    Ok(pool.install(|| figures().map_err(|error| error.to_string()))?)
}

fn figures() -> Outcome<()> {
    let most = std::env::args().find_map(|a| a.parse().ok()).unwrap_or(10_000);
    line(&format!("{} threads", std::thread::available_parallelism()?));
    for (count, classes, curves, allowed) in TABLE {
        table_row((count, classes, curves), allowed)?;
    }
    analysis_in_a_learnt_border()?;
    for count in [10_000, 100_000] {
        if count <= most {
            large(count)?;
        }
    }
    beside_spatstat(20_000)
}

#[expect(clippy::print_stdout, reason = "a benchmark prints its figures")]
fn line(text: &str) {
    println!("{text}");
}

/// The middle time of several runs.
fn middle(mut work: impl FnMut() -> Outcome<()>) -> Outcome<Duration> {
    let mut times = Vec::new();
    for _ in 0..RUNS {
        let start = Instant::now();
        work()?;
        times.push(start.elapsed());
    }
    times.sort_unstable();
    Ok(times[RUNS / 2])
}

fn table_row((count, classes, curves): (usize, usize, usize), allowed: f64) -> Outcome<()> {
    let (elements, graph) = disks((count, classes, curves))?;
    let domain = square(100.0)?;
    let options = AnalysisOptions { triplets: true, ..AnalysisOptions::of(Metric::Disk) };
    let counts = (0..classes).map(|c| elements.iter().filter(|e| e.class == c).count()).collect();
    let target = Target { domain: &domain, room: None, density: None, fixed: &[], counts };
    let time = middle(|| {
        let analysis = pcf::analyse(&elements, &domain, (&graph, &options), &Run::silent())?;
        pcf::synthesise(&analysis, &target, &SynthesisOptions::default(), &Run::silent())?;
        Ok(())
    })?;
    let seconds = time.as_secs_f64();
    let verdict = if seconds <= allowed { "" } else { ": over" };
    line(&format!("{count:7} disks, {classes:2} classes, {curves:2} curves {seconds:8.3} s of {allowed} s{verdict}"));
    Ok(())
}

/// Disks of shrinking size, apart from each other within their class; every class depends on as
/// many earlier ones as give `curves` curves.
fn disks((count, classes, curves): (usize, usize, usize)) -> Outcome<(Vec<Element>, Dependencies)> {
    let mut random = Stream::new(1, Purpose::new("bench.disks"), 0);
    let mut elements: Vec<Element> = Vec::new();
    for class in 0..classes {
        let members = count / classes + usize::from(class < count % classes);
        let first = elements.len();
        let radius = 25.0 / (members as f64).sqrt() / (1.0 + class as f64);
        for _ in 0..members {
            let mut draw = || Element {
                centre: Point::new(random.range(0.0, 100.0), random.range(0.0, 100.0)),
                radius: radius * random.range(0.7, 1.0),
                class,
            };
            let is_free =
                |e: &Element| elements[first..].iter().all(|o| o.centre.distance(e.centre) > o.radius + e.radius);
            let element = (0..2_000).map(|_| draw()).find(is_free).ok_or("no room for a disk")?;
            elements.push(element);
        }
    }
    let pairs: Vec<(usize, usize)> =
        (0..classes).flat_map(|c| (0..c).map(move |p| (c, p))).take(curves - classes).collect();
    Ok((elements, Dependencies::new(classes, &pairs)?))
}

fn analysis_in_a_learnt_border() -> Outcome<()> {
    let elements = points(300, 10.0);
    let graph = Dependencies::new(1, &[])?;
    let centres: Vec<Point> = elements.iter().map(|e| e.centre).collect();
    let time = middle(|| {
        let domain = pcf::learn_border(&centres, &BorderOptions::default())?;
        pcf::analyse(&elements, &domain, (&graph, &AnalysisOptions::of(Metric::Point)), &Run::silent())?;
        Ok(())
    })?;
    line(&format!("analysis of 300 points in a free-form domain {:.1} ms of 10 ms", time.as_secs_f64() * 1e3));
    Ok(())
}

fn large(count: usize) -> Outcome<()> {
    let (elements, graph) = disks((300, 1, 1))?;
    let exemplar = square(100.0)?;
    let options = AnalysisOptions { triplets: true, ..AnalysisOptions::of(Metric::Disk) };
    let analysis = pcf::analyse(&elements, &exemplar, (&graph, &options), &Run::silent())?;
    let domain = square(100.0 * (count as f64 / 300.0).sqrt())?;
    let target = Target { domain: &domain, room: None, density: None, fixed: &[], counts: vec![count] };
    let start = Instant::now();
    pcf::synthesise(&analysis, &target, &SynthesisOptions::default(), &Run::silent())?;
    let seconds = start.elapsed().as_secs_f64();
    line(&format!("{count:7} disks by blocks {seconds:8.2} s, {:.1} µs a disk", seconds * 1e6 / count as f64));
    Ok(())
}

/// The curve of the same points by spatstat, in one run: seconds and their ratio.
fn beside_spatstat(count: usize) -> Outcome<()> {
    let elements = points(count, 1.0);
    let (domain, graph) = (square(1.0)?, Dependencies::new(1, &[])?);
    let options = AnalysisOptions { axis: Axis::default(), ..AnalysisOptions::of(Metric::Point) };
    let ours = middle(|| {
        pcf::analyse(&elements, &domain, (&graph, &options), &Run::silent())?;
        Ok(())
    })?;
    let ours = ours.as_secs_f64();
    let r_max = pcf::maximal_spacing(1.0, count);
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("points.csv");
    let rows: String = elements.iter().map(|e| format!("{},{}\n", e.centre.x, e.centre.y)).collect();
    std::fs::write(&file, rows)?;
    let script = format!(
        "suppressMessages(library(spatstat)); p <- read.csv('{}', header=FALSE); x <- ppp(p[,1], p[,2], c(0,1), c(0,1)); \
         t <- system.time(pcf(x, r=seq(0, {}, length.out=51), kernel='gaussian', bw={}, correction='iso', divisor='r')); \
         cat(t[['elapsed']])",
        file.display(),
        5.0 * r_max,
        0.25 * r_max / std::f64::consts::SQRT_2
    );
    let theirs = match Command::new("Rscript").args(["-e", &script]).output() {
        Ok(out) if out.status.success() => String::from_utf8(out.stdout)?.trim().parse::<f64>()?,
        _ => {
            line(&format!("curve of {count} points {ours:.3} s; R with spatstat is not here to compare with"));
            return Ok(());
        }
    };
    line(&format!("curve of {count} points {ours:.3} s, spatstat {theirs:.3} s: {:.1} times as fast", theirs / ours));
    Ok(())
}

fn points(count: usize, side: f64) -> Vec<Element> {
    let mut random = Stream::new(2, Purpose::new("bench.points"), 0);
    let mut place = || Point::new(random.range(0.0, side), random.range(0.0, side));
    (0..count).map(|_| Element { centre: place(), radius: 0.0, class: 0 }).collect()
}

fn square(side: f64) -> Outcome<Region> {
    Ok(Region::rectangle(Bounds::new(Point::default(), Point::new(side, side)))?)
}
