//! The document of the API: made of the routes and the wire types, so it cannot differ from them.

use std::collections::BTreeSet;
use std::sync::Arc;

use axum::Extension;
use axum::http::HeaderMap;
use biotope_api::asset::Asset;
use biotope_api::error::Problem;
use biotope_api::execute::Execute;
use biotope_api::job::JobList;
use biotope_api::job::ProgressEvent;
use biotope_api::job::StatusInfo;
use biotope_api::process::Conformance;
use biotope_api::process::Landing;
use biotope_api::process::ProcessDescription;
use biotope_api::process::ProcessList;
use biotope_api::warning::Warning;
use schemars::SchemaGenerator;
use schemars::generate::SchemaSettings;
use serde_json::Map;
use serde_json::Value;
use serde_json::json;
use utoipa::OpenApi;

use crate::http::document;
use crate::http::error::Answer;
use crate::jobs::registry::Registry;

mod downgrade;

/// What the document says of the service as a whole.
#[derive(OpenApi)]
#[openapi(
    info(title = "Biotope", description = "Fills a virtual landscape with life. OGC API – Processes 1.0, with the \
        fields of the draft of 2.0 beside them. Lengths are in metres, angles in radians counter-clockwise from \
        east; rasters are row-major, first row north.", license(name = "MIT OR Apache-2.0",
        url = "https://www.apache.org/licenses/LICENSE-2.0")),
    servers((url = "/", description = "This service")),
    tags((name = "service", description = "The service itself"), (name = "processes", description = "What can be done"),
        (name = "jobs", description = "What is being done"), (name = "assets", description = "Uploads"))
)]
pub struct Head;

/// The document in all its forms.
#[derive(Debug, Clone)]
pub struct Documents(Arc<Forms>);

#[derive(Debug)]
struct Forms {
    v3_1: Value,
    v3_0: Value,
    yaml: String,
}

impl Documents {
    /// The document of a service with these processes.
    pub fn new(registry: &Registry) -> Self {
        let mut v3_1 = serde_json::to_value(super::routes().split_for_parts().1).unwrap_or_default();
        v3_1["components"]["schemas"] = Value::Object(components(registry));
        add_problem_answers(&mut v3_1);
        let yaml = yaml_serde::to_string(&v3_1).unwrap_or_default();
        Self(Arc::new(Forms { v3_0: downgrade::to_3_0(&v3_1), v3_1, yaml }))
    }

    /// OpenAPI 3.1 as YAML.
    pub fn yaml(&self) -> &str {
        &self.0.yaml
    }

    /// OpenAPI 3.1.
    pub fn v3_1(&self) -> &Value {
        &self.0.v3_1
    }

    /// OpenAPI 3.0, for clients that read nothing newer.
    pub fn v3_0(&self) -> &Value {
        &self.0.v3_0
    }
}

/// The schemas of all wire types, and of the inputs of every process.
fn components(registry: &Registry) -> Map<String, Value> {
    let settings = SchemaSettings::draft2020_12().with(|s| s.definitions_path = "/components/schemas".into());
    let mut generator = SchemaGenerator::new(settings);
    generator.subschema_for::<Landing>();
    generator.subschema_for::<Conformance>();
    generator.subschema_for::<ProcessList>();
    generator.subschema_for::<ProcessDescription>();
    generator.subschema_for::<Execute>();
    generator.subschema_for::<StatusInfo>();
    generator.subschema_for::<JobList>();
    generator.subschema_for::<ProgressEvent>();
    generator.subschema_for::<Problem>();
    generator.subschema_for::<Warning>();
    generator.subschema_for::<Asset>();
    let mut all = generator.take_definitions(true);
    all.insert(
        "Results".into(),
        json!({ "type": "object", "additionalProperties": true, "description":
        "Outputs by id: a value, or `{\"href\", \"type\"}`." }),
    );
    all.insert("Health".into(), health());
    for entry in registry.entries() {
        add_inputs(&mut all, entry.description.id, entry.description.inputs.as_value());
    }
    all.sort_keys();
    all
}

