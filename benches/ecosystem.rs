//! Seconds and peak memory of each stage of an ecosystem solve on the generated valley, with the
//! 18 plants and 7 animals of L table 1, at growing sizes.
//!
//! `cargo bench --bench ecosystem -- [SIDE …]` (default: 390 1024 2048 4096). Each size runs in a
//! process of its own, from an empty store, so that peaks are its own; the figures include
//! writing each stage's result to disk. Then the same solve is told to stop at five moments, as a
//! dismissal does, and the time until it has stopped is printed.

use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::time::Duration;
use std::time::Instant;

use biotope::codec::map::Georeference;
use biotope::codec::map::Legend;
use biotope::codec::map::Map;
use biotope::codec::map::MapData;
use biotope::compute::ecosystem::valley::Valley;
use biotope::compute::ecosystem::valley::ValleyOptions;
use biotope::jobs::local::FileRequest;
use biotope::jobs::local::LocalError;
use biotope::jobs::local::LocalRun;
use biotope::jobs::progress::Live;
use serde_json::Value;
use serde_json::json;

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// Shares of the seconds of a solve after which it is told to stop, to see how soon it does.
const DISMISSED_AT: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];

/// Names the child process that solves one size.
const CHILD: &str = "BIOTOPE_BENCH_SIDE";

fn main() -> Outcome<()> {
    if let Ok(side) = std::env::var(CHILD) {
        return one(side.parse()?);
    }
    let asked: Vec<usize> = std::env::args().filter_map(|a| a.parse().ok()).collect();
    let sides = if asked.is_empty() { vec![390, 1024, 2048, 4096] } else { asked };
    for side in sides {
        let status = Command::new(std::env::current_exe()?).env(CHILD, side.to_string()).status()?;
        assert!(status.success(), "the solve of {side}² failed");
    }
    Ok(())
}

#[expect(clippy::print_stdout, reason = "a benchmark prints its figures")]
fn one(side: usize) -> Outcome<()> {
    let folder = tempfile::tempdir()?;
    let request = request(side, folder.path())?;
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build()?;
    let handle = runtime.handle().clone();
    let (out, live) = (folder.path().join("out"), Arc::new(Live::new(1)));
    let threads = std::thread::available_parallelism()?.get();
    let solve = Solve { request: &request, out: &out, threads, handle };
    let start = Instant::now();
    let mut meter = Meter::new();
    std::thread::scope(|scope| -> Outcome<()> {
        let work = scope.spawn(|| solve.run(&live));
        while !work.is_finished() {
            meter.look(&live);
            std::thread::sleep(Duration::from_millis(2));
        }
        work.join().map_err(|_| "the work panicked")?.map_err(|e| e.to_string().into())
    })?;
    meter.end_stage();
    let seconds = start.elapsed().as_secs_f64();
    println!("\n{side} x {side} cells, {threads} threads: {:.2} s in all, peak {} MiB", seconds, meter.peak);
    for (stage, seconds, mib) in meter.stages {
        println!("{stage:24} {seconds:8.2} s {mib:7} MiB");
    }
    for share in DISMISSED_AT {
        match solve.stopped_after(Duration::from_secs_f64(share * seconds)) {
            Some(latency) => println!("dismissed at {:2.0} %: stops in {latency:.3} s", 100.0 * share),
            None => println!("dismissed at {:2.0} %: had ended already", 100.0 * share),
        }
    }
    Ok(())
}

/// A solve that can be run again and again, each time from an empty store.
struct Solve<'a> {
    request: &'a Path,
    out: &'a Path,
    threads: usize,
    handle: tokio::runtime::Handle,
}

impl Solve<'_> {
    fn run(&self, live: &Arc<Live>) -> Result<(), LocalError> {
        let place = LocalRun { out: self.out, keep: None, threads: self.threads };
        let handle = self.handle.clone();
        FileRequest::open(self.request).and_then(|file| file.run("ecosystem", &place, live, handle)).map(drop)
    }

    /// Tells a solve to stop after `time`; seconds until it has.
    fn stopped_after(&self, time: Duration) -> Option<f64> {
        let live = Arc::new(Live::new(1));
        std::thread::scope(|scope| {
            let work = scope.spawn(|| self.run(&live));
            std::thread::sleep(time);
            let told = Instant::now();
            live.stop.stop();
            let ended = work.join().ok()?;
            matches!(ended, Err(LocalError::Stopped)).then(|| told.elapsed().as_secs_f64())
        })
    }
}

/// Notes when stages begin, and the peak memory in each.
struct Meter {
    seen: u64,
    stage: Option<(String, Instant)>,
    stages: Vec<(String, f64, u64)>,
    peak: u64,
}

impl Meter {
    fn new() -> Self {
        Self { seen: 0, stage: None, stages: Vec::new(), peak: 0 }
    }

    fn look(&mut self, live: &Live) {
        for event in live.events_after(self.seen) {
            self.seen = event.number;
            if self.stage.as_ref().is_none_or(|(name, _)| name != event.progress.stage) {
                self.end_stage();
                self.stage = Some((event.progress.stage.to_owned(), Instant::now()));
            }
        }
    }

    /// Closes the stage and forgets the peak, so that the next stage has its own.
    fn end_stage(&mut self) {
        let mib = peak_mib();
        self.peak = self.peak.max(mib);
        if let Some((name, since)) = self.stage.take() {
            self.stages.push((name, since.elapsed().as_secs_f64(), mib));
        }
        // Resets VmHWM (proc(5), clear_refs); where that is not allowed, peaks are those so far.
        let _refused = std::fs::write("/proc/self/clear_refs", "5");
    }
}

/// Most memory this process held since the last reset, MiB; 0 where the system does not tell.
fn peak_mib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|rest| rest.split_whitespace().next()?.parse::<u64>().ok()).unwrap_or(0) / 1024
}

/// Writes the valley and a request for it; gives the request's path.
fn request(side: usize, folder: &Path) -> Outcome<std::path::PathBuf> {
    let valley = Valley::generate(&ValleyOptions { width: side, height: side, ..ValleyOptions::default() });
    for (name, raster) in [("height.tif", valley.height), ("water.tif", valley.water_depth_m)] {
        let legend = Legend::continuous(name, "m", biotope::codec::colours::ColourMap::Grey);
        let map = Map { data: MapData::F32(raster), legend, georeference: Georeference::local("valley") };
        std::fs::write(folder.join(name), map.to_geotiff()?)?;
    }
    let mut request: Value = serde_json::from_str(include_str!("../api/examples/ecosystem-tautavel-mild.json"))?;
    let inputs = &mut request["inputs"];
    inputs["terrain"] = json!({"source": {"href": "height.tif"}, "latitude_deg": 42.85});
    inputs["maps"] = json!({"water_depth_m": {"href": "water.tif"}});
    let seven = [
        "Bison priscus",
        "Cervus elaphus",
        "Dama roberti",
        "Ovis ammon",
        "Rangifer tarandus",
        "Canis mosbachensis",
        "Ursus spelaeus",
    ];
    // A few square kilometres hold no pack at the densities of living relatives, so they are let go.
    let animal = |name: &&str| json!({"species": name, "max_density_per_km2": 1000, "group_size_min": 1});
    inputs["animals"] = seven.iter().map(animal).collect();
    request["outputs"] = json!({"summary": {}});
    let path = folder.join("request.json");
    std::fs::write(&path, serde_json::to_vec(&request)?)?;
    Ok(path)
}
