//! Everything that runs in this process: `mod` lines only.

#![allow(clippy::unwrap_used, reason = "a test ends where something it needs is not there")]

mod contract;
mod http;
mod jobs;
mod layers;
mod science;
mod support;
