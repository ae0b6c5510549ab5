use axum::http::Method;
use axum::http::StatusCode;
use serde_json::Value;
use serde_json::json;

use crate::support::TestApp;

fn zoo() -> Value {
    json!({"inputs": {"terrain": {"href": "data:,abc"}, "seed": 7}})
}

#[tokio::test]
async fn the_document_holds_small_documents_and_leads_to_everything_else() {
    let app = TestApp::new().await;
    let (job, _) = app.finish("zoo", &zoo()).await;
    let results = app.get(&format!("{job}/results")).await.json();
    assert_eq!(results["summary"]["seed"], 7);
    assert_eq!(results["herds"], json!([{"herd": 0, "x": 0.5}, {"herd": 1, "x": 1.5}]));
    assert_eq!(results["rag"]["edges"][1]["herd"], 1);
    assert_eq!(results["warnings"][0]["code"], "EIGHT_BIT");
    let map = json!({"href": format!("{job}/results/maps.height"), "type": "image/tiff"});
    assert_eq!(results["maps.height"], map);
    assert_eq!(results["extra"], Value::Null, "only kept when asked for");
    for (id, value) in results.as_object().unwrap() {
        let href = value["href"].as_str().map(str::to_owned).unwrap_or_else(|| format!("{job}/results/{id}"));
        assert_eq!(app.get(&href).await.status, StatusCode::OK, "{href}");
    }
}

#[tokio::test]
async fn an_output_comes_in_the_form_asked_for() {
    let app = TestApp::new().await;
    let (job, _) = app.finish("zoo", &zoo()).await;
    for (output, accept, f, media_type, begin) in [
        ("maps.height", "", "", "image/tiff", "II*"),
        ("maps.height", "*/*", "png", "image/png", "\u{fffd}PNG"),
        ("maps.height", "image/png", "", "image/png", "\u{fffd}PNG"),
        ("maps.height", "application/json", "", "application/json", "{\"title\":\"Heights\""),
        ("maps.height", "text/html,*/*;q=0.8", "", "text/html; charset=utf-8", "<!doctype"),
        ("herds", "", "", "application/json", "[{\"herd\":0"),
        ("herds", "text/csv", "", "text/csv; charset=utf-8", "herd,x\n0,0.5"),
        ("herds", "image/png", "html", "text/html; charset=utf-8", "<!doctype"),
        ("rag", "", "csv", "text/csv; charset=utf-8", "# nodes\nherd,x"),
        ("summary", "", "", "application/json", "{\"seed\":7"),
        ("tracks.bin", "", "", "application/octet-stream", "0123456789"),
        ("tracks.bin", "", "bin", "application/octet-stream", "0123456789"),
    ] {
        let query = if f.is_empty() { String::new() } else { format!("?f={f}") };
        let accept = if accept.is_empty() { "*/*" } else { accept };
        let reply = app.get_as(&format!("{job}/results/{output}{query}"), accept).await;
        assert_eq!((reply.status, reply.header("content-type")), (StatusCode::OK, media_type), "{output} {accept} {f}");
        assert!(reply.text().starts_with(begin), "{output} {accept} {f}: {}", &reply.text()[..20]);
    }
    app.get_as(&format!("{job}/results/herds"), "image/png").await.assert_problem(406, "not-acceptable");
    app.get(&format!("{job}/results/herds?f=tif")).await.assert_problem(400, "invalid-parameter");
    app.get(&format!("{job}/results/nothing")).await.assert_problem(404, "no-such-output");
}

#[tokio::test]
async fn a_request_chooses_what_is_kept_and_how_it_is_handed_over() {
    let app = TestApp::new().await;
    let choice =
        json!({"maps.*": {}, "extra": {"transmissionMode": "reference"}, "herds": {"transmissionMode": "reference"}});
    let body = json!({"inputs": zoo()["inputs"], "outputs": choice});
    let (job, _) = app.finish("zoo", &body).await;
    let results = app.get(&format!("{job}/results")).await.json();
    let ids: Vec<_> = results.as_object().unwrap().keys().collect();
    assert_eq!(ids, ["extra", "herds", "maps.height"]);
    assert!(results["extra"]["href"].is_string() && results["herds"]["href"].is_string());
    app.get(&format!("{job}/results/summary")).await.assert_problem(404, "no-such-output");
    assert_eq!(app.get(&format!("{job}/results/manifest")).await.status, StatusCode::OK, "kept of every job");
}

#[tokio::test]
async fn raw_gives_the_bytes_of_one_output_and_the_document_of_several() {
    let app = TestApp::new().await;
    let one = json!({"inputs": {"value": "hello"}, "response": "raw"});
    assert_eq!(app.execute("echo", &one, &[]).await.text(), "\"hello\"");
    let format = json!({"maps.height": {"format": {"mediaType": "image/png"}}});
    let (job, _) = app.finish("zoo", &json!({"inputs": zoo()["inputs"], "outputs": format, "response": "raw"})).await;
    assert_eq!(app.get(&format!("{job}/results")).await.header("content-type"), "image/png");
    let (job, _) = app.finish("zoo", &json!({"inputs": zoo()["inputs"], "response": "raw"})).await;
    assert!(app.get(&format!("{job}/results")).await.json()["maps.height"]["href"].is_string());
}

