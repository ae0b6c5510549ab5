//! Colours for maps: continuous colour maps and a palette for categories.
//!
//! All are fit for colour-blind readers. The sequential maps rise steadily in lightness (or fall
//! steadily, on white), so that they also read in grey.
//!
//! Sources: viridis and inferno by S. van der Walt, N. Smith and E. Firing (matplotlib, CC0), here
//! eleven anchors each; YlOrBr, Greens, YlGnBu and RdBu after C. Brewer, colorbrewer2.org
//! (Apache-2.0); the categories are M. Okabe and K. Ito, *Color Universal Design* (2008), and
//! P. Tol, *Colour Schemes* (2021), "muted". The terrain map is ours: green plains to white
//! summits as in hypsometric tints, with lightness rising evenly.

/// Red, green and blue, 0–255, sRGB.
pub type Rgb = [u8; 3];

/// A named continuous colour map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColourMap {
    /// Dark blue to yellow: any quantity.
    Viridis,
    /// Black over red to pale yellow: temperature, sunlight.
    Inferno,
    /// Dark green plains over tan to white summits: height.
    Terrain,
    /// White to brown: densities, as in L figure 13.
    Brown,
    /// White to dark green: cover of plants.
    Green,
    /// Pale yellow to dark blue: moisture, water.
    Water,
    /// Blue over white to red: differences around the middle of the range.
    Diverging,
    /// Black to white.
    Grey,
}

impl ColourMap {
    /// All of them, in the order of [`ColourMap::code`].
    pub const ALL: [Self; 8] = [
        Self::Viridis,
        Self::Inferno,
        Self::Terrain,
        Self::Brown,
        Self::Green,
        Self::Water,
        Self::Diverging,
        Self::Grey,
    ];

    /// Its place in [`ColourMap::ALL`]: how it is stored.
    pub(crate) const fn code(self) -> u8 {
        self as u8
    }

    /// The colour at `t`, 0 at the lower and 1 at the upper end; clamped, NaN is the lower end.
    pub fn at(self, t: f64) -> Rgb {
        let anchors = self.anchors();
        let last = anchors.len() - 1;
        let at = t.clamp(0.0, 1.0) * last as f64;
        let low = (at as usize).min(last - 1);
        let mix = at - low as f64;
        std::array::from_fn(|c| {
            let (a, b) = (channel(anchors[low], c), channel(anchors[low + 1], c));
            let value = a + (b - a) * if mix.is_nan() { 0.0 } else { mix };
            value.round() as u8
        })
    }

    /// The colours at `n` even steps from 0 to 1.
    pub fn table(self, n: usize) -> Vec<Rgb> {
        (0..n).map(|i| self.at(i as f64 / (n.max(2) - 1) as f64)).collect()
    }

    /// Evenly spaced anchors as 0xRRGGBB.
    const fn anchors(self) -> &'static [u32] {
        match self {
            Self::Viridis => &[
                0x0044_0154,
                0x0048_2475,
                0x0041_4487,
                0x0035_5f8d,
                0x002a_788e,
                0x0021_918c,
                0x0022_a884,
                0x0044_bf70,
                0x007a_d151,
                0x00bd_df26,
                0x00fd_e725,
            ],
            Self::Inferno => &[
                0x0000_0004,
                0x0016_0b39,
                0x0042_0a68,
                0x006a_176e,
                0x0093_2667,
                0x00bc_3754,
                0x00dd_513a,
                0x00f3_7819,
                0x00fc_a50a,
                0x00f6_d746,
                0x00fc_ffa4,
            ],
            Self::Terrain => &[
                0x002d_5b4a,
                0x0050_7a50,
                0x0081_975b,
                0x00b0_b06f,
                0x00d2_c592,
                0x00e3_d8ba,
                0x00ef_e9dd,
                0x00fb_fbfa,
            ],
            Self::Brown => &[
                0x00ff_ffff,
                0x00ff_f7bc,
                0x00fe_e391,
                0x00fe_c44f,
                0x00fe_9929,
                0x00ec_7014,
                0x00cc_4c02,
                0x0099_3404,
                0x0066_2506,
            ],
            Self::Green => &[
                0x00ff_ffff,
                0x00e5_f5e0,
                0x00c7_e9c0,
                0x00a1_d99b,
                0x0074_c476,
                0x0041_ab5d,
                0x0023_8b45,
                0x0000_6d2c,
                0x0000_441b,
            ],
            Self::Water => &[
                0x00ff_ffd9,
                0x00ed_f8b1,
                0x00c7_e9b4,
                0x007f_cdbb,
                0x0041_b6c4,
                0x001d_91c0,
                0x0022_5ea8,
                0x0025_3494,
                0x0008_1d58,
            ],
            Self::Diverging => &[
                0x0005_3061,
                0x0021_66ac,
                0x0043_93c3,
                0x0092_c5de,
                0x00d1_e5f0,
                0x00f7_f7f7,
                0x00fd_dbc7,
                0x00f4_a582,
                0x00d6_604d,
                0x00b2_182b,
                0x0067_001f,
            ],
            Self::Grey => &[0x0000_0000, 0x00ff_ffff],
        }
    }
}

