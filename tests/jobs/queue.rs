use biotope::jobs::queue::Added;
use biotope::jobs::queue::Filter;
use biotope::jobs::queue::Lane;
use biotope::jobs::queue::NewRow;
use biotope::jobs::queue::Outcome;
use biotope::jobs::queue::Queue;
use biotope::jobs::queue::Row;
use biotope::jobs::queue::STARTS_LIMIT;
use biotope::jobs::queue::SqliteQueue;
use biotope_api::error::ErrorCode;
use biotope_api::error::Problem;
use biotope_api::job::JobState;

fn new_row(task: &str, key: Option<&str>) -> NewRow {
    let key = key.map(str::to_owned);
    NewRow { process: "echo".into(), task: task.into(), key, lane: Lane::Quick, memory_bytes: 10 }
}

async fn added(queue: &SqliteQueue, task: &str) -> Row {
    match queue.add(new_row(task, None), 1000).await.unwrap() {
        Added::New(row) => row,
        other => panic!("{other:?}"),
    }
}

async fn claimed(queue: &SqliteQueue) -> Option<Row> {
    queue.claim(Lane::Quick, 100, "here").await.unwrap()
}

fn done() -> Outcome {
    Outcome::Success { outputs: Default::default(), warnings: Vec::new() }
}

fn failed() -> Outcome {
    Outcome::Failure(Problem::new(ErrorCode::CrashedRepeatedly, "again and again"))
}

#[tokio::test]
async fn rows_are_claimed_once_and_the_oldest_first() {
    let queue = SqliteQueue::in_memory().await.unwrap();
    let (one, two) = (added(&queue, "one").await, added(&queue, "two").await);
    assert!(queue.claim(Lane::Heavy, 100, "here").await.unwrap().is_none(), "another lane");
    assert!(queue.claim(Lane::Quick, 9, "here").await.unwrap().is_none(), "too little memory");
    assert_eq!(claimed(&queue).await.map(|row| row.id), Some(one.id));
    assert_eq!(claimed(&queue).await.map(|row| row.id), Some(two.id));
    assert!(claimed(&queue).await.is_none());
    assert_eq!(queue.counts().await.unwrap().running, 2);
}

#[tokio::test]
async fn a_worker_that_lost_its_row_can_change_nothing() {
    let queue = SqliteQueue::in_memory().await.unwrap();
    added(&queue, "one").await;
    let old = claimed(&queue).await.unwrap();
    queue.recover(&failed()).await.unwrap();
    let new = claimed(&queue).await.unwrap();
    assert_eq!((old.id, old.fence + 1), (new.id, new.fence));
    assert!(!queue.progress(old.id, old.fence, 50, "late").await.unwrap());
    assert!(!queue.finish(old.id, old.fence, &done()).await.unwrap());
    assert!(!queue.release(old.id, old.fence).await.unwrap());
    assert!(queue.finish(new.id, new.fence, &done()).await.unwrap());
    assert!(!queue.finish(new.id, new.fence, &failed()).await.unwrap(), "an end is an end");
    assert_eq!(queue.get(new.id).await.unwrap().unwrap().outcome, Some(done()));
}

#[tokio::test]
async fn a_dismissed_row_stays_dismissed_whatever_its_worker_says() {
    let queue = SqliteQueue::in_memory().await.unwrap();
    added(&queue, "one").await;
    let row = claimed(&queue).await.unwrap();
    let before = queue.dismiss(row.id).await.unwrap().unwrap();
    assert_eq!(before.state, JobState::Running);
    assert!(!queue.finish(row.id, row.fence, &done()).await.unwrap());
    assert!(!queue.release(row.id, row.fence).await.unwrap());
    let after = queue.get(row.id).await.unwrap().unwrap();
    assert_eq!((after.state, after.outcome), (JobState::Dismissed, None));
    queue.recover(&failed()).await.unwrap();
    assert!(claimed(&queue).await.is_none());
}

#[tokio::test]
async fn a_row_that_brings_the_service_down_again_and_again_is_given_up() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("jobs.sqlite");
    let id = added(&SqliteQueue::open(&file).await.unwrap(), "poison").await.id;
    for start in 1..=STARTS_LIMIT {
        let queue = SqliteQueue::open(&file).await.unwrap();
        queue.recover(&failed()).await.unwrap();
        assert_eq!(claimed(&queue).await.map(|row| row.starts), Some(start));
    }
    let queue = SqliteQueue::open(&file).await.unwrap();
    assert_eq!(queue.recover(&failed()).await.unwrap(), (0, 1));
    let row = queue.get(id).await.unwrap().unwrap();
    assert_eq!((row.state, row.outcome), (JobState::Failed, Some(failed())));
}

#[tokio::test]
async fn a_row_that_was_given_back_has_not_started() {
    let queue = SqliteQueue::in_memory().await.unwrap();
    added(&queue, "one").await;
    for _ in 0..STARTS_LIMIT + 2 {
        let row = claimed(&queue).await.unwrap();
        assert_eq!(row.starts, 1);
        assert!(queue.release(row.id, row.fence).await.unwrap());
    }
}

#[tokio::test]
async fn a_key_is_good_for_one_request() {
    let queue = SqliteQueue::in_memory().await.unwrap();
    let add = async |task, limit| queue.add(new_row(task, Some("key")), limit).await.unwrap();
    let Added::New(row) = add("task", 1).await else { panic!() };
    assert_eq!(add("task", 1).await, Added::Replayed(row.clone()), "even when the queue is full");
    assert_eq!(add("other", 100).await, Added::KeyReused);
    assert_eq!(queue.by_key("key").await.unwrap(), Some(row));
    assert_eq!(queue.add(new_row("new", None), 1).await.unwrap(), Added::Full);
}

#[tokio::test]
async fn two_workers_claim_each_row_exactly_once() {
    let folder = tempfile::tempdir().unwrap();
    let queue = SqliteQueue::open(&folder.path().join("jobs.sqlite")).await.unwrap();
    for task in 0..200 {
        added(&queue, &task.to_string()).await;
    }
    let work = |queue: SqliteQueue| async move {
        let mut mine = Vec::new();
        while let Some(row) = claimed(&queue).await {
            assert!(queue.finish(row.id, row.fence, &done()).await.unwrap());
            mine.push(row.id);
        }
        mine
    };
    let (one, two) = tokio::join!(tokio::spawn(work(queue.clone())), tokio::spawn(work(queue.clone())));
    let mut all = [one.unwrap(), two.unwrap()].concat();
    all.sort();
    all.dedup();
    assert_eq!(all.len(), 200);
    let rows = queue.list(Filter { limit: 1000, ..Filter::default() }).await.unwrap();
    assert!(rows.iter().all(|row| row.state == JobState::Successful && row.starts == 1));
}
