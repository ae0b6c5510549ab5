//! `echo`: answers its input, after an optional pause. For trying clients out.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;
use serde_json::Value;

/// Inputs of `echo`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EchoInputs {
    /// What to answer: any JSON value.
    #[schemars(title = "Value")]
    pub value: Value,
    /// How long to wait before answering, in seconds. Default: 0.
    #[schemars(title = "Pause", range(min = 0.0, max = 3600.0))]
    #[serde(default)]
    pub pause_s: f64,
    /// Seed of the random numbers; echo draws none. Default: 0.
    #[schemars(title = "Seed")]
    #[serde(default)]
    pub seed: u64,
}
