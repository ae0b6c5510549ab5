//! The entrance, the processes, the problems.

use biotope_api::error::ErrorCode;
use biotope_api::error::Problem;
use biotope_api::process::InputDescription;
use biotope_api::process::Landing;
use biotope_api::process::OutputDescription;
use biotope_api::process::ProcessDescription;
use biotope_api::process::ProcessList;
use biotope_api::process::ProcessSummary;
use biotope_api::warning::WarningCode;

use crate::http::pages::esc;
use crate::http::pages::layout;

/// The entrance.
pub fn landing(landing: &Landing) -> String {
    let link = |(href, name, text): (&str, &str, &str)| {
        format!(r#"<tr><th><a href="{href}">{name}</a></th><td>{text}</td></tr>"#)
    };
    let rows: String = [
        ("/processes", "Processes", "What can be done: inputs and outputs of each."),
        ("/jobs", "Jobs", "What is being done and was done, with maps and tables."),
        ("/docs/", "API", "Every address, to read and to try."),
        ("/problems", "Problems and warnings", "What each code means."),
        ("/openapi.yaml", "openapi.yaml", "The API for programs."),
        ("/health", "Health", "Whether the service is well."),
    ]
    .into_iter()
    .map(link)
    .collect();
    let body = format!(
        r#"<p>{}</p><div class="scroll"><table><tbody>{rows}</tbody></table></div>"#,
        esc(&landing.description)
    );
    layout(&landing.title, &[], &body)
}

/// The list of processes.
pub fn processes(list: &ProcessList) -> String {
    let row = |process: &ProcessSummary| {
        format!(
            r#"<tr><th><a href="/processes/{id}">{title}</a><br><code class="soft">{id}</code></th><td>{text}</td></tr>"#,
            id = esc(&process.id),
            title = esc(&process.title),
            text = esc(&process.description)
        )
    };
    let rows: String = list.processes.iter().map(row).collect();
    layout("Processes", &[], &format!(r#"<div class="scroll"><table><tbody>{rows}</tbody></table></div>"#))
}

/// One process.
pub fn process(process: &ProcessDescription) -> String {
    let inputs: String = process.inputs.iter().map(input_row).collect();
    let outputs: String = process.outputs.iter().map(output_row).collect();
    let ProcessSummary { id, title, description, version, .. } = &process.summary;
    let body = format!(
        r#"<p>{description}</p>
<p class="soft"><code>{id}</code> · version {version} · run it with <code>POST /processes/{id}/execution</code></p>
<h2>Inputs</h2>
<div class="scroll"><table><thead><tr><th>Id</th><th>What it is</th><th>Form</th></tr></thead><tbody>{inputs}</tbody></table></div>
<h2>Outputs</h2>
<div class="scroll"><table><thead><tr><th>Id</th><th>What it is</th><th>Unit</th><th>Media types</th></tr></thead><tbody>{outputs}</tbody></table></div>
"#,
        description = esc(description),
        id = esc(id),
        version = esc(version),
    );
    layout(title, &[("Processes", "/processes")], &body)
}

fn input_row((id, input): (&String, &InputDescription)) -> String {
    let schema = serde_json::to_string_pretty(&input.schema).unwrap_or_default();
    let needed = if input.min_occurs > 0 { "required" } else { "optional" };
    format!(
        r#"<tr><th><code>{}</code><br><small class="soft">{needed}</small></th><td>{}</td><td><details><summary>schema</summary><pre>{}</pre></details></td></tr>"#,
        esc(id),
        paragraphs(&input.description),
        esc(&schema)
    )
}

fn output_row((id, output): (&String, &OutputDescription)) -> String {
    let kept = if output.default { "" } else { r#"<br><small class="soft">on request</small>"# };
    format!(
        "<tr><th><code>{}</code>{kept}</th><td>{}. {}</td><td>{}</td><td>{}</td></tr>",
        esc(id),
        esc(&output.title),
        esc(&output.description),
        esc(output.unit.as_deref().unwrap_or("")),
        esc(&output.media_types.join(", "))
    )
}

fn paragraphs(text: &str) -> String {
    text.split("\n\n").map(|part| format!("<p>{}</p>", esc(part))).collect()
}

/// A problem, for people.
pub fn problem(problem: &Problem) -> String {
    let faults: String = problem.errors.iter().map(fault).collect();
    let faults = if faults.is_empty() { faults } else { format!(r#"<ul class="notes faults">{faults}</ul>"#) };
    let body = format!(
        r#"<p>{}</p>{faults}<p class="soft">{} · <a href="/problems#{code}"><code>{code}</code></a></p>"#,
        esc(&problem.detail),
        problem.status,
        code = esc(&problem.code)
    );
    layout(&problem.title, &[], &body)
}

fn fault(fault: &biotope_api::error::FieldError) -> String {
    format!(
        "<li><code>{}</code> expected {}, found {} <code>{}</code></li>",
        esc(&fault.pointer),
        esc(&fault.expected),
        esc(&fault.found),
        esc(&fault.code)
    )
}

/// Every code, with its meaning.
pub fn problems() -> String {
    let errors: String = ErrorCode::ALL
        .iter()
        .map(|code| {
            format!(
                r#"<tr id="{0}"><th><code>{0}</code></th><td class="number">{1}</td><td>{2}</td></tr>"#,
                code,
                code.status(),
                esc(code.meaning())
            )
        })
        .collect();
    let warnings: String = WarningCode::ALL
        .iter()
        .map(|code| format!(r#"<tr id="{0}"><th><code>{0}</code></th><td>{1}</td></tr>"#, code, esc(code.meaning())))
        .collect();
    let body = format!(
        r#"<p>A problem ends a request or a job; a warning comes with a result. The codes stay.</p>
<h2>Problems</h2><div class="scroll"><table><thead><tr><th>Code</th><th>Status</th><th>Meaning</th></tr></thead><tbody>{errors}</tbody></table></div>
<h2>Warnings</h2><div class="scroll"><table><thead><tr><th>Code</th><th>Meaning</th></tr></thead><tbody>{warnings}</tbody></table></div>"#
    );
    layout("Problems and warnings", &[], &body)
}
