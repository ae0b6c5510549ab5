//! What a job is.

use biotope_api::error::ErrorCode;
use serde_json::Value;

use crate::compute::run::Stopped;
use crate::jobs::Invalid;
use crate::jobs::JobContext;
use crate::storage::StoreError;

/// Work that is ready to run: its inputs have been parsed into values that cannot be wrong.
pub trait Job: Send {
    /// What the work will need.
    fn estimate(&self) -> Estimate;

    /// The inputs with every default filled in, for the manifest. References stay as they are.
    fn parameters(&self) -> Value;

    /// The stages the work goes through with their share of the time, in order; progress in
    /// percent is made from them. Names are those reported through the run.
    fn stages(&self) -> &'static [(&'static str, u32)] {
        &[]
    }

    /// Does the work on the pool of the job's worker: load, compute, store.
    ///
    /// # Errors
    /// [`Failure::Stopped`] when told to stop; otherwise why there is no result.
    fn run(self: Box<Self>, context: &mut JobContext) -> Result<(), Failure>;
}

/// What work will need.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Estimate {
    /// Most memory held at one time, in bytes, inputs included.
    pub memory_bytes: u64,
}

/// Why a job ended without results.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// It was told to stop.
    #[error("the work was stopped")]
    Stopped,
    /// The inputs turned out to be wrong in a way that only the work could show.
    #[error("the inputs are not valid: {0}")]
    Invalid(Invalid),
    /// It ended for a reason the client should know.
    #[error("{code}: {detail}")]
    Problem {
        /// What kind of reason.
        code: ErrorCode,
        /// A sentence for people.
        detail: String,
    },
    /// A fault of ours; the text is logged and not shown.
    #[error("{0}")]
    Fault(String),
}

impl Failure {
    /// A fault of ours.
    pub fn fault(error: impl std::fmt::Display) -> Self {
        Self::Fault(error.to_string())
    }
}

impl From<Stopped> for Failure {
    fn from(_: Stopped) -> Self {
        Self::Stopped
    }
}

impl From<Invalid> for Failure {
    fn from(invalid: Invalid) -> Self {
        Self::Invalid(invalid)
    }
}

impl From<StoreError> for Failure {
    fn from(error: StoreError) -> Self {
        Self::fault(error)
    }
}
