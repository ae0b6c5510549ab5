//! Colours as the classifier sees them, and the table of all of them.

/// Bits kept of each of red, green and blue: steps of 4 in 256, finer than a photo's noise.
const BITS: u32 = 6;

/// Number of quantised colours.
pub(super) const COLOURS: usize = 1 << (3 * BITS);

/// The place of a colour in the table of quantised colours.
pub(super) fn quantise([r, g, b]: [u8; 3]) -> usize {
    let part = |v: u8| usize::from(v >> (8 - BITS));
    (part(r) << (2 * BITS)) | (part(g) << BITS) | part(b)
}

/// The colour in the middle of a place in the table.
pub(super) fn representative(index: usize) -> [f64; 3] {
    let step = f64::from(1u32 << (8 - BITS));
    let part = |shift: u32| ((index >> shift) & ((1 << BITS) - 1)) as f64 * step + (step - 1.0) / 2.0;
    [part(2 * BITS), part(BITS), part(0)]
}

/// CIE L\*a\*b\* (D65) of an sRGB colour of 0..255 per part (IEC 61966-2-1, CIE 15): distances
/// in it follow what people see as alike.
pub(super) fn lab(rgb: [f64; 3]) -> [f64; 3] {
    let linear = rgb.map(|v| {
        let v = v / 255.0;
        if v <= 0.04045 { v / 12.92 } else { libm::pow((v + 0.055) / 1.055, 2.4) }
    });
    let mix = |w: [f64; 3]| linear[0] * w[0] + linear[1] * w[1] + linear[2] * w[2];
    let f = |t: f64| if t > 216.0 / 24389.0 { libm::cbrt(t) } else { (24389.0 / 27.0 * t + 16.0) / 116.0 };
    let x = f(mix([0.412_456_4, 0.357_576_1, 0.180_437_5]) / 0.950_47);
    let y = f(mix([0.212_672_9, 0.715_152_2, 0.072_175_0]));
    let z = f(mix([0.019_333_9, 0.119_192_0, 0.950_304_1]) / 1.088_83);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_colours_have_their_published_lab_values() {
        let near = |rgb: [f64; 3], expected: [f64; 3]| {
            let found = lab(rgb);
            for i in 0..3 {
                assert!((found[i] - expected[i]).abs() < 0.02, "{rgb:?}: {found:?}");
            }
        };
        near([255.0; 3], [100.0, 0.0, 0.0]);
        near([0.0; 3], [0.0, 0.0, 0.0]);
        near([255.0, 0.0, 0.0], [53.24, 80.09, 67.20]);
        near([0.0, 0.0, 255.0], [32.30, 79.19, -107.86]);
    }

    #[test]
    fn a_quantised_colour_is_within_two_levels_of_its_representative() {
        for rgb in [[0u8, 255, 17], [128, 3, 250], [64, 63, 65]] {
            let back = representative(quantise(rgb));
            assert!(quantise(rgb) < COLOURS);
            for i in 0..3 {
                assert!((f64::from(rgb[i]) - back[i]).abs() <= 2.0);
            }
        }
    }
}
