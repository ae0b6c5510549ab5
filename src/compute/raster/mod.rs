//! Maps on a grid of square cells: row-major, first row north, values at cell centres.

mod grid;

pub use grid::{Cell, Grid, Raster};
