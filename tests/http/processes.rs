use axum::http::StatusCode;
use serde_json::Value;

use crate::support::TestApp;

#[tokio::test]
async fn the_list_is_paged_and_its_links_lead_through_all_of_it() {
    let app = TestApp::new().await;
    let (mut path, mut seen) = ("/processes?limit=1".to_owned(), Vec::new());
    loop {
        let page = app.get(&path).await.json();
        seen.extend(page["processes"].as_array().unwrap().iter().map(|p| p["id"].as_str().unwrap().to_owned()));
        let links = page["links"].as_array().unwrap().clone();
        let Some(next) = links.iter().find(|link| link["rel"] == "next") else { break };
        path = next["href"].as_str().unwrap().strip_prefix("http://biotope.test").unwrap().to_owned();
    }
    assert_eq!(seen, ["echo", "zoo", "trouble"]);
}

#[tokio::test]
async fn a_limit_or_an_offset_that_is_none_is_refused_with_its_name() {
    let app = TestApp::new().await;
    for (path, name) in
        [("?limit=0", "limit"), ("?limit=10001", "limit"), ("?limit=x", "limit"), ("?offset=-1", "offset")]
    {
        let problem = app.get(&format!("/processes{path}")).await.assert_problem(400, "invalid-parameter");
        assert_eq!(problem["errors"][0]["pointer"], name);
    }
}

#[tokio::test]
async fn a_process_describes_each_input_and_each_output() {
    let app = TestApp::new().await;
    let zoo = app.get("/processes/zoo").await.json();
    assert_eq!(zoo["jobControlOptions"], serde_json::json!(["async-execute", "dismiss"]));
    let terrain = &zoo["inputs"]["terrain"];
    assert_eq!((&terrain["minOccurs"], &terrain["maxOccurs"]), (&Value::from(1), &Value::from(1)));
    assert_eq!(zoo["inputs"]["seed"]["minOccurs"], 0);
    assert!(terrain["description"].as_str().is_some_and(|text| !text.is_empty()));
    let map = &zoo["outputs"]["maps.<slug>"];
    assert_eq!(map["mediaTypes"], serde_json::json!(["image/tiff", "image/png", "application/json"]));
    assert_eq!(map["unit"], "m");
    assert_eq!(zoo["outputs"]["extra"]["default"], false);
    assert!(zoo["outputs"]["manifest"].is_object());
    jsonschema::validator_for(&terrain["schema"]).expect("a schema that stands on its own");
}

#[tokio::test]
async fn an_unknown_process_is_a_problem_by_the_name_of_the_standard() {
    let app = TestApp::new().await;
    let problem = app.get("/processes/none").await.assert_problem(404, "no-such-process");
    assert_eq!(problem["type"], "http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/no-such-process");
    assert_eq!(app.get("/processes/echo").await.status, StatusCode::OK);
}
