//! Everything that runs in this process: `mod` lines only.

#![allow(clippy::unwrap_used, reason = "a test ends where something it needs is not there")]
#![allow(clippy::print_stdout, reason = "figures for those who ask with --nocapture")]
#![allow(clippy::type_complexity, reason = "tables of cases")]

mod contract;
mod http;
mod jobs;
mod layers;
mod science;
mod support;
