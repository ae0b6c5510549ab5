//! What finished jobs hand out.

use std::collections::BTreeMap;

use axum::extract::Path;
use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Response;
use biotope_api::error::ErrorCode;
use biotope_api::error::Problem;
use biotope_api::execute::Execute;
use biotope_api::execute::ResponseForm;
use biotope_api::execute::TransmissionMode;
use biotope_api::job::JobState;
use serde_json::Map;
use serde_json::Value;
use serde_json::json;

use crate::app::App;
use crate::http::base::Base;
use crate::http::bytes;
use crate::http::bytes::FileHead;
use crate::http::document;
use crate::http::error::Answer;
use crate::http::error::ApiError;
use crate::http::jobs::find;
use crate::http::negotiate::Accept;
use crate::http::pages;
use crate::http::query::Params;
use crate::http::status::exception;
use crate::http::status::path_of;
use crate::http::status::status_info;
use crate::jobs::Artefact;
use crate::jobs::artefact::Form;
use crate::jobs::artefact::Kind;
use crate::jobs::context::Stored;
use crate::jobs::queue::Outcome;
use crate::jobs::queue::Row;
use crate::jobs::selection::ALWAYS;
use crate::jobs::selection::fits;
use crate::jobs::selection::is_meant;

/// Largest stored document or table that stands by value among the results when the request does
/// not say, in bytes.
const VALUE_LIMIT: u64 = 64 << 10;

/// All outputs of a job: small documents and tables by value, the others by reference.
#[utoipa::path(get, path = "/jobs/{id}/results", operation_id = "get_results", tag = "jobs",
    params(("id" = String, Path, description = "Id of the job.")),
    responses((status = 200, description = "The results.", body = ref("#/components/schemas/Results"),
        content_type = "application/json")))]
pub async fn get_results(
    State(app): State<App>,
    Path(id): Path<String>,
    headers: HeaderMap,
    base: Base,
    params: Params,
) -> Answer {
    let row = find(&app, &id).await?;
    if crate::http::negotiate::wants_page(&headers, params.one("f"))? {
        return page(&app, &row, &base).await;
    }
    of_row(&app, &headers, &row, &base).await
}

/// The results of a job in the form its request asked for.
///
/// # Errors
/// When there are none: not yet, no more, or never.
pub async fn of_row(app: &App, headers: &HeaderMap, row: &Row, _base: &Base) -> Answer {
    let outputs = outputs(row)?;
    let execute = app.jobs.task(row).await?.execute;
    let shown: Vec<_> = outputs.iter().filter(|(id, _)| is_shown(&execute, id)).collect();
    if execute.response == Some(ResponseForm::Raw) {
        let chosen = |id: &str| !ALWAYS.contains(&id) || execute.outputs.as_ref().is_some_and(|c| c.contains_key(id));
        if let [(id, stored)] = shown.iter().filter(|(id, _)| chosen(id)).collect::<Vec<_>>().as_slice() {
            return raw(app, headers, (id, stored), preferred(&execute, id)).await;
        }
    }
    let mut all = Map::new();
    for (id, stored) in shown {
        all.insert(id.clone(), entry(app, row, (id, stored), &execute).await?);
    }
    document::json(headers, &Value::Object(all))
}

/// The outputs of a job that has succeeded.
fn outputs(row: &Row) -> Result<&BTreeMap<String, Stored>, ApiError> {
    match (&row.outcome, row.state) {
        (Some(Outcome::Success { outputs, .. }), JobState::Successful) => Ok(outputs),
        (Some(Outcome::Failure(problem)), _) => Err(Problem::clone(problem).into()),
        (_, JobState::Dismissed) => Err(ApiError::new(ErrorCode::JobDismissed, "The job was dismissed.")),
        (_, state) => {
            let detail = format!("The job is {}; its results are not there yet.", state.as_str());
            let retry = axum::http::HeaderValue::from_static("1");
            Err(ApiError::new(ErrorCode::ResultNotReady, detail).with_header(axum::http::header::RETRY_AFTER, retry))
        }
    }
}

