//! Maps on a grid of square cells: row-major, first row north, values at cell centres.

mod bucket_queue;
pub mod compass;
mod grid;
mod outline;

pub use bucket_queue::BucketQueue;
pub use grid::{Cell, Grid, Raster};
pub use outline::outline;
