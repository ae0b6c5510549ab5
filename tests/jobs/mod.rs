//! The queue and the worker: what must hold whatever happens. What each process refuses, and says.

pub mod determinism;
mod distribution_inputs;
mod distribution_outcomes;
mod ecosystem_inputs;
mod ecosystem_outcomes;
mod herd_inputs;
mod herd_outcomes;
mod housekeeping;
mod memo;
mod queue;
mod worker;
