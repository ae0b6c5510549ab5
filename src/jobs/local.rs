//! A request in a file, run without a server by the same code.

use std::collections::BTreeMap;
use std::path::Path;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::Mutex;
use std::sync::MutexGuard;
use std::sync::PoisonError;

use biotope_api::error::ErrorCode;
use biotope_api::error::Problem;
use biotope_api::execute::Execute;
use biotope_api::reference::Reference;
use biotope_api::warning::Warning;
use bytes::Bytes;
use tokio::runtime::Handle;

use crate::compute::run::Run;
use crate::compute::run::StopFlag;
use crate::jobs::Artefact;
use crate::jobs::Digest;
use crate::jobs::Failure;
use crate::jobs::Job;
use crate::jobs::JobsError;
use crate::jobs::context::Kept;
use crate::jobs::context::Stored;
use crate::jobs::process::inputs_schema;
use crate::jobs::progress::Live;
use crate::jobs::registry::Entry;
use crate::jobs::registry::Registry;
use crate::jobs::results::load;
use crate::jobs::schema::InputCheck;
use crate::jobs::schema::read;
use crate::jobs::sources::Content;
use crate::jobs::sources::Source;
use crate::jobs::sources::SourceError;
use crate::jobs::sources::Sources;
use crate::jobs::sources::data_address;
use crate::jobs::sources::inline;
use crate::jobs::work::Desk;
use crate::jobs::work::accept;
use crate::jobs::work::invalid_problem;
use crate::jobs::work::perform;
use crate::jobs::work::problem;
use crate::storage::BlockingStore;
use crate::storage::Store;

/// Why a request in a file gave no results.
#[derive(Debug, thiserror::Error)]
pub enum LocalError {
    /// A file cannot be read or written.
    #[error("{}: {cause}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
    /// The request is at fault, or the work ended for a reason that is no fault of ours.
    #[error("{}", .0.detail)]
    Problem(Box<Problem>),
    /// A fault of ours.
    #[error("{0}")]
    Fault(String),
    /// The work was told to stop.
    #[error("stopped")]
    Stopped,
}

impl From<JobsError> for LocalError {
    fn from(error: JobsError) -> Self {
        Self::Fault(error.to_string())
    }
}

/// A request in a file.
#[derive(Debug, Clone)]
pub struct FileRequest {
    /// What is to be done.
    pub execute: Execute,
    /// The folder that relative references start from.
    pub folder: PathBuf,
}

/// Where and how a request is run.
#[derive(Debug, Clone)]
pub struct LocalRun<'a> {
    /// Folder the outputs are written to; made when absent.
    pub out: &'a Path,
    /// Folder that keeps the results of stages for the next run; `None`: nothing is kept.
    pub keep: Option<&'a Path>,
    /// Threads to compute on.
    pub threads: usize,
}

/// What requests are run with.
#[derive(Clone, Copy)]
pub struct Bench<'a> {
    /// The processes.
    pub registry: &'a Registry,
    /// Where outputs and stages are stored.
    pub store: &'a BlockingStore,
    /// Threads to compute on.
    pub threads: usize,
}

impl FileRequest {
    /// Reads a request.
    ///
    /// # Errors
    /// When the file cannot be read or is not a request.
    pub fn open(file: &Path) -> Result<Self, LocalError> {
        let bytes = std::fs::read(file).map_err(|cause| LocalError::File { path: file.to_owned(), cause })?;
        let not_json = |error| Problem::new(ErrorCode::BodyNotJson, format!("{}: {error}", file.display()));
        let value = serde_json::from_slice(&bytes).map_err(not_json).map_err(refuse)?;
        let check = InputCheck::new(&inputs_schema::<Execute>()).map_err(LocalError::Fault)?;
        check.check(&value).map_err(|faults| refuse(invalid_problem(faults)))?;
        let execute = read(value).map_err(|faults| refuse(invalid_problem(faults)))?;
        Ok(Self { execute, folder: file.parent().unwrap_or(Path::new("")).to_owned() })
    }

    /// Checks the request as the service would before it queues it. Requests that it refers to
    /// are run.
    ///
    /// # Errors
    /// When the request is at fault.
    pub fn check(&self, process: &str, bench: &Bench<'_>) -> Result<(), LocalError> {
        let sources = self.sources(bench, StopFlag::default());
        let accepted = accept(find(bench.registry, process)?, &self.execute, &sources);
        accepted.map(drop).map_err(|faults| refuse(invalid_problem(faults)))
    }

