//! Biotope fills a virtual landscape with life.
//!
//! Rooms, and the one direction in which they may name each other
//! (`tests/layers.rs` holds the whole table):
//!
//! ```text
//! main → cli → http → app → jobs → {codec, storage} → compute        api hangs from nothing
//! ```
//!
//! * [`cli`] is the command line
//! * [`http`] is what clients see
//! * [`app`] is the service put together, [`config`] what the operator decides
//! * [`jobs`] is the seam: processes, jobs, what they hand back, and the queue they wait in
//! * [`storage`] keeps bytes by key
//! * [`compute`] is what we know: pure functions, no I/O.
//! * [`codec`] turns bytes into compute values and back.

pub mod app;
pub mod cli;
pub mod codec;
pub mod compute;
pub mod config;
pub mod http;
pub mod jobs;
pub mod storage;
