//! All that the other rooms can ask of jobs: submit, look, wait, fetch, dismiss.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::Mutex;
use std::sync::MutexGuard;
use std::sync::PoisonError;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering;
use std::time::Duration;

use biotope_api::error::ErrorCode;
use biotope_api::error::Problem;
use tokio::runtime::Handle;
use tokio::sync::Notify;
use tokio::sync::Semaphore;
use tokio::sync::watch;
use tokio::time::Instant;

use crate::jobs::housekeeping;
use crate::jobs::places::Places;
use crate::jobs::progress::Live;
use crate::jobs::queue::Counts;
use crate::jobs::queue::Filter;
use crate::jobs::queue::JobId;
use crate::jobs::queue::Outcome;
use crate::jobs::queue::Queue;
use crate::jobs::queue::QueueError;
use crate::jobs::queue::Row;
use crate::jobs::queue::STARTS_LIMIT;
use crate::jobs::queue::SqliteQueue;
use crate::jobs::references::StoredSources;
use crate::jobs::registry::Registry;
use crate::jobs::settings::Settings;
use crate::jobs::work::Task;
use crate::jobs::worker;
use crate::storage::BlockingStore;
use crate::storage::Digest;
use crate::storage::FolderLock;
use crate::storage::Key;
use crate::storage::Store;
use crate::storage::StoreError;

/// Requests that are parsed, and results that are encoded, at one time.
const DESKS: usize = 2;

