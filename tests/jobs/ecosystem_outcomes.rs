//! What an `ecosystem` job says of a world in which little or nothing can live.

use std::path::Path;
use std::sync::Arc;
use std::sync::LazyLock;

use biotope::jobs::Artefact;
use biotope::jobs::local::Bench;
use biotope::jobs::local::FileRequest;
use biotope::jobs::progress::Live;
use biotope::jobs::registry::Registry;
use biotope::jobs::results::load;
use biotope::storage::BlockingStore;
use biotope::storage::Store;
use biotope_api::warning::Warning;
use serde_json::Value;
use serde_json::json;

use crate::jobs::ecosystem_inputs::by_value;
use crate::jobs::ecosystem_inputs::grid;
use crate::jobs::ecosystem_inputs::month;
use crate::jobs::ecosystem_inputs::slope;
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

/// A meadow of a square kilometre where deer graze, with a deep pond in its south-west corner.
fn meadow() -> Value {
    let pond = grid(34, 34, |column, row| if column < 3 && row > 30 { 9.0 } else { 0.0 });
    with(|i| {
        i["terrain"]["source"] = grid(34, 34, |column, _| 100.0 + 0.1 * column as f64);
        i["maps"] = json!({ "water_depth_m": pond });
        i["plants"] = json!([{"species": "Poaceae", "growth_kg_per_m2": 1.0}]);
        i["animals"] = json!([{
            "species": "Cervus elaphus", "group_size_min": 5, "group_size_max": 12, "max_density_per_km2": 60.0
        }]);
    })
}

#[tokio::test(flavor = "multi_thread")]
async fn a_way_point_is_in_the_graph_the_trails_and_the_plannings() {
    let (x, y) = (975.0, 945.0);
    let mut inputs = meadow();
    inputs["passages"] = json!({"waypoints": [
        {"x": x, "y": y, "name": "gate", "share": 0.3, "species": ["cervus elaphus"]},
        {"x": 20, "y": 20, "radius_m": 20, "species": ["Cervus elaphus"]},
    ]});
    let app = TestApp::standard().await;
    let (job, status) = app.finish("ecosystem", &json!({ "inputs": inputs })).await;
    assert_eq!(status["status"], "successful", "{status}");
    let rag = app.get(&format!("{job}/results/rag?f=json")).await.json();
    let nodes = rag["nodes"].as_array().expect("nodes");
    let passed: Vec<&Value> = nodes.iter().filter(|n| n["kind"] == "waypoint").collect();
    assert_eq!(passed.len(), 1, "the other lies in the pond: {passed:?}");
    let gate = passed[0];
    assert_eq!((&gate["resource"], &gate["quantity"], &gate["draws"]), (&json!("gate"), &json!(0.0), &json!(0.3)));
    assert_eq!((&gate["x"], &gate["y"]), (&json!(x), &json!(y)));
    let edges = rag["edges"].as_array().expect("edges");
    let ends = |end: &str| edges.iter().filter(|e| e[end] == gate["id"]).count();
    assert!(ends("from") > 0 && ends("from") == ends("to"), "travel times both ways");
    let lines = app.get(&format!("{job}/results/trails.lines?f=json")).await.json().to_string();
    assert!(lines.contains(&format!("[{x:?},{y:?}]")), "a trail leads to the gate");
    let days = app.get(&format!("{job}/results/plannings?f=json")).await.json();
    let stays = days.as_array().expect("rows");
    let passes = stays.iter().filter(|stay| stay["activity"] == "pass");
    assert!(passes.clone().count() > 0 && passes.clone().all(|stay| stay["resource"] == "gate" && stay["x"] == x));
    let warnings = app.get(&format!("{job}/results/warnings?f=json")).await.json().to_string();
    assert!(warnings.contains("WAYPOINT_NOT_REACHED") && warnings.contains("/passages/waypoints/1"), "{warnings}");
    assert!(!warnings.contains("/passages/waypoints/0"), "{warnings}");
}

