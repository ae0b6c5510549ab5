//! The list of jobs, and a job with all it has handed back.

use biotope_api::error::Problem;
use biotope_api::job::JobList;
use biotope_api::job::StatusInfo;
use biotope_api::warning::Warning;

use crate::http::pages::data;
use crate::http::pages::esc;
use crate::http::pages::layout;
use crate::jobs::Artefact;
use crate::jobs::artefact::Kind;

/// Largest stored document or table that is drawn on a page, in bytes; larger ones are linked.
pub const SHOWN_LIMIT: u64 = 1 << 20;

/// Most warnings that are shown without being asked for.
const WARNINGS_OPEN: usize = 4;

/// A job as its page shows it.
pub struct JobView {
    /// Its status.
    pub status: StatusInfo,
    /// Why it failed.
    pub problem: Option<Problem>,
    /// What it has handed back.
    pub outputs: Vec<OutputView>,
    /// What readers should know.
    pub warnings: Vec<Warning>,
}

/// An output as a page shows it.
pub struct OutputView {
    /// Its id.
    pub id: String,
    /// Its place among the outputs of the process.
    pub order: usize,
    /// Whether it is one of several alike, such as one a species.
    pub of_a_family: bool,
    /// Its name, or that of its family.
    pub title: String,
    /// What it holds.
    pub text: String,
    /// Its address.
    pub href: String,
    /// Size of its stored form in bytes.
    pub size: u64,
    /// Whether it is a map with nothing on it.
    pub blank: bool,
    /// What kind of thing it is.
    pub kind: Kind,
    /// The thing itself, when it is a document or table small enough to be drawn.
    pub artefact: Option<Artefact>,
}

