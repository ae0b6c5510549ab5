//! The list of processes.

use serde_json::Value;

use crate::jobs::Description;
use crate::jobs::Invalid;
use crate::jobs::Job;
use crate::jobs::Output;
use crate::jobs::Process;
use crate::jobs::Sources;
use crate::jobs::artefact::Kind;
use crate::jobs::disk_synthesis::DiskSynthesis;
use crate::jobs::distribution_analysis::DistributionAnalysis;
use crate::jobs::distribution_decomposition::DistributionDecomposition;
use crate::jobs::distribution_inpainting::DistributionInpainting;
use crate::jobs::echo::Echo;
use crate::jobs::ecosystem::Ecosystem;
use crate::jobs::herd_animation::HerdAnimation;
use crate::jobs::herd_extraction::HerdExtraction;
use crate::jobs::key_herd::KeyHerd;
use crate::jobs::schema::InputCheck;

/// Every process of the service, in the order in which they are shown.
fn all() -> Vec<Box<dyn Process>> {
    vec![
        Box::new(Echo),
        Box::new(DistributionAnalysis),
        Box::new(DiskSynthesis),
        Box::new(DistributionInpainting),
        Box::new(DistributionDecomposition),
        Box::new(Ecosystem),
        Box::new(HerdExtraction),
        Box::new(KeyHerd),
        Box::new(HerdAnimation),
    ]
}

/// The processes, each with its description and the check of its inputs made ready.
pub struct Registry {
    entries: Vec<Entry>,
}

/// A process with its description and the check of its inputs made ready.
pub struct Entry {
    process: Box<dyn Process>,
    check: InputCheck,
    /// What it is called, takes and gives, with the outputs every process has.
    pub description: Description,
}

impl Registry {
    /// Every process of the service.
    ///
    /// # Errors
    /// When the schema of a process is not one: a fault of ours, seen at the start.
    pub fn standard() -> Result<Self, String> {
        Self::of(all())
    }

    /// Given processes: for tests.
    ///
    /// # Errors
    /// As [`Registry::standard`].
    pub fn of(processes: Vec<Box<dyn Process>>) -> Result<Self, String> {
        processes.into_iter().map(Entry::new).collect::<Result<_, _>>().map(|entries| Self { entries })
    }

    /// The processes in the order in which they are shown.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// The process that a request file is named by: `key-herd.json` and `key-herd-bison.json` are
    /// requests of `key-herd`.
    pub fn named_by(&self, stem: &str) -> Option<&Entry> {
        let fits = |id: &str| stem.strip_prefix(id).is_some_and(|rest| rest.is_empty() || rest.starts_with('-'));
        let all = self.entries.iter().filter(|entry| fits(entry.description.id));
        all.max_by_key(|entry| entry.description.id.len())
    }

    /// The process of that id.
    pub fn find(&self, id: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.description.id == id)
    }
}

impl Entry {
    fn new(process: Box<dyn Process>) -> Result<Self, String> {
        let mut description = process.description();
        let check = InputCheck::new(&description.inputs).map_err(|error| format!("{}: {error}", description.id))?;
        description.outputs.extend(common_outputs());
        Ok(Self { process, check, description })
    }

    /// Makes a job out of inputs; not for async threads.
    ///
    /// # Errors
    /// First every fault against the schema, then every one the process finds; pointers are
    /// relative to the inputs.
    pub fn parse(&self, inputs: Value, sources: &dyn Sources) -> Result<Box<dyn Job>, Invalid> {
        self.check.check(&inputs)?;
        self.process.parse(inputs, sources)
    }
}

/// The outputs every process has.
fn common_outputs() -> [Output; 2] {
    let warnings = "What readers of the result should know: code, pointer, message, count.";
    let manifest = "Process and version, seed, parameters with defaults filled in, digests of what was referred to \
                    and of every output, warnings, and the sources of numbers.";
    [
        Output::new("warnings", "Warnings", warnings, Kind::Json),
        Output::new("manifest", "Manifest", manifest, Kind::Json),
    ]
}
