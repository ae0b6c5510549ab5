use axum::http::StatusCode;
use serde_json::Value;
use serde_json::json;

use crate::support::TestApp;

fn ids(list: &Value) -> Vec<&str> {
    list["jobs"].as_array().unwrap().iter().map(|job| job["jobID"].as_str().unwrap()).collect()
}

#[tokio::test]
async fn a_status_has_the_fields_of_both_versions_of_the_standard() {
    let app = TestApp::new().await;
    let (job, status) = app.finish("echo", &json!({"inputs": {"value": 1}})).await;
    assert_eq!(status["jobID"], status["id"]);
    assert_eq!((&status["type"], &status["processingEntityType"]), (&json!("process"), &json!("ogc-api-processes")));
    assert_eq!((&status["status"], &status["progress"]), (&json!("successful"), &json!(100)));
    for moment in ["created", "started", "finished", "updated"] {
        assert!(status[moment].as_str().is_some_and(|text| text.ends_with('Z')), "{moment}");
    }
    let results = "http://www.opengis.net/def/rel/ogc/1.0/results";
    assert!(status["links"].as_array().unwrap().iter().any(|link| link["rel"] == results));
    assert_eq!(app.get(&job).await.header("retry-after"), "");
}

#[tokio::test]
async fn the_list_is_newest_first_filtered_and_paged() {
    let app = TestApp::new().await;
    let mut made = Vec::new();
    for message in 0..3 {
        made.push(app.finish("echo", &json!({"inputs": {"value": message}})).await.0.replace("/jobs/", ""));
    }
    let (failed, _) = app.finish("trouble", &json!({"inputs": {"kind": "fault"}})).await;
    made.reverse();
    assert_eq!(ids(&app.get("/jobs?processID=echo").await.json()), made);
    assert_eq!(ids(&app.get("/jobs?status=failed").await.json()), [failed.replace("/jobs/", "")]);
    assert_eq!(ids(&app.get("/jobs?status=failed,successful&type=process").await.json()).len(), 4);
    assert_eq!(ids(&app.get("/jobs?type=other").await.json()).len(), 0);
    assert_eq!(ids(&app.get("/jobs?minDuration=1000").await.json()).len(), 0);
    assert_eq!(ids(&app.get("/jobs?maxDuration=1000").await.json()).len(), 4);
    assert_eq!(ids(&app.get("/jobs?datetime=2020-01-01T00:00:00Z/..").await.json()).len(), 4);
    assert_eq!(ids(&app.get("/jobs?datetime=../2020-01-01T00:00:00Z").await.json()).len(), 0);
    let page = app.get("/jobs?limit=2&processID=echo").await.json();
    let next = page["links"].as_array().unwrap().iter().find(|link| link["rel"] == "next").expect("a next page");
    let next = next["href"].as_str().unwrap().strip_prefix("http://biotope.test").unwrap();
    assert_eq!(ids(&app.get(next).await.json()), made[2..]);
    for (wrong, name) in [
        ("status=done", "status"),
        ("datetime=now", "datetime"),
        ("minDuration=-1", "minDuration"),
        ("before=x", "before"),
    ] {
        let problem = app.get(&format!("/jobs?{wrong}")).await.assert_problem(400, "invalid-parameter");
        assert_eq!(problem["errors"][0]["pointer"], name);
    }
}

#[tokio::test]
async fn a_job_that_does_not_exist_is_said_not_to() {
    let app = TestApp::new().await;
    for id in ["none", "01a203e3-c762-7240-b966-e41babdea3fe"] {
        for path in ["", "/results", "/results/x", "/events"] {
            app.get(&format!("/jobs/{id}{path}")).await.assert_problem(404, "no-such-job");
        }
        app.delete(&format!("/jobs/{id}")).await.assert_problem(404, "no-such-job");
    }
}

#[tokio::test]
async fn a_dismissed_job_stops_and_its_results_are_gone() {
    let app = TestApp::new().await;
    let job = app.submit("trouble", &json!({"inputs": {"kind": "forever"}})).await;
    app.until(&job, |state| state == "running").await;
    assert_eq!(app.get(&job).await.header("retry-after"), "1");
    let begin = std::time::Instant::now();
    let reply = app.delete(&job).await;
    assert_eq!((reply.status, &reply.json()["status"]), (StatusCode::OK, &json!("dismissed")));
    while app.app.jobs.live(biotope::jobs::queue::JobId::parse(&job.replace("/jobs/", "")).unwrap()).is_some() {
        tokio::time::sleep(std::time::Duration::from_millis(5)).await;
        assert!(begin.elapsed().as_secs() < 10, "the work goes on");
    }
    app.get(&format!("{job}/results")).await.assert_problem(410, "job-dismissed");
    app.get(&format!("{job}/results/manifest")).await.assert_problem(410, "job-dismissed");
    assert_eq!(app.delete(&job).await.json()["status"], "dismissed", "giving up twice is no fault");
    let (done, _) = app.finish("echo", &json!({"inputs": {"value": 1}})).await;
    assert_eq!(app.delete(&done).await.json()["status"], "dismissed");
    app.get(&format!("{done}/results")).await.assert_problem(410, "job-dismissed");
}
