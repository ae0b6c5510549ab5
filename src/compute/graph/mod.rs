//! Graphs and the problems solved on them: shortest paths over a grid, components, assignment.

pub mod assignment;
pub mod components;
mod dial_queue;
pub mod shortest_paths;
