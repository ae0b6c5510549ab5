//! The service put together: built once, cheap to clone.

use std::sync::Mutex;
use std::sync::PoisonError;

use metrics_exporter_prometheus::BuildError;
use metrics_exporter_prometheus::PrometheusBuilder;
use metrics_exporter_prometheus::PrometheusHandle;

use crate::config::Config;
use crate::jobs::Jobs;
use crate::jobs::JobsError;
use crate::jobs::registry::Registry;

pub use crate::config::Limits;

/// Why the service cannot start.
#[derive(Debug, thiserror::Error)]
pub enum AppError {
    /// The jobs cannot be opened.
    #[error(transparent)]
    Jobs(#[from] JobsError),
    /// The processes are described wrongly.
    #[error("the schema of a process is not one: {0}")]
    Schema(String),
    /// The metrics cannot be kept.
    #[error("the metrics cannot be kept: {0}")]
    Metrics(String),
}

/// The service.
#[derive(Clone)]
pub struct App {
    /// What a request may be.
    pub limits: Limits,
    /// The jobs.
    pub jobs: Jobs,
    /// What `/metrics` shows.
    pub metrics: PrometheusHandle,
}

impl App {
    /// Opens the service with every process.
    ///
    /// # Errors
    /// When its folder cannot be used.
    pub async fn open(config: &Config) -> Result<Self, AppError> {
        let registry = Registry::standard().map_err(AppError::Schema)?;
        let jobs = Jobs::open(&config.data, registry, config.work.settings()).await?;
        Self::new(jobs, config.limits)
    }

    /// A service of given jobs.
    ///
    /// # Errors
    /// When the metrics cannot be kept.
    pub fn new(jobs: Jobs, limits: Limits) -> Result<Self, AppError> {
        let metrics = recorder().map_err(|error| AppError::Metrics(error.to_string()))?;
        Ok(Self { limits, jobs, metrics })
    }
}

/// The one recorder of this process, installed by whoever asks first.
fn recorder() -> Result<PrometheusHandle, BuildError> {
    static INSTALLED: Mutex<Option<PrometheusHandle>> = Mutex::new(None);
    let mut installed = INSTALLED.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(handle) = &*installed {
        return Ok(handle.clone());
    }
    let handle = PrometheusBuilder::new().install_recorder()?;
    Ok(installed.insert(handle).clone())
}
