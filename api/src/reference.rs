//! An input given by value or by reference.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;
use serde_json::Value;

/// Data that stands elsewhere in this service, or here as encoded bytes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Reference {
    /// By reference.
    Link(Href),
    /// By value.
    Inline(Inline),
}

/// Data by reference.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Href {
    /// `/assets/sha256:<hex>`, `/jobs/<id>/results/<output>`, or a `data:` address. In a request
    /// file run by the program itself, also a path relative to that file, or an output of another
    /// request file, which is then run first: `herd-extraction.json#ellipses`.
    pub href: String,
    /// Media type of the data; what the asset was uploaded as when absent.
    #[serde(rename = "type", default, skip_serializing_if = "Option::is_none")]
    pub media_type: Option<String>,
}

/// Data by value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Inline {
    /// The data: bytes as base64 text (with `encoding` "base64"), a text, or any JSON value.
    pub value: Value,
    /// Media type of the data.
    #[serde(rename = "mediaType", default, skip_serializing_if = "Option::is_none")]
    pub media_type: Option<String>,
    /// How the bytes are written as text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub encoding: Option<TextEncoding>,
}

/// How bytes are written as a JSON text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum TextEncoding {
    /// RFC 4648, padded.
    Base64,
}

/// A value that may also be given by reference to a document of the same form, such as another
/// job's output.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Given<T> {
    /// The value itself. It is tried first: a list of one value could be read as the fields of an
    /// envelope.
    Value(T),
    /// By reference, or by value in an envelope.
    Reference(Reference),
}

impl Reference {
    /// A reference to an address.
    pub fn to(href: impl Into<String>) -> Self {
        Self::Link(Href { href: href.into(), media_type: None })
    }
}
