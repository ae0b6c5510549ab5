use std::path::Path;
use std::time::Duration;

use biotope::app::App;
use biotope::app::Limits;
use biotope::jobs::Jobs;
use biotope::jobs::Settings;
use biotope::jobs::housekeeping::Tidied;
use biotope::jobs::queue::Added;
use biotope::jobs::queue::AssetRow;
use biotope::jobs::queue::Keep;
use biotope::jobs::queue::Lane;
use biotope::jobs::queue::NewRow;
use biotope::jobs::queue::Outcome;
use biotope::jobs::queue::Queue as _;
use biotope::jobs::queue::Row;
use biotope::jobs::queue::SqliteQueue;
use serde_json::json;
use time::OffsetDateTime;

use crate::support::TestApp;
use crate::support::registry;
use crate::support::settings;

/// The `zoo` over some bytes by value: outputs that differ with the bytes.
fn zoo(text: &str) -> serde_json::Value {
    json!({"inputs": {"terrain": {"href": format!("data:text/plain,{text}")}}})
}

/// Tidies until there is nothing left to remove; all that was removed.
async fn tidied(app: &TestApp) -> Tidied {
    let mut all = Tidied::default();
    loop {
        let now = app.app.jobs.tidy().await.unwrap();
        if now == Tidied::default() {
            return all;
        }
        all = Tidied { rows: all.rows + now.rows, blobs: all.blobs + now.blobs, bytes: all.bytes + now.bytes };
    }
}

#[tokio::test]
async fn the_results_of_a_dismissed_job_go_and_those_it_shares_with_another_stay() {
    let app = TestApp::new().await;
    let (kept, status) = app.finish("zoo", &zoo("same")).await;
    assert_eq!(status["status"], "successful", "{status}");
    let (shared, _) = app.finish("zoo", &zoo("same")).await;
    let (alone, _) = app.finish("zoo", &zoo("other")).await;
    tidied(&app).await;
    let before = app.get(&format!("{kept}/results/herds")).await.bytes;
    app.delete(&shared).await;
    app.delete(&alone).await;
    let removed = tidied(&app).await;
    assert!(removed.rows == 0 && removed.blobs >= 2 && removed.bytes > 0, "{removed:?}");
    for output in ["herds", "rag", "summary", "maps.height", "manifest"] {
        assert_eq!(app.get(&format!("{kept}/results/{output}")).await.status, 200, "{output}");
    }
    assert_eq!(app.get(&format!("{kept}/results/herds")).await.bytes, before);
    app.get(&format!("{alone}/results")).await.assert_problem(410, "job-dismissed");
}

/// The files in a folder and those below it.
fn files(folder: &Path) -> usize {
    let inside = std::fs::read_dir(folder).map(|entries| entries.flatten().collect::<Vec<_>>()).unwrap_or_default();
    inside.iter().map(|entry| if entry.path().is_dir() { files(&entry.path()) } else { 1 }).sum()
}

#[tokio::test]
async fn a_job_that_is_dismissed_while_it_runs_soon_leaves_nothing_on_the_disk() {
    let folder = tempfile::tempdir().unwrap();
    let jobs = Jobs::open(folder.path(), registry(), settings()).await.unwrap();
    let app = TestApp { app: App::new(jobs, Limits::default()).unwrap() };
    let long = app.submit("trouble", &json!({"inputs": {"kind": "forever"}})).await;
    app.until(&long, |state| state == "running").await;
    let blobs = folder.path().join("store/blobs");
    assert_eq!(files(&blobs), 1, "its request");
    app.delete(&long).await;
    for _ in 0..1000 {
        if files(&blobs) == 0 {
            return;
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    panic!("the service does not tidy up by itself");
}

#[tokio::test]
async fn what_ended_before_the_time_of_keeping_is_forgotten() {
    let short = Settings { keep: Duration::ZERO, ..settings() };
    let app = TestApp::with(short, Default::default()).await;
    let (job, _) = app.finish("zoo", &zoo("old")).await;
    let running = app.submit("trouble", &json!({"inputs": {"kind": "forever"}})).await;
    app.until(&running, |state| state == "running").await;
    tidied(&app).await;
    app.get(&job).await.assert_problem(404, "no-such-job");
    assert_eq!(app.get(&running).await.json()["status"], "running", "what runs is never too old");
    app.delete(&running).await;
}

async fn ended(queue: &SqliteQueue, task: &str, outputs: serde_json::Value) -> Row {
    let new = NewRow { process: "echo".into(), task: task.into(), key: None, lane: Lane::Quick, memory_bytes: 1 };
    assert!(matches!(queue.add(new, 100).await.unwrap(), Added::New(_)));
    let row = queue.claim(Lane::Quick, 100, "here").await.unwrap().unwrap();
    let outcome: Outcome = serde_json::from_value(json!({"success": {"outputs": outputs, "warnings": []}})).unwrap();
    assert!(queue.finish(row.id, row.fence, &outcome).await.unwrap());
    row
}

fn output(digest: &str, size: u64) -> serde_json::Value {
    json!({"kind": "json", "digest": digest, "size": size})
}

#[tokio::test]
async fn jobs_beyond_the_space_for_results_are_forgotten_from_the_one_that_ended_first() {
    let queue = SqliteQueue::in_memory().await.unwrap();
    let first = ended(&queue, "t1", json!({"a": output("d1", 60)})).await;
    let second = ended(&queue, "t2", json!({"a": output("d2", 30), "b": output("shared", 30)})).await;
    let third = ended(&queue, "t3", json!({"a": output("shared", 30), "b": output("d3", 30)})).await;
    let since = OffsetDateTime::UNIX_EPOCH;
    assert_eq!(queue.forget(Keep { since, bytes: 150 }).await.unwrap(), 0, "what two share counts once");
    assert_eq!(queue.forget(Keep { since, bytes: 149 }).await.unwrap(), 1);
    assert!(queue.get(first.id).await.unwrap().is_none());
    assert_eq!(queue.forget(Keep { since, bytes: 89 }).await.unwrap(), 1);
    assert!(queue.get(second.id).await.unwrap().is_none() && queue.get(third.id).await.unwrap().is_some());
    let named: Vec<_> = queue.named().await.unwrap().into_iter().collect();
    assert_eq!(named, ["d3", "shared", "t3"]);
}

#[tokio::test]
async fn an_upload_is_kept_as_long_as_it_is_used() {
    let queue = SqliteQueue::in_memory().await.unwrap();
    let asset = AssetRow { digest: "d".into(), media_type: "image/tiff".into(), size: 5 };
    assert!(queue.add_asset(asset.clone()).await.unwrap());
    let uploaded = OffsetDateTime::now_utc();
    assert!(!queue.add_asset(asset.clone()).await.unwrap(), "used again");
    assert_eq!(queue.forget(Keep { since: uploaded, bytes: 0 }).await.unwrap(), 0);
    assert_eq!(queue.asset("d").await.unwrap(), Some(asset));
    let later = OffsetDateTime::now_utc() + Duration::from_secs(1);
    assert_eq!(queue.forget(Keep { since: later, bytes: 0 }).await.unwrap(), 1);
    assert_eq!(queue.asset("d").await.unwrap(), None);
}
