//! Where this service stands, as the client sees it.

use std::convert::Infallible;

use axum::extract::FromRequestParts;
use axum::http::HeaderMap;
use axum::http::header;
use axum::http::request::Parts;

/// Scheme and authority the client used, such as `http://127.0.0.1:8080`; empty when unknown.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Base(pub String);

impl Base {
    /// The address of `path` on this service.
    pub fn url(&self, path: &str) -> String {
        format!("{}{path}", self.0)
    }

    fn of(headers: &HeaderMap) -> Self {
        let text = |name: &str| headers.get(name).and_then(|value| value.to_str().ok());
        let host = text("x-forwarded-host").or_else(|| text(header::HOST.as_str()));
        let plain = |c: char| c.is_ascii_alphanumeric() || "-._:[]".contains(c);
        let scheme = text("x-forwarded-proto").filter(|scheme| *scheme == "https").unwrap_or("http");
        Self(host.filter(|host| host.chars().all(plain)).map(|host| format!("{scheme}://{host}")).unwrap_or_default())
    }
}

impl<S: Sync> FromRequestParts<S> for Base {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Infallible> {
        Ok(Self::of(&parts.headers))
    }
}
