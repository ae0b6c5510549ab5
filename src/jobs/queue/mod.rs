//! The rows of jobs: the only truth about them.
//!
//! A row is there before a client hears of its job. Every write of a worker carries the fence
//! it was given when it claimed the row, so a worker that lost its row can change nothing.

mod row;
mod sqlite;

use std::collections::BTreeSet;

use futures_util::future::BoxFuture;
use time::OffsetDateTime;

pub use row::Filter;
pub use row::JobId;
pub use row::Lane;
pub use row::NewRow;
pub use row::Outcome;
pub use row::Row;
pub use sqlite::SqliteQueue;

/// Runs of a job that may end with the service dying, before it is given up.
pub const STARTS_LIMIT: i64 = 3;

/// Why the rows cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum QueueError {
    /// The database failed.
    #[error("the table of jobs cannot be used: {0}")]
    Database(#[from] sqlx::Error),
    /// A row holds something this version cannot read.
    #[error("the row of job {job} cannot be read: {what}")]
    Corrupt {
        /// The job.
        job: String,
        /// What cannot be read.
        what: String,
    },
}

/// What became of a row that was to be added.
#[derive(Debug, Clone, PartialEq)]
pub enum Added {
    /// It was added.
    New(Row),
    /// A row with the same key and the same task was there.
    Replayed(Row),
    /// A row with the same key and another task was there.
    KeyReused,
    /// As many rows wait as may.
    Full,
}

/// An uploaded file as the table knows it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AssetRow {
    /// Its digest with prefix.
    pub digest: String,
    /// Media type it was first uploaded as.
    pub media_type: String,
    /// Size in bytes.
    pub size: u64,
}

/// How many jobs there are in each state that is not final.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Jobs that wait.
    pub accepted: u64,
    /// Jobs that run.
    pub running: u64,
}

/// What is kept of jobs that have ended, and of uploads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Keep {
    /// Rows that ended, and uploads that were last used, before this moment are forgotten.
    pub since: OffsetDateTime,
    /// Bytes that the outputs of all rows may take: the rows that ended first are forgotten.
    pub bytes: u64,
}

type Answer<'a, T> = BoxFuture<'a, Result<T, QueueError>>;

/// A table of jobs. Each method is one transaction, on disk when it returns.
pub trait Queue: Send + Sync {
    /// Adds a row, unless its key is known or `limit` rows wait.
    fn add(&self, row: NewRow, limit: u64) -> Answer<'_, Added>;
    /// The row of that id.
    fn get(&self, id: JobId) -> Answer<'_, Option<Row>>;
    /// The row with that idempotency key.
    fn by_key<'a>(&'a self, key: &'a str) -> Answer<'a, Option<Row>>;
    /// Rows that pass the filter, newest first.
    fn list(&self, filter: Filter) -> Answer<'_, Vec<Row>>;
    /// Takes the oldest waiting row of a lane, if it needs at most `memory_bytes`: it is running
    /// now, under a new fence.
    fn claim<'a>(&'a self, lane: Lane, memory_bytes: u64, owner: &'a str) -> Answer<'a, Option<Row>>;
    /// Records progress; `false` when the fence is no longer the row's.
    fn progress<'a>(&'a self, id: JobId, fence: i64, percent: u8, message: &'a str) -> Answer<'a, bool>;
    /// Ends a running row; `false` when the fence is no longer the row's.
    fn finish<'a>(&'a self, id: JobId, fence: i64, outcome: &'a Outcome) -> Answer<'a, bool>;
    /// Puts a running row back among those that wait, as if it had never started.
    fn release(&self, id: JobId, fence: i64) -> Answer<'_, bool>;
    /// Gives a job up: whatever it was, it is dismissed now. The row as it was before.
    fn dismiss(&self, id: JobId) -> Answer<'_, Option<Row>>;
    /// After a crash: rows that ran wait again; those that have crashed the service
    /// [`STARTS_LIMIT`] times fail with `poisoned`. Returns how many wait again and how many
    /// failed. To be called while nobody else uses the table.
    fn recover<'a>(&'a self, poisoned: &'a Outcome) -> Answer<'a, (u64, u64)>;
    /// Forgets rows and uploads that are kept no longer; how many. Rows that wait or run stay.
    fn forget(&self, keep: Keep) -> Answer<'_, u64>;
    /// The digests, with prefix, of everything that rows and uploads name.
    fn named(&self) -> Answer<'_, BTreeSet<String>>;
    /// How many rows wait and run.
    fn counts(&self) -> Answer<'_, Counts>;
    /// Remembers an uploaded file, used now; `false` when it was known.
    fn add_asset(&self, asset: AssetRow) -> Answer<'_, bool>;
    /// The uploaded file of that digest. It counts as used now.
    fn asset<'a>(&'a self, digest: &'a str) -> Answer<'a, Option<AssetRow>>;
}
