//! Black-box tests: they drive the program named by `BIOTOPE_BIN`, or the one just built.

#![allow(clippy::unwrap_used, reason = "a test ends where something it needs is not there")]

use std::io::BufRead as _;
use std::io::BufReader;
use std::io::Read as _;
use std::io::Write as _;
use std::net::TcpListener;
use std::net::TcpStream;
use std::path::Path;
use std::process::Child;
use std::process::Command;
use std::process::Output;
use std::process::Stdio;
use std::time::Duration;
use std::time::Instant;

use serde_json::Value;
use serde_json::json;

fn program() -> Command {
    let built = env!("CARGO_BIN_EXE_biotope").to_owned();
    let mut command = Command::new(std::env::var("BIOTOPE_BIN").unwrap_or(built));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).stdin(Stdio::null());
    command
}

/// A running server; killed when dropped.
struct Server {
    child: Child,
    base: String,
}

impl Server {
    fn start(data: &Path, flags: &[&str]) -> Self {
        let mut command = program();
        command.args(["serve", "--port", "0", "--threads", "2", "--data"]).arg(data).args(flags);
        let mut child = command.stdout(Stdio::piped()).spawn().expect("the program starts");
        let mut line = String::new();
        let out = child.stdout.take().expect("its output");
        BufReader::new(out).read_line(&mut line).expect("a line");
        let base = line.trim().strip_prefix("listening on ").expect("its address").to_owned();
        Self { child, base }
    }

    fn signal(&self, name: &str) {
        let sent = Command::new("kill").args([&format!("-{name}"), &self.child.id().to_string()]).status();
        assert!(sent.expect("kill").success());
    }

    fn kill(mut self) {
        self.signal("KILL");
        self.child.wait().expect("its end");
    }

    /// Waits for the end; how long it took, and whether it ended well.
    fn ended(&mut self) -> (Duration, bool) {
        let begin = Instant::now();
        let status = self.child.wait().expect("its end");
        (begin.elapsed(), status.success())
    }

    fn get(&self, path: &str) -> (u16, Vec<u8>) {
        answer(agent().get(format!("{}{path}", self.base)).call())
    }

    fn json(&self, path: &str) -> Value {
        serde_json::from_slice(&self.get(path).1).expect("JSON")
    }

    fn post(&self, path: &str, body: &Value) -> (u16, Value) {
        let request = agent().post(format!("{}{path}", self.base)).header("prefer", "respond-async");
        let (status, bytes) = answer(request.send_json(body));
        (status, serde_json::from_slice(&bytes).expect("JSON"))
    }

    fn delete(&self, path: &str) -> u16 {
        answer(agent().delete(format!("{}{path}", self.base)).call()).0
    }

    fn submit(&self, process: &str, body: &Value) -> String {
        let (status, job) = self.post(&format!("/processes/{process}/execution"), body);
        assert_eq!(status, 201, "{job}");
        format!("/jobs/{}", job["id"].as_str().expect("an id"))
    }

