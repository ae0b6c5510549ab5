//! Progress on the terminal: a bar, or a line a stage where there is no terminal.

use std::io::IsTerminal as _;
use std::io::Write as _;
use std::time::Duration;

use indicatif::ProgressBar;
use indicatif::ProgressStyle;

use crate::jobs::progress::Live;

/// How often the bar moves.
pub const PACE: Duration = Duration::from_millis(100);

/// Progress of one job on standard error.
pub struct Bar {
    bar: Option<ProgressBar>,
    stage: &'static str,
    seen: u64,
}

impl Bar {
    /// A bar at its beginning.
    pub fn new() -> Self {
        let style = ProgressStyle::with_template("{bar:40} {pos:>3} % {elapsed} {wide_msg}");
        let terminal = std::io::stderr().is_terminal();
        let bar =
            terminal.then(|| ProgressBar::new(100).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar())));
        Self { bar, stage: "", seen: 0 }
    }

    /// Shows how far the job is.
    pub fn show(&mut self, live: &Live) {
        let (percent, message) = live.summary();
        if let Some(bar) = &self.bar {
            bar.set_position(u64::from(percent));
            bar.set_message(message);
            return;
        }
        for event in live.events_after(self.seen) {
            self.seen = event.number;
            if event.progress.stage != self.stage {
                self.stage = event.progress.stage;
                let _nobody_listens = writeln!(std::io::stderr(), "{percent:>3} % {}", self.stage);
            }
        }
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
