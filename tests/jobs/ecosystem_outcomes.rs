//! What an `ecosystem` job says of a world in which little or nothing can live.

use std::path::Path;
use std::sync::Arc;

use biotope::jobs::Artefact;
use biotope::jobs::local::Bench;
use biotope::jobs::local::FileRequest;
use biotope::jobs::progress::Live;
use biotope::jobs::registry::Registry;
use biotope::jobs::results::load;
use biotope::storage::BlockingStore;
use biotope::storage::Store;
use serde_json::Value;
use serde_json::json;

use crate::jobs::ecosystem_inputs::grid;
use crate::jobs::ecosystem_inputs::with;
use crate::support::TestApp;

/// The summary and the warnings of a job that must succeed.
async fn solved(inputs: Value) -> (Value, Vec<Value>) {
    let app = TestApp::standard().await;
    let (job, status) = app.finish("ecosystem", &json!({ "inputs": inputs })).await;
    assert_eq!(status["status"], "successful", "{status}");
    let summary = app.get(&format!("{job}/results/summary?f=json")).await.json();
    let warnings = app.get(&format!("{job}/results/warnings?f=json")).await.json();
    let list = warnings.as_array().or(warnings["warnings"].as_array()).expect("a list").clone();
    (summary, list)
}

/// Every species of `list` lives nowhere, with a reason there and a warning.
fn assert_nobody(summary: &Value, warnings: &[Value], list: &str, measure: &str) {
    for (i, row) in summary[list].as_array().expect("rows").iter().enumerate() {
        assert_eq!(row[measure].as_f64(), Some(0.0), "{row}");
        assert!(row["why_empty"].as_str().is_some_and(|why| why.len() > 10), "{row}");
        let pointer = format!("/inputs/{list}/{i}");
        assert!(warnings.iter().any(|w| w["code"] == "NOT_PLACED" && w["pointer"] == pointer.as_str()), "{warnings:?}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_job_that_can_place_nobody_succeeds_and_says_why_for_each_species() {
    let frozen = with(|i| {
        let months = i["climate"]["months"].as_array_mut().expect("months");
        months.iter_mut().for_each(|m| m["temperature_mean_c"] = json!(-60));
    });
    let (summary, warnings) = solved(frozen).await;
    assert_nobody(&summary, &warnings, "plants", "cover_m2");
    assert_nobody(&summary, &warnings, "animals", "individuals");
    assert_eq!(summary["herds"], 0);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_world_wholly_under_water_or_wholly_excluded_grows_nothing_and_says_why() {
    for map in [json!({"water_depth_m": grid(12, 10, |_, _| 30.0)}), json!({"exclusion": grid(12, 10, |_, _| 1.0)})] {
        let (summary, warnings) = solved(with(|i| i["maps"] = map.clone())).await;
        assert_nobody(&summary, &warnings, "plants", "cover_m2");
        assert_nobody(&summary, &warnings, "animals", "individuals");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn a_request_without_species_gives_the_maps_of_the_land() {
    let bare = with(|i| {
        i["plants"] = json!([]);
        i["animals"] = json!([]);
    });
    let (summary, _) = solved(bare).await;
    assert_eq!((&summary["plants"], &summary["animals"], &summary["herds"]), (&json!([]), &json!([]), &json!(0)));
}

#[test]
fn the_mild_sample_has_animals_no_denser_than_ten_times_their_relatives_and_carnivores_in_proportion() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("api/examples/ecosystem-tautavel-mild.json");
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    let store = BlockingStore::new(Store::in_memory(), runtime.handle().clone());
    let registry = Registry::standard().expect("schemas");
    let bench = Bench { registry: &registry, store: &store, threads: 2 };
    let request = FileRequest::open(&file).expect("the example");
    let kept = request.solve("ecosystem", &bench, &Arc::new(Live::new(1))).expect("a solve");
    for code in ["DENSITY_OUT_OF_RANGE", "BIOMASS_OUT_OF_RANGE"] {
        assert!(kept.warnings.iter().all(|warning| warning.code != code), "{:?}", kept.warnings);
    }
    let Ok(Artefact::Json(summary)) = load(&store, &kept.outputs["summary"]) else { panic!("no summary") };
    let ratio = summary["biomass"]["carnivores_per_prey"].as_f64().expect("a ratio");
    assert!((0.003..=0.03).contains(&ratio), "{ratio}");
    let animals = summary["animals"].as_array().expect("animals");
    let placed = animals.iter().filter(|a| a["individuals"].as_u64() > Some(0)).count();
    assert!(placed >= 6 && summary["herds"].as_u64() > Some(100), "{summary}");
}
