//! Same request, seed and version: the same bytes, on any number of threads.

use std::collections::BTreeMap;
use std::path::Path;
use std::path::PathBuf;
use std::sync::Arc;

use biotope::jobs::local::Bench;
use biotope::jobs::local::FileRequest;
use biotope::jobs::progress::Live;
use biotope::jobs::registry::Registry;
use biotope::storage::BlockingStore;
use biotope::storage::Store;

/// Every worked example as (process, file).
pub fn examples() -> Vec<(String, PathBuf)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("api/examples");
    let files = std::fs::read_dir(folder).expect("the examples").map(|entry| entry.expect("a file").path());
    let mut found: Vec<_> = files.filter(|path| path.extension().is_some_and(|e| e == "json")).map(named).collect();
    found.sort();
    found
}

/// An example is named by its process, or by its process and a word that tells it from others.
fn named(path: PathBuf) -> (String, PathBuf) {
    let stem = path.file_stem().expect("a name").to_string_lossy().into_owned();
    let registry = Registry::standard().expect("schemas");
    let entry = registry.named_by(&stem).unwrap_or_else(|| panic!("{stem} names no process"));
    (entry.description.id.to_owned(), path)
}

/// Digest of every output of a request solved on so many threads.
fn digests(process: &str, file: &Path, threads: usize) -> BTreeMap<String, String> {
    let runtime = tokio::runtime::Runtime::new().expect("a runtime");
    let store = BlockingStore::new(Store::in_memory(), runtime.handle().clone());
    let registry = Registry::standard().expect("schemas");
    let request = FileRequest::open(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let bench = Bench { registry: &registry, store: &store, threads };
    let kept = request.solve(process, &bench, &Arc::new(Live::new(1)));
    let kept = kept.unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    kept.outputs.into_iter().map(|(id, stored)| (id, stored.digest)).collect()
}

#[test]
fn every_example_gives_the_same_bytes_on_one_and_on_two_threads() {
    // One whole ecosystem is enough: the others differ in their numbers only.
    let mut all = examples();
    all.dedup_by(|(process, _), (before, _)| process == before && process == "ecosystem");
    for (process, file) in all {
        let (one, two) = (digests(&process, &file, 1), digests(&process, &file, 2));
        assert!(one.contains_key("manifest"), "{}", file.display());
        for (id, digest) in &one {
            assert_eq!(Some(digest), two.get(id), "{id} of {}", file.display());
        }
        assert_eq!(one.len(), two.len());
    }
}
