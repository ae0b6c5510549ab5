//! What clients see, resource by resource, without a socket.

mod assets;
mod errors;
mod events;
mod execution;
mod jobs;
mod pages;
mod processes;
mod results;
mod service;
