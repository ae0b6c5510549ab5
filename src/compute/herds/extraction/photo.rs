use crate::compute::raster::Grid;
use rayon::prelude::*;

/// A picture with 8 bits each of red, green and blue (sRGB).
#[derive(Debug, Clone, PartialEq)]
pub struct Photo {
    width: usize,
    height: usize,
    rgb: Vec<u8>,
}

impl Photo {
    /// A picture over `rgb`, row-major from the upper left, three bytes a pixel; `None` when a
    /// side is 0 or the count is not 3 × `width` × `height`.
    pub fn new(width: usize, height: usize, rgb: Vec<u8>) -> Option<Self> {
        (width > 0 && height > 0 && rgb.len() == 3 * width * height).then_some(Self { width, height, rgb })
    }

    /// The picture as a map: one pixel a unit, the first row at the top.
    pub const fn grid(&self) -> Grid {
        Grid::new(self.width, self.height, 1.0)
    }

    /// Red, green, blue of the pixel at a place in the row-major order.
    pub fn pixel(&self, index: usize) -> [u8; 3] {
        [self.rgb[3 * index], self.rgb[3 * index + 1], self.rgb[3 * index + 2]]
    }

    /// All bytes, three a pixel.
    pub fn rgb(&self) -> &[u8] {
        &self.rgb
    }

    /// The picture after one pass of the 3 × 3 binomial (1 2 1)ᵀ(1 2 1)/16.
    pub fn blurred(&self) -> Self {
        let (width, height, stride) = (self.width, self.height, 3 * self.width);
        let mut rgb = vec![0u8; self.rgb.len()];
        rgb.par_chunks_mut(stride).enumerate().for_each_init(
            || vec![0u16; stride],
            |sums, (y, out)| {
                let row = |y: usize| &self.rgb[y * stride..(y + 1) * stride];
                let (above, here, below) = (row(y.saturating_sub(1)), row(y), row((y + 1).min(height - 1)));
                for (sum, ((a, h), b)) in sums.iter_mut().zip(above.iter().zip(here).zip(below)) {
                    *sum = u16::from(*a) + 2 * u16::from(*h) + u16::from(*b);
                }
                for x in 0..width {
                    let (left, right) = (3 * x.saturating_sub(1), 3 * (x + 1).min(width - 1));
                    for c in 0..3 {
                        out[3 * x + c] = ((sums[left + c] + 2 * sums[3 * x + c] + sums[right + c] + 8) >> 4) as u8;
                    }
                }
            },
        );
        Self { width, height, rgb }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_blur_keeps_flat_colour_and_spreads_a_point_by_binomial_weights() {
        let flat = Photo::new(4, 3, vec![77; 36]).unwrap();
        assert_eq!(flat.blurred(), flat);
        let mut rgb = vec![0; 75];
        rgb[3 * 12] = 160;
        let point = Photo::new(5, 5, rgb).unwrap().blurred();
        assert_eq!(point.pixel(12), [40, 0, 0]);
        assert_eq!((point.pixel(11)[0], point.pixel(6)[0], point.pixel(10)[0]), (20, 10, 0));
    }

    #[test]
    fn a_picture_of_the_wrong_size_is_none() {
        assert!(Photo::new(2, 2, vec![0; 11]).is_none());
        assert!(Photo::new(0, 2, vec![]).is_none());
    }
}
