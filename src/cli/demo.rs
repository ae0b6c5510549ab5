//! `demo`: the service with a finished sample to look at.

use std::path::Path;
use std::path::PathBuf;

use biotope_api::job::JobState;
use bytes::Bytes;
use clap::Args;
use futures_util::stream;

use crate::cli::CliError;
use crate::cli::bar::Bar;
use crate::cli::bar::PACE;
use crate::cli::say;
use crate::cli::serve::Server;
use crate::config::Config;
use crate::jobs::Jobs;
use crate::jobs::local::FileRequest;
use crate::jobs::local::media_type_of;
use crate::jobs::queue::JobId;
use crate::jobs::queue::Row;
use crate::jobs::references::each_href;

/// The sample: a process and its request.
const SAMPLE: (&str, &str) = ("ecosystem", "ecosystem-tautavel-mild.json");

/// Serves the API, runs the sample and shows where its maps are.
#[derive(Debug, Args)]
pub struct Demo {
    #[command(flatten)]
    config: Config,
    /// End when the sample is done instead of staying up.
    #[arg(long)]
    once: bool,
}

impl Demo {
    /// Serves, runs the sample, says where it is, and stays up.
    pub async fn execute(self) -> Result<(), CliError> {
        let file = examples()?.join(SAMPLE.1);
        let server = Server::start(&self.config).await?;
        let id = submit(&server.app.jobs, &file).await?;
        let row = watch(&server.app.jobs, id).await?;
        if row.state != JobState::Successful {
            let reason = server.url();
            return Err(CliError::Failed(format!("the sample is {}: see {reason}/jobs/{id}", row.state.as_str())));
        }
        say(&format!("ready {}/jobs/{id}", server.url()));
        if self.once {
            server.stop().await;
            return Ok(());
        }
        server.run_until_told().await
    }
}

/// The folder of worked examples: here, beside the program, or where it was built.
fn examples() -> Result<PathBuf, CliError> {
    let program = std::env::current_exe().unwrap_or_default();
    let beside = program.parent().unwrap_or(Path::new("")).join("../share/biotope/examples");
    let built = Path::new(env!("CARGO_MANIFEST_DIR")).join("api/examples");
    let places = [PathBuf::from("api/examples"), beside, built];
    places
        .into_iter()
        .find(|place| place.join(SAMPLE.1).is_file())
        .ok_or_else(|| CliError::Failed(format!("the sample {} is not in api/examples", SAMPLE.1)))
}

/// Uploads what the request refers to, and puts it in the queue.
async fn submit(jobs: &Jobs, file: &Path) -> Result<JobId, CliError> {
    let mut request = FileRequest::open(file).map_err(|error| CliError::Failed(error.to_string()))?;
    let mut inputs = serde_json::Value::Object(request.execute.inputs);
    let mut hrefs = Vec::new();
    each_href(&mut inputs, &mut |href| hrefs.push(href.clone()));
    for href in hrefs.into_iter().filter(|href| !href.starts_with("data:")) {
        let asset = upload(jobs, &request.folder.join(&href)).await?;
        each_href(&mut inputs, &mut |other| {
            if *other == href {
                *other = format!("/assets/{asset}");
            }
        });
    }
    request.execute.inputs = inputs.as_object().cloned().unwrap_or_default();
    let submitted = jobs.submit(SAMPLE.0, request.execute, None).await;
    submitted.map(|submitted| submitted.row.id).map_err(|error| CliError::Failed(error.to_string()))
}

async fn upload(jobs: &Jobs, path: &Path) -> Result<String, CliError> {
    let failed = |error: &dyn std::fmt::Display| CliError::Failed(format!("{}: {error}", path.display()));
    let bytes = std::fs::read(path).map_err(|error| failed(&error))?;
    let whole = stream::iter([Ok::<_, std::convert::Infallible>(Bytes::from(bytes))]);
    match jobs.upload(media_type_of(&path.to_string_lossy()).to_owned(), whole).await {
        Ok((asset, _)) => Ok(asset.digest),
        Err(Err(error)) => Err(failed(&error)),
        Err(Ok(never)) => match never {},
    }
}

/// Shows progress until the job has ended.
async fn watch(jobs: &Jobs, id: JobId) -> Result<Row, CliError> {
    let mut bar = Bar::new();
    loop {
        if let Some(live) = jobs.live(id) {
            bar.show(&live);
        }
        let soon = tokio::time::Instant::now() + PACE;
        let row = jobs.wait(id, Some(soon)).await.map_err(|error| CliError::Failed(error.to_string()))?;
        if let Some(row) = row.filter(|row| row.state.is_final()) {
            bar.finish();
            return Ok(row);
        }
    }
}
