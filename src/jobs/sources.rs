//! What stands behind a reference.

use biotope_api::error::ErrorCode;
use biotope_api::reference::Inline;
use biotope_api::reference::Reference;
use biotope_api::reference::TextEncoding;
use bytes::Bytes;
use serde_json::Value;

use crate::codec::map::Map;
use crate::jobs::Artefact;
use crate::jobs::Digest;
use crate::jobs::Invalid;
use crate::jobs::csv;

/// Gives what stands behind references. Synchronous; not for async threads.
pub trait Sources: Sync {
    /// What stands behind `reference`.
    ///
    /// # Errors
    /// When the reference is not of a kind that is allowed, or nothing stands there.
    fn open(&self, reference: &Reference) -> Result<Source, SourceError>;
}

/// What stands behind a reference.
#[derive(Debug, Clone)]
pub struct Source {
    /// Digest of the content, for memo keys and the manifest.
    pub digest: Digest,
    /// The content.
    pub content: Content,
}

/// The content of a source.
#[derive(Debug, Clone)]
pub enum Content {
    /// Bytes as the client gave them.
    Encoded {
        /// Media type the client named; `application/octet-stream` when none.
        media_type: String,
        /// The bytes.
        bytes: Bytes,
    },
    /// Another job's output in its structured form.
    Artefact(Artefact),
}

/// Why a reference gives nothing.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{code}: expected {expected}, found {found}")]
pub struct SourceError {
    /// What kind of fault.
    pub code: ErrorCode,
    /// What was expected.
    pub expected: String,
    /// What was found.
    pub found: String,
}

impl SourceError {
    /// A fault of the kind `code`.
    pub fn new(code: ErrorCode, expected: impl Into<String>, found: impl Into<String>) -> Self {
        Self { code, expected: expected.into(), found: found.into() }
    }

    /// The fault at the place in the inputs where the reference stands.
    pub fn at(self, pointer: &str) -> Invalid {
        Invalid::new(pointer, self.code, self.expected, self.found)
    }
}

impl Source {
    /// Bytes the client gave.
    pub fn encoded(media_type: impl Into<String>, bytes: Bytes) -> Self {
        let digest = Digest::of(&bytes);
        Self { digest, content: Content::Encoded { media_type: media_type.into(), bytes } }
    }

    /// The content as a JSON value: a document, a table as a list of records, or bytes that are
    /// JSON or a CSV table.
    ///
    /// # Errors
    /// When it is none of these.
    pub fn json(&self) -> Result<Value, SourceError> {
        match &self.content {
            Content::Artefact(Artefact::Json(value)) => Ok(value.clone()),
            Content::Artefact(Artefact::Table(table)) => Ok(table.records()),
            Content::Artefact(other) => Err(not_json(other.kind().name())),
            Content::Encoded { bytes, media_type } if media_type.contains("csv") => csv::records(bytes),
            Content::Encoded { bytes, media_type } => serde_json::from_slice(bytes).map_err(|_| not_json(media_type)),
        }
    }

    /// The map, when the source is another job's map.
    pub fn map(&self) -> Option<&Map> {
        match &self.content {
            Content::Artefact(Artefact::Map(map)) => Some(map),
            _ => None,
        }
    }

    /// The bytes of a file: as given, or another job's picture or file.
    pub fn bytes(&self) -> Option<(&str, &Bytes)> {
        match &self.content {
            Content::Encoded { media_type, bytes } => Some((media_type, bytes)),
            Content::Artefact(Artefact::Picture(bytes)) => Some(("image/png", bytes)),
            Content::Artefact(Artefact::Bytes { media_type, bytes, .. }) => Some((media_type, bytes)),
            Content::Artefact(_) => None,
        }
    }
}

fn not_json(found: &str) -> SourceError {
    SourceError::new(ErrorCode::Unreadable, "a JSON document", found)
}

/// Data given by value.
///
/// # Errors
/// When the text is not what its encoding says.
pub fn inline(inline: &Inline) -> Result<Source, SourceError> {
    let media = |default: &str| inline.media_type.clone().unwrap_or_else(|| default.to_owned());
    match (&inline.value, inline.encoding) {
        (Value::String(text), Some(TextEncoding::Base64)) => {
            Ok(Source::encoded(media("application/octet-stream"), from_base64(text)?))
        }
        (Value::String(text), None) => Ok(Source::encoded(media("text/plain"), Bytes::from(text.clone()))),
        (_, Some(TextEncoding::Base64)) => {
            Err(SourceError::new(ErrorCode::WrongType, "base64 text", "a value that is not a text"))
        }
        (value, None) => Ok(Source::encoded(media("application/json"), Bytes::from(value.to_string()))),
    }
}

/// Data in a `data:` address (RFC 2397).
///
/// # Errors
/// When the address is not of that form.
pub fn data_address(href: &str) -> Result<Source, SourceError> {
    let malformed = || SourceError::new(ErrorCode::Malformed, "data:[<media type>][;base64],<data>", "another form");
    let (head, data) = href.strip_prefix("data:").and_then(|rest| rest.split_once(',')).ok_or_else(malformed)?;
    let (media_type, base64) = match head.strip_suffix(";base64") {
        Some(media_type) => (media_type, true),
        None => (head, false),
    };
    let bytes = if base64 { from_base64(data)? } else { percent_decoded(data).ok_or_else(malformed)? };
    Ok(Source::encoded(if media_type.is_empty() { "text/plain" } else { media_type }, bytes))
}

fn from_base64(text: &str) -> Result<Bytes, SourceError> {
    use base64::Engine as _;
    base64::engine::general_purpose::STANDARD
        .decode(text)
        .map(Bytes::from)
        .map_err(|error| SourceError::new(ErrorCode::Malformed, "base64 text", error.to_string()))
}

fn percent_decoded(text: &str) -> Option<Bytes> {
    let mut out = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&byte, tail)) = rest.split_first() {
        rest = tail;
        if byte == b'%' {
            let digits = std::str::from_utf8(rest.get(..2)?).ok()?;
            out.push(u8::from_str_radix(digits, 16).ok()?);
            rest = &rest[2..];
        } else {
            out.push(byte);
        }
    }
    Some(Bytes::from(out))
}

/// Only what stands in the request itself: for tests.
#[derive(Debug, Clone, Copy, Default)]
pub struct ByValueOnly;

impl Sources for ByValueOnly {
    fn open(&self, reference: &Reference) -> Result<Source, SourceError> {
        match reference {
            Reference::Inline(value) => inline(value),
            Reference::Link(link) if link.href.starts_with("data:") => data_address(&link.href),
            Reference::Link(link) => {
                Err(SourceError::new(ErrorCode::HrefNotAllowed, "a data: address", link.href.as_str()))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(href: &str) -> Option<(String, Vec<u8>)> {
        let source = ByValueOnly.open(&Reference::to(href)).ok()?;
        source.bytes().map(|(media_type, bytes)| (media_type.to_owned(), bytes.to_vec()))
    }

    #[test]
    fn data_addresses_hold_bytes_as_base64_or_percent_signs() {
        assert_eq!(text("data:text/csv;base64,YSxi"), Some(("text/csv".into(), b"a,b".to_vec())));
        assert_eq!(text("data:,a%2Cb"), Some(("text/plain".into(), b"a,b".to_vec())));
        for wrong in ["data:", "data:;base64,*", "data:,%2", "data:,%zz", "http://example.org/a.tif", "a.tif"] {
            assert_eq!(text(wrong), None, "{wrong}");
        }
    }
}
