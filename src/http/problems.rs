//! Every answer that is an error becomes a problem document, in the form the client reads;
//! also those that the framework made.

use axum::body::Body;
use axum::extract::Request;
use axum::http::HeaderValue;
use axum::http::StatusCode;
use axum::http::header;
use axum::middleware::Next;
use axum::response::Html;
use axum::response::IntoResponse;
use axum::response::Response;
use biotope_api::error::ErrorCode;
use biotope_api::error::Problem;

use crate::http::error::ApiError;
use crate::http::negotiate::Accept;
use crate::http::pages;

/// The layer.
pub async fn layer(request: Request, next: Next) -> Response {
    let accept = Accept::of(request.headers());
    let response = next.run(request).await;
    let status = response.status();
    if !(status.is_client_error() || status.is_server_error()) {
        return response;
    }
    let problem = response.extensions().get::<Problem>().cloned().unwrap_or_else(|| of_status(status));
    render(&problem, &accept, response)
}

/// The answer to an address that leads nowhere.
pub async fn not_found(request: Request) -> ApiError {
    ApiError::new(ErrorCode::NotFound, format!("There is nothing at {}.", request.uri().path()))
}

/// The problem of an answer that the framework made.
fn of_status(status: StatusCode) -> Problem {
    let code = match status {
        StatusCode::NOT_FOUND => ErrorCode::NotFound,
        StatusCode::METHOD_NOT_ALLOWED => ErrorCode::MethodNotAllowed,
        StatusCode::PAYLOAD_TOO_LARGE => ErrorCode::BodyTooLarge,
        StatusCode::REQUEST_TIMEOUT => ErrorCode::BodyTooSlow,
        StatusCode::UNSUPPORTED_MEDIA_TYPE => ErrorCode::UnsupportedMediaType,
        StatusCode::RANGE_NOT_SATISFIABLE => ErrorCode::RangeNotSatisfiable,
        status if status.is_client_error() => ErrorCode::InvalidParameter,
        _ => ErrorCode::Internal,
    };
    Problem { status: status.as_u16(), ..Problem::new(code, code.meaning()) }
}

/// The problem in the form the client reads, under the headers the answer had. The official
/// test suite wants `application/json` where only that is accepted.
fn render(problem: &Problem, accept: &Accept, answer: Response) -> Response {
    let (mut parts, _) = answer.into_parts();
    parts.headers.remove(header::CONTENT_LENGTH);
    parts.headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    if accept.prefers_html() {
        let page = Html(pages::problem(problem)).into_response();
        parts.headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("text/html; charset=utf-8"));
        return Response::from_parts(parts, page.into_body());
    }
    let media_type = if accept.is_only_json() { "application/json" } else { "application/problem+json" };
    parts.headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(media_type));
    let body = serde_json::to_vec(problem).unwrap_or_default();
    Response::from_parts(parts, Body::from(body))
}
