use axum::body::Body;
use axum::http::Method;
use axum::http::StatusCode;
use biotope::app::Limits;
use bytes::Bytes;
use serde_json::json;

use crate::support::TestApp;
use crate::support::settings;

#[tokio::test]
async fn an_upload_is_named_by_its_digest_and_kept_once() {
    let app = TestApp::new().await;
    let upload = async |kind| app.ask(Method::POST, "/assets", &[("content-type", kind)], "abc").await;
    let first = upload("image/tiff").await;
    let digest = "sha256:ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
    assert_eq!(first.json(), json!({"digest": digest, "size": 3, "type": "image/tiff"}));
    let location = format!("/assets/{digest}");
    assert_eq!((first.status, first.header("location")), (StatusCode::CREATED, location.as_str()));
    let again = upload("text/plain").await;
    assert_eq!((again.status, &again.json()["type"]), (StatusCode::OK, &json!("image/tiff")));
    let bytes = app.get(&location).await;
    assert_eq!((bytes.text().as_str(), bytes.header("content-type")), ("abc", "image/tiff"));
    assert!(bytes.header("cache-control").contains("immutable"));
    assert!(bytes.header("content-security-policy").contains("sandbox"), "an uploaded page may do nothing here");
    let part = app.ask(Method::GET, &location, &[("range", "bytes=-1")], "").await;
    assert_eq!((part.status, part.text().as_str()), (StatusCode::PARTIAL_CONTENT, "c"));
    let (_, status) = app.finish("zoo", &json!({"inputs": {"terrain": {"href": location}}})).await;
    assert_eq!(status["status"], "successful");
}

#[tokio::test]
async fn an_unknown_asset_is_said_to_be_so() {
    let app = TestApp::new().await;
    app.get("/assets/sha256:00").await.assert_problem(404, "no-such-asset");
}

/// A body of two pieces with a pause between them.
fn slow_body() -> Body {
    let pieces = futures_util::stream::unfold(0, |at| async move {
        match at {
            0 => Some((Ok::<_, std::convert::Infallible>(Bytes::from_static(b"{")), 1)),
            _ => {
                tokio::time::sleep(std::time::Duration::from_secs(60)).await;
                None
            }
        }
    });
    Body::from_stream(pieces)
}

#[tokio::test]
async fn bodies_that_are_too_large_or_too_slow_are_refused() {
    let app = TestApp::with(settings(), Limits { body_mib: 1, upload_mib: 1, body_timeout_s: 1 }).await;
    let large = || vec![b' '; (1 << 20) + 1];
    for path in ["/assets", "/processes/echo/execution"] {
        app.ask(Method::POST, path, &[], large()).await.assert_problem(413, "body-too-large");
        let announced = [("content-length", "99999999999"), ("expect", "100-continue")];
        app.ask(Method::POST, path, &announced, slow_body()).await.assert_problem(413, "body-too-large");
        app.ask(Method::POST, path, &[], slow_body()).await.assert_problem(408, "body-too-slow");
    }
    let broken = futures_util::stream::iter([Ok(Bytes::from_static(b"{")), Err(std::io::Error::other("gone"))]);
    let reply = app.ask(Method::POST, "/assets", &[], Body::from_stream(broken)).await;
    reply.assert_problem(400, "body-unreadable");
}
