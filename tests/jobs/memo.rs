use std::cell::Cell;
use std::path::Path;

use biotope::compute::run::Run;
use biotope::jobs::Failure;
use biotope::jobs::Hasher;
use biotope::jobs::JobContext;
use biotope::jobs::Stage;
use biotope::jobs::selection::Selection;
use biotope::jobs::sources::ByValueOnly;
use biotope::storage::BlockingStore;
use biotope::storage::Store;
use bytes::Bytes;

/// Runs a stage in a context of its own; its result and how often work was done.
fn run(folder: &Path, stage: Stage, result: Result<&'static str, Failure>) -> (Result<Bytes, Failure>, u32) {
    let runtime = tokio::runtime::Runtime::new().unwrap();
    let store = BlockingStore::new(Store::in_folder(folder).unwrap(), runtime.handle().clone());
    let selection = Selection::new(&[], None).unwrap();
    let context = JobContext::new(Run::silent(), 0, selection, &store, &ByValueOnly);
    let count = Cell::new(0);
    let bytes = context.memo(stage, || {
        count.set(count.get() + 1);
        result.map(Bytes::from)
    });
    context.finish().unwrap();
    (bytes, count.get())
}

#[test]
fn a_stage_runs_once_for_the_same_inputs_also_after_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let inputs = |text: &str| Hasher::new().part("terrain", text.as_bytes()).finish();
    let stage = Stage { name: "slope", version: 1, inputs: inputs("a") };
    let (failed, _) = run(folder.path(), stage, Err(Failure::Stopped));
    assert!(matches!(failed, Err(Failure::Stopped)), "a stage that was stopped is not remembered");
    for (stage, result, expected, runs) in [
        (stage, "first", "first", 1),
        (stage, "again", "first", 0),
        (Stage { inputs: inputs("b"), ..stage }, "other inputs", "other inputs", 1),
        (Stage { version: 2, ..stage }, "other version", "other version", 1),
        (Stage { name: "aspect", ..stage }, "other stage", "other stage", 1),
        (stage, "again", "first", 0),
    ] {
        let (bytes, count) = run(folder.path(), stage, Ok(result));
        assert_eq!((bytes.unwrap(), count), (Bytes::from(expected), runs));
    }
}
