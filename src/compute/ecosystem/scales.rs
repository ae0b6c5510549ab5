//! From physical quantities to the scales 1–9 of T table A.1, and back.
//!
//! The scales are those of Julve (and Ellenberg): a larger value is warmer, lighter, wetter.
//! The papers give no conversion. Two presets:
//!
//! * [`Scales::authors`] (default): the linear ones of the authors' sample. Temperature from
//!   −15 °C (1) to 25 °C (9), light fraction from 0.01 (1) to 0.25 (9), wetness index from −8 (1)
//!   to 2 (9).
//! * [`Scales::julve`]: the physical anchors that Tela Botanica prints beside the scales.
//!
//! Conversions are strictly increasing and go on outside 1–9 with the slope of their end
//! segments, so nothing is lost; [`Scale::clamped`] cuts at 1 and 9.

use crate::compute::ecosystem::species::Interval;

/// Both ends of a scale.
pub const ENDS: Interval = Interval::new(1.0, 9.0);

/// How a quantity is read between the knots of a [`Scale`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spacing {
    /// Linearly.
    Linear,
    /// Linearly in its logarithm; below [`Scale::SMALLEST`] it counts as that.
    Logarithmic,
}

/// A strictly increasing conversion from a physical quantity to the scale 1–9.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// The quantity (or its natural logarithm) at 1, 2, … 9; strictly increasing.
    knots: [f64; 9],
    spacing: Spacing,
}

impl Scale {
    /// What a quantity of logarithmic spacing is at least taken for.
    pub const SMALLEST: f64 = 1e-6;

    /// The linear scale that is 1 at `one` and 9 at `nine` (`one < nine`).
    pub fn linear(one: f64, nine: f64) -> Self {
        Self { knots: std::array::from_fn(|k| one + (nine - one) * k as f64 / 8.0), spacing: Spacing::Linear }
    }

    /// The scale that is 1, 2, … 9 at `values`; `None` unless they are finite, strictly
    /// increasing and, for logarithmic spacing, at least [`Scale::SMALLEST`].
    pub fn through(values: [f64; 9], spacing: Spacing) -> Option<Self> {
        let in_order = values.windows(2).all(|w| w[0] < w[1]) && values.iter().all(|v| v.is_finite());
        let in_domain = spacing == Spacing::Linear || values[0] >= Self::SMALLEST;
        let scale = Self { knots: values, spacing };
        (in_order && in_domain).then(|| Self { knots: values.map(|v| scale.warp(v)), spacing })
    }

    /// `quantity` on the scale, not clamped. Not a number stays so.
    pub fn at(&self, quantity: f64) -> f64 {
        let x = self.warp(quantity);
        let k = self.knots[1..8].iter().filter(|knot| **knot <= x).count();
        let (low, high) = (self.knots[k], self.knots[k + 1]);
        (k + 1) as f64 + (x - low) / (high - low)
    }

    /// `quantity` on the scale, cut at 1 and 9.
    pub fn clamped(&self, quantity: f64) -> f64 {
        self.at(quantity).clamp(ENDS.min, ENDS.max)
    }

    /// The quantity that is at `value` on the scale.
    pub fn inverse(&self, value: f64) -> f64 {
        let k = (value.floor() as isize - 1).clamp(0, 7) as usize;
        let (low, high) = (self.knots[k], self.knots[k + 1]);
        let x = low + (high - low) * (value - (k + 1) as f64);
        match self.spacing {
            Spacing::Linear => x,
            Spacing::Logarithmic => libm::exp(x),
        }
    }

    fn warp(&self, quantity: f64) -> f64 {
        match self.spacing {
            Spacing::Linear => quantity,
            Spacing::Logarithmic if quantity.is_nan() => quantity,
            Spacing::Logarithmic => libm::log(quantity.max(Self::SMALLEST)),
        }
    }
}

/// How soil moisture is read from the wetness index.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MoistureScale {
    /// The **wetness index** of a month (see `climate::moisture`), linearly.
    WetnessIndex {
        /// The index at 1.
        one: f64,
        /// The index at 9, above `one`.
        nine: f64,
    },
    /// The **relative extractable water** over the year, 0..=1, the same in all months.
    ExtractableWater(Scale),
}

/// The conversions that one solve uses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scales {
    /// From °C.
    pub temperature: Scale,
    /// From the light fraction (see `climate::sunlight`).
    pub illumination: Scale,
    /// From the wetness of the ground.
    pub moisture: MoistureScale,
}