fn channel(rgb: u32, c: usize) -> f64 {
    f64::from((rgb >> (16 - 8 * c)) & 0xff)
}

/// The colour of the `i`-th category; after sixteen they repeat.
pub const fn category(i: usize) -> Rgb {
    const COLOURS: [Rgb; 16] = [
        [0, 158, 115],
        [230, 159, 0],
        [86, 180, 233],
        [204, 121, 167],
        [240, 228, 66],
        [0, 114, 178],
        [213, 94, 0],
        [51, 34, 136],
        [153, 153, 51],
        [136, 204, 238],
        [136, 34, 85],
        [17, 119, 51],
        [221, 204, 119],
        [170, 68, 153],
        [68, 170, 153],
        [120, 120, 120],
    ];
    COLOURS[i % COLOURS.len()]
}

/// CIE lightness L* of an sRGB colour, 0–100.
pub fn lightness(rgb: Rgb) -> f64 {
    let linear = |v: u8| {
        let v = f64::from(v) / 255.0;
        if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
    };
    let y = 0.2126 * linear(rgb[0]) + 0.7152 * linear(rgb[1]) + 0.0722 * linear(rgb[2]);
    if y > 216.0 / 24389.0 { 116.0 * y.cbrt() - 16.0 } else { y * 24389.0 / 27.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_are_the_first_and_last_anchor() {
        assert_eq!(ColourMap::Viridis.at(0.0), [0x44, 0x01, 0x54]);
        assert_eq!(ColourMap::Viridis.at(1.0), [0xfd, 0xe7, 0x25]);
        assert_eq!(ColourMap::Viridis.at(f64::NAN), ColourMap::Viridis.at(0.0));
        assert_eq!(ColourMap::Grey.at(0.5), [128, 128, 128]);
        for (i, map) in ColourMap::ALL.into_iter().enumerate() {
            assert_eq!(usize::from(map.code()), i);
        }
    }

    #[test]
    fn sequential_maps_rise_or_fall_steadily_in_lightness() {
        for map in ColourMap::ALL.into_iter().filter(|m| *m != ColourMap::Diverging) {
            let steps: Vec<f64> = map.table(33).into_iter().map(lightness).collect();
            let sign = (steps[32] - steps[0]).signum();
            for pair in steps.windows(2) {
                assert!((pair[1] - pair[0]) * sign > 0.2, "{map:?}: {steps:?}");
            }
        }
    }

    #[test]
    fn the_diverging_map_is_lightest_in_the_middle() {
        let l: Vec<f64> = ColourMap::Diverging.table(21).into_iter().map(lightness).collect();
        assert!(l[..11].windows(2).all(|p| p[0] < p[1]) && l[10..].windows(2).all(|p| p[0] > p[1]));
    }

    #[test]
    fn neighbouring_categories_differ() {
        for i in 0..16 {
            assert!((0..i).all(|j| category(i) != category(j)));
        }
    }
}
