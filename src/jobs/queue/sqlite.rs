//! The table in SQLite: one file, one process.
//!
//! WAL with `synchronous=FULL`: a commit is on the disk when it returns. Whoever opens the file
//! holds the folder, so rows that run when it is opened belong to a process that is gone.

use std::collections::BTreeSet;
use std::path::Path;
use std::time::Duration;

use biotope_api::job::JobState;
use futures_util::TryStreamExt as _;
use sqlx::QueryBuilder;
use sqlx::Row as _;
use sqlx::Sqlite;
use sqlx::SqlitePool;
use sqlx::sqlite::SqliteConnectOptions;
use sqlx::sqlite::SqliteJournalMode;
use sqlx::sqlite::SqlitePoolOptions;
use sqlx::sqlite::SqliteRow;
use sqlx::sqlite::SqliteSynchronous;
use time::OffsetDateTime;

use crate::jobs::queue::Added;
use crate::jobs::queue::Answer;
use crate::jobs::queue::AssetRow;
use crate::jobs::queue::Counts;
use crate::jobs::queue::Filter;
use crate::jobs::queue::JobId;
use crate::jobs::queue::Keep;
use crate::jobs::queue::Lane;
use crate::jobs::queue::NewRow;
use crate::jobs::queue::Outcome;
use crate::jobs::queue::Queue;
use crate::jobs::queue::QueueError;
use crate::jobs::queue::Row;
use crate::jobs::queue::STARTS_LIMIT;

/// The tables, made when the file is opened. Times are microseconds since 1970 in UTC.
const SCHEMA: &str = "
CREATE TABLE IF NOT EXISTS jobs (
    id              TEXT PRIMARY KEY,       -- UUID version 7: sorts by age
    process         TEXT NOT NULL,
    task            TEXT NOT NULL,          -- digest of the stored request
    idempotency_key TEXT UNIQUE,
    lane            TEXT NOT NULL,          -- quick or heavy
    memory_bytes    INTEGER NOT NULL,
    status          TEXT NOT NULL,
    progress        INTEGER NOT NULL DEFAULT 0,
    message         TEXT NOT NULL DEFAULT '',
    created         INTEGER NOT NULL,
    started         INTEGER,
    finished        INTEGER,
    updated         INTEGER NOT NULL,
    lease_owner     TEXT,                   -- the process that runs it
    attempt         INTEGER NOT NULL DEFAULT 0, -- the fence: counts up at every claim
    starts          INTEGER NOT NULL DEFAULT 0, -- claims that were not given back
    outcome         TEXT                    -- outputs and warnings, or the problem
) STRICT;
CREATE INDEX IF NOT EXISTS jobs_waiting ON jobs (lane, id) WHERE status = 'accepted';
CREATE INDEX IF NOT EXISTS jobs_by_process ON jobs (process, id);
CREATE INDEX IF NOT EXISTS jobs_by_status ON jobs (status, id);
CREATE TABLE IF NOT EXISTS assets (
    digest     TEXT PRIMARY KEY,
    media_type TEXT NOT NULL,
    size       INTEGER NOT NULL,
    created    INTEGER NOT NULL             -- when it was last uploaded or used
) STRICT;
";

/// How stale the time of an upload's last use may be, in microseconds.
const USED_PACE: i64 = 60_000_000;

/// The table of jobs in a SQLite file.
#[derive(Debug, Clone)]
pub struct SqliteQueue {
    pool: SqlitePool,
}

impl SqliteQueue {
    /// Opens `file`, which is made when absent.
    ///
    /// # Errors
    /// When the file cannot be used.
    pub async fn open(file: &Path) -> Result<Self, QueueError> {
        let options = SqliteConnectOptions::new()
            .filename(file)
            .create_if_missing(true)
            .journal_mode(SqliteJournalMode::Wal)
            .synchronous(SqliteSynchronous::Full)
            .busy_timeout(Duration::from_secs(10));
        Self::connect(SqlitePoolOptions::new().max_connections(4), options).await
    }

    /// A table in memory: for tests.
    ///
    /// # Errors
    /// As [`SqliteQueue::open`].
    pub async fn in_memory() -> Result<Self, QueueError> {
        let lasting = SqlitePoolOptions::new().max_connections(1).idle_timeout(None).max_lifetime(None);
        Self::connect(lasting, SqliteConnectOptions::new().in_memory(true)).await
    }

