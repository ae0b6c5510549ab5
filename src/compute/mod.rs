//! What Biotope knows: pure, deterministic, synchronous algorithms.
//!
//! Nothing here reads a file, a clock or the environment, prints, or knows of HTTP, JSON or
//! queues. The only window out is [`run::Run`]: it says when to stop and hears of progress.
//!
//! | room | holds | may name |
//! |---|---|---|
//! | [`run`] | cancel and progress | – |
//! | [`random`] | random numbers as a function of (seed, purpose, index) | – |
//! | [`geometry`] | points, bounds, polygons, neighbour grid | the rooms above |
//! | [`raster`] | maps on a grid of square cells | the rooms above |
//! | [`graph`] | shortest paths, components, assignment | the rooms above |
//! | [`pcf`] | pair correlation: analysis and synthesis of arrangements | the five |
//! | [`herds`] | from a photo to animals that walk | the five, `pcf` |
//! | [`ecosystem`] | terrain to plants, animals, trails, plannings | the five, `pcf` |
//!
//! **Determinism.** Same input and seed, same bytes, on any number of threads: random numbers
//! never depend on order, parallel results are collected and folded in order, nothing iterates
//! a hash map, ties break by index.

#![deny(clippy::disallowed_methods, clippy::disallowed_types, clippy::disallowed_macros)]

pub mod ecosystem;
pub mod geometry;
pub mod graph;
pub mod herds;
pub mod pcf;
pub mod random;
pub mod raster;
pub mod run;
