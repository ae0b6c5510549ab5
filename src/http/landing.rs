//! The entrance, and the classes of the standard.

use axum::http::HeaderMap;
use biotope_api::link::Link;
use biotope_api::process::Conformance;
use biotope_api::process::Landing;

use crate::http::base::Base;
use crate::http::document;
use crate::http::error::Answer;
use crate::http::negotiate::wants_page;
use crate::http::pages;
use crate::http::query::Params;

const TITLE: &str = "Biotope";
const DESCRIPTION: &str = "Fills a virtual landscape with life: where each plant and animal lives, the trails they \
                           wear, and what each herd does all day; and lays arrangements out as an example shows them.";

/// The entrance: where to go from here.
#[utoipa::path(get, path = "/", operation_id = "get_landing", tag = "service",
    responses((status = 200, description = "The entrance.", body = ref("#/components/schemas/Landing"),
        content_type = "application/json")))]
pub async fn get_landing(headers: HeaderMap, base: Base, params: Params) -> Answer {
    let landing = landing(&base);
    if wants_page(&headers, params.one("f"))? {
        return Ok(document::page(pages::landing(&landing)));
    }
    document::json(&headers, &landing)
}

fn landing(base: &Base) -> Landing {
    const OGC: &str = "http://www.opengis.net/def/rel/ogc/1.0/";
    const JSON: &str = "application/json";
    let link = |path: &str, rel: &str, kind: &str, title: &str| Link::new(base.url(path), rel, kind, title);
    let ogc = |path: &str, rel: &str, title: &str| link(path, &format!("{OGC}{rel}"), JSON, title);
    let openapi = |version: &str| format!("application/vnd.oai.openapi+json;version={version}");
    let links = vec![
        link("/", "self", JSON, "This document"),
        link("/?f=html", "alternate", "text/html", "This document as a page"),
        link("/openapi-3.0.json", "service-desc", &openapi("3.0"), "The API, OpenAPI 3.0"),
        link("/openapi.json", "service-desc", &openapi("3.1"), "The API, OpenAPI 3.1"),
        link("/openapi.yaml", "service-desc", "application/yaml", "The API, OpenAPI 3.1"),
        link("/docs/", "service-doc", "text/html", "The API for people"),
        link("/problems", "help", "text/html", "Every problem and warning"),
        link("/conformance", "conformance", JSON, "What of the standard is kept"),
        ogc("/conformance", "conformance", "What of the standard is kept"),
        ogc("/processes", "processes", "What can be done"),
        ogc("/jobs", "job-list", "What is being done"),
        link("/health", "status", JSON, "Whether the service is well"),
    ];
    Landing { title: TITLE.into(), description: DESCRIPTION.into(), version: env!("CARGO_PKG_VERSION").into(), links }
}

/// The classes of OGC API – Processes that the service keeps.
#[utoipa::path(get, path = "/conformance", operation_id = "get_conformance", tag = "service",
    responses((status = 200, description = "The classes.", body = ref("#/components/schemas/Conformance"),
        content_type = "application/json")))]
pub async fn get_conformance(headers: HeaderMap) -> Answer {
    let classes = |version: &str, names: &[&str]| -> Vec<String> {
        let class = |name: &&str| format!("http://www.opengis.net/spec/ogcapi-processes-1/{version}/conf/{name}");
        names.iter().map(class).collect()
    };
    let one = ["core", "ogc-process-description", "json", "html", "oas30", "job-list", "dismiss"];
    let two = ["core", "ogc-process-description", "json", "html", "oas30", "oas31", "job-list", "dismiss"];
    let conforms_to = [classes("1.0", &one), classes("2.0", &two)].concat();
    document::json(&headers, &Conformance { conforms_to })
}
