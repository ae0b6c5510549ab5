//! Points, bounds, polygons, regions and neighbour search in the plane. Lengths in metres, x
//! east, y north.

mod bounds;
mod cell_grid;
mod ellipse;
mod point;
mod polygon;
mod region;
mod segment_index;
mod surroundings;

pub use bounds::Bounds;
pub use cell_grid::CellGrid;
pub use ellipse::Ellipse;
pub use point::Point;
pub use polygon::MAX_VERTICES;
pub use polygon::Polygon;
pub use polygon::PolygonError;
pub use polygon::ring_area_doubled;
pub use polygon::simple_rings;
pub use region::Region;
pub use segment_index::Segment;
pub use surroundings::Surroundings;
