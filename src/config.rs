//! What the operator decides: flags, each with an environment variable. Nothing else reads the
//! environment.

use std::net::IpAddr;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use crate::jobs;

/// Settings of the service.
#[derive(Debug, Clone, Args)]
pub struct Config {
    /// Address to listen on.
    #[arg(long, env = "BIOTOPE_HOST", default_value = "127.0.0.1")]
    pub host: IpAddr,
    /// Port to listen on; 0 takes a free one.
    #[arg(long, env = "BIOTOPE_PORT", default_value_t = 8080)]
    pub port: u16,
    /// Folder that holds jobs and results; one process at a time works in it.
    #[arg(long, env = "BIOTOPE_DATA", default_value = "data")]
    pub data: PathBuf,
    /// How much is worked on at once.
    #[command(flatten)]
    pub work: Work,
    /// What a request may be.
    #[command(flatten)]
    pub limits: Limits,
}

/// How much is worked on at once, and how much may wait.
#[derive(Debug, Clone, Args)]
pub struct Work {
    /// Threads each job computes on [default: one a processor].
    #[arg(long, env = "BIOTOPE_THREADS", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Heavy jobs that may run at once; quick ones run beside them.
    #[arg(long, env = "BIOTOPE_JOBS", default_value_t = 2, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: u16,
    /// Quick jobs that may run at once beside them.
    #[arg(long, env = "BIOTOPE_QUICK_JOBS", default_value_t = 4, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub quick_jobs: u16,
    /// Memory that all running jobs together may need, in MiB [default: three quarters of the machine's].
    #[arg(long, env = "BIOTOPE_MEMORY_MIB")]
    pub memory_mib: Option<u64>,
    /// Jobs that may wait; more are answered 503.
    #[arg(long, env = "BIOTOPE_QUEUE", default_value_t = 256)]
    pub queue: u64,
    /// Disk that results of stages and encoded forms may take, in GiB; the oldest are dropped.
    #[arg(long, env = "BIOTOPE_CACHE_GIB", default_value_t = 20)]
    pub cache_gib: u64,
    /// Days that ended jobs with their results, and uploads nobody uses, are kept.
    #[arg(long, env = "BIOTOPE_KEEP_DAYS", default_value_t = 30, value_parser = clap::value_parser!(u32).range(1..=36_500))]
    pub keep_days: u32,
    /// Disk that results may take, in GiB; the jobs that ended first are forgotten.
    #[arg(long, env = "BIOTOPE_RESULTS_GIB", default_value_t = 100)]
    pub results_gib: u64,
}

/// What a request may be.
#[derive(Debug, Clone, Copy, Args)]
pub struct Limits {
    /// Largest JSON body, in MiB.
    #[arg(long, env = "BIOTOPE_BODY_MIB", default_value_t = 64)]
    pub body_mib: u64,
    /// Largest upload, in MiB.
    #[arg(long, env = "BIOTOPE_UPLOAD_MIB", default_value_t = 2048)]
    pub upload_mib: u64,
    /// Longest time a JSON body, or the next piece of an upload, may take to arrive, in seconds.
    #[arg(long, env = "BIOTOPE_BODY_TIMEOUT_S", default_value_t = 20)]
    pub body_timeout_s: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { body_mib: 64, upload_mib: 2048, body_timeout_s: 20 }
    }
}

impl Limits {
    /// Largest JSON body in bytes.
    pub const fn body_bytes(&self) -> u64 {
        self.body_mib << 20
    }

    /// Largest upload in bytes.
    pub const fn upload_bytes(&self) -> u64 {
        self.upload_mib << 20
    }

    /// Longest time a body may take.
    pub const fn body_timeout(&self) -> Duration {
        Duration::from_secs(self.body_timeout_s)
    }
}

impl Work {
    /// The settings of the room of jobs.
    pub fn settings(&self) -> jobs::Settings {
        jobs::Settings {
            threads: threads(self.threads),
            heavy_jobs: usize::from(self.jobs),
            quick_jobs: usize::from(self.quick_jobs),
            memory_bytes: self.memory_mib.map_or_else(usable_memory, |mib| mib << 20),
            waiting_jobs: self.queue,
            cache_bytes: self.cache_gib << 30,
            keep: Duration::from_secs(u64::from(self.keep_days) * 24 * 3600),
            results_bytes: self.results_gib << 30,
        }
    }
}

/// The threads asked for, else one a processor.
pub fn threads(asked: Option<u16>) -> usize {
    asked.map_or_else(|| jobs::Settings::default().threads, usize::from)
}

/// Three quarters of the machine's memory, or of what its control group allows; 4 GiB where
/// neither is known.
fn usable_memory() -> u64 {
    let physical = std::fs::read_to_string("/proc/meminfo").ok().and_then(|text| {
        let line = text.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
        line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib << 10)
    });
    let allowed = std::fs::read_to_string("/sys/fs/cgroup/memory.max").ok().and_then(|text| text.trim().parse().ok());
    let total = [physical, allowed].into_iter().flatten().min();
    total.map_or(4 << 30, |bytes| bytes / 4 * 3)
}
