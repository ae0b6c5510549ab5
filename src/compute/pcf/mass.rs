//! The expected kernel mass M(r): what a uniform pattern of density 1 adds to a curve, so that
//! the curve divided by it is 1 for independent uniform patterns.

use crate::compute::pcf::Axis;
use crate::compute::pcf::metric::DISJOINT;
use std::f64::consts::PI;

/// Means over the pairs of radii that occur, in the unit of the axis: all that M(r) of disks
/// depends on.
///
/// On the axis m of the disk metric a uniform partner has the density 2π·d·(dd/dm), which is
/// linear in m in each of the three branches, with coefficients that are quadratic in the radii.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RadiusMoments {
    /// Mean of (r1 − r2)².
    difference_sq: f64,
    /// Mean of r1·r2.
    product: f64,
    /// Mean of the smaller radius squared.
    smaller_sq: f64,
    /// Mean of r1 + r2.
    sum: f64,
}

impl RadiusMoments {
    /// Over all pairs of one of `a` with one of `b`, and without pairing an element with itself
    /// when `same` says that both are the same elements. Costs n·log n.
    pub fn of(a: &[f64], b: &[f64], same: bool) -> Self {
        let (na, nb) = (a.len() as f64, b.len() as f64);
        let sum = |values: &[f64], power: i32| values.iter().map(|v| v.powi(power)).sum::<f64>();
        let selves = |power: i32| if same { sum(a, power) } else { 0.0 };
        let pairs = if same { na * (na - 1.0) } else { na * nb };
        if pairs <= 0.0 {
            return Self::default();
        }
        let product = sum(a, 1) * sum(b, 1) - selves(2);
        let squares = nb * sum(a, 2) + na * sum(b, 2) - 2.0 * selves(2);
        Self {
            difference_sq: ((squares - 2.0 * product) / pairs).max(0.0),
            product: (product / pairs).max(0.0),
            smaller_sq: ((smaller_squares(a, b) - selves(2)) / pairs).max(0.0),
            sum: (nb * sum(a, 1) + na * sum(b, 1) - 2.0 * selves(1)) / pairs,
        }
    }
}

/// Σ min(a, b)² over all pairs, by sorting.
fn smaller_squares(a: &[f64], b: &[f64]) -> f64 {
    let sorted = |values: &[f64]| {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        sorted
    };
    let (a, b) = (sorted(a), sorted(b));
    let (mut below, mut below_sq, mut total) = (0, 0.0, 0.0);
    for value in a {
        while below < b.len() && b[below] < value {
            below_sq += b[below] * b[below];
            below += 1;
        }
        total += below_sq + (b.len() - below) as f64 * value * value;
    }
    total
}

/// M(r) of points at every place of `axis`, in the square of its unit: ∫₀^∞ k_σ(r−t)·2πt dt.
pub fn of_points(axis: &Axis) -> Vec<f64> {
    axis.places()
        .iter()
        .map(|r| linear_piece(*r, axis.sigma, Piece { from: 0.0, to: f64::INFINITY, at_0: 0.0, slope: 2.0 * PI }))
        .collect()
}

/// M(r) of disks whose radii have these moments: the same integral over centre distance of
/// k_σ(r − metric), averaged over the pairs of radii. Exact.
pub fn of_disks(axis: &Axis, radii: &RadiusMoments) -> Vec<f64> {
    let RadiusMoments { difference_sq, product, smaller_sq, sum } = *radii;
    let pieces = [
        // Nested: d = (4m − 3)·u with u = r1 − r2.
        Piece { from: 0.75, to: 1.0, at_0: -2.0 * PI * 12.0 * difference_sq, slope: 2.0 * PI * 16.0 * difference_sq },
        // Partly overlapping: d = r1 + (m − 2)·r2.
        Piece { from: 1.0, to: DISJOINT, at_0: 2.0 * PI * (product - 2.0 * smaller_sq), slope: 2.0 * PI * smaller_sq },
        // Disjoint: d = r1 + r2 + (m − 3)/2.
        Piece { from: DISJOINT, to: f64::INFINITY, at_0: PI * (sum - 1.5), slope: PI * 0.5 },
    ];
    let mass = |r: f64| pieces.iter().map(|p| linear_piece(r, axis.sigma, *p)).sum();
    axis.places().into_iter().map(mass).collect()
}