#[tokio::test]
async fn results_that_are_not_there_say_why() {
    let app = TestApp::new().await;
    let job = app.submit("trouble", &json!({"inputs": {"kind": "forever"}})).await;
    let reply = app.get(&format!("{job}/results")).await;
    let problem = reply.assert_problem(404, "result-not-ready");
    assert_eq!(problem["type"], "http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/result-not-ready");
    assert_eq!(reply.header("retry-after"), "1");
    app.delete(&job).await;
    for (kind, status, code) in
        [("invalid", 400, "invalid-input"), ("fault", 500, "internal"), ("panic", 500, "internal")]
    {
        let (job, ended) = app.finish("trouble", &json!({"inputs": {"kind": kind}})).await;
        assert_eq!((&ended["status"], &ended["exception"]["code"]), (&json!("failed"), &json!(code)));
        let reply = app.get(&format!("{job}/results")).await;
        reply.assert_problem(status, code);
        assert!(!reply.text().contains("secret") && !ended.to_string().contains("secret"), "{ended}");
    }
    assert_eq!(app.get("/health").await.status, StatusCode::OK, "the service lives on");
}

#[tokio::test]
async fn files_are_served_in_ranges_and_not_again_to_those_who_hold_them() {
    let app = TestApp::new().await;
    let (job, _) = app.finish("zoo", &zoo()).await;
    let path = format!("{job}/results/tracks.bin");
    let part = app.ask(Method::GET, &path, &[("range", "bytes=2-4")], "").await;
    assert_eq!((part.status, part.text().as_str()), (StatusCode::PARTIAL_CONTENT, "234"));
    assert_eq!(part.header("content-range"), "bytes 2-4/10");
    let outside = app.ask(Method::GET, &path, &[("range", "bytes=20-")], "").await;
    outside.assert_problem(416, "range-not-satisfiable");
    assert_eq!(outside.header("content-range"), "bytes */10");
    let tag = app.get(&path).await.header("etag").to_owned();
    assert_eq!(app.ask(Method::GET, &path, &[("if-none-match", &tag)], "").await.status, StatusCode::NOT_MODIFIED);
    let head = app.ask(Method::HEAD, &path, &[], "").await;
    assert_eq!((head.status, head.header("content-length"), head.bytes.len()), (StatusCode::OK, "10", 0));
    let png = app.get(&format!("{job}/results/maps.height?f=png")).await.header("etag").to_owned();
    let tif = app.get(&format!("{job}/results/maps.height?f=tif")).await.header("etag").to_owned();
    assert_ne!(png, tif);
}

#[tokio::test]
async fn compressed_results_arrive_whole_under_a_weak_tag() {
    let app = TestApp::new().await;
    let (job, _) = app.finish("zoo", &zoo()).await;
    let path = format!("{job}/results/manifest");
    let plain = app.get(&path).await;
    let zipped = app.ask(Method::GET, &path, &[("accept-encoding", "gzip")], "").await;
    assert_eq!((zipped.header("content-encoding"), zipped.header("accept-ranges")), ("gzip", ""));
    let mut whole = Vec::new();
    std::io::Read::read_to_end(&mut flate2::read::GzDecoder::new(zipped.bytes.as_slice()), &mut whole).unwrap();
    assert_eq!(whole, plain.bytes);
    assert_eq!(zipped.header("etag"), format!("W/{}", plain.header("etag")));
    let tif = app.ask(Method::GET, &format!("{job}/results/maps.height"), &[("accept-encoding", "gzip")], "").await;
    assert_eq!(tif.header("content-encoding"), "", "rasters are packed already");
}

#[tokio::test]
async fn the_manifest_says_what_was_done_and_nothing_of_when_and_where() {
    let app = TestApp::new().await;
    let (one, _) = app.finish("zoo", &zoo()).await;
    let (two, _) = app.finish("zoo", &zoo()).await;
    let manifest = app.get(&format!("{one}/results/manifest")).await;
    assert_eq!(manifest.bytes, app.get(&format!("{two}/results/manifest")).await.bytes);
    let manifest = manifest.json();
    assert_eq!((&manifest["process"], &manifest["seed"]), (&json!("zoo"), &json!(7)));
    let digest = "sha256:ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
    assert_eq!(manifest["parameters"]["terrain"]["digest"], digest, "SHA-256 of abc");
    assert_eq!(manifest["sources"], json!([{"subject": "bison.mass", "source": "T table A.2"}]));
    assert_eq!(manifest["warnings"][0]["count"], 3);
    assert!(manifest["outputs"]["maps.height"]["digest"].is_string());
}