    /// The status of a job once its state is one of `states`.
    fn until(&self, job: &str, states: &[&str]) -> Value {
        let begin = Instant::now();
        loop {
            let status = self.json(job);
            if states.contains(&status["status"].as_str().expect("a state")) {
                return status;
            }
            assert!(begin.elapsed() < Duration::from_secs(120), "{status}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Waits until a job runs and has made progress.
    fn under_way(&self, job: &str) {
        while self.json(job)["progress"].as_u64() == Some(0) {
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// The manifest and every output of a job, as bytes.
    fn results(&self, job: &str) -> Vec<(String, Vec<u8>)> {
        let results = self.json(&format!("{job}/results"));
        let ids = results.as_object().expect("an object").keys();
        ids.map(|id| (id.clone(), self.get(&format!("{job}/results/{id}")).1)).collect()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _gone_already = self.child.kill();
        let _gone = self.child.wait();
    }
}

fn agent() -> ureq::Agent {
    let config =
        ureq::Agent::config_builder().http_status_as_error(false).timeout_global(Some(Duration::from_secs(60)));
    config.build().new_agent()
}

fn answer(sent: Result<ureq::http::Response<ureq::Body>, ureq::Error>) -> (u16, Vec<u8>) {
    let mut answer = sent.expect("an answer");
    let bytes = answer.body_mut().read_to_vec().expect("a body");
    (answer.status().as_u16(), bytes)
}

fn echo(message: &str, pause_s: f64) -> Value {
    json!({"inputs": {"value": message, "pause_s": pause_s}})
}

#[test]
fn a_job_survives_the_sudden_death_of_the_service_with_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let first = Server::start(folder.path(), &[]);
    let job = first.submit("echo", &echo("life", 2.0));
    let waiting: Vec<_> = (0..5).map(|_| first.submit("echo", &echo("more", 1.0))).collect();
    first.under_way(&job);
    first.kill();
    let second = Server::start(folder.path(), &[]);
    for interrupted in waiting.iter().chain([&job]) {
        assert_eq!(second.until(interrupted, &["successful", "failed"])["status"], "successful");
    }
    let elsewhere = tempfile::tempdir().expect("a folder");
    let undisturbed = Server::start(elsewhere.path(), &[]);
    let same = undisturbed.submit("echo", &echo("life", 2.0));
    undisturbed.until(&same, &["successful"]);
    assert_eq!(second.results(&job), undisturbed.results(&same));
}

/// The valley example with its files uploaded: a solve of some seconds.
fn valley(server: &Server) -> Value {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("api/examples");
    let text = std::fs::read_to_string(folder.join("ecosystem-valley.json")).expect("the example");
    let mut request: Value = serde_json::from_str(&text).expect("JSON");
    upload_files(server, &folder, &mut request);
    request
}

/// Replaces every reference to a file by one to the file uploaded.
fn upload_files(server: &Server, folder: &Path, value: &mut Value) {
    match value {
        Value::Object(fields) => {
            if let Some(Value::String(href)) = fields.get_mut("href") {
                let bytes = std::fs::read(folder.join(&*href)).expect("the file");
                let request = agent().post(format!("{}/assets", server.base)).header("content-type", "image/tiff");
                let (status, answer) = answer(request.send(&bytes[..]));
                assert!([200, 201].contains(&status), "{status}");
                let asset: Value = serde_json::from_slice(&answer).expect("JSON");
                *href = format!("/assets/{}", asset["digest"].as_str().expect("a digest"));
            }
            fields.values_mut().for_each(|field| upload_files(server, folder, field));
        }
        Value::Array(items) => items.iter_mut().for_each(|item| upload_files(server, folder, item)),
        _ => {}
    }
}

#[test]
fn a_solve_survives_the_sudden_death_of_the_service_with_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut server = Server::start(folder.path(), &[]);
    let request = valley(&server);
    let job = server.submit("ecosystem", &request);
    // Killed early in the solve, and again late in it.
    for percent in [5, 60] {
        while server.json(&job)["progress"].as_u64().is_some_and(|progress| progress < percent) {
            std::thread::sleep(Duration::from_millis(5));
        }
        assert_eq!(server.json(&job)["status"], "running", "the test came too late");
        server.kill();
        server = Server::start(folder.path(), &[]);
    }
    assert_eq!(server.until(&job, &["successful", "failed"])["status"], "successful");
    let elsewhere = tempfile::tempdir().expect("a folder");
    let undisturbed = Server::start(elsewhere.path(), &[]);
    let same = undisturbed.submit("ecosystem", &valley(&undisturbed));
    assert_eq!(undisturbed.until(&same, &["successful", "failed"])["status"], "successful");
    let (survived, expected) = (server.results(&job), undisturbed.results(&same));
    assert!(expected.len() > 20, "{}", expected.len());
    for ((id, bytes), (same_id, same_bytes)) in survived.iter().zip(&expected) {
        assert!(id == same_id && bytes == same_bytes, "{id} differs");
    }
    assert_eq!(survived.len(), expected.len());
}

#[test]
fn a_dismissal_in_the_middle_of_a_solve_stops_it_and_frees_its_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let server = Server::start(folder.path(), &["--jobs", "1"]);
    let request = valley(&server);
    let job = server.submit("ecosystem", &request);
    server.under_way(&job);
    let next = server.submit("ecosystem", &request);
    let begin = Instant::now();
    assert_eq!(server.delete(&job), 200);
    server.until(&next, &["running", "successful"]);
    assert!(begin.elapsed() < Duration::from_secs(10), "{:?}", begin.elapsed());
    assert_eq!(server.json(&job)["status"], "dismissed");
    server.delete(&next);
}

#[test]
fn a_job_that_brings_the_service_down_three_times_is_given_up() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut server = Server::start(folder.path(), &[]);
    let job = server.submit("echo", &echo("poison", 60.0));
    for _ in 0..3 {
        server.until(&job, &["running"]);
        server.kill();
        server = Server::start(folder.path(), &[]);
    }
    let status = server.json(&job);
    assert_eq!((&status["status"], &status["exception"]["code"]), (&json!("failed"), &json!("crashed-repeatedly")));
    assert_eq!(server.get(&format!("{job}/results")).0, 500);
}

#[test]
fn a_dismissal_frees_the_place_of_the_job() {
    let folder = tempfile::tempdir().expect("a folder");
    let server = Server::start(folder.path(), &["--quick-jobs", "1"]);
    let long = server.submit("echo", &echo("long", 600.0));
    let next = server.submit("echo", &echo("next", 0.0));
    server.until(&long, &["running"]);
    let begin = Instant::now();
    assert_eq!(server.delete(&long), 200);
    server.until(&next, &["successful"]);
    assert!(begin.elapsed() < Duration::from_secs(10), "{:?}", begin.elapsed());
    assert_eq!(server.json(&long)["status"], "dismissed");
    assert_eq!(server.get(&format!("{long}/results")).0, 410);
}

#[test]
fn a_service_told_to_stop_ends_soon_and_its_job_goes_on_at_the_next_start() {
    for signal in ["TERM", "INT"] {
        let folder = tempfile::tempdir().expect("a folder");
        let mut server = Server::start(folder.path(), &[]);
        let job = server.submit("echo", &echo("patience", 1.0));
        server.under_way(&job);
        server.signal(signal);
        let (time, well) = server.ended();
        assert!(well && time < Duration::from_secs(8), "{signal}: {time:?}");
        let again = Server::start(folder.path(), &[]);
        assert_eq!(again.until(&job, &["successful", "failed"])["status"], "successful");
    }
}

#[test]
fn a_port_or_a_folder_that_is_taken_ends_the_program_with_the_name_of_the_flag() {
    let folder = tempfile::tempdir().expect("a folder");
    let taken = TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = taken.local_addr().expect("its number").port().to_string();
    for command in ["serve", "demo"] {
        let done = program().args([command, "--port", &port, "--data"]).arg(folder.path()).output().expect("an end");
        assert_refused(&done, "--port");
    }
    let _held = Server::start(folder.path(), &[]);
    let done = program().args(["serve", "--port", "0", "--data"]).arg(folder.path()).output().expect("an end");
    assert_refused(&done, "--data");
}

fn assert_refused(done: &Output, flag: &str) {
    let said = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(2), "{said}");
    assert!(said.contains(flag), "{said}");
}

