//! What a job is handed when it runs.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::collections::VecDeque;

use biotope_api::warning::Warning;
use bytes::Bytes;
use serde::Deserialize;
use serde::Serialize;

use crate::compute::run::Run;
use crate::jobs::Artefact;
use crate::jobs::Failure;
use crate::jobs::Hasher;
use crate::jobs::artefact::Kind;
use crate::jobs::selection::Selection;
use crate::jobs::sources::Sources;
use crate::storage::BlockingStore;
use crate::storage::Digest;
use crate::storage::Key;
use crate::storage::Pin;
use crate::storage::Writing;

/// What a job is handed when it runs: everything it may know of the world.
pub struct JobContext<'a> {
    /// When to stop, and where to report progress.
    pub run: Run,
    /// Seed of the random numbers.
    pub seed: u64,
    sources: &'a dyn Sources,
    store: &'a BlockingStore,
    selection: Selection,
    kept: Kept,
    /// The stages that are being stored while the job goes on, oldest first, with their sizes.
    writing: RefCell<VecDeque<(usize, Writing)>>,
}

/// Bytes of stages that may wait for the disk while the job goes on (ours: small stages never hold
/// it up, of large ones one waits at a time).
const MAX_WAITING_BYTES: usize = 64 << 20;

/// What a job has handed back so far.
#[derive(Debug, Clone, Default)]
pub struct Kept {
    /// Its outputs by id.
    pub outputs: BTreeMap<String, Stored>,
    /// What readers should know.
    pub warnings: Vec<Warning>,
    /// Where numbers come from.
    pub citations: Vec<Citation>,
    /// Holds the outputs until a row names them.
    pins: Vec<Pin>,
}

/// An output as it is stored.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stored {
    /// What kind of thing it is.
    #[serde(flatten)]
    pub kind: Kind,
    /// Digest of its stored form, with the prefix `sha256:`.
    pub digest: String,
    /// Size of its stored form in bytes.
    pub size: u64,
    /// Whether it is a map that is 0 or without data everywhere.
    #[serde(default, skip_serializing_if = "is_false")]
    pub blank: bool,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks so")]
const fn is_false(value: &bool) -> bool {
    !*value
}

/// Where a number comes from.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Citation {
    /// What the number is: `quercus-ilex.light`.
    pub subject: String,
    /// Where it comes from.
    pub source: String,
}

/// A stage of a chain: a pure function of its parameters and inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stage {
    /// Its name.
    pub name: &'static str,
    /// To be raised whenever the same inputs give other bytes.
    pub version: u32,
    /// Digest of all its parameters and inputs; made with [`Hasher`].
    pub inputs: Digest,
}

impl Stage {
    /// The digest under which the result of the stage is stored.
    pub fn digest(&self) -> Digest {
        let Self { name, version, inputs } = self;
        Hasher::new().part(name, format!("{version} {inputs}").as_bytes()).finish()
    }
}

impl Kept {
    /// What holds the outputs until a row names them.
    pub fn take_pins(&mut self) -> Vec<Pin> {
        std::mem::take(&mut self.pins)
    }
}

impl<'a> JobContext<'a> {
    /// A context that stores in `store` what `selection` wants.
    pub fn new(run: Run, seed: u64, selection: Selection, store: &'a BlockingStore, sources: &'a dyn Sources) -> Self {
        Self { run, seed, sources, store, selection, kept: Kept::default(), writing: RefCell::default() }
    }

    /// What stands behind references.
    pub fn sources(&self) -> &dyn Sources {
        self.sources
    }

    /// Whether the output `id` is to be kept. Work that serves only outputs that nobody wants
    /// can be left out.
    pub fn wants(&self, id: &str) -> bool {
        self.selection.wants(id)
    }

    /// Hands back an output. One that is not wanted is dropped. Nobody sees it before the job
    /// has succeeded.
    ///
    /// # Errors
    /// When the process has no such output or it was handed back before (faults of ours), or
    /// when the store fails.
    pub fn put(&mut self, id: impl Into<String>, artefact: Artefact) -> Result<(), Failure> {
        let id = id.into();
        if !self.selection.knows(&id) {
            return Err(Failure::Fault(format!("the process does not describe an output {id}")));
        }
        if !self.wants(&id) {
            return Ok(());
        }
        let stored = self.store_artefact(&artefact)?;
        match self.kept.outputs.insert(id.clone(), stored) {
            None => Ok(()),
            Some(_) => Err(Failure::Fault(format!("the output {id} was handed back twice"))),
        }
    }

    /// Tells readers of the result something they should know. Its pointer is relative to the
    /// inputs, as that of a fault.
    pub fn warn(&mut self, mut warning: Warning) {
        if !warning.pointer.is_empty() {
            warning.pointer.insert_str(0, "/inputs");
        }
        self.kept.warnings.push(warning);
    }

    /// Names where a number comes from.
    pub fn cite(&mut self, subject: impl Into<String>, source: impl Into<String>) {
        self.kept.citations.push(Citation { subject: subject.into(), source: source.into() });
    }

    /// What [`JobContext::remember`] was given for a stage of the same inputs, by any job.
    ///
    /// # Errors
    /// When the store fails.
    pub fn recall(&self, stage: Stage) -> Result<Option<Bytes>, Failure> {
        Ok(self.store.find(&Key::Stage(stage.digest()))?)
    }

    /// Stores the result of a stage, which goes on while the job does. Warnings belong in the
    /// bytes, since the stage will not run again.
    ///
    /// # Errors
    /// When the store fails, at this stage or at one before.
    pub fn remember(&self, stage: Stage, bytes: Bytes) -> Result<(), Failure> {
        self.written_but(MAX_WAITING_BYTES.saturating_sub(bytes.len()))?;
        let size = bytes.len();
        let writing = self.store.begin_put(Key::Stage(stage.digest()), bytes);
        self.writing.borrow_mut().push_back((size, writing));
        Ok(())
    }

    /// Waits until at most `left` bytes of stages are yet to be stored.
    fn written_but(&self, left: usize) -> Result<(), Failure> {
        let mut writing = self.writing.borrow_mut();
        while writing.iter().map(|(bytes, _)| bytes).sum::<usize>() > left {
            if let Some((_, oldest)) = writing.pop_front() {
                oldest.finish()?;
            }
        }
        Ok(())
    }

    /// What has been handed back so far.
    pub fn kept(&self) -> &Kept {
        &self.kept
    }

    /// What has been handed back, once every stage is stored; the context is used up.
    ///
    /// # Errors
    /// When the store fails.
    pub fn finish(self) -> Result<Kept, Failure> {
        self.writing.into_inner().into_iter().try_for_each(|(_, writing)| writing.finish())?;
        Ok(self.kept)
    }

    fn store_artefact(&mut self, artefact: &Artefact) -> Result<Stored, Failure> {
        let bytes = artefact.to_stored().map_err(Failure::fault)?;
        let size = bytes.len() as u64;
        let pin = self.store.put_blob(bytes)?;
        let digest = pin.digest().to_string();
        self.kept.pins.push(pin);
        Ok(Stored { kind: artefact.kind(), digest, size, blank: artefact.is_blank() })
    }
}
