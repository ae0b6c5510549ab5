//! The seam between what clients say and what we know.
//!
//! A capability is a **process**: it describes its inputs and outputs, and parses inputs into a
//! **job** that cannot be wrong. A job runs once: load, compute, store; everything it needs from
//! the world is in its [`JobContext`]. To add a process: wire types in `api/`, one file here,
//! one line in [`registry`], an example in `api/examples/`. `echo` is the smallest one to read.
//!
//! | file | holds |
//! |---|---|
//! | [`process`], [`job`], [`context`] | the three traits and types a process is made of |
//! | [`invalid`], [`schema`] | every fault of a client's input, with its place |
//! | [`sources`], [`given`], [`csv`] | what stands behind a reference |
//! | [`artefact`], [`table`] | what a job hands back, and the forms it can be had in |
//! | [`selection`] | which outputs a client wants |
//! | [`registry`] | the list of processes |
//! | [`echo`] and the others | one file a process |

pub mod artefact;
pub mod context;
pub mod csv;
pub mod disk_synthesis;
pub mod distribution_analysis;
pub mod distribution_decomposition;
pub mod distribution_inpainting;
pub mod echo;
pub mod ecosystem;
pub mod given;
pub mod herd_animation;
pub mod herd_extraction;
mod herds;
pub mod housekeeping;
pub mod invalid;
pub mod job;
pub mod key_herd;
pub mod local;
mod places;
pub mod points;
pub mod process;
pub mod progress;
pub mod queue;
pub mod rasters;
pub mod references;
pub mod registry;
pub mod results;
pub mod schema;
pub mod selection;
pub mod service;
pub mod settings;
pub mod sources;
pub mod submit;
pub mod table;
pub mod work;
mod worker;

pub use artefact::Artefact;
pub use context::JobContext;
pub use context::Stage;
pub use invalid::Invalid;
pub use job::Estimate;
pub use job::Failure;
pub use job::Job;
pub use process::Description;
pub use process::Output;
pub use process::Process;
pub use service::Jobs;
pub use service::JobsError;
pub use settings::Settings;
pub use sources::Sources;
pub use table::Table;

pub use crate::storage::Digest;
pub use crate::storage::Hasher;
