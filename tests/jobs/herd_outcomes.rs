//! What jobs on herds give: chained by reference, corrected, painted, and refused while they run.

use axum::http::StatusCode;
use serde_json::Value;
use serde_json::json;

use crate::jobs::herd_inputs::animals;
use crate::jobs::herd_inputs::animation;
use crate::jobs::herd_inputs::extraction;
use crate::jobs::herd_inputs::key_herd;
use crate::support::Reply;
use crate::support::TestApp;

/// Runs a job that must succeed; its address.
async fn done(app: &TestApp, process: &str, inputs: Value) -> String {
    let (job, status) = app.finish(process, &json!({ "inputs": inputs })).await;
    assert_eq!(status["status"], "successful", "{status}");
    job
}

async fn output(app: &TestApp, job: &str, output: &str) -> Reply {
    let reply = app.get(&format!("{job}/results/{output}")).await;
    assert_eq!(reply.status, StatusCode::OK, "{output}: {}", reply.text());
    reply
}

async fn rows(app: &TestApp, job: &str, table: &str) -> Vec<Value> {
    output(app, job, &format!("{table}?f=json")).await.json().as_array().expect("rows").clone()
}

/// Runs a job that must fail by the input's fault: the pointer, code and finding of its fault.
async fn refused(app: &TestApp, process: &str, inputs: Value) -> (String, String, String) {
    let (job, status) = app.finish(process, &json!({ "inputs": inputs })).await;
    assert_eq!(status["status"], "failed", "{status}");
    let problem = app.get(&format!("{job}/results")).await.assert_problem(400, "invalid-input");
    let error = &problem["errors"][0];
    let text = |field: &str| error[field].as_str().unwrap_or_default().to_owned();
    assert!(!text("expected").is_empty());
    (text("pointer"), text("code"), text("found"))
}

fn reference(job: &str, output: &str) -> Value {
    json!({"href": format!("{job}/results/{output}")})
}

