//! From a request to a row.

use std::sync::Arc;

use biotope_api::error::ErrorCode;
use biotope_api::error::Problem;
use biotope_api::execute::Execute;
use bytes::Bytes;
use futures_util::Stream;
use tokio::runtime::Handle;

use crate::jobs::Estimate;
use crate::jobs::Invalid;
use crate::jobs::Jobs;
use crate::jobs::JobsError;
use crate::jobs::queue::Added;
use crate::jobs::queue::AssetRow;
use crate::jobs::queue::Lane;
use crate::jobs::queue::NewRow;
use crate::jobs::queue::Row;
use crate::jobs::service::Inner;
use crate::jobs::work::Accepted;
use crate::jobs::work::Task;
use crate::jobs::work::accept;
use crate::jobs::work::invalid_problem;
use crate::storage::StoreError;

/// A request that became a row, or had become one before.
#[derive(Debug, Clone, PartialEq)]
pub struct Submitted {
    /// The row.
    pub row: Row,
    /// Whether an earlier request with the same key had made it.
    pub replayed: bool,
}

/// Why a request became no row.
#[derive(Debug, thiserror::Error)]
pub enum Refused {
    /// The request is at fault, or the queue is full.
    #[error("{}", .0.detail)]
    Problem(Box<Problem>),
    /// The service is at fault.
    #[error(transparent)]
    Fault(#[from] JobsError),
}

impl Jobs {
    /// Checks a request and puts it in the queue. When this returns the row is on the disk.
    ///
    /// # Errors
    /// Every fault of the request; or that the queue is full or the service about to stop.
    pub async fn submit(&self, process: &str, execute: Execute, key: Option<String>) -> Result<Submitted, Refused> {
        if self.is_draining() {
            return Err(refuse(ErrorCode::Draining, "The service is about to stop."));
        }
        let unknown = || refuse(ErrorCode::NoSuchProcess, format!("There is no process {process:?}."));
        let lane = Lane::of(&self.registry().find(process).ok_or_else(unknown)?.description);
        let task = Task { process: process.to_owned(), execute };
        let bytes = Bytes::from(serde_json::to_vec(&task).map_err(JobsError::from)?);
        let estimate = self.check(task).await?;
        self.fits(estimate)?;
        let task = self.0.store.put_blob(bytes).await.map_err(JobsError::from)?;
        let digest = task.digest().to_string();
        let new = NewRow { process: process.to_owned(), task: digest, key, lane, memory_bytes: estimate.memory_bytes };
        let added = self.0.queue.add(new, self.0.settings.waiting_jobs).await.map_err(JobsError::from)?;
        drop(task);
        match added {
            Added::New(row) => {
                metrics::counter!("biotope_jobs_accepted_total", "process" => row.process.clone()).increment(1);
                self.0.changed();
                Ok(Submitted { row, replayed: false })
            }
            Added::Replayed(row) => Ok(Submitted { row, replayed: true }),
            Added::KeyReused => Err(refuse(
                ErrorCode::IdempotencyKeyReused,
                "This Idempotency-Key was sent before with another request.",
            )),
            Added::Full => Err(refuse(ErrorCode::QueueFull, "The queue of waiting jobs is full.")),
        }
    }

    /// Parses a request off the async threads.
    async fn check(&self, task: Task) -> Result<Estimate, Refused> {
        self.at_desk(move |inner, handle| {
            let (_, sources) = inner.at_desk(handle);
            let Some(entry) = inner.registry.find(&task.process) else { return Ok(Estimate::default()) };
            inner.desk.install(|| accept(entry, &task.execute, &sources)).map(|Accepted { job, .. }| job.estimate())
        })
        .await?
        .map_err(|invalid: Invalid| Refused::Problem(Box::new(invalid_problem(invalid))))
    }

    fn fits(&self, estimate: Estimate) -> Result<(), Refused> {
        let (needed, allowed) = (estimate.memory_bytes, self.0.settings.memory_bytes);
        if needed <= allowed {
            return Ok(());
        }
        let mebibytes = |bytes: u64| format!("{} MiB", bytes.div_ceil(1 << 20));
        let code = ErrorCode::NeedsTooMuchMemory;
        let faults = Invalid::new("/inputs", code, format!("at most {}", mebibytes(allowed)), mebibytes(needed));
        let detail =
            format!("The work needs about {}, this service may use {}.", mebibytes(needed), mebibytes(allowed));
        Err(Refused::Problem(Box::new(Problem { errors: faults.errors, ..Problem::new(code, detail) })))
    }

    /// Runs synchronous work of the service itself, off the async threads, at one of few desks.
    pub(super) async fn at_desk<T: Send + 'static>(
        &self,
        work: impl FnOnce(&Inner, Handle) -> T + Send + 'static,
    ) -> Result<T, JobsError> {
        let broken = |error: &dyn std::fmt::Display| JobsError::Broken(error.to_string());
        let _desk = self.0.desks.acquire().await.map_err(|error| broken(&error))?;
        let (inner, handle) = (Arc::clone(&self.0), Handle::current());
        tokio::task::spawn_blocking(move || work(&inner, handle)).await.map_err(|error| broken(&error))
    }

    /// Keeps an uploaded file under its digest; whether it is new.
    ///
    /// # Errors
    /// The stream's own error as `Err(Ok(_))`, ours as `Err(Err(_))`.
    pub async fn upload<E>(
        &self,
        media_type: String,
        bytes: impl Stream<Item = Result<Bytes, E>> + Unpin,
    ) -> Result<(AssetRow, bool), Result<E, JobsError>> {
        let ours = |error: StoreError| Err(JobsError::from(error));
        let stored = self.0.store.put_stream(bytes).await;
        let (pin, size) = stored.map_err(|error| error.map_or_else(ours, Ok))?;
        let asset = AssetRow { digest: pin.digest().to_string(), media_type, size };
        let added = self.0.queue.add_asset(asset.clone()).await.map_err(|error| Err(JobsError::from(error)))?;
        if added {
            return Ok((asset, true));
        }
        let known = self.0.queue.asset(&asset.digest).await.map_err(|error| Err(JobsError::from(error)))?;
        Ok((known.unwrap_or(asset), false))
    }

    /// The uploaded file of that digest.
    ///
    /// # Errors
    /// When the table fails.
    pub async fn asset(&self, digest: &str) -> Result<Option<AssetRow>, JobsError> {
        Ok(self.0.queue.asset(digest).await?)
    }
}

fn refuse(code: ErrorCode, detail: impl Into<String>) -> Refused {
    Refused::Problem(Box::new(Problem::new(code, detail)))
}