    async fn connect(pool: SqlitePoolOptions, options: SqliteConnectOptions) -> Result<Self, QueueError> {
        let pool = pool.connect_with(options).await?;
        sqlx::raw_sql(SCHEMA).execute(&pool).await?;
        Ok(Self { pool })
    }

    async fn add_row(&self, new: NewRow, limit: u64) -> Result<Added, QueueError> {
        let mut tx = self.pool.begin_with("BEGIN IMMEDIATE").await?;
        if let Some(key) = &new.key {
            let known = sqlx::query("SELECT * FROM jobs WHERE idempotency_key = ?").bind(key);
            if let Some(row) = known.fetch_optional(&mut *tx).await? {
                let row = read(&row)?;
                let same = row.task == new.task && row.process == new.process;
                return Ok(if same { Added::Replayed(row) } else { Added::KeyReused });
            }
        }
        let waiting = sqlx::query("SELECT count(*) FROM jobs WHERE status = 'accepted'");
        let waiting: i64 = waiting.fetch_one(&mut *tx).await?.try_get(0)?;
        if waiting.unsigned_abs() >= limit {
            return Ok(Added::Full);
        }
        let insert =
            "INSERT INTO jobs (id, process, task, idempotency_key, lane, memory_bytes, status, created, updated)
            VALUES (?1, ?2, ?3, ?4, ?5, ?6, 'accepted', ?7, ?7) RETURNING *";
        let row = sqlx::query(insert)
            .bind(JobId::new().to_string())
            .bind(new.process)
            .bind(new.task)
            .bind(new.key)
            .bind(new.lane.name())
            .bind(new.memory_bytes.cast_signed())
            .bind(now())
            .fetch_one(&mut *tx)
            .await?;
        let row = read(&row)?;
        tx.commit().await?;
        Ok(Added::New(row))
    }

    async fn list_rows(&self, filter: Filter) -> Result<Vec<Row>, QueueError> {
        let mut query = QueryBuilder::<Sqlite>::new("SELECT * FROM jobs WHERE true");
        any_of(&mut query, "process", filter.processes);
        any_of(&mut query, "status", filter.states.into_iter().map(|state| state.as_str().to_owned()).collect());
        if let Some(from) = filter.from {
            query.push(" AND created >= ").push_bind(micros(from));
        }
        if let Some(to) = filter.to {
            query.push(" AND created <= ").push_bind(micros(to));
        }
        let duration = " AND started IS NOT NULL AND (coalesce(finished, ";
        if let Some(least) = filter.min_duration_s {
            query.push(duration).push_bind(now()).push(") - started) >= ").push_bind(least * 1e6);
        }
        if let Some(most) = filter.max_duration_s {
            query.push(duration).push_bind(now()).push(") - started) <= ").push_bind(most * 1e6);
        }
        if let Some(before) = filter.before {
            query.push(" AND id < ").push_bind(before.to_string());
        }
        query.push(" ORDER BY id DESC LIMIT ").push_bind(filter.limit);
        let rows = query.build().fetch_all(&self.pool).await?;
        rows.iter().map(read).collect()
    }

    async fn claim_row(&self, lane: Lane, memory_bytes: u64, owner: &str) -> Result<Option<Row>, QueueError> {
        let claim = "UPDATE jobs SET status = 'running', attempt = attempt + 1, starts = starts + 1, lease_owner = ?1,
                started = ?2, updated = ?2, progress = 0, message = ''
            WHERE id = (SELECT id FROM jobs WHERE status = 'accepted' AND lane = ?3 ORDER BY id LIMIT 1)
                AND status = 'accepted' AND memory_bytes <= ?4
            RETURNING *";
        let row = sqlx::query(claim)
            .bind(owner)
            .bind(now())
            .bind(lane.name())
            .bind(memory_bytes.cast_signed())
            .fetch_optional(&self.pool)
            .await?;
        row.as_ref().map(read).transpose()
    }

