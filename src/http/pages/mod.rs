//! Pages for people: the same resources, drawn by the server. Nothing is fetched from elsewhere,
//! and all but the live progress works without scripts.

mod data;
mod jobs;
mod service;

pub use jobs::JobView;
pub use jobs::OutputView;
pub use jobs::SHOWN_LIMIT;
pub use jobs::job;
pub use jobs::jobs;
pub use jobs::output;
pub use service::landing;
pub use service::problem;
pub use service::problems;
pub use service::process;
pub use service::processes;

/// `text` so that it can stand in a page, also within quotes.
fn esc(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;").replace('\'', "&#39;")
}

/// A whole page around `body`, which is HTML already.
fn layout(title: &str, trail: &[(&str, &str)], body: &str) -> String {
    let crumbs: String =
        trail.iter().map(|(name, href)| format!(r#"<li><a href="{}">{}</a></li>"#, esc(href), esc(name))).collect();
    let crumbs = if crumbs.is_empty() {
        crumbs
    } else {
        format!(r#"<ol class="trail" aria-label="You are here">{crumbs}</ol>"#)
    };
    format!(
        r#"<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title} – Biotope</title>
<link rel="icon" href="data:,">
<style>
{style}</style>
</head>
<body>
<header><a class="name" href="/">Biotope</a>
<nav><a href="/processes">Processes</a><a href="/jobs">Jobs</a><a href="/docs/">API</a><a href="/problems">Problems</a></nav></header>
<main>
{crumbs}
<h1>{title}</h1>
{body}</main>
<footer>Biotope {version} · OGC API – Processes</footer>
</body>
</html>
"#,
        title = esc(title),
        style = include_str!("style.css"),
        version = env!("CARGO_PKG_VERSION"),
    )
}
