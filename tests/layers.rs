//! The import table, enforced: which room may name which, and which outside names a room may
//! not use. The two tables below *are* the architecture; a row is changed before an import is.

use std::fs;
use std::path::Path;
use std::path::PathBuf;

/// Room → our rooms that it may name as `crate::<room>` (deeper paths bind before shorter ones).
const MAY_NAME: &[(&str, &[&str])] = &[
    ("compute/run", &["compute::run"]),
    ("compute/random", &["compute::random", "compute::run"]),
    ("compute/geometry", &["compute::geometry", "compute::random", "compute::run"]),
    ("compute/raster", &["compute::raster", "compute::geometry", "compute::random", "compute::run"]),
    ("compute/graph", &["compute::graph", "compute::raster", "compute::geometry", "compute::random", "compute::run"]),
    ("compute/pcf", &["compute::pcf", FIVE[0], FIVE[1], FIVE[2], FIVE[3], FIVE[4]]),
    ("compute/herds", &["compute::herds", "compute::pcf", FIVE[0], FIVE[1], FIVE[2], FIVE[3], FIVE[4]]),
    ("compute/ecosystem", &["compute::ecosystem", "compute::pcf", FIVE[0], FIVE[1], FIVE[2], FIVE[3], FIVE[4]]),
    ("compute", &["compute"]),
    ("codec", &["codec", "compute"]),
    ("storage", &["storage"]),
    ("jobs", &["jobs", "codec", "storage", "compute"]),
    ("app", &["app", "config", "jobs", "storage"]),
    ("config", &["config", "storage", "jobs"]),
    ("http", &["http", "app", "jobs"]),
    ("cli", &["cli", "app", "http", "jobs", "config"]),
];

const FIVE: [&str; 5] = ["compute::run", "compute::random", "compute::geometry", "compute::raster", "compute::graph"];

/// Room → outside names that must not appear in its code.
const MUST_NOT_NAME: &[(&str, &[&str])] = &[
    (
        "compute",
        &[
            "std::fs",
            "std::env",
            "std::net",
            "std::time",
            "std::process",
            "tokio",
            "axum",
            "serde",
            "image::",
            "tracing",
            "biotope_api",
            "sqlx",
            "object_store",
        ],
    ),
    ("codec", &["tokio", "axum", "sqlx", "object_store", "biotope_api", "std::net"]),
    ("storage", &["axum", "image::", "biotope_api", "rayon"]),
    ("jobs", &["axum"]),
    ("http", &["rayon", "sqlx", "object_store", "image::"]),
    ("cli", &["axum", "sqlx", "object_store", "image::", "rayon"]),
];

fn source_root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// Every source file as (path below `src` without the ending, text).
fn sources() -> Vec<(String, String)> {
    let (root, mut folders, mut found) = (source_root(), vec![source_root()], Vec::new());
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).expect("the source tree is readable") {
            let path = entry.expect("a readable entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let name = path.strip_prefix(&root).expect("below src").with_extension("");
                found.push((name.to_string_lossy().replace('\\', "/"), fs::read_to_string(&path).expect("UTF-8")));
            }
        }
    }
    found.sort();
    found
}

/// Whether `name` is the room itself or lies in it.
fn lies_in(name: &str, room: &str) -> bool {
    name == room || name.strip_prefix(room).is_some_and(|rest| rest.starts_with('/'))
}

/// Whether the path `used` (after `crate::`) lies in `allowed`.
fn reaches(used: &str, allowed: &str) -> bool {
    used.strip_prefix(allowed).is_some_and(|rest| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_'))
}

/// The code of a file, line by line, without comments.
fn code(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.lines().enumerate().map(|(i, line)| (i + 1, line.split("//").next().unwrap_or("")))
}

fn row<'a, T>(table: &'a [(&str, T)], name: &str) -> Option<&'a T> {
    table.iter().find(|(room, _)| lies_in(name, room)).map(|(_, value)| value)
}

/// What is wrong with the imports of one file, as `file:line: sentence`.
fn complaints(name: &str, text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut complain = |line: usize, what: String| found.push(format!("src/{name}.rs:{line}: {what}"));
    for (line, code) in code(text) {
        if code.contains("super::super::") {
            complain(line, "`super::super::` hides where a name comes from; write the full path".into());
        }
        for used in code.split("crate::").skip(1).filter(|_| !code.contains("$crate")) {
            if used.starts_with('{') || used.starts_with('*') {
                complain(line, "write one full path a line instead of a group".into());
            }
            if let Some(allowed) = row(MAY_NAME, name)
                && !allowed.iter().any(|room| reaches(used, room))
                && !used.starts_with('{')
            {
                complain(line, format!("this room may not name crate::{used}"));
            }
        }
        for outside in row(MUST_NOT_NAME, name).into_iter().flat_map(|names| names.iter()) {
            let named = code.match_indices(outside).any(|(at, _)| {
                !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':' || c == '"')
                    && !code[at + outside.len()..].starts_with(|c: char| c.is_alphanumeric() || c == '_')
            });
            if named {
                complain(line, format!("this room may not name {outside}"));
            }
        }
    }
    found
}

#[test]
fn every_room_names_only_what_the_table_allows() {
    let all: Vec<String> = sources().iter().flat_map(|(name, text)| complaints(name, text)).collect();
    assert!(all.is_empty(), "{}", all.join("\n"));
}

#[test]
fn every_room_stands_in_the_table() {
    let loose: Vec<String> = sources()
        .into_iter()
        .map(|(name, _)| name)
        .filter(|name| !["main", "lib"].contains(&name.as_str()) && row(MAY_NAME, name).is_none())
        .collect();
    assert!(loose.is_empty(), "no row for {loose:?}");
}

#[test]
fn a_wall_that_is_broken_is_reported_with_file_and_line() {
    let bad = "use crate::http::router;\nuse std::fs;\nlet x = super::super::y();\n";
    assert_eq!(complaints("compute/pcf/mod", bad).len(), 3);
    assert!(complaints("compute/pcf/mod", bad)[0].starts_with("src/compute/pcf/mod.rs:1:"));
    assert_eq!(complaints("compute/geometry/point", "use crate::compute::graph::Tree;").len(), 1);
    assert_eq!(complaints("jobs/echo", "use crate::codec::map::Map;"), Vec::<String>::new());
}

#[test]
fn the_wire_crate_depends_on_nothing_of_ours() {
    let manifest = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("api/Cargo.toml")).expect("manifest");
    let table = manifest.split("[dependencies]").nth(1).expect("a dependency table");
    for line in table.lines().take_while(|l| !l.starts_with('[')).filter(|l| l.contains('=')) {
        let name = line.split('=').next().unwrap_or("").trim();
        assert!(["serde", "serde_json", "schemars"].contains(&name), "{name}");
    }
}

#[test]
fn every_file_of_tests_is_named_by_its_module() {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    for folder in ["http", "jobs", "science"] {
        let listed = fs::read_to_string(tests.join(folder).join("mod.rs")).expect("a mod.rs");
        for entry in fs::read_dir(tests.join(folder)).expect("a folder") {
            let path = entry.expect("a readable entry").path();
            let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
            let is_module = path.extension().is_some_and(|e| e == "rs") && name != "mod";
            assert!(!is_module || listed.contains(&format!("mod {name};")), "{folder}/{name}.rs is never run");
        }
    }
}
