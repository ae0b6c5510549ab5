//! Takes waiting jobs up, as many as memory and places allow, each on a thread and a pool of
//! its own; never on an async thread.

use std::sync::Arc;
use std::sync::Weak;
use std::sync::atomic::Ordering;
use std::time::Duration;

use biotope_api::error::ErrorCode;
use biotope_api::error::Problem;
use biotope_api::job::JobState;
use tokio::runtime::Handle;

use crate::compute::run::Run;
use crate::jobs::Failure;
use crate::jobs::Job;
use crate::jobs::context::Kept;
use crate::jobs::progress::Live;
use crate::jobs::queue::Lane;
use crate::jobs::queue::Outcome;
use crate::jobs::queue::Row;
use crate::jobs::service::Inner;
use crate::jobs::service::Jobs;
use crate::jobs::work::Desk;
use crate::jobs::work::perform;
use crate::jobs::work::problem;

/// How often progress reaches the table.
const PROGRESS_PACE: Duration = Duration::from_millis(500);
/// Tries to write the end of a job before it is left to the next start.
const FINISH_TRIES: u32 = 5;

/// Starts to take jobs up and to write progress down, until the service is dropped or drains.
pub(super) fn start(jobs: &Jobs) {
    tokio::spawn(take_up(Arc::downgrade(&jobs.0)));
    tokio::spawn(write_progress(Arc::downgrade(&jobs.0)));
}

async fn take_up(inner: Weak<Inner>) {
    while let Some(inner) = inner.upgrade() {
        if inner.draining.load(Ordering::Relaxed) {
            return;
        }
        for lane in Lane::ALL {
            while let Some(row) = next(&inner, lane).await {
                launch(&inner, lane, row);
            }
        }
        // Not to hold the service while nothing happens.
        let bell = tokio::time::timeout(Duration::from_secs(2), inner.bell.notified());
        let _rung_or_not = bell.await;
    }
}

/// The next row of a lane, claimed, if there is a place and memory for it.
async fn next(inner: &Inner, lane: Lane) -> Option<Row> {
    let memory = inner.places().free(lane, &inner.settings)?;
    let owner = std::process::id().to_string();
    match inner.queue.claim(lane, memory, &owner).await {
        Ok(row) => row,
        Err(error) => {
            tracing::error!(%error, "no job can be taken up");
            None
        }
    }
}

/// Runs a claimed row on a thread of its own.
fn launch(inner: &Arc<Inner>, lane: Lane, row: Row) {
    let live = Arc::new(Live::new(row.fence));
    inner.lives().insert(row.id, Arc::clone(&live));
    inner.places().take(lane, row.memory_bytes);
    inner.changed();
    let (shared, claimed, handle) = (Arc::clone(inner), row.clone(), Handle::current());
    let begun = std::thread::Builder::new().name("job".to_owned()).spawn(move || {
        work(&shared, &claimed, &live, &handle);
        if live.stop.is_stopped() {
            shared.broom.notify_one();
        }
        leave(&shared, lane, &claimed);
        trim(&shared, &handle);
    });
    if let Err(error) = begun {
        tracing::error!(%error, job = %row.id, "no thread for a job; it runs again at the next start");
        leave(inner, lane, &row);
    }
}

fn leave(inner: &Inner, lane: Lane, row: &Row) {
    inner.lives().remove(&row.id);
    inner.places().give_back(lane, row.memory_bytes);
    inner.changed();
}

/// Drops what is oldest of what can be made again.
fn trim(inner: &Inner, handle: &Handle) {
    match handle.block_on(inner.store.trim(inner.settings.cache_bytes)) {
        Ok(0) => {}
        Ok(removed) => tracing::info!(removed, "dropped old results of stages"),
        Err(error) => tracing::warn!(%error, "old results of stages could not be dropped"),
    }
}

