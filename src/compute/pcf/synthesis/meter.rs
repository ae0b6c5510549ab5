use crate::compute::pcf::PcfError;
use crate::compute::run::Run;
use std::sync::Mutex;
use std::sync::PoisonError;

/// Counts the steps of a synthesis over all its classes, blocks and rounds, whichever thread does
/// them: one step is one element in one round.
pub(super) struct Meter<'a> {
    /// Where steps are reported to.
    pub(super) run: &'a Run,
    done: Mutex<u64>,
    total: u64,
}

impl<'a> Meter<'a> {
    /// No step of `total` done.
    pub(super) fn new(run: &'a Run, total: u64) -> Self {
        Self { run, done: Mutex::new(0), total }
    }

    /// `steps` more are done; reported in order, so that progress never falls.
    pub(super) fn advance(&self, steps: usize) -> Result<(), PcfError> {
        let mut done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
        *done += steps as u64;
        Ok(self.run.progress("distribution.synthesis", *done, self.total)?)
    }
}
