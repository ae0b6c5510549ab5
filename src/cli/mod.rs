//! The command line: `serve`, `run`, `demo`, `openapi`.

mod bar;
mod demo;
mod openapi;
mod run;
mod serve;

use std::io::IsTerminal as _;
use std::io::Write as _;
use std::process::ExitCode;

use clap::Parser;
use clap::Subcommand;
use tracing_subscriber::EnvFilter;

/// Fills a virtual landscape with life.
#[derive(Debug, Parser)]
#[command(name = "biotope", version, about)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Serves the API.
    Serve(serve::Serve),
    /// Runs one request from a file, without a server.
    Run(run::RunFile),
    /// Serves the API, runs the sample and shows where its maps are.
    Demo(demo::Demo),
    /// Prints the document of the API.
    Openapi(openapi::OpenApi),
}

/// Why a command ended without doing its work.
#[derive(Debug)]
enum CliError {
    /// The command cannot begin as it was given: exit 2.
    Usage(String),
    /// The command failed: exit 1.
    Failed(String),
}

/// Reads the command line and does what it says.
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    log_to_stderr();
    let runtime = match tokio::runtime::Runtime::new() {
        Ok(runtime) => runtime,
        Err(error) => return fail(&CliError::Failed(format!("the runtime cannot be started: {error}"))),
    };
    let done = match cli.command {
        Command::Serve(serve) => runtime.block_on(serve.execute()),
        Command::Run(run) => run.execute(runtime.handle()),
        Command::Demo(demo) => runtime.block_on(demo.execute()),
        Command::Openapi(openapi) => openapi.execute(),
    };
    runtime.shutdown_background();
    done.map_or_else(|error| fail(&error), |()| ExitCode::SUCCESS)
}

/// Logs go to standard error; `RUST_LOG` says how much, by default what an operator must see.
fn log_to_stderr() {
    let filter = EnvFilter::builder().with_default_directive(tracing::Level::WARN.into()).from_env_lossy();
    let _set_before = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_ansi(std::io::stderr().is_terminal())
        .with_writer(std::io::stderr)
        .try_init();
}

fn fail(error: &CliError) -> ExitCode {
    let (code, text) = match error {
        CliError::Usage(text) => (2, text),
        CliError::Failed(text) => (1, text),
    };
    let _nobody_listens = writeln!(std::io::stderr(), "error: {text}");
    ExitCode::from(code)
}

/// Writes a line to standard output.
fn say(line: &str) {
    let mut out = std::io::stdout();
    let _nobody_listens = writeln!(out, "{line}").and_then(|()| out.flush());
}
