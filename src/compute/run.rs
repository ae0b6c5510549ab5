//! The only window out of the core: when to stop, and how far the work is.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The work was told to stop before it was done. Its partial results are to be thrown away.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the work was stopped before it was done")]
pub struct Stopped;

/// A flag that asks running work to stop. Clones share one flag.
#[derive(Debug, Clone, Default)]
pub struct StopFlag(Arc<AtomicBool>);

impl StopFlag {
    /// Asks all work that holds this flag to stop; cannot be taken back.
    pub fn stop(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the work was asked to stop.
    pub fn is_stopped(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// How far the work is: `done` of `total` steps of the named stage.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Progress {
    /// The stage, a dotted lower-case name such as `plants.competition`.
    pub stage: &'static str,
    /// Steps done, at most `total`.
    pub done: u64,
    /// Steps in the stage, at least 1.
    pub total: u64,
    /// A short sentence for people; may be empty.
    pub message: String,
}

type Observer = Arc<dyn Fn(Progress) + Send + Sync>;

/// What a computation is handed beside its input: a flag to poll and somewhere to report to.
///
/// Loops call [`Run::check`] at least every few milliseconds of work. Reports may come from any
/// thread; the observer must be quick and must not influence the result.
#[derive(Clone)]
pub struct Run {
    stop: StopFlag,
    observer: Option<Observer>,
}

impl Run {
    /// A run that polls `stop` and reports to `observer`.
    pub fn new(stop: StopFlag, observer: impl Fn(Progress) + Send + Sync + 'static) -> Self {
        Self { stop, observer: Some(Arc::new(observer)) }
    }

    /// A run that nobody watches and nobody stops: for tests and for small work.
    pub fn silent() -> Self {
        Self { stop: StopFlag::default(), observer: None }
    }

    /// A run that nobody watches, stopped by `stop`.
    pub fn stoppable(stop: StopFlag) -> Self {
        Self { stop, observer: None }
    }

    /// Fails with [`Stopped`] once the work was asked to stop.
    pub fn check(&self) -> Result<(), Stopped> {
        if self.stop.is_stopped() { Err(Stopped) } else { Ok(()) }
    }

    /// Whether the work was asked to stop, for inner loops that cannot return early by `?`.
    pub fn is_stopped(&self) -> bool {
        self.stop.is_stopped()
    }

    /// Reports that `done` of `total` steps of `stage` are done, and checks for a stop.
    pub fn progress(&self, stage: &'static str, done: u64, total: u64) -> Result<(), Stopped> {
        self.tell(stage, done, total, String::new())
    }

    /// Like [`Run::progress`], with a short sentence for people.
    pub fn tell(&self, stage: &'static str, done: u64, total: u64, message: String) -> Result<(), Stopped> {
        if let Some(observer) = &self.observer {
            let total = total.max(1);
            observer(Progress { stage, done: done.min(total), total, message });
        }
        self.check()
    }
}

impl fmt::Debug for Run {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Run").field("stopped", &self.is_stopped()).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stopped_run_fails_at_the_next_check() {
        let flag = StopFlag::default();
        let run = Run::stoppable(flag.clone());
        assert_eq!(run.check(), Ok(()));
        flag.stop();
        assert_eq!(run.check(), Err(Stopped));
        assert_eq!(run.progress("any", 1, 2), Err(Stopped));
    }

    #[test]
    fn progress_never_exceeds_its_total() {
        let seen = Arc::new(std::sync::Mutex::new(Vec::new()));
        let sink = Arc::clone(&seen);
        let run = Run::new(StopFlag::default(), move |p| sink.lock().unwrap().push((p.done, p.total)));
        run.progress("any", 7, 3).unwrap();
        run.progress("any", 0, 0).unwrap();
        assert_eq!(*seen.lock().unwrap(), vec![(3, 3), (0, 1)]);
    }
}
