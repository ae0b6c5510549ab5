//! The state of a job.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

use crate::error::Problem;
use crate::link::Link;

/// Where a job stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum JobState {
    /// Waits its turn.
    Accepted,
    /// Is being worked on.
    Running,
    /// Done; the results are there.
    Successful,
    /// Ended without results; `exception` says why.
    Failed,
    /// Given up at the client's wish.
    Dismissed,
}

impl JobState {
    /// The state as it stands on the wire.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Accepted => "accepted",
            Self::Running => "running",
            Self::Successful => "successful",
            Self::Failed => "failed",
            Self::Dismissed => "dismissed",
        }
    }

    /// The state of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Accepted, Self::Running, Self::Successful, Self::Failed, Self::Dismissed]
            .into_iter()
            .find(|state| state.as_str() == name)
    }

    /// Whether nothing will change any more, unless the client dismisses the job.
    pub const fn is_final(self) -> bool {
        matches!(self, Self::Successful | Self::Failed | Self::Dismissed)
    }
}

/// Status of a job: the fields of OGC API – Processes 1.0 and of the draft of 2.0 side by side.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct StatusInfo {
    /// Id of the job (1.0).
    #[serde(rename = "jobID")]
    pub job_id: String,
    /// Id of the job (2.0).
    pub id: String,
    /// Always `process` (1.0).
    #[serde(rename = "type")]
    pub kind: String,
    /// Always `ogc-api-processes` (2.0).
    #[serde(rename = "processingEntityType")]
    pub processing_entity_type: String,
    /// Id of the process.
    #[serde(rename = "processID")]
    pub process_id: String,
    /// Where the job stands.
    pub status: JobState,
    /// A sentence for people.
    pub message: String,
    /// Percent done, 0 to 100.
    pub progress: u8,
    /// When the job was accepted, RFC 3339 in UTC.
    pub created: String,
    /// When it began to run, last.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub started: Option<String>,
    /// When it ended.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub finished: Option<String>,
    /// When this status last changed.
    pub updated: String,
    /// Why it failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exception: Option<Problem>,
    /// Related resources.
    pub links: Vec<Link>,
}

/// A page of the list of jobs, newest first.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct JobList {
    /// The jobs.
    pub jobs: Vec<StatusInfo>,
    /// This page in its forms, and the next one.
    pub links: Vec<Link>,
}

/// One event of a job's stream: how far it is, or how it stands.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct ProgressEvent {
    /// The stage, a dotted lower-case name.
    pub stage: String,
    /// Steps done.
    pub done: u64,
    /// Steps in the stage.
    pub total: u64,
    /// A sentence for people; may be empty.
    pub message: String,
}
