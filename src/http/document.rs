//! Answers that are JSON documents: with a tag, so that asking again costs little.

use axum::body::Body;
use axum::http::HeaderMap;
use axum::http::HeaderValue;
use axum::http::StatusCode;
use axum::http::header;
use axum::response::Html;
use axum::response::IntoResponse;
use axum::response::Response;
use serde::Serialize;

use crate::http::error::Answer;
use crate::http::error::ApiError;
use crate::jobs::Digest;
use crate::jobs::JobsError;

/// `value` as JSON, or 304 when the client holds the same bytes already.
pub fn json(headers: &HeaderMap, value: &impl Serialize) -> Answer {
    let bytes = serde_json::to_vec(value).map_err(JobsError::from)?;
    Ok(tagged(headers, "application/json", bytes))
}

/// A page for people.
pub fn page(html: String) -> Response {
    let mut response = Html(html).into_response();
    response.headers_mut().insert(header::CACHE_CONTROL, HeaderValue::from_static("no-cache"));
    response.headers_mut().insert(header::VARY, HeaderValue::from_static("Accept"));
    response
}

/// A document made when it is asked for: the client may keep it but has to ask whether it is
/// still the same.
pub fn tagged(headers: &HeaderMap, media_type: &'static str, bytes: Vec<u8>) -> Response {
    let tag = format!("W/\"{}\"", &Digest::of(&bytes).hex()[..32]);
    let mut answer = Response::new(Body::empty());
    let out = answer.headers_mut();
    out.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-cache"));
    out.insert(header::VARY, HeaderValue::from_static("Accept"));
    if let Ok(value) = HeaderValue::from_str(&tag) {
        out.insert(header::ETAG, value);
    }
    if holds(headers, &tag) {
        *answer.status_mut() = StatusCode::NOT_MODIFIED;
        return answer;
    }
    out.insert(header::CONTENT_TYPE, HeaderValue::from_static(media_type));
    *answer.body_mut() = Body::from(bytes);
    answer
}

/// Whether the client says that it holds what `tag` names.
pub fn holds(headers: &HeaderMap, tag: &str) -> bool {
    let bare = |tag: &str| tag.trim().trim_start_matches("W/").to_owned();
    let held = headers.get_all(header::IF_NONE_MATCH).iter().filter_map(|value| value.to_str().ok());
    held.flat_map(|value| value.split(',')).any(|held| held.trim() == "*" || bare(held) == bare(tag))
}

/// A status document of a job that was just made.
pub fn created(location: &str, value: &impl Serialize) -> Answer {
    let bytes = serde_json::to_vec(value).map_err(JobsError::from)?;
    let location = HeaderValue::from_str(location).map_err(|_| {
        ApiError::new(biotope_api::error::ErrorCode::Internal, "The address of the job cannot be written.")
    })?;
    let mut answer = Response::new(Body::from(bytes));
    *answer.status_mut() = StatusCode::CREATED;
    let out = answer.headers_mut();
    out.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/json"));
    out.insert(header::LOCATION, location);
    Ok(answer)
}
