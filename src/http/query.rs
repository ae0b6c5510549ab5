//! Parameters of an address.

use std::convert::Infallible;

use axum::extract::FromRequestParts;
use axum::extract::Query;
use axum::http::request::Parts;
use biotope_api::error::ErrorCode;

use crate::http::error::ApiError;

/// The parameters of an address as they stand there. Unknown ones are ignored.
#[derive(Debug, Clone, Default)]
pub struct Params(Vec<(String, String)>);

impl<S: Sync> FromRequestParts<S> for Params {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Infallible> {
        Ok(Query::try_from_uri(&parts.uri).map(|Query(pairs)| Self(pairs)).unwrap_or_default())
    }
}

impl Params {
    /// The value of a parameter.
    pub fn one(&self, name: &str) -> Option<&str> {
        self.0.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str()).filter(|v| !v.is_empty())
    }

    /// All values of a parameter that may be repeated or hold several parted by commas.
    pub fn all(&self, name: &str) -> Vec<&str> {
        let values = self.0.iter().filter(|(known, _)| known == name);
        values.flat_map(|(_, value)| value.split(',')).filter(|value| !value.is_empty()).collect()
    }

    /// The value of a parameter, read by `read`.
    ///
    /// # Errors
    /// When it is there and cannot be read; `expected` says what was.
    pub fn read<T>(
        &self,
        name: &str,
        expected: &str,
        read: impl FnOnce(&str) -> Option<T>,
    ) -> Result<Option<T>, ApiError> {
        let fault = |found: &str| ApiError::parameter(ErrorCode::InvalidParameter, name, expected, found);
        self.one(name).map(|text| read(text).ok_or_else(|| fault(text))).transpose()
    }

    /// Entries a page may hold, 1 to 10,000. Default: 100.
    ///
    /// # Errors
    /// When it is out of range.
    pub fn limit(&self) -> Result<u32, ApiError> {
        let allowed = |text: &str| text.parse().ok().filter(|limit| (1..=10_000).contains(limit));
        Ok(self.read("limit", "a number from 1 to 10000", allowed)?.unwrap_or(100))
    }

    /// The address of the same page with one parameter changed.
    pub fn with(&self, path: &str, name: &str, value: &str) -> String {
        let kept = self.0.iter().filter(|(known, _)| known != name).map(|(n, v)| (n.as_str(), v.as_str()));
        let pairs: Vec<_> =
            kept.chain([(name, value)]).map(|(n, v)| format!("{}={}", encoded(n), encoded(v))).collect();
        format!("{path}?{}", pairs.join("&"))
    }
}

/// `text` with all but plain characters as percent signs.
pub fn encoded(text: &str) -> String {
    use std::fmt::Write as _;
    text.bytes().fold(String::new(), |mut out, byte| {
        if byte.is_ascii_alphanumeric() || b"-._~:".contains(&byte) {
            out.push(char::from(byte));
        } else {
            let _infallible = write!(out, "%{byte:02X}");
        }
        out
    })
}
