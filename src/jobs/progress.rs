//! How far a running job is: what the worker reports, what status and event streams read.

use std::collections::VecDeque;
use std::sync::Mutex;
use std::sync::PoisonError;
use std::time::Duration;
use std::time::Instant;

use tokio::sync::watch;

use crate::compute::run::Progress;
use crate::compute::run::StopFlag;

/// Events kept for clients that come back.
const EVENTS_LIMIT: usize = 1000;
/// Least time between two events of one stage.
const PACE: Duration = Duration::from_millis(100);

/// A step on the way of a running job.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Event {
    /// Its number in this run of the job, from 1.
    pub number: u64,
    /// What was reported.
    pub progress: Progress,
}

/// A job that runs in this process.
#[derive(Debug)]
pub struct Live {
    /// Which run of the job this is.
    pub fence: i64,
    /// Asks it to stop.
    pub stop: StopFlag,
    state: Mutex<State>,
    changed: watch::Sender<u64>,
}

#[derive(Debug, Default)]
struct State {
    events: VecDeque<Event>,
    count: u64,
    latest: Option<Progress>,
    recorded: Option<Instant>,
    stages: &'static [(&'static str, u32)],
    percent: u8,
    unwritten: bool,
}

impl Live {
    /// A run that has reported nothing yet.
    pub fn new(fence: i64) -> Self {
        let state = Mutex::new(State::default());
        Self { fence, stop: StopFlag::default(), state, changed: watch::Sender::new(0) }
    }

    /// Sets the stages of the job with their share of the time.
    pub fn set_stages(&self, stages: &'static [(&'static str, u32)]) {
        self.lock().stages = stages;
    }

    /// Takes in a report of the worker. Called often and from many threads.
    pub fn report(&self, progress: Progress) {
        let number = self.lock().take(progress, Instant::now());
        if let Some(number) = number {
            self.changed.send_replace(number);
        }
    }

    /// Events after the one of that number, at most as many as are kept.
    pub fn events_after(&self, number: u64) -> Vec<Event> {
        self.lock().events.iter().filter(|event| event.number > number).cloned().collect()
    }

    /// Percent done and the sentence that goes with it.
    pub fn summary(&self) -> (u8, String) {
        let state = self.lock();
        (state.percent, state.latest.as_ref().map(sentence).unwrap_or_default())
    }

    /// The summary, if it has changed since this was last asked.
    pub fn unwritten_summary(&self) -> Option<(u8, String)> {
        let unwritten = std::mem::take(&mut self.lock().unwritten);
        unwritten.then(|| self.summary())
    }

    /// Tells of new events.
    pub fn subscribe(&self) -> watch::Receiver<u64> {
        self.changed.subscribe()
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// The number of the event made of `progress`; `None` when it comes too soon after the last
    /// one of its stage to be one.
    fn take(&mut self, progress: Progress, now: Instant) -> Option<u64> {
        let same_stage = self.latest.as_ref().is_some_and(|latest| latest.stage == progress.stage);
        let soon = self.recorded.is_some_and(|at| now.duration_since(at) < PACE);
        self.percent = self.percent.max(percent(self.stages, &progress));
        self.unwritten = true;
        let dropped = same_stage && soon && progress.done < progress.total;
        self.latest = Some(progress.clone());
        if dropped {
            return None;
        }
        self.recorded = Some(now);
        self.count += 1;
        self.events.push_back(Event { number: self.count, progress });
        if self.events.len() > EVENTS_LIMIT {
            self.events.pop_front();
        }
        Some(self.count)
    }
}

/// Percent done, at most 99: the work is done when its results are there.
fn percent(stages: &[(&str, u32)], progress: &Progress) -> u8 {
    let part = progress.done as f64 / progress.total.max(1) as f64;
    let all: u32 = stages.iter().map(|(_, share)| share).sum();
    let done = match stages.iter().position(|(name, _)| *name == progress.stage) {
        Some(at) => {
            let before: u32 = stages[..at].iter().map(|(_, share)| share).sum();
            (f64::from(before) + part * f64::from(stages[at].1)) / f64::from(all.max(1))
        }
        None if stages.is_empty() => part,
        None => 0.0,
    };
    (done * 100.0).clamp(0.0, 99.0) as u8
}

fn sentence(progress: &Progress) -> String {
    let Progress { stage, done, total, message } = progress;
    if message.is_empty() { format!("{stage}: {done} of {total}") } else { format!("{stage}: {message}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(stage: &'static str, done: u64, total: u64) -> Progress {
        Progress { stage, done, total, message: String::new() }
    }

    #[test]
    fn percent_follows_the_shares_of_the_stages_and_never_falls() {
        let live = Live::new(1);
        live.set_stages(&[("terrain", 1), ("plants", 3)]);
        for (progress, expected) in [(at("terrain", 1, 1), 25), (at("plants", 1, 3), 50), (at("other", 1, 1), 50)] {
            live.report(progress);
            assert_eq!(live.summary().0, expected);
        }
        live.report(at("plants", 3, 3));
        assert_eq!(live.summary(), (99, "plants: 3 of 3".to_owned()));
    }

    #[test]
    fn a_flood_of_reports_makes_few_events_and_none_is_read_twice() {
        let live = Live::new(1);
        for done in 0..=10_000 {
            live.report(at("plants", done, 10_000));
        }
        let events = live.events_after(0);
        assert!(events.len() < 50, "{}", events.len());
        assert_eq!(events.last().map(|event| event.progress.done), Some(10_000));
        let last = events.last().map_or(0, |event| event.number);
        assert!(live.events_after(last).is_empty());
    }
}
