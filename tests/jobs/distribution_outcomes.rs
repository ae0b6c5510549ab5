//! What jobs on arrangements say when a pattern cannot be met, and bodies that hold no numbers.

use std::time::Duration;
use std::time::Instant;

use axum::http::Method;
use biotope::compute::random::Purpose;
use biotope::compute::random::Stream;
use serde_json::Value;
use serde_json::json;

use crate::support::TestApp;

/// Runs a job that must succeed; the document `report` or `analysis` it hands back.
async fn document(app: &TestApp, process: &str, inputs: Value, output: &str) -> Value {
    let (job, status) = app.finish(process, &json!({ "inputs": inputs })).await;
    assert_eq!(status["status"], "successful", "{status}");
    app.get(&format!("{job}/results/{output}")).await.json()
}

fn has_warning(document: &Value, code: &str) -> bool {
    document["warnings"]
        .as_array()
        .expect("warnings")
        .iter()
        .any(|w| w["code"] == code && w["count"].as_u64() > Some(0))
}

/// A hexagonal grid of points a metre apart (T figure 3.19) with its domain.
fn hexagonal() -> Value {
    let place = |k: u32| {
        let (row, column) = (k / 8, k % 8);
        json!({"x": f64::from(column) + 0.5 * f64::from(row % 2) + 0.25, "y": (f64::from(row) + 0.5) * 0.866_025_4})
    };
    let domain = json!({"type": "rectangle", "min": [0, 0], "max": [8, 8.660_254]});
    json!({"elements": (0..80).map(place).collect::<Vec<Value>>(), "domain": domain})
}

#[tokio::test(flavor = "multi_thread")]
async fn a_grid_too_regular_to_be_met_ends_with_a_warning() {
    let app = TestApp::standard().await;
    let (job, status) = app.finish("disk-synthesis", &json!({"inputs": {"exemplar": hexagonal(), "seed": 1}})).await;
    assert_eq!(status["status"], "successful", "{status}");
    let report = app.get(&format!("{job}/results/report")).await.json();
    assert!(has_warning(&report, "OUTSIDE_VALIDITY"), "{report}");
    let manifest = app.get(&format!("{job}/results/manifest")).await.json();
    assert!(has_warning(&manifest, "OUTSIDE_VALIDITY"), "{manifest}");
    let elements = app.get(&format!("{job}/results/elements?f=json")).await.json();
    let places: Vec<(f64, f64)> = elements
        .as_array()
        .expect("rows")
        .iter()
        .map(|e| (e["x"].as_f64().expect("x"), e["y"].as_f64().expect("y")))
        .collect();
    assert!(places.len() >= 76, "{} of 80", places.len());
    for (i, a) in places.iter().enumerate() {
        assert!(places[..i].iter().all(|b| (a.0 - b.0).hypot(a.1 - b.1) >= 0.5 - 1e-9), "half the spacing is kept");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_count_that_cannot_be_reached_ends_with_what_fits_and_says_so() {
    let app = TestApp::standard().await;
    // All are asked for in one of sixteen cells, which has room for few at the spacing of the rest.
    let corner =
        format!("ncols 4\nnrows 4\nxllcorner 0\nyllcorner 0\ncellsize 2.2\n9 0 0 0\n{}", "0 0 0 0\n".repeat(3));
    let density = json!({"raster": {"value": corner, "mediaType": "text/plain"}});
    let target = json!({"counts": {"a": 240}, "density": density});
    let inputs = json!({"exemplar": hexagonal(), "target": target, "options": {"max_fails": 20}});
    let report = document(&app, "disk-synthesis", inputs, "report").await;
    let class = &report["classes"][0];
    let number = |field: &str| class[field].as_u64().expect("a number");
    assert_eq!((number("asked"), number("fixed")), (240, 0), "{report}");
    assert!(number("missing") > 0 && number("missing") + number("placed") == 240, "{report}");
    assert!(has_warning(&report, "COUNT_NOT_REACHED"), "{report}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_place_shared_by_two_classes_is_a_warning_of_the_job() {
    let app = TestApp::standard().await;
    let mut exemplar = hexagonal();
    let mut twin = exemplar["elements"][11].clone();
    twin["class"] = json!("other");
    exemplar["elements"].as_array_mut().expect("a list").push(twin);
    for process in ["disk-synthesis", "distribution-inpainting"] {
        let report = document(&app, process, json!({"exemplar": exemplar.clone()}), "report").await;
        assert!(has_warning(&report, "SHARED_PLACES"), "{process}: {report}");
    }
    for (process, more) in [("distribution-analysis", None), ("distribution-decomposition", Some(2))] {
        let mut inputs = json!({"exemplar": exemplar.clone()});
        if let Some(clusters) = more {
            inputs["clusters"] = json!(clusters);
        }
        let manifest = document(&app, process, inputs, "manifest").await;
        assert!(has_warning(&manifest, "SHARED_PLACES"), "{process}: {manifest}");
    }
}

#[tokio::test]
async fn a_number_too_large_for_one_is_refused_in_the_body_of_every_process() {
    let app = TestApp::standard().await;
    for process in ["distribution-analysis", "disk-synthesis", "distribution-inpainting", "distribution-decomposition"]
    {
        for number in ["1e999", "-1e999", "NaN", "Infinity"] {
            let body = format!(r#"{{"inputs":{{"exemplar":{{"elements":[{{"x":{number},"y":1}}]}}}}}}"#);
            let reply = app.ask(Method::POST, &format!("/processes/{process}/execution"), &[], body).await;
            reply.assert_problem(400, "body-not-json");
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn ten_thousand_elements_show_how_far_they_are_and_stop_within_a_second() {
    let app = TestApp::standard().await;
    let domain = json!({"type": "rectangle", "min": [0, 0], "max": [100, 100]});
    let mut random = Stream::new(1, Purpose::new("test.ten-thousand"), 0);
    let elements: Vec<Value> =
        (0..100).map(|_| json!({"x": random.range(0.0, 10.0), "y": random.range(0.0, 10.0)})).collect();
    let exemplar = json!({"elements": elements, "domain": {"type": "rectangle", "min": [0, 0], "max": [10, 10]}});
    let inputs = json!({"exemplar": exemplar, "target": {"domain": domain, "counts": {"a": 10_000}}});
    let job = app.submit("disk-synthesis", &json!({ "inputs": inputs })).await;
    let (mut shown, begin) = (Vec::new(), Instant::now());
    while shown.len() < 4 && begin.elapsed() < Duration::from_secs(60) {
        let status = app.get(&job).await.json();
        assert!(["accepted", "running"].contains(&status["status"].as_str().expect("a state")), "{status}");
        let percent = status["progress"].as_u64().expect("a number");
        if shown.last() != Some(&percent) {
            shown.push(percent);
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    assert!(shown.len() == 4 && shown.is_sorted(), "{shown:?}");
    let begin = Instant::now();
    assert_eq!(app.delete(&job).await.json()["status"], "dismissed");
    let id = biotope::jobs::queue::JobId::parse(&job.replace("/jobs/", "")).expect("an id");
    while app.app.jobs.live(id).is_some() {
        assert!(begin.elapsed() < Duration::from_secs(1), "the work goes on");
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
}
