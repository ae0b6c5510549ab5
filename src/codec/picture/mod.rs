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

impl Image {
    /// The same picture with no side longer than `side`: means over squares of whole pixels. What
    /// is left over at the right and lower rim is cut off.
    pub fn shrunk(&self, side: usize) -> Self {
        let factor = self.width.max(self.height).div_ceil(side.max(1)).max(1);
        let (width, height) = ((self.width / factor).max(1), (self.height / factor).max(1));
        let mean = |i: usize| {
            let (left, top) = (i % width * factor, i / width * factor);
            let rows = top..(top + factor).min(self.height);
            let (mut sum, mut count) = ([0u32; 3], 0);
            for row in rows {
                let from = row * self.width + left;
                for pixel in &self.rgb[from..from + factor.min(self.width - left)] {
                    (0..3).for_each(|c| sum[c] += u32::from(pixel[c]));
                    count += 1;
                }
            }
            sum.map(|s| ((s + count / 2) / count.max(1)) as u8)
        };
        Self { width, height, rgb: (0..width * height).map(mean).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shrunk_picture_keeps_its_mean_and_a_small_one_every_pixel() {
        let rgb = (0..60 * 40).map(|i| [(i % 60) as u8 * 4, 90, 200]).collect();
        let picture = Image { width: 60, height: 40, rgb };
        let small = picture.shrunk(20);
        assert_eq!((small.width, small.height, small.rgb[0], small.rgb[19]), (20, 13, [4, 90, 200], [232, 90, 200]));
        assert_eq!(picture.shrunk(60), picture);
        assert_eq!(picture.shrunk(1).rgb.len(), 1);
    }
}
