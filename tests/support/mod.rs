//! The service in this process: memory instead of a folder, requests without a socket.
//!
//! A [`TestApp`] has the processes of the service and a few that misbehave on purpose.

pub mod processes;

use std::time::Duration;

use axum::body::Body;
use axum::http::HeaderMap;
use axum::http::Method;
use axum::http::Request;
use axum::http::StatusCode;
use biotope::app::App;
use biotope::app::Limits;
use biotope::http::router;
use biotope::jobs::Jobs;
use biotope::jobs::Settings;
use biotope::jobs::registry::Registry;
use serde_json::Value;
use tower::ServiceExt as _;

/// The service in this process.
pub struct TestApp {
    /// Its parts.
    pub app: App,
}

/// An answer, whole.
#[derive(Debug)]
pub struct Reply {
    pub status: StatusCode,
    pub headers: HeaderMap,
    pub bytes: Vec<u8>,
}

impl TestApp {
    /// A service with room for everything.
    pub async fn new() -> Self {
        Self::with(settings(), Limits::default()).await
    }

    /// A service with the processes that users have.
    pub async fn standard() -> Self {
        let processes = Registry::standard().expect("schemas");
        let jobs = Jobs::in_memory(processes, settings()).await.expect("a service in memory");
        Self { app: App::new(jobs, Limits::default()).expect("a service") }
    }

    pub async fn with(settings: Settings, limits: Limits) -> Self {
        let jobs = Jobs::in_memory(registry(), settings).await.expect("a service in memory");
        Self { app: App::new(jobs, limits).expect("a service") }
    }

    pub async fn send(&self, request: Request<Body>) -> Reply {
        let answer = router(self.app.clone()).oneshot(request).await.expect("an answer");
        let (parts, body) = answer.into_parts();
        let bytes = axum::body::to_bytes(body, usize::MAX).await.expect("a body").to_vec();
        Reply { status: parts.status, headers: parts.headers, bytes }
    }

    pub async fn ask(&self, method: Method, path: &str, headers: &[(&str, &str)], body: impl Into<Body>) -> Reply {
        let builder = Request::builder().method(method).uri(path).header("host", "biotope.test");
        let builder = headers.iter().fold(builder, |builder, (name, value)| builder.header(*name, *value));
        self.send(builder.body(body.into()).expect("a request")).await
    }

    pub async fn get(&self, path: &str) -> Reply {
        self.ask(Method::GET, path, &[], Body::empty()).await
    }

    pub async fn get_as(&self, path: &str, accept: &str) -> Reply {
        self.ask(Method::GET, path, &[("accept", accept)], Body::empty()).await
    }

    pub async fn delete(&self, path: &str) -> Reply {
        self.ask(Method::DELETE, path, &[], Body::empty()).await
    }

    /// Runs a process with these headers.
    pub async fn execute(&self, process: &str, body: &Value, headers: &[(&str, &str)]) -> Reply {
        let path = format!("/processes/{process}/execution");
        self.ask(Method::POST, &path, headers, body.to_string()).await
    }

    /// Makes a job; its address.
    pub async fn submit(&self, process: &str, body: &Value) -> String {
        let reply = self.execute(process, body, &[("prefer", "respond-async")]).await;
        assert_eq!(reply.status, StatusCode::CREATED, "{}", reply.text());
        reply.header("location").to_owned()
    }

    /// Makes a job and waits for its end; its address and its last status.
    pub async fn finish(&self, process: &str, body: &Value) -> (String, Value) {
        let job = self.submit(process, body).await;
        let status = self.ended(&job).await;
        (job, status)
    }

    /// The status of a job once it has ended.
    pub async fn ended(&self, job: &str) -> Value {
        self.until(job, |status| !["accepted", "running"].contains(&status)).await
    }

    /// The status of a job once its state passes `test`.
    pub async fn until(&self, job: &str, test: impl Fn(&str) -> bool) -> Value {
        for _ in 0..2000 {
            let status = self.get(job).await.json();
            if test(status["status"].as_str().expect("a state")) {
                return status;
            }
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
        panic!("{job} does not get there");
    }
}

impl Reply {
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.bytes).unwrap_or_else(|_| panic!("not JSON: {}", self.text()))
    }

    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.bytes).into_owned()
    }

    /// The value of a header; empty when absent.
    pub fn header(&self, name: &str) -> &str {
        self.headers.get(name).map_or("", |value| value.to_str().expect("plain text"))
    }

    /// Asserts that this is a problem document of that code and status.
    pub fn assert_problem(&self, status: u16, code: &str) -> Value {
        assert_eq!(self.status.as_u16(), status, "{}", self.text());
        let problem = self.json();
        assert_eq!(problem["code"], code, "{problem}");
        assert_eq!(problem["status"], status);
        for part in ["type", "title", "detail"] {
            assert!(problem[part].as_str().is_some_and(|text| !text.is_empty()), "{part} in {problem}");
        }
        problem
    }
}

/// Two threads and room for everything.
pub fn settings() -> Settings {
    Settings {
        threads: 2,
        heavy_jobs: 2,
        quick_jobs: 4,
        memory_bytes: 1 << 30,
        waiting_jobs: 100,
        ..Settings::default()
    }
}

/// The processes of the service and those of the tests.
pub fn registry() -> Registry {
    Registry::of(processes::all()).expect("schemas")
}
