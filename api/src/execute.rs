//! A request to run a process.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;
use serde_json::Map;
use serde_json::Value;

/// The body of an execution: what to work on and what to hand back. Members that are not named
/// here are ignored, since clients of other servers send some.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Execute {
    /// Value of each input, by its id; as the process describes them.
    #[serde(default)]
    pub inputs: Map<String, Value>,
    /// The outputs to keep, by id; an id may end in `.*` for all below it. Absent: all that the
    /// process keeps by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outputs: Option<BTreeMap<String, OutputChoice>>,
    /// How results are handed back. Default: `document`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub response: Option<ResponseForm>,
}

/// How one output is wanted.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct OutputChoice {
    /// In the document of results: by value or by reference. Default: small documents by value.
    #[serde(rename = "transmissionMode", default, skip_serializing_if = "Option::is_none")]
    pub transmission_mode: Option<TransmissionMode>,
    /// Media type wanted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub format: Option<OutputFormat>,
}

/// Media type wanted of an output.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct OutputFormat {
    /// The media type.
    #[serde(rename = "mediaType", default, skip_serializing_if = "Option::is_none")]
    pub media_type: Option<String>,
}

/// By value or by reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum TransmissionMode {
    /// The output stands in the document.
    Value,
    /// The document holds the address of the output.
    Reference,
}

/// How results are handed back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ResponseForm {
    /// One output: its bytes. Several: the document.
    Raw,
    /// A JSON document of all outputs.
    Document,
}
