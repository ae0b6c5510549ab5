use std::path::Path;
use std::time::Duration;

use biotope::jobs::Jobs;
use biotope::jobs::JobsError;
use biotope::jobs::Settings;
use biotope::jobs::queue::JobId;
use biotope::jobs::submit::Submitted;
use biotope_api::execute::Execute;
use biotope_api::job::JobState;
use serde_json::Value;
use serde_json::json;

use crate::support::TestApp;
use crate::support::registry;
use crate::support::settings;

fn execute(inputs: Value) -> Execute {
    Execute { inputs: inputs.as_object().cloned().unwrap_or_default(), ..Execute::default() }
}

/// Opens the folder, waiting for an earlier holder of this process to let go.
async fn open(folder: &Path) -> Jobs {
    for _ in 0..500 {
        match Jobs::open(folder, registry(), settings()).await {
            Ok(jobs) => return jobs,
            Err(JobsError::Store(_)) => tokio::time::sleep(Duration::from_millis(20)).await,
            Err(error) => panic!("{error}"),
        }
    }
    panic!("the folder is never let go");
}

async fn submitted(jobs: &Jobs, process: &str, inputs: Value) -> JobId {
    let Submitted { row, .. } = jobs.submit(process, execute(inputs), None).await.unwrap();
    row.id
}

async fn running(jobs: &Jobs, id: JobId) {
    while jobs.live(id).is_none_or(|live| live.events_after(0).is_empty()) {
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_that_was_stopped_by_the_service_runs_again_at_the_next_start() {
    let folder = tempfile::tempdir().unwrap();
    let first = open(folder.path()).await;
    let id = submitted(&first, "echo", json!({"value": 5, "pause_s": 0.5})).await;
    running(&first, id).await;
    first.drain(Duration::from_secs(5)).await;
    let row = first.status(id).await.unwrap().unwrap();
    assert_eq!((row.state, row.starts), (JobState::Accepted, 0), "stopping is not crashing");
    drop(first);
    let second = open(folder.path()).await;
    let row = second.wait(id, None).await.unwrap().unwrap();
    assert_eq!((row.state, row.fence), (JobState::Successful, 2));
}

#[tokio::test]
async fn one_process_works_in_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    let _held = open(folder.path()).await;
    let error = Jobs::open(folder.path(), registry(), settings()).await.err().unwrap();
    assert!(error.to_string().contains("another process works in"), "{error}");
}

#[tokio::test]
async fn jobs_wait_for_memory_and_a_full_queue_says_so() {
    let small = Settings { memory_bytes: 100, waiting_jobs: 1, ..settings() };
    let app = TestApp::with(small, Default::default()).await;
    let forever = json!({"inputs": {"kind": "forever", "memory_bytes": 60}});
    let first = app.submit("trouble", &forever).await;
    app.until(&first, |state| state == "running").await;
    let second = app.submit("trouble", &forever).await;
    let third = app.execute("trouble", &forever, &[]).await;
    third.assert_problem(503, "queue-full");
    assert_eq!(third.header("retry-after"), "5");
    tokio::time::sleep(Duration::from_millis(50)).await;
    assert_eq!(app.get(&second).await.json()["status"], "accepted", "120 of 100 bytes");
    app.delete(&first).await;
    app.until(&second, |state| state == "running").await;
    app.delete(&second).await;
}

#[tokio::test]
async fn a_panic_fails_its_job_and_frees_its_place() {
    let one = Settings { heavy_jobs: 1, ..settings() };
    let app = TestApp::with(one, Default::default()).await;
    for kind in ["panic", "fault", "undescribed", "panic"] {
        let (_, status) = app.finish("trouble", &json!({"inputs": {"kind": kind}})).await;
        assert_eq!((&status["status"], &status["exception"]["code"]), (&json!("failed"), &json!("internal")), "{kind}");
    }
    let (_, status) = app.finish("trouble", &json!({"inputs": {"kind": "fine"}})).await;
    assert_eq!(status["status"], "successful");
}

#[tokio::test]
async fn a_job_that_waits_can_be_dismissed_and_never_runs() {
    let one = Settings { heavy_jobs: 1, ..settings() };
    let app = TestApp::with(one, Default::default()).await;
    let first = app.submit("trouble", &json!({"inputs": {"kind": "forever"}})).await;
    let second = app.submit("trouble", &json!({"inputs": {"kind": "panic"}})).await;
    assert_eq!(app.delete(&second).await.json()["status"], "dismissed");
    app.delete(&first).await;
    let (_, status) = app.finish("trouble", &json!({"inputs": {"kind": "fine"}})).await;
    assert_eq!(status["status"], "successful");
    assert_eq!(app.get(&second).await.json()["status"], "dismissed");
}
