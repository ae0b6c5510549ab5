//! Uploads, named by their digest.

use axum::Json;
use axum::body::Body;
use axum::extract::Path;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::http::HeaderValue;
use axum::http::StatusCode;
use axum::http::header;
use axum::response::IntoResponse;
use biotope_api::asset::Asset;
use biotope_api::error::ErrorCode;

use crate::app::App;
use crate::http::body::BodyLimits;
use crate::http::body::pieces;
use crate::http::bytes;
use crate::http::bytes::FileHead;
use crate::http::error::Answer;
use crate::http::error::ApiError;

/// Uploads bytes, to be referred to by their digest. The same bytes again are not kept twice.
#[utoipa::path(post, path = "/assets", operation_id = "upload_asset", tag = "assets",
    request_body(content = String, content_type = "application/octet-stream", description = "The bytes, as they are."),
    responses(
        (status = 200, description = "The bytes were known.", body = ref("#/components/schemas/Asset"),
            content_type = "application/json", headers(("Location" = String, description = "Address of the asset."))),
        (status = 201, description = "The bytes are new.", body = ref("#/components/schemas/Asset"),
            content_type = "application/json", headers(("Location" = String, description = "Address of the asset.")))))]
pub async fn upload_asset(State(app): State<App>, headers: HeaderMap, body: Body) -> Answer {
    let limits = BodyLimits { bytes: app.limits.upload_bytes(), time: app.limits.body_timeout() };
    let media_type = headers.get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok());
    let media_type = media_type.unwrap_or("application/octet-stream").to_owned();
    let pieces = Box::pin(pieces(&headers, body, limits));
    let uploaded = app.jobs.upload(media_type, pieces).await;
    let (asset, new) = uploaded.map_err(|error| error.unwrap_or_else(ApiError::from))?;
    let location = HeaderValue::from_str(&format!("/assets/{}", asset.digest))
        .map_err(|_| ApiError::new(ErrorCode::Internal, "The address of the asset cannot be written."))?;
    let status = if new { StatusCode::CREATED } else { StatusCode::OK };
    let asset = Asset { digest: asset.digest, size: asset.size, media_type: asset.media_type };
    Ok((status, [(header::LOCATION, location)], Json(asset)).into_response())
}

/// The bytes of an upload, also in ranges.
#[utoipa::path(get, path = "/assets/{digest}", operation_id = "get_asset", tag = "assets",
    params(("digest" = String, Path, description = "`sha256:` and 64 hexadecimal digits.")),
    responses((status = 200, description = "The bytes.", content_type = "application/octet-stream"),
        (status = 206, description = "A part of them.", content_type = "application/octet-stream"),
        (status = 304, description = "The client holds them already.")))]
pub async fn get_asset(State(app): State<App>, Path(digest): Path<String>, headers: HeaderMap) -> Answer {
    let unknown = || ApiError::new(ErrorCode::NoSuchAsset, format!("There is no asset {digest:?}."));
    let asset = app.jobs.asset(&digest).await?.ok_or_else(unknown)?;
    let delivery = app.jobs.deliver_asset(&digest).await?;
    let name = asset.digest.replace(':', "-");
    bytes::serve(&app.jobs, &headers, delivery, &FileHead { media_type: asset.media_type, name, immutable: true })
}