/// Runs a claimed row and writes down what came of it.
fn work(inner: &Inner, row: &Row, live: &Arc<Live>, handle: &Handle) {
    let began = std::time::Instant::now();
    tracing::info!(job = %row.id, process = row.process, start = row.starts, "job begins");
    // A dismissal between the claim and the entry among the live ones has found nobody to stop.
    match handle.block_on(inner.queue.get(row.id)) {
        Ok(Some(now)) if now.state == JobState::Running => {}
        _ => live.stop.stop(),
    }
    let mut result = run(inner, row, live, handle);
    // The outputs are held until the row names them, or nobody ever will.
    let pins = result.as_mut().ok().map(Kept::take_pins);
    let stopped = matches!(result, Err(Failure::Stopped));
    let duration_ms = u64::try_from(began.elapsed().as_millis()).unwrap_or(u64::MAX);
    tracing::info!(job = %row.id, process = row.process, duration_ms, stopped, "job ends");
    if let Some(outcome) = outcome(row, result) {
        finish(inner, row, handle, &outcome);
        metrics::counter!("biotope_jobs_ended_total", "process" => row.process.clone(),
            "status" => outcome.state().as_str())
        .increment(1);
        metrics::histogram!("biotope_job_duration_seconds", "process" => row.process.clone())
            .record(began.elapsed().as_secs_f64());
    } else if inner.draining.load(Ordering::Relaxed)
        && let Err(error) = handle.block_on(inner.queue.release(row.id, row.fence))
    {
        tracing::error!(job = %row.id, %error, "a stopped job could not be put back; it runs again at the next start");
    }
    drop(pins);
}

fn run(inner: &Inner, row: &Row, live: &Arc<Live>, handle: &Handle) -> Result<Kept, Failure> {
    let entry = inner.registry.find(&row.process);
    let entry = entry.ok_or_else(|| Failure::Fault(format!("no process {} any more", row.process)))?;
    let task = handle.block_on(inner.task(row)).map_err(Failure::fault)?;
    let (store, sources) = inner.at_desk(handle.clone());
    let observer = Arc::clone(live);
    let run = Run::new(live.stop.clone(), move |progress| observer.report(progress));
    let begun = |job: &dyn Job| live.set_stages(job.stages());
    perform(
        entry,
        &task.execute,
        Desk { store: &store, sources: &sources, run, threads: inner.settings.threads },
        &begun,
    )
}

/// What is to be written down; `None` for work that was told to stop.
fn outcome(row: &Row, result: Result<Kept, Failure>) -> Option<Outcome> {
    let failure = match result {
        Ok(kept) => return Some(Outcome::Success { outputs: kept.outputs, warnings: kept.warnings }),
        Err(failure) => failure,
    };
    if let Failure::Fault(error) = &failure {
        tracing::error!(job = %row.id, process = row.process, error, "a job failed by a fault of ours");
    }
    problem(failure).map(Outcome::Failure)
}

/// Writes the end of a job down. A fence that is no longer ours means that the job was dismissed
/// or belongs to another worker: what was stored for it is left unnamed, and swept away.
fn finish(inner: &Inner, row: &Row, handle: &Handle, outcome: &Outcome) {
    for attempt in 1..=FINISH_TRIES {
        match handle.block_on(inner.queue.finish(row.id, row.fence, outcome)) {
            Ok(true) => return,
            Ok(false) => return tracing::info!(job = %row.id, "the job was given up meanwhile"),
            Err(error) => tracing::error!(job = %row.id, attempt, %error, "the end of a job could not be written"),
        }
        std::thread::sleep(Duration::from_millis(200) * attempt);
    }
    let failed = Outcome::Failure(Problem::new(ErrorCode::Internal, "The result could not be stored."));
    let _logged_above = handle.block_on(inner.queue.finish(row.id, row.fence, &failed));
}

/// Writes the progress of running jobs down, every now and then.
async fn write_progress(inner: Weak<Inner>) {
    loop {
        tokio::time::sleep(PROGRESS_PACE).await;
        let Some(inner) = inner.upgrade() else { return };
        let lives: Vec<_> = inner.lives().iter().map(|(id, live)| (*id, Arc::clone(live))).collect();
        for (id, live) in lives {
            let Some((percent, message)) = live.unwritten_summary() else { continue };
            if let Err(error) = inner.queue.progress(id, live.fence, percent, &message).await {
                tracing::warn!(job = %id, %error, "progress could not be written");
            }
        }
    }
}
