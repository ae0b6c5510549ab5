//! Running a process.

use std::sync::LazyLock;
use std::time::Duration;

use axum::body::Body;
use axum::extract::Path;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::http::HeaderValue;
use axum::http::header;
use axum::response::Response;
use biotope_api::error::ErrorCode;
use biotope_api::execute::Execute;
use biotope_api::process::JobControl;
use serde_json::Value;
use tokio::time::Instant;

use crate::app::App;
use crate::http::base::Base;
use crate::http::body::BodyLimits;
use crate::http::body::read_whole;
use crate::http::document;
use crate::http::error::Answer;
use crate::http::error::ApiError;
use crate::http::prefer::Prefer;
use crate::http::results;
use crate::http::status::path_of;
use crate::http::status::status_info;
use crate::jobs::Invalid;
use crate::jobs::process::inputs_schema;
use crate::jobs::queue::Row;
use crate::jobs::references::each_href;
use crate::jobs::schema::InputCheck;
use crate::jobs::schema::read;
use crate::jobs::work::invalid_problem;

/// Longest Idempotency-Key.
const KEY_LIMIT: usize = 255;

/// Runs a process: as a job, or at once where the process allows it.
#[utoipa::path(post, path = "/processes/{id}/execution", operation_id = "execute_process", tag = "processes",
    params(("id" = String, Path, description = "Id of the process."),
        ("Prefer" = Option<String>, Header, description = "`respond-async`, `wait=<seconds>`."),
        ("Idempotency-Key" = Option<String>, Header, description = "A retry with the same key makes no second job.")),
    request_body(content = ref("#/components/schemas/Execute"), content_type = "application/json"),
    responses(
        (status = 200, description = "The results.", content_type = "application/json", body = ref("#/components/schemas/Results")),
        (status = 201, description = "A job was made.", body = ref("#/components/schemas/StatusInfo"),
            content_type = "application/json", headers(("Location" = String, description = "Address of the job.")))))]
pub async fn execute_process(
    State(app): State<App>,
    Path(id): Path<String>,
    headers: HeaderMap,
    base: Base,
    body: Body,
) -> Answer {
    let limits = BodyLimits { bytes: app.limits.body_bytes(), time: app.limits.body_timeout() };
    let key = idempotency_key(&headers)?;
    let unknown = || ApiError::new(ErrorCode::NoSuchProcess, format!("There is no process {id:?}."));
    let entry = app.jobs.registry().find(&id).ok_or_else(unknown)?;
    let quick = entry.description.control.contains(&JobControl::SyncExecute);
    let execute = parse(&read_whole(&headers, body, limits).await?, &base)?;
    let submitted = app.jobs.submit(&id, execute, key).await?;
    let prefer = Prefer::of(&headers);
    let row = await_end(&app, submitted.row, deadline(prefer, quick)).await?;
    if row.state.is_final() && !prefer.asynchronous && quick || prefer.wait.is_some() && row.state.is_final() {
        let mut answer = results::of_row(&app, &headers, &row, &base).await?;
        let monitor = HeaderValue::from_str(&format!("<{}>; rel=\"monitor\"", base.url(&path_of(&row))));
        answer.headers_mut().extend(monitor.ok().map(|link| (header::LINK, link)));
        return Ok(answer);
    }
    accepted(&row, &base, prefer)
}

/// Until when the answer waits for the job to end: not at all, for a while, or for ever (`None`).
fn deadline(prefer: Prefer, quick: bool) -> Option<Instant> {
    match prefer.wait {
        Some(wait) => Some(Instant::now() + wait),
        None if prefer.asynchronous || !quick => Some(Instant::now()),
        None => None,
    }
}

async fn await_end(app: &App, row: Row, deadline: Option<Instant>) -> Result<Row, ApiError> {
    if deadline.is_some_and(|deadline| deadline <= Instant::now() + Duration::from_millis(1)) {
        return Ok(row);
    }
    Ok(app.jobs.wait(row.id, deadline).await?.unwrap_or(row))
}

fn accepted(row: &Row, base: &Base, prefer: Prefer) -> Answer {
    let mut answer: Response = document::created(&path_of(row), &status_info(row, base))?;
    if prefer.asynchronous {
        answer.headers_mut().insert("preference-applied", HeaderValue::from_static("respond-async"));
    }
    Ok(answer)
}

/// Reads the body: JSON, of the form of an execution, its references to this service shortened.
fn parse(body: &[u8], base: &Base) -> Result<Execute, ApiError> {
    static CHECK: LazyLock<Result<InputCheck, String>> = LazyLock::new(|| InputCheck::new(&inputs_schema::<Execute>()));
    let not_json = |error| ApiError::new(ErrorCode::BodyNotJson, format!("The body is not JSON: {error}."));
    let mut value: Value = serde_json::from_slice(body).map_err(not_json)?;
    let check = CHECK.as_ref().map_err(|error| ApiError::new(ErrorCode::Internal, error.as_str()))?;
    check.check(&value).map_err(refuse)?;
    if !base.0.is_empty() {
        each_href(&mut value, &mut |href| {
            if let Some(path) = href.strip_prefix(&base.0).filter(|path| path.starts_with('/')) {
                *href = path.to_owned();
            }
        });
    }
    read(value).map_err(refuse)
}

fn refuse(invalid: Invalid) -> ApiError {
    invalid_problem(invalid).into()
}

fn idempotency_key(headers: &HeaderMap) -> Result<Option<String>, ApiError> {
    let Some(value) = headers.get("idempotency-key") else { return Ok(None) };
    let text = value.to_str().map(str::trim).unwrap_or_default();
    if text.is_empty() || text.len() > KEY_LIMIT {
        let expected = format!("1 to {KEY_LIMIT} plain characters");
        return Err(ApiError::parameter(ErrorCode::InvalidHeader, "Idempotency-Key", expected, text));
    }
    Ok(Some(text.to_owned()))
}