    async fn finish_row(&self, id: JobId, fence: i64, outcome: &Outcome) -> Result<bool, QueueError> {
        let end = "UPDATE jobs SET status = ?3, outcome = ?4, finished = ?5, updated = ?5, message = '',
                progress = CASE WHEN ?3 = 'successful' THEN 100 ELSE progress END
            WHERE id = ?1 AND attempt = ?2 AND status = 'running'";
        let text = serde_json::to_string(outcome).map_err(|error| corrupt(&id.to_string(), error))?;
        let done = sqlx::query(end)
            .bind(id.to_string())
            .bind(fence)
            .bind(outcome.state().as_str())
            .bind(text)
            .bind(now())
            .execute(&self.pool)
            .await?;
        Ok(done.rows_affected() == 1)
    }

    async fn dismiss_row(&self, id: JobId) -> Result<Option<Row>, QueueError> {
        let mut tx = self.pool.begin_with("BEGIN IMMEDIATE").await?;
        let found =
            sqlx::query("SELECT * FROM jobs WHERE id = ?").bind(id.to_string()).fetch_optional(&mut *tx).await?;
        let before = found.as_ref().map(read).transpose()?;
        let give_up = "UPDATE jobs SET status = 'dismissed', outcome = NULL, message = '', updated = ?2,
                finished = coalesce(finished, ?2)
            WHERE id = ?1 AND status <> 'dismissed'";
        sqlx::query(give_up).bind(id.to_string()).bind(now()).execute(&mut *tx).await?;
        tx.commit().await?;
        Ok(before)
    }

    async fn recover_rows(&self, poisoned: &Outcome) -> Result<(u64, u64), QueueError> {
        let text = serde_json::to_string(poisoned).map_err(|error| corrupt("of every row", error))?;
        let mut tx = self.pool.begin_with("BEGIN IMMEDIATE").await?;
        let fail = "UPDATE jobs SET status = 'failed', outcome = ?1, finished = ?2, updated = ?2
            WHERE status = 'running' AND starts >= ?3";
        let failed = sqlx::query(fail).bind(text).bind(now()).bind(STARTS_LIMIT).execute(&mut *tx).await?;
        let wait = "UPDATE jobs SET status = 'accepted', lease_owner = NULL, progress = 0, message = '', updated = ?1
            WHERE status = 'running'";
        let waiting = sqlx::query(wait).bind(now()).execute(&mut *tx).await?;
        tx.commit().await?;
        Ok((waiting.rows_affected(), failed.rows_affected()))
    }

    async fn forget_rows(&self, keep: Keep) -> Result<u64, QueueError> {
        let since = micros(keep.since);
        let old = sqlx::query("DELETE FROM jobs WHERE finished < ?1 AND status NOT IN ('accepted', 'running')");
        let mut forgotten = old.bind(since).execute(&self.pool).await?.rows_affected();
        let unused = sqlx::query("DELETE FROM assets WHERE created < ?").bind(since);
        forgotten += unused.execute(&self.pool).await?.rows_affected();
        for id in self.beyond(keep.bytes).await? {
            let delete = sqlx::query("DELETE FROM jobs WHERE id = ? AND status = 'successful'").bind(id);
            forgotten += delete.execute(&self.pool).await?.rows_affected();
        }
        Ok(forgotten)
    }

    /// The ids of the rows whose outputs no longer fit into `bytes`, counted from those that
    /// ended last; what several rows share counts once.
    async fn beyond(&self, bytes: u64) -> Result<Vec<String>, QueueError> {
        let successful = "SELECT id, outcome FROM jobs WHERE status = 'successful' ORDER BY finished DESC, id DESC";
        let mut rows = sqlx::query(successful).fetch(&self.pool);
        let (mut counted, mut taken, mut beyond) = (BTreeSet::new(), 0_u64, Vec::new());
        while let Some(row) = rows.try_next().await? {
            let id: String = row.try_get(0)?;
            for (digest, size) in outputs(&id, row.try_get(1)?)? {
                taken += if counted.insert(digest) { size } else { 0 };
            }
            if taken > bytes {
                beyond.push(id);
            }
        }
        Ok(beyond)
    }

