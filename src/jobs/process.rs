//! What a process is.

use biotope_api::process::JobControl;
use schemars::JsonSchema;
use schemars::Schema;
use schemars::SchemaGenerator;
use serde_json::Value;

use crate::jobs::Invalid;
use crate::jobs::Job;
use crate::jobs::Sources;
use crate::jobs::artefact::Kind;

/// Something the service can do.
pub trait Process: Send + Sync {
    /// What it is called, takes and gives. Asked once, when the service starts.
    fn description(&self) -> Description;

    /// Makes a job out of inputs that already fit the schema of the description.
    ///
    /// Called twice: at the edge, so that a fault is answered before anything is queued, and in
    /// the worker, from the stored inputs. Never on an async thread. Beside the schema it checks
    /// what a schema cannot say (contents of rasters, sums, cycles) and reports **all** faults it
    /// can find; pointers are relative to the inputs (`/terrain`).
    ///
    /// # Errors
    /// Everything that is wrong with the inputs.
    fn parse(&self, inputs: Value, sources: &dyn Sources) -> Result<Box<dyn Job>, Invalid>;
}

/// What a process is called, takes and gives.
#[derive(Debug, Clone)]
pub struct Description {
    /// Its id on the wire, lower case with dashes.
    pub id: &'static str,
    /// Its name for people.
    pub title: &'static str,
    /// What it does, in one or two sentences.
    pub text: &'static str,
    /// Version of its results; to be raised whenever the same inputs give other bytes.
    pub version: &'static str,
    /// Words to find it by.
    pub keywords: &'static [&'static str],
    /// How it may be run: [`ASYNC`] for heavy work, [`QUICK`] for work of well under a second.
    pub control: &'static [JobControl],
    /// Schema of its inputs, an object; see [`inputs_schema`].
    pub inputs: Schema,
    /// Its outputs. `manifest` and `warnings` are added for every process.
    pub outputs: Vec<Output>,
}

/// Heavy work: runs as a job only.
pub const ASYNC: &[JobControl] = &[JobControl::AsyncExecute, JobControl::Dismiss];

/// Quick work: also answers at once.
pub const QUICK: &[JobControl] = &[JobControl::SyncExecute, JobControl::AsyncExecute, JobControl::Dismiss];

/// One output of a process, or a family of them.
#[derive(Debug, Clone)]
pub struct Output {
    /// Its id. `<slug>`, `<mm>` and the like stand for a part without dots.
    pub id: &'static str,
    /// Its name for people.
    pub title: &'static str,
    /// What it holds.
    pub text: &'static str,
    /// What kind of thing it is, which says the media types it can be had in.
    pub kind: Kind,
    /// Unit of its values; empty when there is none.
    pub unit: &'static str,
    /// Whether it is kept when a request names no outputs.
    pub default: bool,
}

impl Output {
    /// An output that is kept by default and has no unit.
    pub const fn new(id: &'static str, title: &'static str, text: &'static str, kind: Kind) -> Self {
        Self { id, title, text, kind, unit: "", default: true }
    }

    /// The same output with a unit.
    pub const fn in_unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }

    /// The same output, kept only when asked for.
    pub const fn on_request(mut self) -> Self {
        self.default = false;
        self
    }
}

/// The schema of an inputs type, self-contained.
pub fn inputs_schema<T: JsonSchema>() -> Schema {
    SchemaGenerator::default().into_root_schema_for::<T>()
}