/// The list of jobs.
pub fn jobs(list: &JobList) -> String {
    let row = |job: &StatusInfo| {
        format!(
            r#"<tr><th><a href="/jobs/{id}">{process}</a><br><code class="soft">{id}</code></th><td>{state}</td><td class="number">{progress} %</td><td>{created}</td><td>{message}</td></tr>"#,
            id = esc(&job.id),
            process = esc(&job.process_id),
            state = state(job),
            progress = job.progress,
            created = moment(&job.created),
            message = esc(&job.message)
        )
    };
    let rows: String = list.jobs.iter().map(row).collect();
    let older = list.links.iter().find(|link| link.rel == "next");
    let older = older.map(|link| format!(r#"<p><a href="{}">Older jobs</a></p>"#, esc(&link.href))).unwrap_or_default();
    let body = if rows.is_empty() {
        "<p>No jobs yet.</p>".to_owned()
    } else {
        format!(
            r#"<div class="scroll"><table><thead><tr><th>Job</th><th>State</th><th class="number">Done</th><th>Accepted</th><th></th></tr></thead><tbody>{rows}</tbody></table></div>{older}"#
        )
    };
    layout("Jobs", &[], &body)
}

/// A job: its progress while it runs, all it has handed back when it is done.
pub fn job(view: &JobView) -> String {
    let status = &view.status;
    let mut body = head(status);
    if !status.status.is_final() {
        body.push_str(&live(status));
    }
    if let Some(problem) = &view.problem {
        body.push_str(&failure(problem));
    }
    let (first, rest): (Vec<_>, Vec<_>) = view.outputs.iter().partition(|output| !output.of_a_family);
    body.push_str(&warnings(&view.warnings));
    body.push_str(&figures("Maps and pictures", first.iter().filter(|output| is_picture(output))));
    body.push_str(&documents("Summary", &view.outputs, is_summary));
    for members in rest.chunk_by(|a, b| a.order == b.order) {
        body.push_str(&family(members));
    }
    body.push_str(&documents("Tables and documents", &view.outputs, |output| !is_summary(output)));
    body.push_str(&files(&view.outputs));
    layout(&format!("{} job", status.process_id), &[("Jobs", "/jobs")], &body)
}

/// One output on a page of its own.
pub fn output(status: &StatusInfo, view: &OutputView) -> String {
    let shown = match (&view.kind, &view.artefact) {
        (Kind::Map | Kind::Picture, _) => figure(view, true),
        (_, Some(artefact)) => contents(artefact),
        _ => String::new(),
    };
    let body = format!(r#"<p>{}</p>{}{shown}"#, esc(&view.text), forms(view));
    let job = format!("/jobs/{}", status.id);
    layout(&heading(view), &[("Jobs", "/jobs"), (&status.process_id, &job)], &body)
}

fn head(status: &StatusInfo) -> String {
    let row = |name: &str, value: Option<&String>| {
        value.map(|value| format!("<tr><th>{name}</th><td>{}</td></tr>", moment(value))).unwrap_or_default()
    };
    format!(
        r#"<p>{state} <span class="soft">{message}</span></p>
<div class="scroll fit"><table><tbody><tr><th>Job</th><td><code>{id}</code></td></tr><tr><th>Process</th><td><a href="/processes/{process}">{process}</a></td></tr>{created}{started}{finished}</tbody></table></div>
<div class="forms"><a href="/jobs/{id}?f=json">status</a><a href="/jobs/{id}/results?f=json">results</a></div>
"#,
        state = state(status),
        message = esc(&status.message),
        id = esc(&status.id),
        process = esc(&status.process_id),
        created = row("Accepted", Some(&status.created)),
        started = row("Started", status.started.as_ref()),
        finished = row("Ended", status.finished.as_ref()),
    )
}

/// A bar that follows the job; without scripts the page asks again every few seconds.
fn live(status: &StatusInfo) -> String {
    format!(
        r#"<noscript><meta http-equiv="refresh" content="3"></noscript>
<div class="sheet" id="live" data-events="/jobs/{id}/events" data-status="/jobs/{id}"><p>{state} <output>{message}</output></p>
<progress max="100" value="{progress}"></progress></div>
<script>
{script}</script>
"#,
        id = esc(&status.id),
        state = state(status),
        message = esc(&status.message),
        progress = status.progress,
        script = include_str!("live.js"),
    )
}

fn failure(problem: &Problem) -> String {
    let fault = |fault: &biotope_api::error::FieldError| {
        format!(
            "<li><code>{}</code> expected {}, found {}</li>",
            esc(&fault.pointer),
            esc(&fault.expected),
            esc(&fault.found)
        )
    };
    let faults: String = problem.errors.iter().map(fault).collect();
    format!(
        r#"<h2>Why it failed</h2><ul class="notes faults"><li>{} <code>{}</code></li>{faults}</ul>"#,
        esc(&problem.detail),
        esc(&problem.code)
    )
}

fn warnings(warnings: &[Warning]) -> String {
    if warnings.is_empty() {
        return String::new();
    }
    let note = |warning: &Warning| {
        let count = if warning.count > 1 { format!(" (× {})", warning.count) } else { String::new() };
        let Warning { code, pointer, message, .. } = warning;
        format!(
            r#"<li>{}{count} <code><a href="/problems#{code}">{code}</a> {}</code></li>"#,
            esc(message),
            esc(pointer),
            code = esc(code)
        )
    };
    let notes: String = warnings.iter().map(note).collect();
    let open = if warnings.len() <= WARNINGS_OPEN { " open" } else { "" };
    format!(
        r#"<h2>Warnings</h2><details{open}><summary>{} warnings</summary><ul class="notes">{notes}</ul></details>"#,
        warnings.len()
    )
}

fn is_picture(view: &OutputView) -> bool {
    matches!(view.kind, Kind::Map | Kind::Picture)
}

/// Whether a reader wants to see it at once.
fn is_summary(view: &OutputView) -> bool {
    ["summary", "report", "value"].contains(&view.id.as_str())
}

/// Maps and pictures under a heading.
fn figures<'a>(title: &str, views: impl Iterator<Item = &'a &'a OutputView>) -> String {
    let figures: String = views.map(|view| figure(view, false)).collect();
    if figures.is_empty() {
        return figures;
    }
    format!(r#"<h2>{}</h2><div class="maps">{figures}</div>"#, esc(title))
}

/// The maps of a family; those with nothing on them are only named.
fn family(members: &[&OutputView]) -> String {
    let pictures: Vec<_> = members.iter().copied().filter(|output| is_picture(output)).collect();
    let Some(first) = pictures.first() else { return String::new() };
    let (blank, seen): (Vec<_>, Vec<_>) = pictures.iter().partition(|output| output.blank);
    let name = |view: &&&OutputView| format!(r#"<a href="{}">{}</a>"#, esc(&view.href), esc(&own_name(view)));
    let names: Vec<String> = blank.iter().map(name).collect();
    let nothing = match names.is_empty() {
        true => String::new(),
        false => format!("<p>Nothing anywhere: {}.</p>", names.join(", ")),
    };
    match figures(&first.title, seen.into_iter()) {
        none if none.is_empty() => format!("<h2>{}</h2>{nothing}", esc(&first.title)),
        figures => figures + &nothing,
    }
}

fn figure(view: &OutputView, whole: bool) -> String {
    format!(
        r#"<figure{}><a href="{href}?f=png"><img src="{href}?f=png" alt="{title}" loading="lazy"></a><figcaption><b>{title}</b><br><code>{id}</code>{forms}</figcaption></figure>"#,
        if whole { r#" class="whole""# } else { "" },
        href = esc(&view.href),
        title = esc(&if whole { heading(view) } else { own_name(view) }),
        id = esc(&view.id),
        forms = forms(view)
    )
}

/// Documents and tables under a heading; summaries are open, the others to be opened.
fn documents(title: &str, outputs: &[OutputView], wanted: impl Fn(&OutputView) -> bool) -> String {
    let section = |view: &OutputView| {
        let inside = match &view.artefact {
            Some(artefact) => contents(artefact),
            None => format!(r#"<p class="soft">Too large for this page ({}).</p>"#, size(view.size)),
        };
        format!(
            r#"<details{}><summary>{} <code class="soft">{}</code></summary>{}{inside}</details>"#,
            if is_summary(view) { " open" } else { "" },
            esc(&heading(view)),
            esc(&view.id),
            forms(view)
        )
    };
    let structured = |view: &&OutputView| matches!(view.kind, Kind::Json | Kind::Table | Kind::Tables);
    let sections: String = outputs.iter().filter(structured).filter(|view| wanted(view)).map(section).collect();
    if sections.is_empty() { sections } else { format!("<h2>{}</h2>{sections}", esc(title)) }
}

fn files(outputs: &[OutputView]) -> String {
    let row = |view: &OutputView| {
        format!(
            r#"<tr><th><a href="{}"><code>{}</code></a></th><td>{}</td><td class="number">{}</td></tr>"#,
            esc(&view.href),
            esc(&view.id),
            esc(&view.text),
            size(view.size)
        )
    };
    let rows: String = outputs.iter().filter(|view| matches!(view.kind, Kind::File { .. })).map(row).collect();
    if rows.is_empty() {
        return rows;
    }
    format!(r#"<h2>Files</h2><div class="scroll"><table><tbody>{rows}</tbody></table></div>"#)
}

fn contents(artefact: &Artefact) -> String {
    match artefact {
        Artefact::Json(value) => data::json(value),
        Artefact::Table(table) => data::table(table),
        Artefact::Tables(tables) => {
            tables.iter().map(|(name, table)| format!("<h3>{}</h3>{}", esc(name), data::table(table))).collect()
        }
        Artefact::Map(_) | Artefact::Picture(_) | Artefact::Bytes { .. } => String::new(),
    }
}

/// Links to the forms an output can be had in.
fn forms(view: &OutputView) -> String {
    let link =
        |form: &crate::jobs::artefact::Form| format!(r#"<a href="{}?f={1}">{1}</a>"#, esc(&view.href), esc(&form.name));
    let links: String = view.kind.forms().iter().map(link).collect();
    format!(r#"<div class="forms">{links}</div>"#)
}

/// The name of an output, whole.
fn heading(view: &OutputView) -> String {
    if view.of_a_family { format!("{}: {}", view.title, own_name(view)) } else { view.title.clone() }
}

/// The name of an output beside others of its family: its own part of the id.
fn own_name(view: &OutputView) -> String {
    let own = view.id.rsplit_once('.').map_or("", |(_, own)| own).replace('-', " ");
    let mut letters = own.chars();
    match letters.next().filter(|_| view.of_a_family) {
        Some(first) => first.to_uppercase().chain(letters).collect(),
        None => view.title.clone(),
    }
}

fn state(status: &StatusInfo) -> String {
    format!(r#"<span class="state {0}">{0}</span>"#, status.status.as_str())
}

/// `2026-11-22T10:00:00.123456Z` as `2026-11-22 10:00:00 UTC`.
fn moment(text: &str) -> String {
    let seconds = text.split('.').next().unwrap_or_default().trim_end_matches('Z');
    format!("<time datetime=\"{}\">{} UTC</time>", esc(text), esc(&seconds.replace('T', " ")))
}

fn size(bytes: u64) -> String {
    match bytes {
        0..10_000 => format!("{bytes} B"),
        10_000..10_000_000 => format!("{} kB", bytes / 1000),
        _ => format!("{} MB", bytes / 1_000_000),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_with_nothing_on_them_are_named_and_not_drawn() {
        let map = |id: &str, blank| OutputView {
            id: id.into(),
            order: 0,
            of_a_family: true,
            title: "Cover of a plant".into(),
            text: String::new(),
            href: format!("/jobs/1/results/{id}"),
            size: 10,
            blank,
            kind: Kind::Map,
            artefact: None,
        };
        let (oak, fern, moss) =
            (map("plants.cover.quercus-ilex", false), map("plants.cover.fern", true), map("plants.cover.moss", true));
        let page = family(&[&fern, &oak, &moss]);
        assert_eq!(page.matches("<img").count(), 1);
        assert!(page.contains("<b>Quercus ilex</b>"), "{page}");
        assert!(
            page.contains("Nothing anywhere: <a href=\"/jobs/1/results/plants.cover.fern\">Fern</a>, <a"),
            "{page}"
        );
        let none = family(&[&fern]);
        assert!(none.contains("<h2>Cover of a plant</h2>") && !none.contains("<img"), "{none}");
        assert_eq!(heading(&oak), "Cover of a plant: Quercus ilex");
    }
}
