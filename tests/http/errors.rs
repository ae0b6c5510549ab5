use axum::http::Method;
use axum::http::StatusCode;

use crate::support::TestApp;

#[tokio::test]
async fn what_the_framework_refuses_is_a_problem_document_too() {
    let app = TestApp::new().await;
    app.get("/nowhere").await.assert_problem(404, "not-found");
    let reply = app.ask(Method::PUT, "/jobs", &[], "").await;
    reply.assert_problem(405, "method-not-allowed");
    assert!(reply.header("allow").contains("GET"));
    app.get("/processes/%ff").await.assert_problem(400, "invalid-parameter");
}

#[tokio::test]
async fn problems_come_in_the_form_the_client_reads() {
    let app = TestApp::new().await;
    for (accept, media_type) in [
        ("*/*", "application/problem+json"),
        ("application/json, */*", "application/problem+json"),
        ("application/json", "application/json"),
        ("text/html,*/*;q=0.8", "text/html; charset=utf-8"),
    ] {
        let reply = app.get_as("/jobs/none", accept).await;
        assert_eq!((reply.status, reply.header("content-type")), (StatusCode::NOT_FOUND, media_type), "{accept}");
    }
}

#[tokio::test]
async fn every_code_has_its_line_on_the_page_of_problems() {
    let app = TestApp::new().await;
    let page = app.get("/problems").await.text();
    for code in biotope_api::error::ErrorCode::ALL {
        assert!(page.contains(&format!("id=\"{code}\"")), "{code}");
    }
    for code in biotope_api::warning::WarningCode::ALL {
        assert!(page.contains(&format!("id=\"{code}\"")), "{code}");
    }
}
