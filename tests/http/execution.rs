use axum::http::Method;
use axum::http::StatusCode;
use serde_json::json;

use crate::support::TestApp;

#[tokio::test]
async fn a_quick_process_answers_at_once_and_a_heavy_one_by_a_job() {
    let app = TestApp::new().await;
    let now = app.execute("echo", &json!({"inputs": {"value": "hello"}}), &[("prefer", "respond-sync")]).await;
    assert_eq!((now.status, &now.json()["value"]), (StatusCode::OK, &json!("hello")));
    assert!(now.header("link").contains("rel=\"monitor\""));
    let later = app.execute("trouble", &json!({"inputs": {"kind": "fine"}}), &[]).await;
    assert_eq!(later.status, StatusCode::CREATED);
    assert!(later.header("location").starts_with("/jobs/"));
    assert_eq!(later.json()["status"], "accepted");
    let asked = app.execute("echo", &json!({"inputs": {"value": 1}}), &[("prefer", "respond-async ")]).await;
    assert_eq!((asked.status, asked.header("preference-applied")), (StatusCode::CREATED, "respond-async"));
}

#[tokio::test]
async fn an_answer_is_held_back_as_long_as_the_client_waits_and_no_longer() {
    let app = TestApp::new().await;
    let slow = json!({"inputs": {"value": 1, "pause_s": 30}});
    let reply = app.execute("echo", &slow, &[("prefer", "wait=1")]).await;
    assert_eq!(reply.status, StatusCode::CREATED);
    app.delete(reply.header("location")).await;
    let quick = app.execute("trouble", &json!({"inputs": {"kind": "fine"}}), &[("prefer", "wait=20")]).await;
    assert_eq!(quick.status, StatusCode::OK);
}

#[tokio::test]
async fn every_fault_of_a_request_is_reported_before_anything_is_queued() {
    let app = TestApp::new().await;
    let body = json!({"inputs": {"pause_s": -1, "colour": "red"}, "outputs": {"nothing": {}}});
    let problem = app.execute("echo", &body, &[]).await.assert_problem(400, "invalid-input");
    let mut faults: Vec<_> =
        problem["errors"].as_array().unwrap().iter().map(|e| (&e["pointer"], &e["code"])).collect();
    faults.sort_by_key(|(pointer, _)| pointer.to_string());
    let expected = [
        ("/inputs/colour", "unknown-field"),
        ("/inputs/pause_s", "out-of-range"),
        ("/inputs/value", "missing"),
        ("/outputs/nothing", "unknown-output"),
    ]
    .map(|(pointer, code)| (json!(pointer), json!(code)));
    assert_eq!(faults, expected.iter().map(|(a, b)| (a, b)).collect::<Vec<_>>());
    let both =
        app.execute("trouble", &json!({"inputs": {"kind": "parse"}}), &[]).await.assert_problem(400, "invalid-input");
    assert_eq!(both["errors"].as_array().unwrap().len(), 2);
    assert_eq!(both["errors"][0]["pointer"], "/inputs/kind");
    assert_eq!(app.get("/jobs").await.json()["jobs"], json!([]));
}

#[tokio::test]
async fn a_body_must_be_json_of_the_form_of_an_execution() {
    let app = TestApp::new().await;
    let post = async |body: &'static str| app.ask(Method::POST, "/processes/echo/execution", &[], body).await;
    post("{").await.assert_problem(400, "body-not-json");
    post("").await.assert_problem(400, "body-not-json");
    for (body, pointer) in
        [("[]", ""), (r#"{"inputs": 1}"#, "/inputs"), (r#"{"inputs": {}, "outputs": 3}"#, "/outputs")]
    {
        assert_eq!(post(body).await.assert_problem(400, "invalid-input")["errors"][0]["pointer"], pointer, "{body}");
    }
    let more = r#"{"inputs": {"value": 1}, "mode": "async", "subscriber": {}}"#;
    assert_eq!(post(more).await.status, StatusCode::OK, "unknown members are ignored");
}

#[tokio::test]
async fn a_retry_with_the_same_key_makes_no_second_job() {
    let app = TestApp::new().await;
    let (one, other) = (json!({"inputs": {"value": 1}}), json!({"inputs": {"value": 2}}));
    let headers = [("idempotency-key", "k"), ("prefer", "respond-async")];
    let first = app.execute("echo", &one, &headers).await;
    let again = app.execute("echo", &one, &headers).await;
    assert_eq!((first.status, again.status), (StatusCode::CREATED, StatusCode::CREATED));
    assert_eq!(first.header("location"), again.header("location"));
    app.execute("echo", &other, &headers).await.assert_problem(422, "idempotency-key-reused");
    app.execute("trouble", &one, &headers).await.assert_problem(400, "invalid-input");
    let long = "k".repeat(256);
    let problem = app.execute("echo", &one, &[("idempotency-key", &long)]).await.assert_problem(400, "invalid-header");
    assert_eq!(problem["errors"][0]["pointer"], "Idempotency-Key");
}

#[tokio::test]
async fn references_may_lead_into_this_service_only() {
    let app = TestApp::new().await;
    let run = async |href: &str| app.execute("zoo", &json!({"inputs": {"terrain": {"href": href}}}), &[]).await;
    for outside in ["terrain.tif", "../etc/passwd", "/etc/passwd", "file:///etc/passwd", "http://example.org/a.tif"] {
        let problem = run(outside).await.assert_problem(400, "invalid-input");
        let fault = &problem["errors"][0];
        assert_eq!((&fault["code"], &fault["pointer"]), (&json!("href-not-allowed"), &json!("/inputs/terrain")));
    }
    let unknown = format!("/assets/sha256:{}", "0".repeat(64));
    for missing in [unknown.as_str(), "/assets/x", "/jobs/x/results/y"] {
        let problem = run(missing).await.assert_problem(400, "invalid-input");
        assert_eq!(problem["errors"][0]["code"], "href-not-found", "{missing}");
    }
    assert_eq!(run("data:;base64,AAEC").await.status, StatusCode::CREATED);
    let inline = json!({"inputs": {"terrain": {"value": "AAEC", "encoding": "base64", "mediaType": "image/tiff"}}});
    assert_eq!(app.execute("zoo", &inline, &[]).await.status, StatusCode::CREATED);
}

#[tokio::test]
async fn a_job_takes_another_jobs_output_by_reference_in_its_structured_form() {
    let app = TestApp::new().await;
    let (first, _) = app.finish("zoo", &json!({"inputs": {"terrain": {"href": "data:,abc"}}})).await;
    for href in [format!("{first}/results/maps.height"), format!("http://biotope.test{first}/results/maps.height")] {
        let (second, status) = app.finish("zoo", &json!({"inputs": {"terrain": {"href": href}}})).await;
        assert_eq!(status["status"], "successful", "{status}");
        let manifest = app.get(&format!("{second}/results/manifest")).await.text();
        assert!(!manifest.contains("/jobs/") && manifest.contains("sha256:"), "{manifest}");
    }
}

#[tokio::test]
async fn work_that_needs_more_memory_than_there_is_is_refused() {
    let app = TestApp::new().await;
    let body = json!({"inputs": {"kind": "fine", "memory_bytes": 2_u64 << 30}});
    let problem = app.execute("trouble", &body, &[]).await.assert_problem(400, "needs-too-much-memory");
    assert_eq!(problem["errors"][0]["expected"], "at most 1024 MiB");
}