/// M(r) of ellipses whose product of semi-axes is `mean_ab` in the mean, with r in body sizes:
/// mean(a·b)·M(r) in the unit of that product.
pub fn of_ellipses(axis: &Axis, mean_ab: f64) -> Vec<f64> {
    of_points(axis).into_iter().map(|m| m * mean_ab).collect()
}

/// The density `at_0 + slope·m` between `from` and `to`.
#[derive(Debug, Clone, Copy)]
struct Piece {
    from: f64,
    to: f64,
    at_0: f64,
    slope: f64,
}

/// ∫ k_σ(r − m)·(at_0 + slope·m) dm over the piece.
fn linear_piece(r: f64, sigma: f64, piece: Piece) -> f64 {
    let (from, to) = ((piece.from - r) / sigma, (piece.to - r) / sigma);
    let weight = 0.5 * (libm::erf(to) - libm::erf(from));
    let moment = sigma / (2.0 * PI.sqrt()) * (libm::exp(-from * from) - libm::exp(-to * to));
    (piece.at_0 + piece.slope * r) * weight + piece.slope * moment
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::pcf::Metric;

    #[test]
    fn the_mass_of_points_has_its_closed_form() {
        let axis = Axis::default();
        for (r, mass) in axis.places().iter().zip(of_points(&axis)) {
            let closed = 2.0
                * PI
                * (r / 2.0 * (1.0 + libm::erf(r / axis.sigma))
                    + axis.sigma / (2.0 * PI.sqrt()) * libm::exp(-(r / axis.sigma).powi(2)));
            assert!((mass - closed).abs() < 1e-12 * closed);
        }
        let mass = of_points(&axis);
        for (bin, factor) in [(0, 0.760), (1, 0.946), (2, 0.989), (3, 0.998)] {
            assert!((2.0 * PI * axis.r(bin) / mass[bin] - factor).abs() < 6e-4);
        }
    }

    #[test]
    fn the_mass_of_disks_is_the_integral_over_the_centre_distance() {
        let axis = Axis { sigma: 0.25, step: 0.5, extent: 8.0 };
        let (a, b) = ([0.3, 0.7, 0.1], [0.9, 0.2]);
        let moments = RadiusMoments::of(&a, &b, false);
        for (r, mass) in axis.places().iter().zip(of_disks(&axis, &moments)) {
            let mut counted = 0.0;
            for (ra, rb) in a.iter().flat_map(|ra| b.iter().map(move |rb| (ra, rb))) {
                for k in 0..60_000 {
                    let d = (f64::from(k) + 0.5) * 1e-4;
                    let x = (r - Metric::Disk.value(d, *ra, *rb)) / axis.sigma;
                    counted += 2.0 * PI * d * 1e-4 * (-x * x).exp() / (PI.sqrt() * axis.sigma) / 6.0;
                }
            }
            assert!((mass - counted).abs() < 2e-4 * (1.0 + counted), "{r}: {mass} {counted}");
        }
    }

    #[test]
    fn moments_of_one_class_leave_out_the_pairs_with_oneself() {
        let radii = [0.5_f64, 0.2, 0.2, 0.9];
        let mut direct = RadiusMoments::default();
        for (i, a) in radii.iter().enumerate() {
            for (_, b) in radii.iter().enumerate().filter(|(j, _)| i != *j) {
                direct.difference_sq += (a - b).powi(2) / 12.0;
                direct.product += a * b / 12.0;
                direct.smaller_sq += a.min(*b).powi(2) / 12.0;
                direct.sum += (a + b) / 12.0;
            }
        }
        let found = RadiusMoments::of(&radii, &radii, true);
        for (x, y) in [
            (found.difference_sq, direct.difference_sq),
            (found.product, direct.product),
            (found.smaller_sq, direct.smaller_sq),
            (found.sum, direct.sum),
        ] {
            assert!((x - y).abs() < 1e-12);
        }
    }

    #[test]
    fn disks_without_radius_have_the_mass_of_points_on_a_stretched_axis() {
        let axis = Axis { sigma: 0.25, step: 0.1, extent: 9.0 };
        let mass = of_disks(&axis, &RadiusMoments::of(&[0.0; 3], &[0.0; 3], true));
        assert!((mass[79] - PI * 0.5 * (axis.r(79) - 3.0)).abs() < 1e-9);
        assert!(mass[9] < 1e-20);
    }
}
