//! What is kept no longer goes: rows of jobs that ended long ago, uploads nobody uses, and the
//! blobs that no row names.
//!
//! Blobs are swept, not counted: a sweep reads what all rows name and removes the rest, so a
//! crash at any moment leaves nothing behind for good.

use std::sync::Arc;
use std::sync::Weak;
use std::sync::atomic::Ordering;
use std::time::Duration;
use std::time::Instant;

use time::OffsetDateTime;

use crate::jobs::Jobs;
use crate::jobs::JobsError;
use crate::jobs::queue::Keep;
use crate::jobs::service::Inner;
use crate::storage::Digest;

/// Time between rounds when nobody asks for one.
const ROUND: Duration = Duration::from_secs(3600);
/// Least time between rounds, and least multiple of what the last one took.
const REST: (Duration, u32) = (Duration::from_secs(2), 20);

/// What a round has removed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tidied {
    /// Rows of jobs and uploads.
    pub rows: u64,
    /// Blobs that no row named.
    pub blobs: usize,
    /// Their bytes.
    pub bytes: u64,
}

/// Makes a round now, every hour, and soon after a job left something behind; until the service
/// is dropped or drains.
pub(super) fn start(jobs: &Jobs) {
    let broom = Arc::clone(&jobs.0.broom);
    let inner = Arc::downgrade(&jobs.0);
    tokio::spawn(async move {
        clear_remains(&inner).await;
        while let Some(rest) = round(&inner).await {
            tokio::time::sleep(rest).await;
            let _asked_or_not = tokio::time::timeout(ROUND, broom.notified()).await;
        }
    });
}

async fn clear_remains(inner: &Weak<Inner>) {
    let Some(store) = inner.upgrade().map(|inner| inner.store.clone()) else { return };
    match store.clear_remains().await {
        Ok(0) => {}
        Ok(removed) => tracing::warn!(removed, "removed what interrupted writes had left"),
        Err(error) => tracing::warn!(%error, "what interrupted writes have left could not be removed"),
    }
}

/// One round; how long to rest after it, `None` when it was the last.
async fn round(inner: &Weak<Inner>) -> Option<Duration> {
    let inner = inner.upgrade().filter(|inner| !inner.draining.load(Ordering::Relaxed))?;
    let began = Instant::now();
    match tidy(&inner).await {
        Ok(Tidied { rows: 0, blobs: 0, .. }) => {}
        Ok(Tidied { rows, blobs, bytes }) => tracing::info!(rows, blobs, bytes, "tidied up"),
        Err(error) => tracing::warn!(%error, "what is kept no longer could not be removed"),
    }
    Some(REST.0.max(began.elapsed() * REST.1))
}

async fn tidy(inner: &Inner) -> Result<Tidied, JobsError> {
    let since = OffsetDateTime::now_utc() - inner.settings.keep;
    let rows = inner.queue.forget(Keep { since, bytes: inner.settings.results_bytes }).await?;
    let Some(sweep) = inner.store.sweep() else { return Ok(Tidied { rows, ..Tidied::default() }) };
    let named = inner.queue.named().await?;
    let wanted = named.iter().filter_map(|digest| Digest::parse(digest)).collect();
    let (blobs, bytes) = sweep.keep_only(&wanted).await?;
    Ok(Tidied { rows, blobs, bytes })
}

impl Jobs {
    /// Forgets what is kept no longer and removes every blob that no row names; what was removed.
    ///
    /// # Errors
    /// When the table or the store fails.
    pub async fn tidy(&self) -> Result<Tidied, JobsError> {
        tidy(&self.0).await
    }
}