    /// Runs the request, after those that it refers to; its outputs are in the store. Not for
    /// async threads.
    ///
    /// # Errors
    /// When the request is at fault or the work fails.
    pub fn solve(&self, process: &str, bench: &Bench<'_>, live: &Arc<Live>) -> Result<Kept, LocalError> {
        let sources = self.sources(bench, live.stop.clone());
        let observer = Arc::clone(live);
        let run = Run::new(live.stop.clone(), move |progress| observer.report(progress));
        let begun = |job: &dyn Job| live.set_stages(job.stages());
        let Bench { registry, store, threads } = *bench;
        let entry = find(registry, process)?;
        perform(entry, &self.execute, Desk { store, sources: &sources, run, threads }, &begun).map_err(failed)
    }

    fn sources<'a>(&self, bench: &'a Bench<'a>, stop: StopFlag) -> FileSources<'a> {
        FileSources { folder: self.folder.clone(), bench, stop, above: Vec::new(), done: Arc::default() }
    }

    /// Runs the request and writes every output as `<output id>.<extension>`; returns the
    /// warnings. Not for async threads; the store works on the runtime of `handle`.
    ///
    /// # Errors
    /// When the request is at fault, the work fails, or a file cannot be written.
    pub fn run(
        &self,
        process: &str,
        place: &LocalRun<'_>,
        live: &Arc<Live>,
        handle: Handle,
    ) -> Result<Vec<Warning>, LocalError> {
        let registry = Registry::standard().map_err(LocalError::Fault)?;
        find(&registry, process)?;
        make_folder(place.out)?;
        let work = WorkFolder::make(place)?;
        let store = BlockingStore::new(Store::in_folder(&work.folder).map_err(JobsError::from)?, handle);
        let bench = Bench { registry: &registry, store: &store, threads: place.threads };
        let kept = self.solve(process, &bench, live)?;
        for (id, stored) in &kept.outputs {
            write_output(&store, id, stored, place.out, &live.stop)?;
        }
        Ok(kept.warnings)
    }
}

fn find<'a>(registry: &'a Registry, process: &str) -> Result<&'a Entry, LocalError> {
    let unknown = || refuse(Problem::new(ErrorCode::NoSuchProcess, format!("There is no process {process:?}.")));
    registry.find(process).ok_or_else(unknown)
}

fn refuse(problem: Problem) -> LocalError {
    LocalError::Problem(Box::new(problem))
}

fn failed(failure: Failure) -> LocalError {
    match failure {
        Failure::Stopped => LocalError::Stopped,
        Failure::Fault(text) => LocalError::Fault(text),
        other => problem(other).map_or(LocalError::Stopped, refuse),
    }
}

/// Writes an output in every form that carries its contents.
fn write_output(
    store: &BlockingStore,
    id: &str,
    stored: &Stored,
    out: &Path,
    stop: &StopFlag,
) -> Result<(), LocalError> {
    let artefact = load(store, stored)?;
    for form in stored.kind.file_forms() {
        if stop.is_stopped() {
            return Err(LocalError::Stopped);
        }
        if let (Artefact::Tables(tables), "csv") = (&artefact, form.name.as_str()) {
            for (name, table) in tables {
                write(&out.join(format!("{id}.{name}.csv")), table.csv().as_bytes())?;
            }
            continue;
        }
        let encoded = artefact.encode(&form.name).map_err(JobsError::from)?;
        let name = if id.ends_with(&format!(".{}", form.name)) { id.to_owned() } else { format!("{id}.{}", form.name) };
        write(&out.join(name), &encoded.bytes)?;
    }
    Ok(())
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), LocalError> {
    std::fs::write(path, bytes).map_err(|cause| LocalError::File { path: path.to_owned(), cause })
}

fn make_folder(path: &Path) -> Result<(), LocalError> {
    std::fs::create_dir_all(path).map_err(|cause| LocalError::File { path: path.to_owned(), cause })
}

/// Where a run keeps what it works with; gone after it, unless it is to be kept.
struct WorkFolder {
    folder: PathBuf,
    passing: bool,
}

impl WorkFolder {
    fn make(place: &LocalRun<'_>) -> Result<Self, LocalError> {
        let passing = place.out.join(format!(".biotope-{}", std::process::id()));
        let folder = place.keep.map_or(passing, Path::to_owned);
        make_folder(&folder)?;
        Ok(Self { folder, passing: place.keep.is_none() })
    }
}

