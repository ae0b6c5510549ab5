//! Biotope fills a virtual landscape with life.
//!
//! Rooms, and the one direction in which they may name each other
//! (`tests/layers.rs` holds the whole table):
//!
//! ```text
//! main → cli → http → app → jobs → {codec, storage} → compute        api hangs from nothing
//! ```
//!
//! * [`compute`] is what we know: pure functions, no I/O.
//! * [`codec`] turns bytes into compute values and back.

pub mod codec;
pub mod compute;
