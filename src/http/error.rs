//! Errors as clients see them: one mapping, logged once, here.

use axum::http::HeaderMap;
use axum::http::HeaderValue;
use axum::http::StatusCode;
use axum::http::header;
use axum::response::IntoResponse;
use axum::response::Response;
use biotope_api::error::ErrorCode;
use biotope_api::error::Problem;

use crate::jobs::Invalid;
use crate::jobs::JobsError;
use crate::jobs::submit::Refused;

/// Seconds after which a client may try again when the queue is full.
const QUEUE_RETRY_S: &str = "5";

/// An error on its way to the client.
#[derive(Debug)]
pub struct ApiError {
    /// What the client reads.
    pub problem: Box<Problem>,
    headers: HeaderMap,
}

/// What a handler answers.
pub type Answer = Result<Response, ApiError>;

impl ApiError {
    /// A problem of the kind `code` with a sentence on this occurrence.
    pub fn new(code: ErrorCode, detail: impl Into<String>) -> Self {
        Problem::new(code, detail).into()
    }

    /// A fault in a parameter of the address or in a header, named `name`.
    pub fn parameter(code: ErrorCode, name: &str, expected: impl Into<String>, found: &str) -> Self {
        let faults = Invalid::new(name, code, expected, found);
        let mut problem = Problem::new(code, faults.to_string());
        problem.errors = faults.errors;
        problem.into()
    }

    /// There is no job of that id.
    pub fn no_such_job(id: &str) -> Self {
        Self::new(ErrorCode::NoSuchJob, format!("There is no job {id:?}."))
    }

    /// The same error with a further header.
    pub fn with_header(mut self, name: header::HeaderName, value: HeaderValue) -> Self {
        self.headers.insert(name, value);
        self
    }
}

impl From<Problem> for ApiError {
    fn from(problem: Problem) -> Self {
        Self { problem: Box::new(problem), headers: HeaderMap::new() }
    }
}

impl From<JobsError> for ApiError {
    fn from(error: JobsError) -> Self {
        tracing::error!(%error, "a request failed by a fault of ours");
        Self::new(ErrorCode::Internal, "The service could not answer; the fault has been logged.")
    }
}

impl From<Refused> for ApiError {
    fn from(refused: Refused) -> Self {
        match refused {
            Refused::Fault(error) => error.into(),
            Refused::Problem(problem) if problem.status == StatusCode::SERVICE_UNAVAILABLE.as_u16() => {
                Self::from(*problem).with_header(header::RETRY_AFTER, HeaderValue::from_static(QUEUE_RETRY_S))
            }
            Refused::Problem(problem) => (*problem).into(),
        }
    }
}

impl IntoResponse for ApiError {
    /// The problem travels beside the response; [`crate::http::problems`] writes it in the form
    /// the client reads.
    fn into_response(self) -> Response {
        let status = StatusCode::from_u16(self.problem.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
        let mut response = (status, self.headers).into_response();
        response.extensions_mut().insert(*self.problem);
        response
    }
}