impl Drop for WorkFolder {
    fn drop(&mut self) {
        if self.passing {
            let _nothing_else_to_do = std::fs::remove_dir_all(&self.folder);
        }
    }
}

/// Files beside the request, outputs of other requests beside it, and data by value.
struct FileSources<'a> {
    folder: PathBuf,
    bench: &'a Bench<'a>,
    stop: StopFlag,
    /// The requests that are being read on the way to this one.
    above: Vec<PathBuf>,
    /// What requests have given so far; each is run once.
    done: Arc<Mutex<BTreeMap<PathBuf, Kept>>>,
}

impl Sources for FileSources<'_> {
    fn open(&self, reference: &Reference) -> Result<Source, SourceError> {
        let link = match reference {
            Reference::Inline(value) => return inline(value),
            Reference::Link(link) if link.href.starts_with("data:") => return data_address(&link.href),
            Reference::Link(link) => link,
        };
        if link.href.contains("://") {
            return Err(SourceError::new(ErrorCode::HrefNotAllowed, "a file or a data: address", link.href.as_str()));
        }
        if let Some((request, output)) = link.href.rsplit_once('#') {
            return self.output(request, output);
        }
        let path = self.folder.join(&link.href);
        let bytes = std::fs::read(path).map_err(|cause| missing(&link.href, cause))?;
        let media_type = link.media_type.clone().unwrap_or_else(|| media_type_of(&link.href).to_owned());
        Ok(Source::encoded(media_type, Bytes::from(bytes)))
    }
}

fn missing(href: &str, cause: impl std::fmt::Display) -> SourceError {
    SourceError::new(ErrorCode::HrefNotFound, "a file that can be read", format!("{href}: {cause}"))
}

impl FileSources<'_> {
    /// An output of another request, which is run first: `herd-extraction.json#ellipses`.
    fn output(&self, request: &str, output: &str) -> Result<Source, SourceError> {
        let path = self.folder.join(request).canonicalize().map_err(|cause| missing(request, cause))?;
        if self.above.contains(&path) {
            let expected = "requests that do not refer to each other in a circle";
            return Err(SourceError::new(ErrorCode::Inconsistent, expected, request));
        }
        let found = self.lock().get(&path).cloned();
        let kept = match found {
            Some(kept) => kept,
            None => {
                let kept = self.run(&path, request)?;
                self.lock().insert(path, kept.clone());
                kept
            }
        };
        let absent = || SourceError::new(ErrorCode::HrefNotFound, format!("an output that {request} keeps"), output);
        let stored = kept.outputs.get(output).ok_or_else(absent)?;
        let digest = Digest::parse(&stored.digest).ok_or_else(absent)?;
        let artefact = load(self.bench.store, stored).map_err(|error| missing(request, error))?;
        Ok(Source { digest, content: Content::Artefact(artefact) })
    }

    fn run(&self, path: &Path, request: &str) -> Result<Kept, SourceError> {
        let refused = |error: &dyn std::fmt::Display| {
            SourceError::new(ErrorCode::HrefNotFound, "a request that succeeds", format!("{request}: {error}"))
        };
        let file = FileRequest::open(path).map_err(|error| refused(&error))?;
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let entry = self.bench.registry.named_by(&stem).ok_or_else(|| {
            SourceError::new(ErrorCode::HrefNotFound, "a request file that is named by its process", request)
        })?;
        let sources = FileSources {
            folder: file.folder.clone(),
            bench: self.bench,
            stop: self.stop.clone(),
            above: self.above.iter().cloned().chain([path.to_owned()]).collect(),
            done: Arc::clone(&self.done),
        };
        let Bench { store, threads, .. } = *self.bench;
        let desk = Desk { store, sources: &sources, run: Run::stoppable(self.stop.clone()), threads };
        perform(entry, &file.execute, desk, &|_| {}).map_err(|failure| refused(&failed(failure)))
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<PathBuf, Kept>> {
        self.done.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The media type of a file, by its name.
pub fn media_type_of(name: &str) -> &'static str {
    match name.rsplit('.').next().unwrap_or_default().to_ascii_lowercase().as_str() {
        "tif" | "tiff" => "image/tiff",
        "png" => "image/png",
        "jpg" | "jpeg" => "image/jpeg",
        "json" => "application/json",
        "geojson" => "application/geo+json",
        "csv" => "text/csv",
        "asc" | "txt" => "text/plain",
        _ => "application/octet-stream",
    }
}
