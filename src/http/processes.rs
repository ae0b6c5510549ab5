//! What can be done.

use std::collections::BTreeMap;

use axum::extract::Path;
use axum::extract::State;
use axum::http::HeaderMap;
use biotope_api::error::ErrorCode;
use biotope_api::link::Link;
use biotope_api::process::InputDescription;
use biotope_api::process::OutputDescription;
use biotope_api::process::ProcessDescription;
use biotope_api::process::ProcessList;
use biotope_api::process::ProcessSummary;
use serde_json::Value;
use serde_json::json;

use crate::app::App;
use crate::http::base::Base;
use crate::http::document;
use crate::http::error::Answer;
use crate::http::error::ApiError;
use crate::http::negotiate::wants_page;
use crate::http::pages;
use crate::http::query::Params;
use crate::jobs::Description;
use crate::jobs::Output;
use crate::jobs::artefact::Kind;

/// The processes of the service.
#[utoipa::path(get, path = "/processes", operation_id = "list_processes", tag = "processes",
    params(("limit" = Option<u32>, Query, minimum = 1, maximum = 10000, description = "Entries a page may hold."),
        ("offset" = Option<u32>, Query, description = "Entries to leave out at the beginning.")),
    responses((status = 200, description = "The processes.", body = ref("#/components/schemas/ProcessList"),
        content_type = "application/json")))]
pub async fn list_processes(State(app): State<App>, headers: HeaderMap, base: Base, params: Params) -> Answer {
    let limit = params.limit()? as usize;
    let offset = params.read("offset", "a number from 0", |text| text.parse::<usize>().ok())?.unwrap_or(0);
    let entries = app.jobs.registry().entries();
    let processes: Vec<_> =
        entries.iter().skip(offset).take(limit).map(|entry| summary(&entry.description, &base)).collect();
    let mut links = vec![
        Link::new(base.url("/processes"), "self", "application/json", "This document"),
        Link::new(base.url("/processes?f=html"), "alternate", "text/html", "This document as a page"),
    ];
    if offset + processes.len() < entries.len() {
        let next = params.with("/processes", "offset", &(offset + limit).to_string());
        links.push(Link::new(base.url(&next), "next", "application/json", "More"));
    }
    let list = ProcessList { processes, links };
    if wants_page(&headers, params.one("f"))? {
        return Ok(document::page(pages::processes(&list)));
    }
    document::json(&headers, &list)
}

/// One process: its inputs and outputs.
#[utoipa::path(get, path = "/processes/{id}", operation_id = "get_process", tag = "processes",
    params(("id" = String, Path, description = "Id of the process.")),
    responses((status = 200, description = "The process.", body = ref("#/components/schemas/ProcessDescription"),
        content_type = "application/json")))]
pub async fn get_process(
    State(app): State<App>,
    Path(id): Path<String>,
    headers: HeaderMap,
    base: Base,
    params: Params,
) -> Answer {
    let unknown = || ApiError::new(ErrorCode::NoSuchProcess, format!("There is no process {id:?}."));
    let entry = app.jobs.registry().find(&id).ok_or_else(unknown)?;
    let process = describe(&entry.description, &base);
    if wants_page(&headers, params.one("f"))? {
        return Ok(document::page(pages::process(&process)));
    }
    document::json(&headers, &process)
}

fn summary(description: &Description, base: &Base) -> ProcessSummary {
    let path = format!("/processes/{}", description.id);
    let execute = "http://www.opengis.net/def/rel/ogc/1.0/execute";
    ProcessSummary {
        id: description.id.into(),
        title: description.title.into(),
        description: description.text.into(),
        version: description.version.into(),
        keywords: description.keywords.iter().map(|word| (*word).to_owned()).collect(),
        job_control_options: description.control.to_vec(),
        output_transmission: vec!["value".into(), "reference".into()],
        links: vec![
            Link::new(base.url(&path), "self", "application/json", "The process"),
            Link::new(base.url(&format!("{path}?f=html")), "alternate", "text/html", "The process as a page"),
            Link::new(base.url(&format!("{path}/execution")), execute, "application/json", "Run the process"),
        ],
    }
}

fn describe(description: &Description, base: &Base) -> ProcessDescription {
    let outputs = description.outputs.iter().map(|output| (output.id.to_owned(), describe_output(output))).collect();
    ProcessDescription { summary: summary(description, base), inputs: inputs(description.inputs.as_value()), outputs }
}

/// The properties of an inputs schema, each with the definitions it needs.
fn inputs(schema: &Value) -> BTreeMap<String, InputDescription> {
    let required: Vec<_> = schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    let text = |property: &Value, name: &str| property[name].as_str().map(str::to_owned);
    let describe = |(id, property): (&String, &Value)| {
        let mut own = property.clone();
        if let (Some(fields), Some(definitions)) = (own.as_object_mut(), schema.get("$defs"))
            && property.to_string().contains("\"#/$defs/")
        {
            fields.insert("$defs".into(), definitions.clone());
        }
        let input = InputDescription {
            title: text(property, "title").unwrap_or_else(|| id.clone()),
            description: text(property, "description").unwrap_or_default(),
            schema: own,
            min_occurs: u32::from(required.contains(&id.as_str())),
            max_occurs: 1,
        };
        (id.clone(), input)
    };
    schema["properties"].as_object().into_iter().flatten().map(describe).collect()
}

fn describe_output(output: &Output) -> OutputDescription {
    let forms = output.kind.forms();
    let schema = match forms.as_slice() {
        [one] => form_schema(&output.kind, &one.media_type),
        several => {
            let each: Vec<_> = several.iter().map(|form| form_schema(&output.kind, &form.media_type)).collect();
            json!({ "oneOf": each })
        }
    };
    OutputDescription {
        title: output.title.into(),
        description: output.text.into(),
        schema,
        media_types: forms.into_iter().map(|form| form.media_type).collect(),
        unit: Some(output.unit.to_owned()).filter(|unit| !unit.is_empty()),
        default: output.default,
    }
}

fn form_schema(kind: &Kind, media_type: &str) -> Value {
    match media_type {
        "application/json" if matches!(kind, Kind::Table) => {
            json!({ "type": "array", "items": { "type": "object" }, "contentMediaType": media_type })
        }
        "application/json" => json!({ "contentMediaType": media_type }),
        text if text.starts_with("text/") => json!({ "type": "string", "contentMediaType": text }),
        binary => json!({ "type": "string", "contentEncoding": "binary", "contentMediaType": binary }),
    }
}
