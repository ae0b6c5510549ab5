//! Progress as it happens.

use std::convert::Infallible;
use std::time::Duration;

use axum::extract::Path;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::http::HeaderValue;
use axum::http::StatusCode;
use axum::http::header;
use axum::response::IntoResponse;
use axum::response::sse::Event;
use axum::response::sse::KeepAlive;
use axum::response::sse::Sse;
use biotope_api::job::ProgressEvent;
use futures_util::Stream;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;

use crate::app::App;
use crate::http::base::Base;
use crate::http::error::Answer;
use crate::http::jobs::find;
use crate::http::status::status_info;
use crate::jobs::progress::Event as Step;
use crate::jobs::queue::JobId;
use crate::jobs::queue::Row;

/// Longest silence of a stream.
const KEEP_ALIVE: Duration = Duration::from_secs(15);

/// Progress of a job as server-sent events: `progress` (stage, done, total, message) while it
/// runs, `status` (the status document) when its state changes; ends when the job has. A client
/// that comes back with `Last-Event-ID` is told what it has missed.
#[utoipa::path(get, path = "/jobs/{id}/events", operation_id = "watch_job", tag = "jobs",
    params(("id" = String, Path, description = "Id of the job."),
        ("Last-Event-ID" = Option<String>, Header, description = "The last event the client has seen.")),
    responses((status = 200, description = "The events.", content_type = "text/event-stream", body = String),
        (status = 204, description = "The client has seen the end.")))]
pub async fn watch_job(State(app): State<App>, Path(id): Path<String>, headers: HeaderMap, base: Base) -> Answer {
    let row = find(&app, &id).await?;
    let seen = headers.get("last-event-id").and_then(|value| value.to_str().ok()).map(Mark::parse).unwrap_or_default();
    if seen.ended && row.state.is_final() {
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    let (to_client, events) = mpsc::channel(64);
    tokio::spawn(follow(app, base, row.id, seen, to_client));
    let stream: ReceiverStream<Result<Event, Infallible>> = ReceiverStream::new(events);
    let mut answer = sse(stream).into_response();
    answer.headers_mut().insert(header::CACHE_CONTROL, HeaderValue::from_static("no-cache, no-transform"));
    answer.headers_mut().insert("x-accel-buffering", HeaderValue::from_static("no"));
    Ok(answer)
}

fn sse(
    stream: impl Stream<Item = Result<Event, Infallible>> + Send + 'static,
) -> Sse<impl Stream<Item = Result<Event, Infallible>>> {
    Sse::new(stream).keep_alive(KeepAlive::new().interval(KEEP_ALIVE))
}

/// What a client has seen: `<run>-<event>`, or `<run>-end`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Mark {
    fence: i64,
    number: u64,
    ended: bool,
}

impl Mark {
    fn parse(text: &str) -> Self {
        let (fence, number) = text.trim().split_once('-').unwrap_or_default();
        Self { fence: fence.parse().unwrap_or(0), number: number.parse().unwrap_or(0), ended: number == "end" }
    }
}

/// Sends what happens until the job has ended or the client has gone.
async fn follow(app: App, base: Base, id: JobId, mut seen: Mark, to_client: mpsc::Sender<Result<Event, Infallible>>) {
    let mut changes = app.jobs.changes();
    let mut told = None;
    loop {
        changes.mark_unchanged();
        let live = app.jobs.live(id);
        let Ok(Some(row)) = app.jobs.status(id).await else { return };
        if told != Some((row.state, row.fence)) {
            told = Some((row.state, row.fence));
            if !row.state.is_final() && to_client.send(Ok(state_event(&row, &base, None))).await.is_err() {
                return;
            }
        }
        if let Some(live) = live {
            let mut steps = live.subscribe();
            loop {
                if seen.fence != live.fence {
                    seen = Mark { fence: live.fence, ..Mark::default() };
                }
                for step in live.events_after(seen.number) {
                    seen.number = step.number;
                    if to_client.send(Ok(step_event(&step, live.fence))).await.is_err() {
                        return;
                    }
                }
                if app.jobs.live(id).is_none() {
                    break;
                }
                tokio::select! {
                    _ = steps.changed() => {}
                    _ = changes.changed() => {}
                    () = to_client.closed() => return,
                }
            }
            continue;
        }
        if row.state.is_final() {
            let _gone_or_not = to_client.send(Ok(state_event(&row, &base, Some("end")))).await;
            return;
        }
        tokio::select! {
            _ = changes.changed() => {}
            () = to_client.closed() => return,
        }
    }
}

fn step_event(step: &Step, fence: i64) -> Event {
    let data = ProgressEvent {
        stage: step.progress.stage.to_owned(),
        done: step.progress.done,
        total: step.progress.total,
        message: step.progress.message.clone(),
    };
    let text = serde_json::to_string(&data).unwrap_or_default();
    Event::default().event("progress").id(format!("{fence}-{}", step.number)).data(text)
}

fn state_event(row: &Row, base: &Base, mark: Option<&str>) -> Event {
    let text = serde_json::to_string(&status_info(row, base)).unwrap_or_default();
    let event = Event::default().event("status").data(text);
    match mark {
        Some(mark) => event.id(format!("{}-{mark}", row.fence)),
        None => event,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_client_that_comes_back_says_what_it_has_seen() {
        assert_eq!(Mark::parse("2-17"), Mark { fence: 2, number: 17, ended: false });
        assert_eq!(Mark::parse("2-end"), Mark { fence: 2, number: 0, ended: true });
        assert_eq!(Mark::parse("nonsense"), Mark::default());
    }
}