#[tokio::test(flavor = "multi_thread")]
async fn herds_that_miss_a_drink_say_why_in_the_warning_and_in_their_planning() {
    let mut inputs = meadow();
    // Nobody has room to drink.
    inputs["planning"] = json!({"m2_each": 200_000.0});
    let app = TestApp::standard().await;
    let (job, status) = app.finish("ecosystem", &json!({ "inputs": inputs })).await;
    assert_eq!(status["status"], "successful", "{status}");
    let why = "no place within reach holds the whole herd";
    let warnings = app.get(&format!("{job}/results/warnings?f=json")).await.json().to_string();
    assert!(warnings.contains("HERD_WAITS") && warnings.contains(&format!("drink as often as they should: {why}")));
    let days = app.get(&format!("{job}/results/plannings?f=json")).await.json();
    let said = days.as_array().expect("rows").iter().filter_map(|stay| stay["missed"].as_str());
    assert!(said.clone().any(|missed| missed.contains(&format!("drink: {why}"))), "{days}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_request_far_from_nature_is_solved_and_warned_of() {
    let mut inputs = meadow();
    inputs["plants"][0]["growth_kg_per_m2"] = json!(60.0);
    inputs["animals"][0]["max_density_per_km2"] = json!(5000.0);
    inputs["animals"].as_array_mut().expect("animals").push(json!({
        "species": "Canis mosbachensis", "group_size_min": 1, "food_kg_per_day": 0.05, "max_density_per_km2": 5000.0
    }));
    let (summary, warnings) = solved(inputs).await;
    for code in ["DENSITY_OUT_OF_RANGE", "BIOMASS_OUT_OF_RANGE"] {
        assert!(warnings.iter().any(|w| w["code"] == code), "{code}: {summary} {warnings:?}");
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn what_cannot_be_worked_with_is_a_problem_and_never_a_job() {
    let zero = |i: &mut Value| i["animals"].as_array_mut().unwrap().iter_mut().for_each(|a| a["proportion"] = json!(0));
    let eat = |i: &mut Value, who: usize, whom: &str| i["animals"][who]["diet"] = json!([{ "food": whom }]);
    let wide = "ncols 40000\nnrows 40000\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3";
    let bad: Vec<(&str, Value)> = vec![
        ("no terrain", with(|i| drop(i.as_object_mut().unwrap().remove("terrain")))),
        ("one cell", with(|i| i["terrain"]["source"] = grid(1, 1, slope))),
        ("40,000² cells", with(|i| i["terrain"]["source"] = by_value(wide))),
        ("all nodata", with(|i| i["terrain"]["source"] = grid(5, 5, |_, _| -9999.0))),
        ("infinite heights", with(|i| i["terrain"]["source"] = grid(5, 5, |_, _| 1e39))),
        ("a mask of another size", with(|i| i["maps"] = json!({"exclusion": grid(9, 10, |_, _| 0.0)}))),
        ("an unknown species", with(|i| i["plants"][1]["species"] = json!("Quercsu"))),
        ("min above max", with(|i| i["plants"][0]["moisture"] = json!({"min": 7, "max": 3}))),
        ("negative mass", with(|i| i["animals"][0]["mass_kg"] = json!(-3))),
        ("proportions that sum to zero", with(zero)),
        (
            "a cycle",
            with(|i| {
                eat(i, 0, "Canis mosbachensis");
                eat(i, 1, "Cervus elaphus");
            }),
        ),
        ("a missing prey", with(|i| eat(i, 1, "Mammuthus"))),
        ("a latitude of 95", with(|i| i["terrain"]["latitude_deg"] = json!(95))),
        ("eleven months", with(|i| i["climate"]["months"] = json!(vec![month(); 11]))),
        ("a way-point off the map", with(|i| i["passages"] = json!({"waypoints": [{"x": -9, "y": 0}]}))),
    ];
    let app = TestApp::standard().await;
    for (what, inputs) in bad {
        let problem = app.execute("ecosystem", &json!({ "inputs": inputs }), &[]).await;
        let problem = problem.assert_problem(400, "invalid-input");
        let error = &problem["errors"][0];
        for field in ["pointer", "code", "expected", "found"] {
            assert!(error[field].as_str().is_some_and(|text| !text.is_empty()), "{what}: {problem}");
        }
    }
    assert_eq!(app.get("/jobs").await.json()["jobs"], json!([]), "nothing was queued");
}

/// A period of the Tautavel sample, solved: its summary and its warnings.
fn sample(period: &str) -> (Value, Vec<Warning>) {
    let name = format!("api/examples/ecosystem-tautavel-{period}.json");
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    let store = BlockingStore::new(Store::in_memory(), runtime.handle().clone());
    let registry = Registry::standard().expect("schemas");
    let bench = Bench { registry: &registry, store: &store, threads: 2 };
    let request = FileRequest::open(&file).expect("the example");
    let kept = request.solve("ecosystem", &bench, &Arc::new(Live::new(1))).expect("a solve");
    let Ok(Artefact::Json(summary)) = load(&store, &kept.outputs["summary"]) else { panic!("no summary") };
    (summary, kept.warnings)
}

/// No herd misses food or prey for a whole day, or a drink it should have.
fn assert_nobody_goes_without(warnings: &[Warning]) {
    let missed = warnings.iter().find(|w| w.code == "HERD_WAITS" && w.message.starts_with("herds could not"));
    assert_eq!(missed, None);
}

static MILD: LazyLock<(Value, Vec<Warning>)> = LazyLock::new(|| sample("mild"));

#[test]
fn the_mild_sample_has_animals_no_denser_than_ten_times_their_relatives_and_carnivores_in_proportion() {
    let (summary, warnings) = &*MILD;
    for code in ["DENSITY_OUT_OF_RANGE", "BIOMASS_OUT_OF_RANGE"] {
        assert!(warnings.iter().all(|warning| warning.code != code), "{warnings:?}");
    }
    assert_nobody_goes_without(warnings);
    let ratio = summary["biomass"]["carnivores_per_prey"].as_f64().expect("a ratio");
    assert!((0.003..=0.03).contains(&ratio), "{ratio}");
    let animals = summary["animals"].as_array().expect("animals");
    let placed = animals.iter().filter(|a| a["individuals"].as_u64() > Some(0)).count();
    assert!(placed >= 6 && summary["herds"].as_u64() > Some(100), "{summary}");
}

#[test]
fn in_the_ice_age_reindeer_live_in_a_region_at_least_twice_as_large_and_are_most_of_the_herbivores() {
    let (ice, warnings) = sample("ice-age");
    assert_nobody_goes_without(&warnings);
    let reindeer = |summary: &Value, field: &str| {
        let animals = summary["animals"].as_array().expect("animals");
        let row = animals.iter().find(|a| a["species"] == "Rangifer tarandus").expect("reindeer");
        row[field].as_f64().expect("a number")
    };
    let (cold, mild) = (reindeer(&ice, "accessible_km2"), reindeer(&MILD.0, "accessible_km2"));
    assert!(cold >= 2.0 * mild && cold > 100.0, "{cold} km² against {mild}");
    assert!(reindeer(&ice, "individuals") > 0.0 && reindeer(&ice, "proportion_reached") > 0.5);
}