/// Why the service of jobs cannot answer.
#[derive(Debug, thiserror::Error)]
pub enum JobsError {
    /// The table failed.
    #[error(transparent)]
    Queue(#[from] QueueError),
    /// The store failed.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A stored document cannot be read.
    #[error("a stored document cannot be read: {0}")]
    Stored(#[from] serde_json::Error),
    /// An artefact cannot be written in the form asked for.
    #[error(transparent)]
    Artefact(#[from] crate::jobs::artefact::ArtefactError),
    /// The schemas of the processes are wrong.
    #[error("the schema of a process is not one: {0}")]
    Schema(String),
    /// The threads of the service cannot be started.
    #[error("the compute threads cannot be started: {0}")]
    Threads(String),
    /// A part of the service ended by a panic.
    #[error("a part of the service ended early: {0}")]
    Broken(String),
}

/// The jobs of the service. Clones share them.
#[derive(Clone)]
pub struct Jobs(pub(super) Arc<Inner>);

/// What the parts of [`Jobs`] share.
pub(super) struct Inner {
    pub registry: Registry,
    pub queue: Arc<dyn Queue>,
    pub store: Store,
    pub settings: Settings,
    /// The jobs that run in this process.
    pub live: Mutex<BTreeMap<JobId, Arc<Live>>>,
    /// The places and the memory that are taken.
    pub places: Mutex<Places>,
    /// Rung when a job waits or a place is free.
    pub bell: Notify,
    /// Rung when a job has left something behind that nobody names.
    pub broom: Arc<Notify>,
    /// Counts changes of state of any job.
    pub changes: watch::Sender<u64>,
    pub draining: AtomicBool,
    /// Pool and places for parsing and encoding.
    pub desk: rayon::ThreadPool,
    pub desks: Semaphore,
    _folder: Option<FolderLock>,
}

impl Jobs {
    /// Opens the jobs in `folder`, takes up those that a crash interrupted, and starts to work.
    ///
    /// # Errors
    /// [`StoreError::Held`] when another process works in the folder; otherwise when it cannot be
    /// used.
    pub async fn open(folder: &Path, registry: Registry, settings: Settings) -> Result<Self, JobsError> {
        let lock = FolderLock::take(folder)?;
        let queue = SqliteQueue::open(&folder.join("jobs.sqlite")).await?;
        let store = Store::in_folder(&folder.join("store"))?;
        Self::start(Arc::new(queue), store, registry, settings, Some(lock)).await
    }

    /// Jobs that live in memory: for tests.
    ///
    /// # Errors
    /// As [`Jobs::open`].
    pub async fn in_memory(registry: Registry, settings: Settings) -> Result<Self, JobsError> {
        let queue = SqliteQueue::in_memory().await?;
        Self::start(Arc::new(queue), Store::in_memory(), registry, settings, None).await
    }

    async fn start(
        queue: Arc<dyn Queue>,
        store: Store,
        registry: Registry,
        settings: Settings,
        folder: Option<FolderLock>,
    ) -> Result<Self, JobsError> {
        let (again, failed) = queue.recover(&poisoned()).await?;
        if again + failed > 0 {
            tracing::warn!(again, failed, "took up jobs that were interrupted");
        }
        let desk = rayon::ThreadPoolBuilder::new().num_threads(settings.threads).thread_name(|i| format!("desk-{i}"));
        let inner = Inner {
            registry,
            queue,
            store,
            settings,
            live: Mutex::default(),
            places: Mutex::default(),
            bell: Notify::new(),
            broom: Arc::default(),
            changes: watch::Sender::new(0),
            draining: AtomicBool::new(false),
            desk: desk.build().map_err(|error| JobsError::Threads(error.to_string()))?,
            desks: Semaphore::new(DESKS),
            _folder: folder,
        };
        let jobs = Self(Arc::new(inner));
        worker::start(&jobs);
        housekeeping::start(&jobs);
        Ok(jobs)
    }

    /// The processes.
    pub fn registry(&self) -> &Registry {
        &self.0.registry
    }

    /// The row of a job, with the progress of this moment if it runs here.
    ///
    /// # Errors
    /// When the table fails.
    pub async fn status(&self, id: JobId) -> Result<Option<Row>, JobsError> {
        Ok(self.0.queue.get(id).await?.map(|row| self.with_progress(row)))
    }

    /// The rows that pass a filter, newest first.
    ///
    /// # Errors
    /// When the table fails.
    pub async fn list(&self, filter: Filter) -> Result<Vec<Row>, JobsError> {
        let rows = self.0.queue.list(filter).await?;
        Ok(rows.into_iter().map(|row| self.with_progress(row)).collect())
    }

    fn with_progress(&self, mut row: Row) -> Row {
        if let Some(live) = self.live(row.id).filter(|live| live.fence == row.fence && !row.state.is_final()) {
            (row.percent, row.message) = live.summary();
        }
        row
    }

    /// The progress of a job that runs in this process.
    pub fn live(&self, id: JobId) -> Option<Arc<Live>> {
        self.0.lives().get(&id).cloned()
    }

    /// Tells of every change of state of any job.
    pub fn changes(&self) -> watch::Receiver<u64> {
        self.0.changes.subscribe()
    }

    /// Waits until a job has ended, at most until `deadline`; its row as it is then.
    ///
    /// # Errors
    /// When the table fails.
    pub async fn wait(&self, id: JobId, deadline: Option<Instant>) -> Result<Option<Row>, JobsError> {
        let mut changes = self.changes();
        loop {
            let row = self.status(id).await?;
            let ended = row.as_ref().is_none_or(|row| row.state.is_final());
            let late = deadline.is_some_and(|deadline| deadline <= Instant::now());
            if ended || late {
                return Ok(row);
            }
            let turn = deadline.unwrap_or_else(|| Instant::now() + Duration::from_secs(60));
            let _a_change_or_the_deadline = tokio::time::timeout_at(turn, changes.changed()).await;
        }
    }

    /// Gives a job up; its row as it was before. Work stops at its next check.
    ///
    /// # Errors
    /// When the table fails.
    pub async fn dismiss(&self, id: JobId) -> Result<Option<Row>, JobsError> {
        let before = self.0.queue.dismiss(id).await?;
        if let Some(live) = self.live(id) {
            live.stop.stop();
        }
        self.0.broom.notify_one();
        self.0.changed();
        Ok(before)
    }

    /// The request of a job.
    ///
    /// # Errors
    /// When the store fails.
    pub async fn task(&self, row: &Row) -> Result<Task, JobsError> {
        self.0.task(row).await
    }

    /// How many jobs wait and run.
    ///
    /// # Errors
    /// When the table fails.
    pub async fn counts(&self) -> Result<Counts, JobsError> {
        Ok(self.0.queue.counts().await?)
    }

    /// Whether the service is about to stop.
    pub fn is_draining(&self) -> bool {
        self.0.draining.load(Ordering::Relaxed)
    }

    /// Accepts no more work, stops what runs and puts it back among the waiting; returns when
    /// nothing runs any more or `grace` is over.
    pub async fn drain(&self, grace: Duration) {
        self.0.draining.store(true, Ordering::Relaxed);
        self.0.bell.notify_one();
        let until = Instant::now() + grace;
        while !self.0.lives().is_empty() && Instant::now() < until {
            self.0.lives().values().for_each(|live| live.stop.stop());
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    }
}

impl Inner {
    /// The jobs that run in this process.
    pub fn lives(&self) -> MutexGuard<'_, BTreeMap<JobId, Arc<Live>>> {
        self.live.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The places and the memory that are taken.
    pub fn places(&self) -> MutexGuard<'_, Places> {
        self.places.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Tells all who wait that some job is in another state.
    pub fn changed(&self) {
        self.changes.send_modify(|count| *count += 1);
        self.bell.notify_one();
    }

    /// The store and what stands behind references, for synchronous code.
    pub fn at_desk(&self, handle: Handle) -> (BlockingStore, StoredSources) {
        let store = BlockingStore::new(self.store.clone(), handle);
        (store.clone(), StoredSources::new(store, Arc::clone(&self.queue)))
    }

    /// The request of a job.
    pub async fn task(&self, row: &Row) -> Result<Task, JobsError> {
        let missing = || StoreError::NotFound { key: row.task.clone() };
        let digest = Digest::parse(&row.task).ok_or_else(missing)?;
        Ok(serde_json::from_slice(&self.store.get(&Key::Blob(digest)).await?)?)
    }
}

/// What becomes of a job that has brought the service down too often.
fn poisoned() -> Outcome {
    let detail = format!("The service stopped {STARTS_LIMIT} times while it ran this job.");
    Outcome::Failure(Problem::new(ErrorCode::CrashedRepeatedly, detail))
}
