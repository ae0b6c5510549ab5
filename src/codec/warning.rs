//! What could be worked with, but should be known.

/// A remark on an input or a result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Warning {
    /// Its stable code, one of the constants below.
    pub code: &'static str,
    /// A sentence for people.
    pub message: String,
    /// How many cells it concerns; 1 for the whole.
    pub count: u64,
}

/// Heights of 8 bits.
pub const EIGHT_BIT: &str = "EIGHT_BIT";
/// The values are much smoother with their bytes swapped.
pub const LOOKS_BYTESWAPPED: &str = "LOOKS_BYTESWAPPED";
/// Some cells hold no data.
pub const NODATA_PRESENT: &str = "NODATA_PRESENT";
/// Cells that were not square, or a rotated grid, were resampled.
pub const NON_SQUARE_CELL: &str = "NON_SQUARE_CELL";
/// Degrees were projected to metres.
pub const GEOGRAPHIC_CRS: &str = "GEOGRAPHIC_CRS";
/// Web Mercator was projected to true metres.
pub const STRETCHED_CRS: &str = "STRETCHED_CRS";
/// Values belonged to points; the raster was moved by half a cell.
pub const HALF_PIXEL_POINT: &str = "HALF_PIXEL_POINT";
/// The smallest step of height is coarse.
pub const HEIGHT_STEP: &str = "HEIGHT_STEP";
/// Feet were converted to metres.
pub const FEET_CONVERTED: &str = "FEET_CONVERTED";
/// Only the first of several bands was read.
pub const FIRST_BAND: &str = "FIRST_BAND";
/// Heights that occur nowhere on Earth, perhaps an undeclared mark for no data.
pub const IMPLAUSIBLE_HEIGHT: &str = "IMPLAUSIBLE_HEIGHT";
/// The file's own cell size was kept against the one in the request.
pub const CELL_SIZE_IGNORED: &str = "CELL_SIZE_IGNORED";

impl Warning {
    /// A remark on the whole.
    pub fn new(code: &'static str, message: impl Into<String>) -> Self {
        Self { code, message: message.into(), count: 1 }
    }

    /// The same remark on `count` cells.
    pub fn with_count(self, count: usize) -> Self {
        Self { count: count as u64, ..self }
    }
}