/// Whether an output belongs in the document: what the request chose, else everything kept.
fn is_shown(execute: &Execute, id: &str) -> bool {
    execute.outputs.as_ref().is_none_or(|chosen| chosen.keys().any(|wish| is_meant(wish, id)))
}

/// An output in the document of results.
async fn entry(app: &App, row: &Row, output: (&String, &Stored), execute: &Execute) -> Result<Value, ApiError> {
    let (id, stored) = output;
    let wish = execute.outputs.as_ref().and_then(|chosen| {
        chosen.get(id).or_else(|| chosen.iter().find(|(wish, _)| is_meant(wish, id)).map(|(_, choice)| choice))
    });
    let structured = matches!(stored.kind, Kind::Json | Kind::Table | Kind::Tables);
    let by_value = match wish.and_then(|wish| wish.transmission_mode) {
        Some(TransmissionMode::Value) => structured,
        Some(TransmissionMode::Reference) => false,
        None => structured && stored.size <= VALUE_LIMIT && id != "manifest",
    };
    if !by_value {
        let form = default_form(stored, preferred(execute, id));
        return Ok(json!({ "href": format!("{}/results/{id}", path_of(row)), "type": form.media_type }));
    }
    Ok(match app.jobs.artefact(stored).await? {
        Artefact::Json(value) => value,
        Artefact::Table(table) => table.records(),
        other => {
            let encoded = other.encode("json").map_err(crate::jobs::JobsError::from)?;
            serde_json::from_slice(&encoded.bytes).map_err(crate::jobs::JobsError::from)?
        }
    })
}

/// The media type the request asked of an output.
fn preferred<'a>(execute: &'a Execute, id: &str) -> Option<&'a str> {
    execute.outputs.as_ref()?.get(id)?.format.as_ref()?.media_type.as_deref()
}

/// The form an output is handed out in when the client does not say: what its request asked for,
/// else the first.
fn default_form(stored: &Stored, preferred: Option<&str>) -> Form {
    let forms = stored.kind.forms();
    let asked = forms.iter().find(|form| Some(form.media_type.as_str()) == preferred).cloned();
    asked.unwrap_or_else(|| forms.into_iter().next().unwrap_or_else(|| Form::new("bin", "application/octet-stream")))
}

async fn raw(app: &App, headers: &HeaderMap, output: (&String, &Stored), preferred: Option<&str>) -> Answer {
    let (id, stored) = output;
    let form = default_form(stored, preferred);
    deliver(app, headers, id, stored, &form).await
}

async fn deliver(app: &App, headers: &HeaderMap, id: &str, stored: &Stored, form: &Form) -> Answer {
    let delivery = app.jobs.deliver(stored, form).await?;
    let name = if id.ends_with(&format!(".{}", form.name)) { id.to_owned() } else { format!("{id}.{}", form.name) };
    let media_type = if form.media_type == "text/csv" { "text/csv; charset=utf-8" } else { &form.media_type };
    bytes::serve(&app.jobs, headers, delivery, &FileHead { media_type: media_type.to_owned(), name, immutable: false })
}

/// One output, in the form asked for by `f` or `Accept`.
#[utoipa::path(get, path = "/jobs/{id}/results/{output}", operation_id = "get_output", tag = "jobs",
    params(("id" = String, Path, description = "Id of the job."),
        ("output" = String, Path, description = "Id of the output."),
        ("f" = Option<String>, Query, description = "Form: `tif`, `png`, `json`, `csv`, `html` …; before `Accept`.")),
    responses((status = 200, description = "The output.", content_type = "application/octet-stream"),
        (status = 206, description = "A part of it.", content_type = "application/octet-stream"),
        (status = 304, description = "The client holds it already.")))]
