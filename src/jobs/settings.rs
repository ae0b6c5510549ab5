//! What the operator decides about jobs.

use std::time::Duration;

/// How much is worked on at once, how much may wait, and how long results are kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Settings {
    /// Threads each job computes on. Default: one a processor.
    pub threads: usize,
    /// Heavy jobs that may run at once. Default: 2.
    pub heavy_jobs: usize,
    /// Quick jobs that may run at once beside them. Default: 4.
    pub quick_jobs: usize,
    /// Memory that all running jobs together may need, in bytes. Default: three quarters of the
    /// machine's.
    pub memory_bytes: u64,
    /// Jobs that may wait. Default: 256.
    pub waiting_jobs: u64,
    /// Disk that the results of stages and encoded forms may take, in bytes; the oldest are
    /// dropped. Default: 20 GiB.
    pub cache_bytes: u64,
    /// How long jobs that have ended, and uploads nobody uses, are kept. Default: 30 days.
    pub keep: Duration,
    /// Disk that the results of jobs may take, in bytes; the jobs that ended first are forgotten.
    /// Default: 100 GiB.
    pub results_bytes: u64,
}

impl Default for Settings {
    fn default() -> Self {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        Self {
            threads,
            heavy_jobs: 2,
            quick_jobs: 4,
            memory_bytes: 4 << 30,
            waiting_jobs: 256,
            cache_bytes: 20 << 30,
            keep: Duration::from_secs(30 * 24 * 3600),
            results_bytes: 100 << 30,
        }
    }
}
