//! Pictures: photos that come in, PNG and animated PNG that go out.

mod photo;
mod write;

pub use photo::{MAX_PIXELS, PhotoError};
pub use write::{Animation, Rgba};

use crate::codec::colours::Rgb;

/// A picture of red, green and blue, 0–255, sRGB.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Pixels, row by row from the top; `rgb.len() == width * height`.
    pub rgb: Vec<Rgb>,
}
