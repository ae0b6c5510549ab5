//! One resource, one species: how much of what a year offers suits the species
//! (L 4.2, T eq. 5.4).

use crate::compute::ecosystem::resources::MONTHS;
use crate::compute::ecosystem::species::Interval;

/// How the months of a year make one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MonthRule {
    /// Their mean (T eq. 5.4; the default, as the published species tables go with it).
    #[default]
    Mean,
    /// The worst of them (L 4.2).
    Minimum,
}

impl MonthRule {
    /// One number from the twelve shares of the months.
    pub fn combine(self, shares: &[f64; MONTHS]) -> f64 {
        match self {
            Self::Mean => shares.iter().sum::<f64>() / MONTHS as f64,
            Self::Minimum => shares.iter().copied().fold(1.0, f64::min),
        }
    }

    /// The same when every share is 0 or 1 and `inside` of them are 1.
    pub(super) fn combine_inside(self, inside: u8) -> f32 {
        match self {
            Self::Mean => f32::from(inside) / MONTHS as f32,
            Self::Minimum => f32::from(u8::from(usize::from(inside) == MONTHS)),
        }
    }
}

/// The part of a resource's **variation** between `low` and `high` that lies in the species'
/// `range`, in 0..=1 (one summand of T eq. 5.4).
///
/// The text's fraction is 0/0 for a variation that is a single value, and negative for disjoint
/// intervals: here it is 1 inside and 0 outside, and clipped. No data (NaN) gives 0.
///
/// ```
/// use biotope::compute::ecosystem::fitness::share_in_range;
/// use biotope::compute::ecosystem::species::Interval;
/// assert_eq!(share_in_range(Interval::new(2.0, 9.0), 1.0, 5.0), 0.75);
/// assert_eq!(share_in_range(Interval::new(2.0, 9.0), 9.0, 9.0), 1.0);
/// assert_eq!(share_in_range(Interval::new(2.0, 9.0), 0.0, 1.5), 0.0);
/// ```
pub fn share_in_range(range: Interval, low: f64, high: f64) -> f64 {
    if low.is_nan() || high.is_nan() {
        return 0.0;
    }
    let (low, high) = (low.min(high), low.max(high));
    if high <= low {
        return f64::from(u8::from(range.contains(low)));
    }
    ((range.max.min(high) - range.min.max(low)) / (high - low)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RANGE: Interval = Interval::new(3.0, 6.0);

    #[test]
    fn a_variation_within_the_range_fits_wholly_and_one_outside_not_at_all() {
        assert_eq!(share_in_range(RANGE, 3.5, 5.5), 1.0);
        assert_eq!(share_in_range(RANGE, 6.5, 7.0), 0.0);
        assert_eq!(share_in_range(RANGE, 2.0, 7.0), 0.6);
        assert_eq!(share_in_range(RANGE, 5.0, 7.0), 0.5);
    }

    #[test]
    fn a_single_value_is_in_or_out_with_both_ends_in() {
        for (value, share) in [(3.0, 1.0), (6.0, 1.0), (4.2, 1.0), (2.999, 0.0), (6.001, 0.0)] {
            assert_eq!(share_in_range(RANGE, value, value), share);
        }
    }

    #[test]
    fn no_data_fits_nothing_and_the_order_of_the_ends_does_not_matter() {
        assert_eq!(share_in_range(RANGE, f64::NAN, 4.0), 0.0);
        assert_eq!(share_in_range(RANGE, 4.0, f64::NAN), 0.0);
        assert_eq!(share_in_range(RANGE, 7.0, 5.0), share_in_range(RANGE, 5.0, 7.0));
    }

    #[test]
    fn the_year_is_the_mean_or_the_worst_month() {
        let mut shares = [1.0; MONTHS];
        shares[0] = 0.4;
        assert!((MonthRule::Mean.combine(&shares) - 0.95).abs() < 1e-12);
        assert_eq!(MonthRule::Minimum.combine(&shares), 0.4);
        assert_eq!(MonthRule::Mean.combine_inside(6), 0.5);
        assert_eq!(MonthRule::Minimum.combine_inside(11), 0.0);
        assert_eq!(MonthRule::Minimum.combine_inside(12), 1.0);
    }
}