impl Default for Scales {
    fn default() -> Self {
        Self::authors()
    }
}

impl Scales {
    /// The linear conversions of the sample that the authors of L published.
    pub fn authors() -> Self {
        Self {
            temperature: Scale::linear(-15.0, 25.0),
            illumination: Scale::linear(0.01, FULL_LIGHT),
            moisture: MoistureScale::WetnessIndex { one: -8.0, nine: 2.0 },
        }
    }

    /// The physical anchors of Julve's scales as Tela Botanica prints them: mean annual
    /// temperature, and light in lux against the 100 000 lux of open ground, which we set equal
    /// to [`FULL_LIGHT`]. The printed temperatures at 4 and 5 overlap (9, then 7–10 °C): we take 9
    /// and 10. For humidity only words are printed; the shares of extractable water are ours.
    pub fn julve() -> Self {
        let lux = [1e-4, 5e-4, 1e-3, 0.01, 0.05, 0.10, 0.50, 0.75, 1.0];
        Self {
            temperature: Scale { knots: [0.0, 5.0, 7.0, 9.0, 10.0, 12.0, 13.0, 15.0, 18.0], spacing: Spacing::Linear },
            illumination: Scale {
                knots: lux.map(|share| libm::log(share * FULL_LIGHT)),
                spacing: Spacing::Logarithmic,
            },
            moisture: MoistureScale::ExtractableWater(Scale {
                knots: [0.02, 0.08, 0.18, 0.32, 0.50, 0.70, 0.90, 0.98, 1.0],
                spacing: Spacing::Linear,
            }),
        }
    }
}

/// The light fraction from which ground counts as fully lit: 9 on the authors' scale.
pub const FULL_LIGHT: f64 = 0.25;

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> Vec<Scale> {
        [Scales::authors(), Scales::julve()]
            .into_iter()
            .flat_map(|s| {
                let moisture = match s.moisture {
                    MoistureScale::WetnessIndex { one, nine } => Scale::linear(one, nine),
                    MoistureScale::ExtractableWater(scale) => scale,
                };
                [s.temperature, s.illumination, moisture]
            })
            .collect()
    }

    #[test]
    fn the_authors_ends_are_one_and_nine() {
        let s = Scales::default();
        assert_eq!((s.temperature.at(-15.0), s.temperature.at(25.0)), (1.0, 9.0));
        assert_eq!(s.temperature.at(5.0), 5.0);
        assert!((s.illumination.at(0.01) - 1.0).abs() < 1e-12 && (s.illumination.at(0.25) - 9.0).abs() < 1e-12);
        assert_eq!(s.temperature.at(30.0), 10.0);
        assert_eq!(s.temperature.clamped(30.0), 9.0);
        assert_eq!(s.temperature.clamped(-40.0), 1.0);
    }

    #[test]
    fn julves_anchors_are_met() {
        let s = Scales::julve();
        assert_eq!(s.temperature.at(12.0), 6.0);
        assert_eq!(s.temperature.at(18.0), 9.0);
        assert!((s.illumination.at(0.5 * FULL_LIGHT) - 7.0).abs() < 1e-9);
        assert!((s.illumination.at(1e-3 * FULL_LIGHT) - 3.0).abs() < 1e-9);
        assert!(s.illumination.at(0.0).is_finite());
    }

    #[test]
    fn every_conversion_is_increasing_and_undone_by_its_inverse() {
        for scale in all() {
            let values = (-5..=70).map(|i| 0.2 * f64::from(i)).map(|v| (v, scale.inverse(v)));
            let mut last = f64::NEG_INFINITY;
            for (value, quantity) in values {
                assert!(quantity > last, "{scale:?} at {value}");
                last = quantity;
                if quantity >= Scale::SMALLEST || scale.spacing == Spacing::Linear {
                    assert!((scale.at(quantity) - value).abs() < 1e-9, "{scale:?} at {value}");
                }
            }
        }
    }

    #[test]
    fn a_scale_must_increase() {
        assert!(Scale::through([1.0; 9], Spacing::Linear).is_none());
        let values = std::array::from_fn(|k| k as f64);
        assert_eq!(Scale::through(values, Spacing::Linear).map(|s| s.at(3.5)), Some(4.5));
        assert!(Scale::through(values, Spacing::Logarithmic).is_none(), "the logarithm of 0");
    }

    #[test]
    fn what_is_not_a_number_stays_so() {
        assert!(all().into_iter().all(|s| s.at(f64::NAN).is_nan()));
    }
}
