//! Maps on a grid of square cells: row-major, first row north, values at cell centres.

mod bucket_queue;
pub mod compass;
mod distance;
mod grid;
mod outline;
mod smooth;
mod tiling;

pub use bucket_queue::BucketQueue;
pub use distance::distance_to_zero;
pub use grid::{Cell, Grid, Raster};
pub use outline::outline;
pub use smooth::box_mean;
pub use tiling::Tiling;
