//! What is published is what the code does.

use std::collections::BTreeSet;
use std::path::Path;

use axum::http::Method;
use biotope::http::openapi::Documents;
use biotope::http::openapi::operations;
use biotope::jobs::local::Bench;
use biotope::jobs::local::FileRequest;
use biotope::jobs::registry::Registry;
use biotope::storage::BlockingStore;
use biotope::storage::Store;

use crate::jobs::determinism::examples;
use crate::support::TestApp;

fn documents() -> Documents {
    Documents::new(&Registry::standard().expect("schemas"))
}

#[test]
fn the_published_document_is_the_one_the_code_makes() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("openapi.yaml");
    let made = documents().yaml().to_owned();
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&path, &made).expect("openapi.yaml is written");
    }
    let published = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(published == made, "openapi.yaml differs from the code; UPDATE=1 rewrites it");
}

#[test]
fn every_example_is_a_request_its_process_takes() {
    let registry = Registry::standard().expect("schemas");
    let all = examples();
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    let store = BlockingStore::new(Store::in_memory(), runtime.handle().clone());
    let bench = Bench { registry: &registry, store: &store, threads: 2 };
    for (process, file) in &all {
        let request = FileRequest::open(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        request.check(process, &bench).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    }
    for entry in registry.entries() {
        let id = entry.description.id;
        assert!(all.iter().any(|(process, _)| process == id), "{id} has no worked example");
    }
}

#[test]
fn every_route_is_in_the_document() {
    let routes = [
        "GET /",
        "GET /conformance",
        "GET /processes",
        "GET /processes/{id}",
        "POST /processes/{id}/execution",
        "GET /jobs",
        "GET /jobs/{id}",
        "DELETE /jobs/{id}",
        "GET /jobs/{id}/results",
        "GET /jobs/{id}/results/{output}",
        "GET /jobs/{id}/events",
        "POST /assets",
        "GET /assets/{digest}",
        "GET /openapi.yaml",
        "GET /openapi.json",
        "GET /openapi-3.0.json",
        "GET /health",
        "GET /livez",
        "GET /readyz",
        "GET /metrics",
        "GET /problems",
    ];
    let expected: BTreeSet<_> = routes.iter().map(|route| (*route).to_owned()).collect();
    assert_eq!(operations(documents().v3_1()), expected);
    assert_eq!(operations(documents().v3_0()), expected);
}

#[tokio::test]
async fn every_route_of_the_document_is_served() {
    let app = TestApp::new().await;
    for operation in operations(documents().v3_1()) {
        let (method, path) = operation.split_once(' ').expect("a method and a path");
        let path = path.replace("{id}", "x").replace("{output}", "y").replace("{digest}", "z");
        let reply = app.ask(method.parse::<Method>().expect("a method"), &path, &[], "").await;
        let code = if reply.status.is_success() { String::new() } else { reply.json()["code"].to_string() };
        assert!(!["\"not-found\"", "\"method-not-allowed\""].contains(&code.as_str()), "{operation}: {code}");
    }
}

#[test]
fn every_reference_of_the_documents_leads_somewhere() {
    for document in [documents().v3_1().clone(), documents().v3_0().clone()] {
        let text = document.to_string();
        for part in text.split("\"$ref\":\"").skip(1) {
            let target = part.split('"').next().expect("an end").trim_start_matches('#');
            assert!(document.pointer(target).is_some(), "{target}");
        }
    }
}
