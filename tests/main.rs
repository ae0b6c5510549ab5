//! Everything that runs in this process: `mod` lines only.

mod layers;
mod science;
