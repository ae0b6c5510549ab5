//! Uploaded data, named by its digest.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

/// Uploaded data.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Asset {
    /// `sha256:` and 64 hexadecimal digits.
    pub digest: String,
    /// Size in bytes.
    pub size: u64,
    /// Media type it was uploaded as.
    #[serde(rename = "type")]
    pub media_type: String,
}
