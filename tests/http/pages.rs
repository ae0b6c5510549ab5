use axum::http::StatusCode;
use serde_json::json;

use crate::support::TestApp;

const BROWSER: &str = "text/html,application/xhtml+xml,application/xml;q=0.9,*/*;q=0.8";

#[tokio::test]
async fn every_resource_has_a_page_for_people() {
    let app = TestApp::new().await;
    let (job, _) = app.finish("zoo", &json!({"inputs": {"terrain": {"href": "data:,abc"}}})).await;
    let output = format!("{job}/results/maps.height");
    for path in ["/", "/processes", "/processes/zoo", "/jobs", &job, &format!("{job}/results"), &output] {
        for reply in [app.get_as(path, BROWSER).await, app.get(&format!("{path}?f=html")).await] {
            assert_eq!((reply.status, reply.header("content-type")), (StatusCode::OK, "text/html; charset=utf-8"));
            let page = reply.text();
            assert!(page.starts_with("<!doctype html>") && page.trim_end().ends_with("</html>"), "{path}");
            assert!(!page.contains("http://") && !page.contains("https://"), "{path} fetches nothing from elsewhere");
        }
    }
    app.get("/jobs?f=pdf").await.assert_problem(400, "invalid-parameter");
}

#[tokio::test]
async fn the_page_of_a_finished_job_shows_maps_tables_and_warnings() {
    let app = TestApp::new().await;
    let (job, _) = app.finish("zoo", &json!({"inputs": {"terrain": {"href": "data:,abc"}}})).await;
    let page = app.get_as(&job, BROWSER).await.text();
    assert!(page.contains(&format!("<img src=\"{job}/results/maps.height?f=png\"")));
    assert!(page.contains("The ground shows steps.") && page.contains("× 3"));
    assert!(page.contains("<th class=\"number\">x <small>m</small></th>"));
    assert!(
        page.contains(&format!("{job}/results/herds?f=csv")) && page.contains(&format!("{job}/results/tracks.bin"))
    );
    assert!(page.contains("&lt;b&gt;") && !page.contains("<i>"), "what a job says is no HTML");
    assert!(!page.contains("EventSource"));
}

#[tokio::test]
async fn the_page_of_a_running_job_follows_it_and_that_of_a_failed_one_says_why() {
    let app = TestApp::new().await;
    let running = app.submit("trouble", &json!({"inputs": {"kind": "forever"}})).await;
    let page = app.get_as(&running, BROWSER).await.text();
    assert!(page.contains("EventSource") && page.contains("<progress") && page.contains("http-equiv=\"refresh\""));
    app.delete(&running).await;
    let (failed, _) = app.finish("trouble", &json!({"inputs": {"kind": "invalid"}})).await;
    let page = app.get_as(&failed, BROWSER).await.text();
    assert!(page.contains("Why it failed") && page.contains("something that works"));
}