pub async fn get_output(
    State(app): State<App>,
    Path((id, output)): Path<(String, String)>,
    headers: HeaderMap,
    base: Base,
    params: Params,
) -> Answer {
    let row = find(&app, &id).await?;
    let unknown = || ApiError::new(ErrorCode::NoSuchOutput, format!("The job has kept no output {output:?}."));
    let stored = outputs(&row)?.get(&output).ok_or_else(unknown)?.clone();
    let execute = app.jobs.task(&row).await?.execute;
    match choose(&stored, &headers, params.one("f"), preferred(&execute, &output))? {
        Some(form) => deliver(&app, &headers, &output, &stored, &form).await,
        None => output_page(&app, &row, &base, (&output, &stored)).await,
    }
}

/// The form a client wants; `None` for a page for people.
fn choose(
    stored: &Stored,
    headers: &HeaderMap,
    f: Option<&str>,
    preferred: Option<&str>,
) -> Result<Option<Form>, ApiError> {
    let forms = stored.kind.forms();
    let names = || forms.iter().map(|form| form.name.as_str()).chain(["html"]).collect::<Vec<_>>().join(", ");
    if let Some(f) = f {
        let form = forms.iter().find(|form| form.name == f).cloned();
        let page = f == "html" && form.is_none();
        let refuse = || ApiError::parameter(ErrorCode::InvalidParameter, "f", format!("one of {}", names()), f);
        return if page { Ok(None) } else { form.map(Some).ok_or_else(refuse) };
    }
    let first = default_form(stored, preferred);
    let offers: Vec<_> =
        [first.clone()].into_iter().chain(forms.iter().filter(|form| **form != first).cloned()).collect();
    let media_types = offers.iter().map(|form| form.media_type.as_str()).chain(["text/html"]);
    let refuse = || ApiError::new(ErrorCode::NotAcceptable, format!("The output can be had as: {}.", names()));
    let chosen = Accept::of(headers).choose(media_types).ok_or_else(refuse)?;
    Ok(offers.get(chosen).cloned())
}

async fn output_page(app: &App, row: &Row, base: &Base, output: (&String, &Stored)) -> Answer {
    let view = view(app, row, output.0, output.1).await?;
    Ok(document::page(pages::output(&status_info(row, base), &view)))
}

/// A job as a page: its progress, or all it has handed back.
///
/// # Errors
/// When the store fails.
pub async fn page(app: &App, row: &Row, base: &Base) -> Answer {
    let (mut views, mut warnings) = (Vec::new(), Vec::new());
    if let Some(Outcome::Success { outputs, warnings: told }) = &row.outcome {
        for (id, stored) in outputs {
            views.push(view(app, row, id, stored).await?);
        }
        views.sort_by_key(|view| view.order);
        warnings.clone_from(told);
    }
    let answer: Response = document::page(pages::job(&pages::JobView {
        status: status_info(row, base),
        problem: exception(row).cloned(),
        outputs: views,
        warnings,
    }));
    Ok(answer)
}

/// An output as a page shows it.
async fn view(app: &App, row: &Row, id: &str, stored: &Stored) -> Result<pages::OutputView, ApiError> {
    let entry = app.jobs.registry().find(&row.process);
    let described = entry.map_or(&[][..], |entry| entry.description.outputs.as_slice());
    let order = described.iter().position(|output| fits(id, output.id)).unwrap_or(usize::MAX);
    let known = described.get(order);
    let shown = matches!(stored.kind, Kind::Json | Kind::Table | Kind::Tables) && stored.size <= pages::SHOWN_LIMIT;
    Ok(pages::OutputView {
        id: id.to_owned(),
        order,
        of_a_family: known.is_some_and(|output| output.id.contains('<')),
        title: known.map_or_else(|| id.to_owned(), |output| output.title.to_owned()),
        text: known.map_or_else(String::new, |output| output.text.to_owned()),
        href: format!("{}/results/{id}", path_of(row)),
        size: stored.size,
        blank: stored.blank,
        kind: stored.kind.clone(),
        artefact: if shown { Some(app.jobs.artefact(stored).await?) } else { None },
    })
}
