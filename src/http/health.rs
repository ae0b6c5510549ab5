//! Whether the service is well, for people, supervisors and Prometheus.

use axum::Json;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::http::StatusCode;
use axum::http::header;
use axum::response::IntoResponse;
use biotope_api::error::ErrorCode;
use serde_json::json;

use crate::app::App;
use crate::http::document;
use crate::http::error::Answer;
use crate::http::error::ApiError;
use crate::http::pages;

/// Whether the service is well, its version, and how much it has to do.
#[utoipa::path(get, path = "/health", operation_id = "get_health", tag = "service",
    responses((status = 200, description = "The service is well.", content_type = "application/json",
        body = ref("#/components/schemas/Health"))))]
pub async fn get_health(State(app): State<App>) -> Answer {
    let counts = app.jobs.counts().await?;
    let status = if app.jobs.is_draining() { "draining" } else { "ok" };
    let jobs = json!({ "accepted": counts.accepted, "running": counts.running });
    Ok(Json(json!({ "status": status, "version": env!("CARGO_PKG_VERSION"), "jobs": jobs })).into_response())
}

/// Whether the process lives; asks nothing of it.
#[utoipa::path(get, path = "/livez", operation_id = "get_liveness", tag = "service",
    responses((status = 200, description = "It lives.", content_type = "text/plain", body = String)))]
pub async fn get_liveness() -> &'static str {
    "ok\n"
}

/// Whether the service takes work now.
#[utoipa::path(get, path = "/readyz", operation_id = "get_readiness", tag = "service",
    responses((status = 200, description = "It does.", content_type = "text/plain", body = String)))]
pub async fn get_readiness(State(app): State<App>) -> Answer {
    if app.jobs.is_draining() {
        return Err(ApiError::new(ErrorCode::Draining, "The service is about to stop."));
    }
    app.jobs.counts().await?;
    Ok((StatusCode::OK, "ok\n").into_response())
}

/// Counts and durations in the text form of Prometheus.
#[utoipa::path(get, path = "/metrics", operation_id = "get_metrics", tag = "service",
    responses((status = 200, description = "The metrics.", content_type = "text/plain", body = String)))]
pub async fn get_metrics(State(app): State<App>) -> Answer {
    let counts = app.jobs.counts().await?;
    metrics::gauge!("biotope_jobs_waiting").set(counts.accepted as f64);
    metrics::gauge!("biotope_jobs_running").set(counts.running as f64);
    app.metrics.run_upkeep();
    let text = app.metrics.render();
    Ok(([(header::CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")], text).into_response())
}

/// Every code of a problem and of a warning, with its meaning: a page for people.
#[utoipa::path(get, path = "/problems", operation_id = "get_problems", tag = "service",
    responses((status = 200, description = "The tables.", content_type = "text/html", body = String)))]
pub async fn get_problems(_headers: HeaderMap) -> Answer {
    Ok(document::page(pages::problems()))
}
