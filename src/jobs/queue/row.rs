use std::collections::BTreeMap;
use std::fmt;

use biotope_api::error::Problem;
use biotope_api::job::JobState;
use biotope_api::process::JobControl;
use biotope_api::warning::Warning;
use serde::Deserialize;
use serde::Serialize;
use time::OffsetDateTime;
use uuid::Uuid;

use crate::jobs::Description;
use crate::jobs::context::Stored;

/// Id of a job; ids sort by the time they were made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct JobId(Uuid);

impl JobId {
    /// A new id.
    pub fn new() -> Self {
        Self(Uuid::now_v7())
    }

    /// The id written as `text`; `None` when it is not one.
    pub fn parse(text: &str) -> Option<Self> {
        Uuid::try_parse(text).ok().map(Self)
    }
}

impl Default for JobId {
    fn default() -> Self {
        Self::new()
    }
}

impl fmt::Display for JobId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// Where a job waits: quick work does not stand behind heavy work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lane {
    /// Work that a client may wait for.
    Quick,
    /// Everything else.
    Heavy,
}

impl Lane {
    /// Both lanes.
    pub const ALL: [Self; 2] = [Self::Quick, Self::Heavy];

    /// The lane of a process: quick when it may be run while the client waits.
    pub fn of(description: &Description) -> Self {
        if description.control.contains(&JobControl::SyncExecute) { Self::Quick } else { Self::Heavy }
    }

    /// The lane as the table writes it.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Quick => "quick",
            Self::Heavy => "heavy",
        }
    }
}

/// A row that is to be added.
#[derive(Debug, Clone, PartialEq)]
pub struct NewRow {
    /// Id of the process.
    pub process: String,
    /// Digest of the stored request.
    pub task: String,
    /// Key that makes a retry safe.
    pub key: Option<String>,
    /// Where it waits.
    pub lane: Lane,
    /// Memory it needs, in bytes.
    pub memory_bytes: u64,
}

/// A job as the table knows it.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Its id.
    pub id: JobId,
    /// Id of its process.
    pub process: String,
    /// Digest of the stored request.
    pub task: String,
    /// Memory it needs, in bytes.
    pub memory_bytes: u64,
    /// Where it stands.
    pub state: JobState,
    /// Percent done.
    pub percent: u8,
    /// A sentence for people.
    pub message: String,
    /// When it was accepted.
    pub created: OffsetDateTime,
    /// When it last began to run.
    pub started: Option<OffsetDateTime>,
    /// When it ended.
    pub finished: Option<OffsetDateTime>,
    /// When the row last changed.
    pub updated: OffsetDateTime,
    /// Which run of the job this is; a worker that holds another number has lost the row.
    pub fence: i64,
    /// Runs that have begun and were not given back.
    pub starts: i64,
    /// What came out, once the state is successful or failed.
    pub outcome: Option<Outcome>,
}

/// What came out of a job.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// It succeeded: its outputs by id, and its warnings.
    Success {
        /// The outputs.
        outputs: BTreeMap<String, Stored>,
        /// The warnings.
        warnings: Vec<Warning>,
    },
    /// It failed.
    Failure(Problem),
}

impl Outcome {
    /// The state of a job with this outcome.
    pub const fn state(&self) -> JobState {
        match self {
            Self::Success { .. } => JobState::Successful,
            Self::Failure(_) => JobState::Failed,
        }
    }
}

/// Which rows of the table are wanted.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Filter {
    /// Of one of these processes; empty for any.
    pub processes: Vec<String>,
    /// In one of these states; empty for any.
    pub states: Vec<JobState>,
    /// Accepted at this moment or later.
    pub from: Option<OffsetDateTime>,
    /// Accepted at this moment or earlier.
    pub to: Option<OffsetDateTime>,
    /// Having run for at least so many seconds.
    pub min_duration_s: Option<f64>,
    /// Having run for at most so many seconds.
    pub max_duration_s: Option<f64>,
    /// Older than this job: the next page.
    pub before: Option<JobId>,
    /// Most rows.
    pub limit: u32,
}
