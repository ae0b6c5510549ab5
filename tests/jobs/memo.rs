use std::path::Path;
use std::sync::Arc;

use biotope::compute::run::Run;
use biotope::jobs::Hasher;
use biotope::jobs::JobContext;
use biotope::jobs::Stage;
use biotope::jobs::local::FileRequest;
use biotope::jobs::local::LocalRun;
use biotope::jobs::progress::Live;
use biotope::jobs::selection::Selection;
use biotope::jobs::sources::ByValueOnly;
use biotope::storage::BlockingStore;
use biotope::storage::Store;
use bytes::Bytes;
use serde_json::json;

use crate::jobs::ecosystem_inputs::inputs;

/// Bytes of stages, some more than may wait for the disk.
const SIZES: [usize; 3] = [1 << 20, 70 << 20, 0];

/// What a context of its own, in a process of its own, does.
fn in_context<T>(folder: &Path, work: impl FnOnce(&JobContext<'_>) -> T) -> T {
    let runtime = tokio::runtime::Runtime::new().unwrap();
    let store = BlockingStore::new(Store::in_folder(folder).unwrap(), runtime.handle().clone());
    let selection = Selection::new(&[], None).unwrap();
    let context = JobContext::new(Run::silent(), 0, selection, &store, &ByValueOnly);
    let done = work(&context);
    context.finish().unwrap();
    done
}

#[test]
fn a_stage_is_remembered_for_the_same_inputs_also_after_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let inputs = |text: &str| Hasher::new().part("terrain", text.as_bytes()).finish();
    let stage = Stage { name: "slope", version: 1, inputs: inputs("a") };
    let others =
        [Stage { inputs: inputs("b"), ..stage }, Stage { version: 2, ..stage }, Stage { name: "aspect", ..stage }];
    in_context(folder.path(), |context| {
        assert_eq!(context.recall(stage).unwrap(), None);
        context.remember(stage, Bytes::from("first")).unwrap();
    });
    in_context(folder.path(), |context| {
        assert_eq!(context.recall(stage).unwrap(), Some(Bytes::from("first")));
        assert!(others.iter().all(|other| context.recall(*other).unwrap().is_none()));
        for (other, size) in others.iter().zip(SIZES) {
            context.remember(*other, Bytes::from(vec![1; size])).unwrap();
        }
    });
    in_context(folder.path(), |context| {
        let found = others.map(|other| context.recall(other).unwrap().map(|bytes| bytes.len()));
        assert_eq!(found, SIZES.map(Some));
    });
}

/// Every file below `folder`.
fn files(folder: &Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut all: Vec<_> = entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect();
    all.sort();
    all
}

#[test]
fn stored_stages_give_the_same_bytes_and_those_that_cannot_be_read_are_made_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("request.json"), json!({ "inputs": inputs() }).to_string()).unwrap();
    let runtime = tokio::runtime::Runtime::new().unwrap();
    let run = |name: &str| {
        let (out, keep) = (path(name), path("keep"));
        let place = LocalRun { out: &out, keep: Some(&keep), threads: 2 };
        let request = FileRequest::open(&path("request.json")).unwrap();
        request.run("ecosystem", &place, &Arc::new(Live::new(1)), runtime.handle().clone()).unwrap();
        files(&out).iter().map(|file| std::fs::read(file).unwrap()).collect::<Vec<_>>()
    };
    let first = run("first");
    assert!(run("stored") == first, "read from what was stored");
    let stages: Vec<_> =
        files(&path("keep")).into_iter().filter(|file| file.to_string_lossy().contains("stages")).collect();
    assert!(stages.len() >= 8, "{stages:?}");
    stages.iter().enumerate().for_each(|(i, file)| std::fs::write(file, vec![7; i * 10]).unwrap());
    assert!(run("torn") == first, "made again");
    assert!(stages.iter().enumerate().all(|(i, file)| std::fs::read(file).unwrap() != vec![7; i * 10]));
}