#[test]
fn run_writes_every_output_of_a_request_in_a_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, out) = (folder.path().join("request.json"), folder.path().join("out"));
    std::fs::write(&file, echo("from a file", 0.1).to_string()).expect("a request");
    let mut run = program();
    run.args(["run", "echo"]).arg(&file).arg("--out").arg(&out).args(["--threads", "1"]);
    let done = run.output().expect("an end");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let mut names: Vec<_> =
        std::fs::read_dir(&out).expect("the folder").map(|f| f.expect("a file").file_name()).collect();
    names.sort();
    assert_eq!(names, ["manifest.json", "value.json", "warnings.json"]);
    assert_eq!(std::fs::read_to_string(out.join("value.json")).expect("an output"), "\"from a file\"");
    std::fs::write(&file, json!({"inputs": {"pause_s": -1}}).to_string()).expect("a request");
    let failed = run.output().expect("an end");
    let said = String::from_utf8_lossy(&failed.stderr);
    assert_eq!(failed.status.code(), Some(1));
    assert!(said.contains("/inputs/value") && said.contains("/inputs/pause_s"), "{said}");
}

#[test]
fn run_and_the_service_give_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, out) = (folder.path().join("request.json"), folder.path().join("out"));
    std::fs::write(&file, echo("the same", 0.0).to_string()).expect("a request");
    let done = program().args(["run", "echo"]).arg(&file).arg("--out").arg(&out).output().expect("an end");
    assert!(done.status.success());
    let server = Server::start(&folder.path().join("data"), &[]);
    let job = server.submit("echo", &echo("the same", 0.0));
    server.until(&job, &["successful"]);
    for (id, bytes) in server.results(&job) {
        assert_eq!(std::fs::read(out.join(format!("{id}.json"))).expect("an output"), bytes, "{id}");
    }
}

#[test]
fn the_document_of_the_api_is_printed_in_both_versions() {
    for version in ["3.0", "3.1"] {
        let done = program().args(["openapi", "--version", version]).output().expect("an end");
        let document: Value = serde_json::from_slice(&done.stdout).expect("JSON");
        assert!(document["openapi"].as_str().is_some_and(|v| v.starts_with(version)), "{}", document["openapi"]);
    }
}

#[test]
fn a_body_that_does_not_arrive_is_answered_in_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let server = Server::start(folder.path(), &["--body-timeout-s", "1", "--body-mib", "1"]);
    let address = server.base.trim_start_matches("http://");
    let mut stream = TcpStream::connect(address).expect("a connection");
    stream.set_read_timeout(Some(Duration::from_secs(20))).expect("a limit");
    let head = "POST /processes/echo/execution HTTP/1.1\r\nHost: test\r\nContent-Length: 100\r\n\r\n{";
    stream.write_all(head.as_bytes()).expect("the head is sent");
    let mut reply = String::new();
    let _until_closed = stream.read_to_string(&mut reply);
    assert!(reply.starts_with("HTTP/1.1 408") && reply.contains("body-too-slow"), "{reply}");
    let large = json!({"inputs": {"value": "x".repeat(3 << 20)}});
    assert_eq!(server.post("/processes/echo/execution", &large).0, 413);
    assert_eq!(server.get("/health").0, 200);
}

#[test]
fn a_stream_of_events_comes_over_the_wire_while_the_job_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let server = Server::start(folder.path(), &[]);
    let job = server.submit("echo", &echo("events", 1.0));
    let begin = Instant::now();
    let mut answer = agent().get(format!("{}{job}/events", server.base)).call().expect("an answer");
    let mut lines = BufReader::new(answer.body_mut().as_reader()).lines();
    let first = lines.find(|line| line.as_ref().is_ok_and(|line| line == "event: progress"));
    assert!(first.is_some() && begin.elapsed() < Duration::from_millis(900), "{:?}", begin.elapsed());
    let last = lines.map_while(Result::ok).filter(|line| line.starts_with("data:")).last();
    assert!(last.is_some_and(|line| line.contains("successful")));
}
