//! What clients see: one file per resource, the same for all processes. No numbers are computed
//! here.

mod assets;
mod base;
mod body;
mod bytes;
mod document;
mod error;
mod events;
mod execution;
mod health;
mod jobs;
mod landing;
mod layers;
mod negotiate;
pub mod openapi;
mod pages;
mod prefer;
mod problems;
mod processes;
mod query;
mod results;
mod status;

use std::net::IpAddr;

use axum::Router;
use tokio::net::TcpListener;
use utoipa::OpenApi as _;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;
use utoipa_swagger_ui::Config;
use utoipa_swagger_ui::SwaggerUi;

use crate::app::App;
use crate::http::openapi::Documents;

/// Every route of the service, with its place in the document of the API.
fn routes() -> OpenApiRouter<App> {
    OpenApiRouter::with_openapi(openapi::Head::openapi())
        .routes(routes!(landing::get_landing))
        .routes(routes!(landing::get_conformance))
        .routes(routes!(processes::list_processes))
        .routes(routes!(processes::get_process))
        .routes(routes!(execution::execute_process))
        .routes(routes!(jobs::list_jobs))
        .routes(routes!(jobs::get_job, jobs::dismiss_job))
        .routes(routes!(results::get_results))
        .routes(routes!(results::get_output))
        .routes(routes!(events::watch_job))
        .routes(routes!(assets::upload_asset))
        .routes(routes!(assets::get_asset))
        .routes(routes!(openapi::get_yaml))
        .routes(routes!(openapi::get_json))
        .routes(routes!(openapi::get_json_3_0))
        .routes(routes!(health::get_health))
        .routes(routes!(health::get_liveness))
        .routes(routes!(health::get_readiness))
        .routes(routes!(health::get_metrics))
        .routes(routes!(health::get_problems))
}

/// The service.
pub fn router(app: App) -> Router {
    let documents = Documents::new(app.jobs.registry());
    let docs = SwaggerUi::new("/docs").config(Config::from("/openapi.json"));
    let router = routes().with_state(app).split_for_parts().0;
    let router = router.merge(docs).layer(axum::Extension(documents)).fallback(problems::not_found);
    layers::around(router)
}

/// Takes a port.
///
/// # Errors
/// When it is taken or may not be used.
pub async fn listen(host: IpAddr, port: u16) -> std::io::Result<TcpListener> {
    TcpListener::bind((host, port)).await
}

/// Answers at `listener` until dropped.
///
/// # Errors
/// When connections can no longer be accepted.
pub async fn serve(listener: TcpListener, app: App) -> std::io::Result<()> {
    axum::serve(listener, router(app)).await
}