fn health() -> Value {
    let count = json!({ "type": "integer", "minimum": 0 });
    json!({ "type": "object", "required": ["status", "version", "jobs"], "properties": {
        "status": { "type": "string", "enum": ["ok", "draining"] },
        "version": { "type": "string" },
        "jobs": { "type": "object", "required": ["accepted", "running"],
            "properties": { "accepted": count, "running": count } } } })
}

/// Adds the schema of a process's inputs as `<process>.inputs`, its definitions beside it.
fn add_inputs(all: &mut Map<String, Value>, process: &str, schema: &Value) {
    let name = format!("{process}.inputs");
    let mut schema = schema.clone();
    let definitions = schema.as_object_mut().and_then(|fields| {
        fields.remove("$schema");
        fields.remove("$defs")
    });
    for (definition, mut value) in definitions.and_then(|d| d.as_object().cloned()).unwrap_or_default() {
        rename_references(&mut value, process);
        all.insert(format!("{process}.{definition}"), value);
    }
    rename_references(&mut schema, process);
    all.insert(name, schema);
}

fn rename_references(value: &mut Value, process: &str) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(|item| rename_references(item, process)),
        Value::Object(fields) => {
            if let Some(Value::String(target)) = fields.get_mut("$ref")
                && let Some(definition) = target.strip_prefix("#/$defs/")
            {
                *target = format!("#/components/schemas/{process}.{definition}");
            }
            fields.values_mut().for_each(|field| rename_references(field, process));
        }
        _ => {}
    }
}

/// Every operation may answer with a problem.
fn add_problem_answers(document: &mut Value) {
    let schema = json!({ "schema": { "$ref": "#/components/schemas/Problem" } });
    let problem = json!({ "description": "A problem.",
        "content": { "application/problem+json": schema, "application/json": schema } });
    for path in document["paths"].as_object_mut().into_iter().flat_map(|paths| paths.values_mut()) {
        for operation in path.as_object_mut().into_iter().flat_map(|operations| operations.values_mut()) {
            if let Some(answers) = operation["responses"].as_object_mut() {
                answers.insert("default".into(), problem.clone());
            }
        }
    }
}

/// The routes of the document as `GET /jobs/{id}`.
pub fn operations(document: &Value) -> BTreeSet<String> {
    let paths = document["paths"].as_object().into_iter().flatten();
    paths
        .flat_map(|(path, item)| {
            let methods = item.as_object().into_iter().flat_map(|operations| operations.keys());
            methods.map(move |method| format!("{} {path}", method.to_uppercase()))
        })
        .collect()
}

/// The API, OpenAPI 3.1 as YAML.
#[utoipa::path(get, path = "/openapi.yaml", operation_id = "get_openapi_yaml", tag = "service",
    responses((status = 200, description = "The document.", content_type = "application/yaml", body = String)))]
pub async fn get_yaml(Extension(documents): Extension<Documents>, headers: HeaderMap) -> Answer {
    Ok(document::tagged(&headers, "application/yaml", documents.yaml().as_bytes().to_vec()))
}

/// The API, OpenAPI 3.1 as JSON.
#[utoipa::path(get, path = "/openapi.json", operation_id = "get_openapi", tag = "service",
    responses((status = 200, description = "The document.",
        content_type = "application/vnd.oai.openapi+json;version=3.1", body = String)))]
pub async fn get_json(Extension(documents): Extension<Documents>, headers: HeaderMap) -> Answer {
    let bytes = documents.v3_1().to_string().into_bytes();
    Ok(document::tagged(&headers, "application/vnd.oai.openapi+json;version=3.1", bytes))
}

/// The API, OpenAPI 3.0 as JSON.
#[utoipa::path(get, path = "/openapi-3.0.json", operation_id = "get_openapi_3_0", tag = "service",
    responses((status = 200, description = "The document.",
        content_type = "application/vnd.oai.openapi+json;version=3.0", body = String)))]
pub async fn get_json_3_0(Extension(documents): Extension<Documents>, headers: HeaderMap) -> Answer {
    let bytes = documents.v3_0().to_string().into_bytes();
    Ok(document::tagged(&headers, "application/vnd.oai.openapi+json;version=3.0", bytes))
}
