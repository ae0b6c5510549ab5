use axum::http::Method;
use axum::http::StatusCode;
use serde_json::Value;
use serde_json::json;

use crate::support::TestApp;

/// The events of a stream as (event, id, data).
fn events(text: &str) -> Vec<(String, String, Value)> {
    let field = |block: &str, name: &str| {
        let lines = block.lines().filter_map(|line| line.strip_prefix(name));
        lines.map(str::trim).collect::<String>()
    };
    let blocks = text.split("\n\n").filter(|block| block.contains("data:"));
    blocks
        .map(|block| {
            let data = serde_json::from_str(&field(block, "data:")).expect("JSON");
            (field(block, "event:"), field(block, "id:"), data)
        })
        .collect()
}

#[tokio::test]
async fn a_stream_tells_the_progress_and_ends_with_the_job() {
    let app = TestApp::new().await;
    let job = app.submit("echo", &json!({"inputs": {"value": 1, "pause_s": 0.4}})).await;
    let reply = app.get(&format!("{job}/events")).await;
    assert_eq!(reply.header("content-type"), "text/event-stream");
    let all = events(&reply.text());
    let steps: Vec<_> = all.iter().filter(|(name, _, _)| name == "progress").collect();
    assert!(steps.len() >= 2);
    let done: Vec<_> = steps.iter().map(|(_, _, data)| data["done"].as_u64().unwrap()).collect();
    assert!(done.is_sorted() && done.last() == Some(&400), "{done:?}");
    assert!(steps.iter().all(|(_, id, data)| !id.is_empty() && data["stage"] == "pause" && data["total"] == 400));
    let (name, id, data) = all.last().unwrap();
    assert_eq!((name.as_str(), &data["status"]), ("status", &json!("successful")));
    let again = app.ask(Method::GET, &format!("{job}/events"), &[("last-event-id", id)], "").await;
    assert_eq!(again.status, StatusCode::NO_CONTENT, "nothing is left to tell");
}

#[tokio::test]
async fn a_client_that_comes_back_hears_what_it_has_missed_and_no_more() {
    let app = TestApp::new().await;
    let job = app.submit("echo", &json!({"inputs": {"value": 1, "pause_s": 0.8}})).await;
    tokio::time::sleep(std::time::Duration::from_millis(400)).await;
    let path = format!("{job}/events");
    let rest = app.ask(Method::GET, &path, &[("last-event-id", "1-2")], "").await;
    let numbers: Vec<_> = events(&rest.text()).into_iter().filter(|(name, _, _)| name == "progress").collect();
    assert_eq!(numbers.first().map(|(_, id, _)| id.as_str()), Some("1-3"));
}

#[tokio::test]
async fn the_stream_of_a_finished_job_is_its_last_status() {
    let app = TestApp::new().await;
    let (job, _) = app.finish("echo", &json!({"inputs": {"value": 1}})).await;
    let all = events(&app.get(&format!("{job}/events")).await.text());
    assert_eq!(all.len(), 1);
    assert_eq!(all[0].2["status"], "successful");
}
