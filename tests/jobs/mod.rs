//! The queue and the worker: what must hold whatever happens.

pub mod determinism;
mod memo;
mod queue;
mod worker;
