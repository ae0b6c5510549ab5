//! What happens to every request and answer.

use std::time::Instant;

use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::extract::MatchedPath;
use axum::extract::Request;
use axum::http::HeaderName;
use axum::http::HeaderValue;
use axum::http::Method;
use axum::http::header;
use axum::middleware::Next;
use axum::middleware::from_fn;
use axum::response::IntoResponse;
use axum::response::Response;
use biotope_api::error::ErrorCode;
use tower_http::catch_panic::CatchPanicLayer;
use tower_http::compression::CompressionLayer;
use tower_http::compression::Predicate as _;
use tower_http::compression::predicate::DefaultPredicate;
use tower_http::compression::predicate::NotForContentType;
use tower_http::cors::Any;
use tower_http::cors::CorsLayer;
use tower_http::request_id::MakeRequestUuid;
use tower_http::request_id::PropagateRequestIdLayer;
use tower_http::request_id::SetRequestIdLayer;

use crate::http::error::ApiError;
use crate::http::problems;

/// The router inside all of its layers; the last one named is the outermost.
pub fn around(router: Router) -> Router {
    router
        .layer(DefaultBodyLimit::disable())
        .layer(CatchPanicLayer::custom(|_: Box<dyn std::any::Any + Send>| panicked()))
        .layer(from_fn(problems::layer))
        .layer(compression())
        .layer(from_fn(weaken_tags))
        .layer(cors())
        .layer(from_fn(observe))
        .layer(PropagateRequestIdLayer::x_request_id())
        .layer(SetRequestIdLayer::x_request_id(MakeRequestUuid))
}

fn panicked() -> Response {
    tracing::error!("a handler panicked");
    ApiError::new(ErrorCode::Internal, "The service could not answer; the fault has been logged.").into_response()
}

/// Text is compressed; event streams, pictures and rasters are not.
fn compression() -> CompressionLayer<impl tower_http::compression::Predicate> {
    CompressionLayer::new().compress_when(
        DefaultPredicate::new()
            .and(NotForContentType::const_new("image/tiff"))
            .and(NotForContentType::const_new("application/octet-stream")),
    )
}

/// Compressed bytes are not the bytes a strong tag names.
async fn weaken_tags(request: Request, next: Next) -> Response {
    let mut answer = next.run(request).await;
    if answer.headers().contains_key(header::CONTENT_ENCODING)
        && let Some(tag) = answer.headers().get(header::ETAG).and_then(|tag| tag.to_str().ok())
        && !tag.starts_with("W/")
        && let Ok(weak) = HeaderValue::from_str(&format!("W/{tag}"))
    {
        answer.headers_mut().insert(header::ETAG, weak);
        answer.headers_mut().remove(header::ACCEPT_RANGES);
    }
    answer
}

/// Any page may use the service; it knows no cookies.
fn cors() -> CorsLayer {
    let named = [
        "location",
        "link",
        "etag",
        "preference-applied",
        "retry-after",
        "content-range",
        "content-disposition",
        "x-request-id",
    ];
    CorsLayer::new()
        .allow_origin(Any)
        .allow_headers(Any)
        .allow_methods([Method::GET, Method::HEAD, Method::POST, Method::DELETE])
        .expose_headers(named.map(HeaderName::from_static))
}

/// Logs and counts every request.
async fn observe(request: Request, next: Next) -> Response {
    let begin = Instant::now();
    let method = request.method().clone();
    let path = request.uri().path().to_owned();
    let route = request.extensions().get::<MatchedPath>().map_or("none", MatchedPath::as_str).to_owned();
    let id = request.headers().get("x-request-id").and_then(|id| id.to_str().ok()).unwrap_or("").to_owned();
    let answer = next.run(request).await;
    let status = answer.status().as_u16();
    let duration = begin.elapsed();
    tracing::debug!(%method, path, status, duration_ms = duration.as_millis() as u64, request_id = id, "answered");
    let labels = [("method", method.to_string()), ("route", route), ("status", status.to_string())];
    metrics::counter!("biotope_http_requests_total", &labels).increment(1);
    metrics::histogram!("biotope_http_request_duration_seconds", &labels[..2]).record(duration.as_secs_f64());
    answer
}
