//! Points, bounds and neighbour search in the plane. Lengths in metres, x east, y north.

mod bounds;
mod cell_grid;
mod ellipse;
mod point;

pub use bounds::Bounds;
pub use cell_grid::CellGrid;
pub use ellipse::Ellipse;
pub use point::Point;
