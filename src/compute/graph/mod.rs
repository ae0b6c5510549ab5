//! Graphs and the problems solved on them: shortest paths over a grid, components, assignment.

pub mod assignment;
mod bucket_queue;
pub mod components;
pub mod shortest_paths;

pub use bucket_queue::BucketQueue;
