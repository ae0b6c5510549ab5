//! What processes there are, and what one takes and gives.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;
use serde_json::Value;

use crate::link::Link;

/// How a process may be run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum JobControl {
    /// The results come in the answer.
    SyncExecute,
    /// The answer names a job.
    AsyncExecute,
    /// A job can be given up.
    Dismiss,
}

/// A process in short.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ProcessSummary {
    /// Id of the process.
    pub id: String,
    /// Name for people.
    pub title: String,
    /// What it does.
    pub description: String,
    /// Version of its results: the same version, inputs and seed give the same bytes.
    pub version: String,
    /// Words to find it by.
    pub keywords: Vec<String>,
    /// How it may be run.
    #[serde(rename = "jobControlOptions")]
    pub job_control_options: Vec<JobControl>,
    /// How outputs may be handed back: `value`, `reference`.
    #[serde(rename = "outputTransmission")]
    pub output_transmission: Vec<String>,
    /// Related resources.
    pub links: Vec<Link>,
}

/// A process with its inputs and outputs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ProcessDescription {
    /// The process in short.
    #[serde(flatten)]
    pub summary: ProcessSummary,
    /// Its inputs by id.
    pub inputs: BTreeMap<String, InputDescription>,
    /// Its outputs by id; `<slug>` in an id stands for a species, `<mm>` for a month.
    pub outputs: BTreeMap<String, OutputDescription>,
}

/// An input of a process.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct InputDescription {
    /// Name for people.
    pub title: String,
    /// What it is, with its unit and frame.
    pub description: String,
    /// JSON schema of its value.
    pub schema: Value,
    /// 1 when it must be given.
    #[serde(rename = "minOccurs")]
    pub min_occurs: u32,
    /// Always 1: lists are arrays.
    #[serde(rename = "maxOccurs")]
    pub max_occurs: u32,
}

/// An output of a process.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct OutputDescription {
    /// Name for people.
    pub title: String,
    /// What it is.
    pub description: String,
    /// JSON schema, with the media types it can be had in.
    pub schema: Value,
    /// Media types it can be had in, the default first.
    #[serde(rename = "mediaTypes")]
    pub media_types: Vec<String>,
    /// Unit of its values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Whether it is kept when a request names no outputs.
    pub default: bool,
}

/// The processes of the service.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ProcessList {
    /// The processes.
    pub processes: Vec<ProcessSummary>,
    /// This page in its forms, and the next one.
    pub links: Vec<Link>,
}

/// The entrance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Landing {
    /// Name of the service.
    pub title: String,
    /// What it does.
    pub description: String,
    /// Version of the service.
    pub version: String,
    /// Where to go from here.
    pub links: Vec<Link>,
}

/// The classes of the standard the service keeps.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Conformance {
    /// Their addresses.
    #[serde(rename = "conformsTo")]
    pub conforms_to: Vec<String>,
}
