//! A link to another resource.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

/// A link to another resource, or to the same one in another form.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Link {
    /// Where to; relative addresses belong to this service.
    pub href: String,
    /// What the target is to the document that holds the link.
    pub rel: String,
    /// Media type of the target.
    #[serde(rename = "type")]
    pub media_type: String,
    /// What stands there, for people.
    pub title: String,
}

impl Link {
    /// A link with all its parts.
    pub fn new(
        href: impl Into<String>,
        rel: impl Into<String>,
        media_type: impl Into<String>,
        title: impl Into<String>,
    ) -> Self {
        Self { href: href.into(), rel: rel.into(), media_type: media_type.into(), title: title.into() }
    }
}
