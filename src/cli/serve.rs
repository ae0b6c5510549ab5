//! `serve`: the API, until told to stop.

use std::net::SocketAddr;
use std::time::Duration;

use clap::Args;
use tokio::signal::unix::SignalKind;
use tokio::signal::unix::signal;
use tokio::task::JoinHandle;

use crate::app::App;
use crate::app::AppError;
use crate::cli::CliError;
use crate::cli::say;
use crate::config::Config;
use crate::http;

/// Time that running jobs are given to stop, and open requests to end.
const GRACE: Duration = Duration::from_secs(5);

/// Serves the API.
#[derive(Debug, Args)]
pub struct Serve {
    #[command(flatten)]
    config: Config,
}

impl Serve {
    /// Serves until SIGTERM or SIGINT.
    pub async fn execute(self) -> Result<(), CliError> {
        let server = Server::start(&self.config).await?;
        say(&format!("listening on {}", server.url()));
        server.run_until_told().await
    }
}

/// A service that answers.
pub struct Server {
    /// The service.
    pub app: App,
    address: SocketAddr,
    serving: JoinHandle<std::io::Result<()>>,
}

impl Server {
    /// Takes the port and the folder, and begins to answer.
    pub async fn start(config: &Config) -> Result<Self, CliError> {
        let listener = http::listen(config.host, config.port)
            .await
            .map_err(|error| CliError::Usage(format!("--port {} cannot be used: {error}", config.port)))?;
        let address = listener.local_addr().map_err(|error| CliError::Failed(error.to_string()))?;
        let app = App::open(config).await.map_err(|error| no_app(&error, config))?;
        let serving = tokio::spawn(http::serve(listener, app.clone()));
        Ok(Self { app, address, serving })
    }

    /// Where it answers.
    pub fn url(&self) -> String {
        match self.address {
            SocketAddr::V4(v4) if v4.ip().is_unspecified() => format!("http://127.0.0.1:{}", v4.port()),
            address => format!("http://{address}"),
        }
    }

    /// Answers until SIGTERM or SIGINT; then puts running jobs back and ends.
    pub async fn run_until_told(mut self) -> Result<(), CliError> {
        let broken = |error: std::io::Error| CliError::Failed(format!("signals cannot be heard: {error}"));
        let mut term = signal(SignalKind::terminate()).map_err(broken)?;
        let mut int = signal(SignalKind::interrupt()).map_err(broken)?;
        tokio::select! {
            _ = term.recv() => {}
            _ = int.recv() => {}
            ended = &mut self.serving => {
                return Err(CliError::Failed(format!("the service ended by itself: {ended:?}")));
            }
        }
        self.stop().await;
        Ok(())
    }

    /// Puts running jobs back and ends.
    pub async fn stop(self) {
        tracing::info!("stopping");
        self.app.jobs.drain(GRACE).await;
        // Event streams may stay open for ever, so open requests get a moment and no more.
        tokio::time::sleep(Duration::from_millis(100)).await;
        self.serving.abort();
    }
}

fn no_app(error: &AppError, config: &Config) -> CliError {
    CliError::Usage(format!("--data {} cannot be used: {error}", config.data.display()))
}