    async fn named_digests(&self) -> Result<BTreeSet<String>, QueueError> {
        let mut named = BTreeSet::new();
        let mut rows = sqlx::query("SELECT id, task, outcome FROM jobs WHERE status <> 'dismissed'").fetch(&self.pool);
        while let Some(row) = rows.try_next().await? {
            let id: String = row.try_get(0)?;
            named.insert(row.try_get(1)?);
            named.extend(outputs(&id, row.try_get(2)?)?.into_iter().map(|(digest, _)| digest));
        }
        let mut assets = sqlx::query("SELECT digest FROM assets").fetch(&self.pool);
        while let Some(row) = assets.try_next().await? {
            named.insert(row.try_get(0)?);
        }
        Ok(named)
    }

    async fn count_rows(&self) -> Result<Counts, QueueError> {
        let count = "SELECT coalesce(sum(status = 'accepted'), 0), coalesce(sum(status = 'running'), 0)
            FROM jobs WHERE status IN ('accepted', 'running')";
        let row = sqlx::query(count).fetch_one(&self.pool).await?;
        let at = |i: usize| row.try_get::<i64, _>(i).map(i64::unsigned_abs);
        Ok(Counts { accepted: at(0)?, running: at(1)? })
    }
}

impl Queue for SqliteQueue {
    fn add(&self, row: NewRow, limit: u64) -> Answer<'_, Added> {
        Box::pin(self.add_row(row, limit))
    }

    fn get(&self, id: JobId) -> Answer<'_, Option<Row>> {
        Box::pin(async move {
            let query = sqlx::query("SELECT * FROM jobs WHERE id = ?").bind(id.to_string());
            query.fetch_optional(&self.pool).await?.as_ref().map(read).transpose()
        })
    }

    fn by_key<'a>(&'a self, key: &'a str) -> Answer<'a, Option<Row>> {
        Box::pin(async move {
            let query = sqlx::query("SELECT * FROM jobs WHERE idempotency_key = ?").bind(key);
            query.fetch_optional(&self.pool).await?.as_ref().map(read).transpose()
        })
    }

    fn list(&self, filter: Filter) -> Answer<'_, Vec<Row>> {
        Box::pin(self.list_rows(filter))
    }

    fn claim<'a>(&'a self, lane: Lane, memory_bytes: u64, owner: &'a str) -> Answer<'a, Option<Row>> {
        Box::pin(self.claim_row(lane, memory_bytes, owner))
    }

    fn progress<'a>(&'a self, id: JobId, fence: i64, percent: u8, message: &'a str) -> Answer<'a, bool> {
        Box::pin(async move {
            let write = "UPDATE jobs SET progress = ?3, message = ?4, updated = ?5
                WHERE id = ?1 AND attempt = ?2 AND status = 'running'";
            let query = sqlx::query(write).bind(id.to_string()).bind(fence).bind(percent).bind(message).bind(now());
            Ok(query.execute(&self.pool).await?.rows_affected() == 1)
        })
    }

    fn finish<'a>(&'a self, id: JobId, fence: i64, outcome: &'a Outcome) -> Answer<'a, bool> {
        Box::pin(self.finish_row(id, fence, outcome))
    }

    fn release(&self, id: JobId, fence: i64) -> Answer<'_, bool> {
        Box::pin(async move {
            let write = "UPDATE jobs SET status = 'accepted', starts = starts - 1, lease_owner = NULL, progress = 0,
                    message = '', updated = ?3
                WHERE id = ?1 AND attempt = ?2 AND status = 'running'";
            let query = sqlx::query(write).bind(id.to_string()).bind(fence).bind(now());
            Ok(query.execute(&self.pool).await?.rows_affected() == 1)
        })
    }

    fn dismiss(&self, id: JobId) -> Answer<'_, Option<Row>> {
        Box::pin(self.dismiss_row(id))
    }

    fn recover<'a>(&'a self, poisoned: &'a Outcome) -> Answer<'a, (u64, u64)> {
        Box::pin(self.recover_rows(poisoned))
    }

    fn forget(&self, keep: Keep) -> Answer<'_, u64> {
        Box::pin(self.forget_rows(keep))
    }

    fn named(&self) -> Answer<'_, BTreeSet<String>> {
        Box::pin(self.named_digests())
    }

    fn counts(&self) -> Answer<'_, Counts> {
        Box::pin(self.count_rows())
    }

    fn add_asset(&self, asset: AssetRow) -> Answer<'_, bool> {
        Box::pin(async move {
            let insert = "INSERT INTO assets (digest, media_type, size, created) VALUES (?, ?, ?, ?)
                ON CONFLICT (digest) DO NOTHING";
            let known = sqlx::query("UPDATE assets SET created = ? WHERE digest = ?").bind(now()).bind(&asset.digest);
            if known.execute(&self.pool).await?.rows_affected() == 1 {
                return Ok(false);
            }
            let query = sqlx::query(insert)
                .bind(asset.digest)
                .bind(asset.media_type)
                .bind(asset.size.cast_signed())
                .bind(now());
            Ok(query.execute(&self.pool).await?.rows_affected() == 1)
        })
    }

    fn asset<'a>(&'a self, digest: &'a str) -> Answer<'a, Option<AssetRow>> {
        Box::pin(async move {
            let query = sqlx::query("SELECT digest, media_type, size, created FROM assets WHERE digest = ?");
            let Some(row) = query.bind(digest).fetch_optional(&self.pool).await? else { return Ok(None) };
            let used: i64 = row.try_get(3)?;
            if used < now() - USED_PACE {
                let touch = sqlx::query("UPDATE assets SET created = ? WHERE digest = ?").bind(now()).bind(digest);
                if touch.execute(&self.pool).await?.rows_affected() == 0 {
                    return Ok(None);
                }
            }
            let size = row.try_get::<i64, _>(2)?.unsigned_abs();
            Ok(Some(AssetRow { digest: row.try_get(0)?, media_type: row.try_get(1)?, size }))
        })
    }
}

