//! What is being done, was done, and is no longer wanted.

use axum::extract::Path;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::http::HeaderValue;
use axum::http::header;
use biotope_api::error::ErrorCode;
use biotope_api::job::JobList;
use biotope_api::job::JobState;
use biotope_api::link::Link;
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use crate::app::App;
use crate::http::base::Base;
use crate::http::document;
use crate::http::error::Answer;
use crate::http::error::ApiError;
use crate::http::negotiate::wants_page;
use crate::http::pages;
use crate::http::query::Params;
use crate::http::results;
use crate::http::status::status_info;
use crate::jobs::queue::Filter;
use crate::jobs::queue::JobId;
use crate::jobs::queue::Row;

/// Jobs, newest first.
#[utoipa::path(get, path = "/jobs", operation_id = "list_jobs", tag = "jobs",
    params(("limit" = Option<u32>, Query, minimum = 1, maximum = 10000, description = "Entries a page may hold."),
        ("type" = Option<String>, Query, description = "Kinds of jobs; there is only `process`."),
        ("processID" = Option<String>, Query, description = "Of these processes, parted by commas."),
        ("status" = Option<String>, Query, description = "In these states, parted by commas."),
        ("datetime" = Option<String>, Query, description = "Accepted at this moment or in this interval (RFC 3339, `a/b`, `../b`, `a/..`)."),
        ("minDuration" = Option<f64>, Query, description = "Having run for at least so many seconds."),
        ("maxDuration" = Option<f64>, Query, description = "Having run for at most so many seconds."),
        ("before" = Option<String>, Query, description = "Older than this job.")),
    responses((status = 200, description = "A page of jobs.", body = ref("#/components/schemas/JobList"),
        content_type = "application/json")))]
pub async fn list_jobs(State(app): State<App>, headers: HeaderMap, base: Base, params: Params) -> Answer {
    let filter = filter(&params)?;
    let limit = filter.limit as usize;
    let only_others = !params.all("type").is_empty() && !params.all("type").contains(&"process");
    let rows =
        if only_others { Vec::new() } else { app.jobs.list(Filter { limit: filter.limit + 1, ..filter }).await? };
    let mut links = vec![
        Link::new(base.url("/jobs"), "self", "application/json", "This document"),
        Link::new(base.url("/jobs?f=html"), "alternate", "text/html", "This document as a page"),
    ];
    if let Some(last) = rows.get(limit).and(rows.get(limit.saturating_sub(1))) {
        let next = params.with("/jobs", "before", &last.id.to_string());
        links.push(Link::new(base.url(&next), "next", "application/json", "Older jobs"));
    }
    let jobs = rows.iter().take(limit).map(|row| status_info(row, &base)).collect();
    let list = JobList { jobs, links };
    if wants_page(&headers, params.one("f"))? {
        return Ok(document::page(pages::jobs(&list)));
    }
    document::json(&headers, &list)
}

fn filter(params: &Params) -> Result<Filter, ApiError> {
    let (from, to) = match params.read("datetime", "a moment or an interval of RFC 3339", interval)? {
        Some((from, to)) => (from, to),
        None => (None, None),
    };
    let seconds = |text: &str| text.parse::<f64>().ok().filter(|s| s.is_finite() && *s >= 0.0);
    Ok(Filter {
        processes: params.all("processID").into_iter().map(str::to_owned).collect(),
        states: states(params)?,
        from,
        to,
        min_duration_s: params.read("minDuration", "a number of seconds", seconds)?,
        max_duration_s: params.read("maxDuration", "a number of seconds", seconds)?,
        before: params.read("before", "the id of a job", JobId::parse)?,
        limit: params.limit()?,
    })
}

fn states(params: &Params) -> Result<Vec<JobState>, ApiError> {
    let expected = "accepted, running, successful, failed or dismissed";
    let fault = |found: &str| ApiError::parameter(ErrorCode::InvalidParameter, "status", expected, found);
    params.all("status").into_iter().map(|name| JobState::from_name(name).ok_or_else(|| fault(name))).collect()
}

type Interval = (Option<OffsetDateTime>, Option<OffsetDateTime>);

/// `a`, `a/b`, `../b`, `a/..`.
fn interval(text: &str) -> Option<Interval> {
    let end = |text: &str| match text {
        "" | ".." => Some(None),
        // A plus sign in an address is read as a blank.
        text => OffsetDateTime::parse(&text.replace(' ', "+"), &Rfc3339).ok().map(Some),
    };
    match text.split_once('/') {
        Some((from, to)) => Some((end(from)?, end(to)?)),
        None => end(text).map(|at| (at, at)),
    }
}

/// The row of a job.
///
/// # Errors
/// When there is no such job.
pub async fn find(app: &App, id: &str) -> Result<Row, ApiError> {
    let parsed = JobId::parse(id).ok_or_else(|| ApiError::no_such_job(id))?;
    app.jobs.status(parsed).await?.ok_or_else(|| ApiError::no_such_job(id))
}

/// Status of a job; as a page, with its results.
#[utoipa::path(get, path = "/jobs/{id}", operation_id = "get_job", tag = "jobs",
    params(("id" = String, Path, description = "Id of the job.")),
    responses((status = 200, description = "The status.", body = ref("#/components/schemas/StatusInfo"),
        content_type = "application/json")))]
pub async fn get_job(
    State(app): State<App>,
    Path(id): Path<String>,
    headers: HeaderMap,
    base: Base,
    params: Params,
) -> Answer {
    let row = find(&app, &id).await?;
    if wants_page(&headers, params.one("f"))? {
        return results::page(&app, &row, &base).await;
    }
    let mut answer = document::json(&headers, &status_info(&row, &base))?;
    if !row.state.is_final() {
        answer.headers_mut().insert(header::RETRY_AFTER, HeaderValue::from_static("1"));
    }
    Ok(answer)
}

/// Gives a job up: its work stops within a second and its results are gone.
#[utoipa::path(delete, path = "/jobs/{id}", operation_id = "dismiss_job", tag = "jobs",
    params(("id" = String, Path, description = "Id of the job.")),
    responses((status = 200, description = "The status, now `dismissed`.",
        body = ref("#/components/schemas/StatusInfo"), content_type = "application/json")))]
pub async fn dismiss_job(State(app): State<App>, Path(id): Path<String>, headers: HeaderMap, base: Base) -> Answer {
    let row = find(&app, &id).await?;
    app.jobs.dismiss(row.id).await?;
    let row = find(&app, &id).await?;
    document::json(&headers, &status_info(&row, &base))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_and_intervals_are_read_and_nothing_else() {
        let at = OffsetDateTime::parse("2026-11-22T10:00:00Z", &Rfc3339).ok();
        assert_eq!(interval("2026-11-22T10:00:00Z"), Some((at, at)));
        assert_eq!(interval("2026-11-22T11:00:00 01:00/.."), Some((at, None)));
        assert_eq!(interval("../2026-11-22T10:00:00Z"), Some((None, at)));
        for wrong in ["yesterday", "2026-11-22", "a/b"] {
            assert_eq!(interval(wrong), None, "{wrong}");
        }
    }
}