#[tokio::test(flavor = "multi_thread")]
async fn a_photo_becomes_a_herd_that_walks() {
    let app = TestApp::standard().await;
    // 1. Six animals in the photo.
    let found = done(&app, "herd-extraction", extraction::inputs()).await;
    let animals = rows(&app, &found, "ellipses").await;
    assert_eq!(animals.len(), 6, "{animals:?}");
    let header = output(&app, &found, "ellipses?f=csv").await.text();
    assert!(header.starts_with("id,x,y,a,b,theta,suspect"), "{header}");
    for (id, magic) in [("overlay", &b"\x89PNG"[..]), ("mask?f=png", b"\x89PNG"), ("mask?f=tif", b"II")] {
        assert!(output(&app, &found, id).await.bytes.starts_with(magic), "{id}");
    }
    // 2. Twelve on the ground, at two places.
    let herd_at = |x: f64, seed: u64| {
        key_herd::with(|i| {
            i["exemplar"] = reference(&found, "ellipses");
            i["place"]["position"] = json!([x, 50]);
            i["seed"] = json!(seed);
        })
    };
    let one = done(&app, "key-herd", herd_at(25.0, 1)).await;
    let two = done(&app, "key-herd", herd_at(75.0, 2)).await;
    let herd = rows(&app, &one, "ellipses").await;
    assert_eq!(herd.len(), 12);
    assert!(herd.iter().all(|e| e["a"] == 1.2 && e["b"] == 0.5 && e["suspect"] == false), "{herd:?}");
    // 3. They walk.
    let walk = animation::with(|i| {
        i["obstacles"] = json!({});
        i["key_frames"] = json!([
            {"time_s": 10, "herd": reference(&one, "ellipses")},
            {"time_s": 70, "herd": reference(&two, "ellipses")},
        ]);
        i["every_s"] = json!(1.0);
    });
    let walk = done(&app, "herd-animation", walk).await;
    let tracks = rows(&app, &walk, "tracks").await;
    assert_eq!(tracks.len(), 12 * 61);
    assert!((tracks[0]["t"] == 10.0) && (tracks[60]["t"] == 70.0) && tracks[61]["id"] == 1);
    assert!(output(&app, &walk, "tracks?f=csv").await.text().starts_with("id,t,x,y,z,heading\n0,10.0,"));
    // 4. The same numbers in every form.
    let binary = output(&app, &walk, "tracks.bin").await.bytes;
    assert_eq!(&binary[..16], b"BTRK\x01\0\0\0\x0c\0\0\0\x3d\0\0\0");
    let x = f32::from_le_bytes(binary[16 + 4 * 61..][..4].try_into().expect("four bytes"));
    assert_eq!(x, tracks[0]["x"].as_f64().expect("a number") as f32);
    let features = output(&app, &walk, "tracks.mfjson").await.json();
    assert_eq!(features["features"][0]["temporalGeometry"]["coordinates"][0][0], tracks[0]["x"]);
    assert_eq!(features["features"][0]["temporalGeometry"]["datetimes"][0], "2000-01-01T00:00:10.000Z");
    let scene = output(&app, &walk, "tracks.gltf").await.json();
    assert_eq!(scene["nodes"][1]["translation"][0].as_f64().map(|v| v as f32), Some(x));
    let report = output(&app, &walk, "report").await.json();
    assert!(report["arrivals"][0]["on_place"].as_f64().expect("a share") >= 0.95, "{report}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_second_run_takes_the_corrections_of_the_first() {
    let app = TestApp::standard().await;
    let first = rows(&app, &done(&app, "herd-extraction", extraction::inputs()).await, "ellipses").await;
    let drawn = json!({"x": 50, "y": 5, "a": 4, "b": 2, "theta": 0.5});
    let corrections = json!({
        "remove": [0], "flip": [1], "add": [drawn], "replace": [{"id": 2, "by": [drawn, drawn]}],
    });
    let inputs = extraction::with(|i| i["corrections"] = corrections.clone());
    let second = rows(&app, &done(&app, "herd-extraction", inputs).await, "ellipses").await;
    let ids: Vec<u64> = second.iter().filter_map(|e| e["id"].as_u64()).collect();
    assert_eq!(ids, [1, 2, 3, 4, 5, 6, 7]);
    let theta = |e: &Value| e["theta"].as_f64().expect("an angle");
    assert!(((theta(&second[0]) - theta(&first[1])).abs() - std::f64::consts::PI).abs() < 1e-9);
    assert_eq!((&second[1]["x"], &second[2]), (&json!(50.0), &first[3]));

    let strange = extraction::with(|i| i["corrections"] = json!({"flip": [1, 6]}));
    let (pointer, code, found) = refused(&app, "herd-extraction", strange).await;
    assert_eq!(
        (pointer.as_str(), code.as_str(), found.as_str()),
        ("/inputs/corrections/flip/1", "unknown-animal", "6")
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn photos_without_anything_to_find_are_refused() {
    let app = TestApp::standard().await;
    let large = extraction::with(|i| i["options"] = json!({"min_area_px": 1000}));
    assert_eq!(refused(&app, "herd-extraction", large).await.1, "no-region");
    let alike = extraction::with(|i| i["scribbles"]["strokes"][0]["points"] = json!([[12, 2], [18, 2]]));
    assert_eq!(refused(&app, "herd-extraction", alike).await.1, "colours-alike");
}

#[tokio::test(flavor = "multi_thread")]
async fn maps_of_a_key_herd_are_taken_back_painted() {
    let app = TestApp::standard().await;
    let first = done(&app, "key-herd", key_herd::inputs()).await;
    let painted = key_herd::with(|i| {
        i["density"] = json!({"type": "painted", "map": {"raster": reference(&first, "density")}});
        i["orientation"] = json!({"raster": reference(&first, "orientation")});
        i["seed"] = json!(5);
    });
    let second = done(&app, "key-herd", painted).await;
    let map = |job: String, id: &'static str| {
        let app = &app;
        async move { output(app, &job, &format!("{id}?f=json")).await.json() }
    };
    for id in ["density", "orientation"] {
        let (one, two) = (map(first.clone(), id).await, map(second.clone(), id).await);
        for field in ["width", "height", "cell_m", "origin_x_m", "origin_y_m"] {
            assert_eq!(one[field], two[field], "{field} of {id}");
        }
        let mean = |map: &Value| map["mean"].as_f64().expect("a mean");
        assert!((mean(&one) - mean(&two)).abs() < 0.01 * mean(&one).abs(), "{one} {two}");
    }
    assert_eq!(rows(&app, &second, "ellipses").await.len(), 12);
    // East, whatever the exemplar says: a grey picture of black is 0 radians.
    let east = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 50\n0 0\n0 0\n";
    let east = json!({"raster": {"value": east, "mediaType": "text/plain"}});
    let turned = done(&app, "key-herd", key_herd::with(|i| i["orientation"] = east.clone())).await;
    let herd = rows(&app, &turned, "ellipses").await;
    assert!(herd.iter().all(|e| e["theta"].as_f64().expect("an angle").abs() < 1e-6), "{herd:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn more_animals_than_there_is_room_for_are_refused() {
    let app = TestApp::standard().await;
    let (pointer, code, found) = refused(&app, "key-herd", key_herd::with(|i| i["count"] = json!(90_000))).await;
    assert_eq!((pointer.as_str(), code.as_str(), found.as_str()), ("/inputs/count", "no-room-for-herd", "90000"));
    let desert = "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 50\n0 0\n0 0\n";
    let desert = json!({"type": "painted", "map": {"raster": {"value": desert, "mediaType": "text/plain"}}});
    let (_, code, _) = refused(&app, "key-herd", key_herd::with(|i| i["density"] = desert.clone())).await;
    assert_eq!(code, "no-density");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_wall_without_a_way_round_is_refused_with_where() {
    let app = TestApp::standard().await;
    let wall = json!({"areas": [{"outer": [[45, -1], [49, -1], [49, 101], [45, 101]]}]});
    let (pointer, code, found) =
        refused(&app, "herd-animation", animation::with(|i| i["obstacles"] = wall.clone())).await;
    assert_eq!((pointer.as_str(), code.as_str()), ("/inputs/key_frames/1", "no-way"));
    assert!(found.contains("the nearest place that can be reached is (4"), "{found}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_key_frame_that_nobody_can_reach_is_warned_of_with_the_time_needed() {
    let app = TestApp::standard().await;
    let hasty = animation::with(|i| {
        i["key_frames"][1]["time_s"] = json!(3);
        i["key_frames"][2]["time_s"] = json!(8);
    });
    let job = done(&app, "herd-animation", hasty).await;
    let warnings = output(&app, &job, "warnings").await.json();
    let warning = warnings.as_array().expect("a list").iter().find(|w| w["code"] == "KEY_FRAME_UNREACHABLE");
    let warning = warning.unwrap_or_else(|| panic!("{warnings}"));
    assert!(warning["pointer"].as_str().expect("a pointer").starts_with("/inputs/key_frames/"));
    assert!(warning["message"].as_str().expect("a message").contains("s are needed"), "{warning}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_herd_of_one_stands_and_walks() {
    let app = TestApp::standard().await;
    let alone = key_herd::with(|i| {
        i["exemplar"] = animals(1, 0.0, 0.0);
        i["count"] = json!(1);
    });
    let stands = done(&app, "key-herd", alone).await;
    let warnings = output(&app, &stands, "warnings").await.text();
    assert!(warnings.contains("NO_HULL"), "{warnings}");
    let walks = animation::with(|i| {
        i["key_frames"] = json!([
            {"time_s": 0, "herd": reference(&stands, "ellipses")}, {"time_s": 40, "position": [80, 30]},
        ]);
    });
    let job = done(&app, "herd-animation", walks).await;
    assert_eq!(rows(&app, &job, "tracks").await.len(), 81);
}