fn any_of(query: &mut QueryBuilder<Sqlite>, column: &'static str, values: Vec<String>) {
    if values.is_empty() {
        return;
    }
    query.push(" AND ").push(column).push(" IN (");
    let mut list = query.separated(", ");
    for value in values {
        list.push_bind(value);
    }
    query.push(")");
}

fn read(row: &SqliteRow) -> Result<Row, QueueError> {
    let id: String = row.try_get("id")?;
    let state: String = row.try_get("status")?;
    let outcome: Option<String> = row.try_get("outcome")?;
    let moment = |column| row.try_get::<Option<i64>, _>(column).map(|at| at.map(time_of));
    Ok(Row {
        process: row.try_get("process")?,
        task: row.try_get("task")?,
        memory_bytes: row.try_get::<i64, _>("memory_bytes")?.unsigned_abs(),
        state: JobState::from_name(&state).ok_or_else(|| corrupt(&id, state))?,
        percent: row.try_get("progress")?,
        message: row.try_get("message")?,
        created: time_of(row.try_get("created")?),
        started: moment("started")?,
        finished: moment("finished")?,
        updated: time_of(row.try_get("updated")?),
        fence: row.try_get("attempt")?,
        starts: row.try_get("starts")?,
        outcome: outcome.map(|text| serde_json::from_str(&text)).transpose().map_err(|error| corrupt(&id, error))?,
        id: JobId::parse(&id).ok_or_else(|| corrupt(&id, "its id"))?,
    })
}

/// The digests and sizes of the outputs in a column `outcome`.
fn outputs(job: &str, outcome: Option<String>) -> Result<Vec<(String, u64)>, QueueError> {
    let Some(text) = outcome else { return Ok(Vec::new()) };
    Ok(match serde_json::from_str(&text).map_err(|error| corrupt(job, error))? {
        Outcome::Success { outputs, .. } => outputs.into_values().map(|stored| (stored.digest, stored.size)).collect(),
        Outcome::Failure(_) => Vec::new(),
    })
}

fn corrupt(job: &str, what: impl std::fmt::Display) -> QueueError {
    QueueError::Corrupt { job: job.to_owned(), what: what.to_string() }
}

fn now() -> i64 {
    micros(OffsetDateTime::now_utc())
}

fn micros(at: OffsetDateTime) -> i64 {
    i64::try_from(at.unix_timestamp_nanos() / 1000).unwrap_or(i64::MAX)
}

fn time_of(micros: i64) -> OffsetDateTime {
    OffsetDateTime::from_unix_timestamp_nanos(i128::from(micros) * 1000).unwrap_or(OffsetDateTime::UNIX_EPOCH)
}
