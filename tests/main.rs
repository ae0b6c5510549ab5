//! Everything that runs in this process: `mod` lines only.

mod contract;
mod http;
mod jobs;
mod layers;
mod science;
mod support;
