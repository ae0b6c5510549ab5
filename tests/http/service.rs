use axum::http::StatusCode;

use crate::support::TestApp;

#[tokio::test]
async fn the_entrance_leads_to_everything_an_ogc_client_looks_for() {
    let app = TestApp::new().await;
    let landing = app.get("/").await.json();
    let links = landing["links"].as_array().unwrap();
    let rels: Vec<_> = links.iter().map(|link| link["rel"].as_str().unwrap()).collect();
    for rel in ["conformance", "processes", "job-list"] {
        assert!(rels.contains(&format!("http://www.opengis.net/def/rel/ogc/1.0/{rel}").as_str()), "{rel}");
    }
    let described: Vec<_> = links.iter().filter(|link| link["rel"] == "service-desc").collect();
    assert!(described.iter().any(|link| link["type"] == "application/vnd.oai.openapi+json;version=3.0"));
    for link in links {
        let path = link["href"].as_str().unwrap().strip_prefix("http://biotope.test").expect("an absolute address");
        assert_eq!(app.get(path).await.status, StatusCode::OK, "{path}");
    }
}

#[tokio::test]
async fn health_counts_jobs_and_metrics_name_them() {
    let app = TestApp::new().await;
    app.finish("echo", &serde_json::json!({"inputs": {"value": 1}})).await;
    let health = app.get("/health").await.json();
    assert_eq!(health["status"], "ok");
    assert_eq!(health["jobs"]["running"], 0);
    let metrics = app.get("/metrics").await.text();
    assert!(metrics.contains("biotope_jobs_ended_total"), "{metrics}");
    assert_eq!(app.get("/livez").await.status, StatusCode::OK);
    assert_eq!(app.get("/readyz").await.status, StatusCode::OK);
}

#[tokio::test]
async fn a_service_that_drains_is_not_ready_and_takes_no_work() {
    let app = TestApp::new().await;
    app.app.jobs.drain(std::time::Duration::from_millis(10)).await;
    app.get("/readyz").await.assert_problem(503, "draining");
    let body = serde_json::json!({"inputs": {"value": 1}});
    let reply = app.execute("echo", &body, &[]).await;
    reply.assert_problem(503, "draining");
    assert!(!reply.header("retry-after").is_empty());
}

#[tokio::test]
async fn every_answer_carries_a_request_id_and_may_be_read_by_any_page() {
    let app = TestApp::new().await;
    let headers = [("x-request-id", "mine"), ("origin", "http://elsewhere.test")];
    let reply = app.ask(axum::http::Method::GET, "/jobs", &headers, "").await;
    assert_eq!(reply.header("x-request-id"), "mine");
    assert_eq!(reply.header("access-control-allow-origin"), "*");
    assert!(reply.header("access-control-expose-headers").contains("location"));
    assert!(!app.get("/").await.header("x-request-id").is_empty());
}

#[tokio::test]
async fn documents_are_compressed_and_answered_304_when_the_client_holds_them() {
    let app = TestApp::new().await;
    let zipped = app.ask(axum::http::Method::GET, "/openapi.json", &[("accept-encoding", "gzip")], "").await;
    assert_eq!(zipped.header("content-encoding"), "gzip");
    let tag = app.get("/processes").await.header("etag").to_owned();
    let again = app.ask(axum::http::Method::GET, "/processes", &[("if-none-match", &tag)], "").await;
    assert_eq!((again.status, again.bytes.len()), (StatusCode::NOT_MODIFIED, 0));
}

#[tokio::test]
async fn the_documentation_is_served_from_the_program() {
    let app = TestApp::new().await;
    let page = app.get("/docs/").await;
    assert_eq!(page.status, StatusCode::OK);
    assert!(!page.text().contains("https://"), "{}", page.text());
}
