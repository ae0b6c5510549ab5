//! Removing blobs that nobody names any more, while others are being written.

use std::collections::BTreeMap;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::Mutex;
use std::sync::MutexGuard;
use std::sync::PoisonError;

use crate::storage::Digest;

/// Which blobs are being handed over: stored, but perhaps not named by any row yet.
#[derive(Debug, Default)]
pub(super) struct Pins {
    state: Mutex<State>,
    /// Taken to read while a blob is stored, to write while one is removed.
    pub gate: tokio::sync::RwLock<()>,
}

#[derive(Debug, Default)]
struct State {
    held: BTreeMap<Digest, usize>,
    /// Every blob that was held at some time since the sweep began; `None` when there is none.
    since: Option<BTreeSet<Digest>>,
}

impl Pins {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Holds a blob. To be called before it is looked for or stored.
    pub fn hold(self: &Arc<Self>, digest: Digest) -> Pin {
        let mut state = self.state();
        *state.held.entry(digest).or_default() += 1;
        if let Some(since) = &mut state.since {
            since.insert(digest);
        }
        Pin { digest, pins: Arc::clone(self) }
    }

    /// From here on, what is held is remembered. `None` while another sweep is under way.
    pub fn begin(self: &Arc<Self>) -> Option<Watch> {
        let mut state = self.state();
        if state.since.is_some() {
            return None;
        }
        state.since = Some(state.held.keys().copied().collect());
        Some(Watch(Arc::clone(self)))
    }
}

/// A blob that is no sweep's to remove as long as this lives: until a row names it.
#[derive(Debug)]
#[must_use = "the blob may be swept away once its pin is gone"]
pub struct Pin {
    digest: Digest,
    pins: Arc<Pins>,
}

impl Pin {
    /// The blob.
    pub fn digest(&self) -> Digest {
        self.digest
    }
}

impl Clone for Pin {
    fn clone(&self) -> Self {
        self.pins.hold(self.digest)
    }
}

impl Drop for Pin {
    fn drop(&mut self) {
        let mut state = self.pins.state();
        if let Some(count) = state.held.get_mut(&self.digest) {
            *count -= 1;
            if *count == 0 {
                state.held.remove(&self.digest);
            }
        }
    }
}

/// What a sweep knows of the blobs held since it began.
#[derive(Debug)]
pub(super) struct Watch(Arc<Pins>);

impl Watch {
    /// Whether a blob was held at any time since the sweep began.
    pub fn was_held(&self, digest: &Digest) -> bool {
        self.0.state().since.as_ref().is_some_and(|since| since.contains(digest))
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.0.state().since = None;
    }
}
