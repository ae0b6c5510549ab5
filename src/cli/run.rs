//! `run`: one request from a file, without a server.

use std::io::Write as _;
use std::path::PathBuf;
use std::sync::Arc;
use std::thread;

use biotope_api::error::Problem;
use clap::Args;
use tokio::runtime::Handle;

use crate::cli::CliError;
use crate::cli::bar::Bar;
use crate::cli::bar::PACE;
use crate::config;
use crate::jobs::local::FileRequest;
use crate::jobs::local::LocalError;
use crate::jobs::local::LocalRun;
use crate::jobs::progress::Live;

/// Runs one request from a file, without a server.
#[derive(Debug, Args)]
pub struct RunFile {
    /// Id of the process.
    process: String,
    /// The request: a JSON file of inputs and outputs; paths in it start from its folder.
    file: PathBuf,
    /// Folder to write every output to, as `<output id>.<extension>`.
    #[arg(long)]
    out: PathBuf,
    /// Folder to keep the results of stages in, so that the next run is quicker.
    #[arg(long)]
    keep: Option<PathBuf>,
    /// Threads to compute on [default: one a processor].
    #[arg(long, env = "BIOTOPE_THREADS", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

impl RunFile {
    /// Runs the request with a progress bar on standard error.
    pub fn execute(self, handle: &Handle) -> Result<(), CliError> {
        let live = Arc::new(Live::new(1));
        let stop = live.stop.clone();
        handle.spawn(async move {
            if tokio::signal::ctrl_c().await.is_ok() {
                stop.stop();
            }
        });
        let place = LocalRun { out: &self.out, keep: self.keep.as_deref(), threads: config::threads(self.threads) };
        let mut bar = Bar::new();
        let done = thread::scope(|scope| {
            let work = scope.spawn(|| FileRequest::open(&self.file)?.run(&self.process, &place, &live, handle.clone()));
            while !work.is_finished() {
                bar.show(&live);
                thread::sleep(PACE);
            }
            bar.show(&live);
            work.join()
        });
        bar.finish();
        let warnings = done.map_err(|_| CliError::Failed("the work broke off".into()))?.map_err(explain)?;
        for warning in warnings {
            let _nobody_listens = writeln!(std::io::stderr(), "warning {}: {}", warning.code, warning.message);
        }
        Ok(())
    }
}

/// What went wrong, with every fault on a line of its own.
fn explain(error: LocalError) -> CliError {
    match error {
        LocalError::Problem(problem) if problem.errors.len() > 1 => CliError::Failed(faults(&problem)),
        other => CliError::Failed(other.to_string()),
    }
}

fn faults(problem: &Problem) -> String {
    let line = |fault: &biotope_api::error::FieldError| {
        format!("\n  {} ({}): expected {}, found {}", fault.pointer, fault.code, fault.expected, fault.found)
    };
    format!("{}{}", problem.title, problem.errors.iter().map(line).collect::<String>())
}
