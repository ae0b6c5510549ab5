//! One run of a job, from its request to what it hands back: the same for the server and for
//! the command line.

use std::any::Any;
use std::panic::AssertUnwindSafe;
use std::panic::catch_unwind;

use biotope_api::error::ErrorCode;
use biotope_api::error::Problem;
use biotope_api::execute::Execute;
use serde::Deserialize;
use serde::Serialize;
use serde_json::Value;
use serde_json::json;

use crate::compute::run::Run;
use crate::jobs::Artefact;
use crate::jobs::Failure;
use crate::jobs::Invalid;
use crate::jobs::Job;
use crate::jobs::JobContext;
use crate::jobs::Sources;
use crate::jobs::context::Kept;
use crate::jobs::references::Recorder;
use crate::jobs::registry::Entry;
use crate::jobs::selection::Selection;
use crate::storage::BlockingStore;

/// A request as it is stored: a process and what it is to do.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Task {
    /// Id of the process.
    pub process: String,
    /// What it is to do.
    pub execute: Execute,
}

/// A request that has been found valid.
pub struct Accepted {
    /// The job.
    pub job: Box<dyn Job>,
    /// The outputs that are to be kept.
    pub selection: Selection,
}

/// Parses a request; not for async threads.
///
/// # Errors
/// Every fault, with pointers relative to the body.
pub fn accept(entry: &Entry, execute: &Execute, sources: &dyn Sources) -> Result<Accepted, Invalid> {
    let mut faults = Invalid::default();
    let selection = faults.keep(Selection::new(&entry.description.outputs, execute.outputs.as_ref()));
    let inputs = Value::Object(execute.inputs.clone());
    let job = faults.keep(entry.parse(inputs, sources).map_err(|faults| faults.below("/inputs")));
    match (job, selection) {
        (Some(job), Some(selection)) => Ok(Accepted { job, selection }),
        _ => Err(faults),
    }
}

/// What one run needs beside the request.
pub struct Desk<'a> {
    /// Where outputs and stages are stored.
    pub store: &'a BlockingStore,
    /// What stands behind references.
    pub sources: &'a dyn Sources,
    /// When to stop and where to report.
    pub run: Run,
    /// Threads of the run's own pool.
    pub threads: usize,
}

/// Runs a request on a pool of its own. `begun` hears of the job before it runs.
///
/// Each run has its own pool: on a shared one, a thread that waits for a part of its own job
/// would take up another job whole, and could not stop before that one ends.
///
/// # Errors
/// Why there is no result. A panic is a fault.
pub fn perform(entry: &Entry, execute: &Execute, desk: Desk<'_>, begun: &dyn Fn(&dyn Job)) -> Result<Kept, Failure> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(desk.threads)
        .thread_name(|i| format!("compute-{i}"))
        .build()
        .map_err(Failure::fault)?;
    let recorder = Recorder::new(desk.sources);
    let Accepted { job, selection } = guarded(|| Ok(pool.install(|| accept(entry, execute, &recorder))?))?;
    begun(job.as_ref());
    let parameters = job.parameters();
    let seed = parameters.get("seed").and_then(Value::as_u64).unwrap_or(0);
    let mut context = JobContext::new(desk.run, seed, selection, desk.store, &recorder);
    guarded(|| pool.install(|| job.run(&mut context)))?;
    context.run.check()?;
    let warnings = Artefact::document(&context.kept().warnings).map_err(Failure::fault)?;
    context.put("warnings", warnings)?;
    let manifest = manifest(entry, seed, recorder.settle(parameters), context.kept());
    context.put("manifest", Artefact::Json(manifest))?;
    context.finish()
}

/// Runs `work`; a panic in it becomes a fault.
fn guarded<T>(work: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| Err(Failure::Fault(panic_text(panic.as_ref()))))
}

fn panic_text(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied().or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    format!("panicked: {}", text.unwrap_or("without a text"))
}

/// What was done, out of what, with what. It names no time, place or number of threads, so the
/// same request gives the same bytes.
fn manifest(entry: &Entry, seed: u64, parameters: Value, kept: &Kept) -> Value {
    let mut citations = kept.citations.clone();
    citations.sort();
    citations.dedup();
    json!({
        "process": entry.description.id,
        "process_version": entry.description.version,
        "software": "biotope",
        "software_version": env!("CARGO_PKG_VERSION"),
        "seed": seed,
        "parameters": parameters,
        "outputs": kept.outputs,
        "warnings": kept.warnings,
        "sources": citations,
    })
}

/// A failure as clients see it; `None` when the work was only told to stop. A fault of ours is
/// hidden.
pub fn problem(failure: Failure) -> Option<Problem> {
    match failure {
        Failure::Stopped => None,
        Failure::Invalid(invalid) => Some(invalid_problem(invalid.below("/inputs"))),
        Failure::Problem { code, detail } => Some(Problem::new(code, detail)),
        Failure::Fault(_) => Some(Problem::new(ErrorCode::Internal, "The work ended by a fault of the service.")),
    }
}

/// The problem that faults in a request make; pointers are relative to the body.
pub fn invalid_problem(invalid: Invalid) -> Problem {
    let count = invalid.errors.len();
    let detail = match count {
        1 => invalid.to_string(),
        _ => format!("{count} faults: {invalid}"),
    };
    Problem { errors: invalid.errors, ..Problem::new(ErrorCode::InvalidInput, detail) }
}
