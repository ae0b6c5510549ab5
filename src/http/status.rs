//! A row as the status document of the standard.

use biotope_api::error::Problem;
use biotope_api::job::JobState;
use biotope_api::job::StatusInfo;
use biotope_api::link::Link;
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use crate::http::base::Base;
use crate::jobs::queue::Outcome;
use crate::jobs::queue::Row;

const OGC: &str = "http://www.opengis.net/def/rel/ogc/1.0/";

/// The address of a job, from the root of the service.
pub fn path_of(row: &Row) -> String {
    format!("/jobs/{}", row.id)
}

/// The status document of a job.
pub fn status_info(row: &Row, base: &Base) -> StatusInfo {
    let id = row.id.to_string();
    StatusInfo {
        job_id: id.clone(),
        id,
        kind: "process".into(),
        processing_entity_type: "ogc-api-processes".into(),
        process_id: row.process.clone(),
        status: row.state,
        message: message(row),
        progress: row.percent,
        created: moment(row.created),
        started: row.started.map(moment),
        finished: row.finished.map(moment),
        updated: moment(row.updated),
        exception: exception(row).cloned(),
        links: links(row, base),
    }
}

/// Why a job failed.
pub fn exception(row: &Row) -> Option<&Problem> {
    match &row.outcome {
        Some(Outcome::Failure(problem)) => Some(problem),
        _ => None,
    }
}

fn message(row: &Row) -> String {
    match (row.state, &row.outcome) {
        (JobState::Accepted, _) => "Waits its turn.".into(),
        (JobState::Running, _) if row.message.is_empty() => "Runs.".into(),
        (JobState::Running, _) => row.message.clone(),
        (JobState::Successful, Some(Outcome::Success { warnings, .. })) if !warnings.is_empty() => {
            format!("Done, with {} warnings.", warnings.len())
        }
        (JobState::Successful, _) => "Done.".into(),
        (JobState::Failed, Some(Outcome::Failure(problem))) => problem.detail.clone(),
        (JobState::Failed, _) => "Failed.".into(),
        (JobState::Dismissed, _) => "Dismissed.".into(),
    }
}

fn links(row: &Row, base: &Base) -> Vec<Link> {
    const JSON: &str = "application/json";
    let path = path_of(row);
    let link = |path: &str, rel: &str, kind: &str, title: &str| Link::new(base.url(path), rel, kind, title);
    let mut links = vec![
        link(&path, "self", JSON, "This document"),
        link(&format!("{path}?f=html"), "alternate", "text/html", "The job as a page"),
        link("/jobs", "up", JSON, "All jobs"),
        link(&format!("{path}/events"), "monitor", "text/event-stream", "Progress as it happens"),
    ];
    let results = format!("{path}/results");
    match row.state {
        JobState::Successful => links.push(link(&results, &format!("{OGC}results"), JSON, "The results")),
        JobState::Failed => links.push(link(&results, &format!("{OGC}exceptions"), JSON, "Why it failed")),
        _ => {}
    }
    links
}

/// RFC 3339 in UTC.
fn moment(at: OffsetDateTime) -> String {
    at.format(&Rfc3339).unwrap_or_default()
}
