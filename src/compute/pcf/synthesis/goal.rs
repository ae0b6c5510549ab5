use super::kernel_rows::KernelRows;
use crate::compute::pcf::Axis;
use crate::compute::pcf::Curve;
use crate::compute::pcf::RELATIVE_FLOOR;

/// Trials look at every place of the axis that is at least this many σ from the last: a curve
/// smoothed by k_σ says no more in between.
const SPARSE_STEP_IN_SIGMAS: f64 = 0.8;

/// The places of an axis that trials look at: every so many.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sparse {
    /// The axis of those places.
    pub(super) axis: Axis,
    stride: usize,
}

impl Sparse {
    /// The sparse places of `axis`.
    pub(super) fn of(axis: Axis) -> Self {
        let stride = ((SPARSE_STEP_IN_SIGMAS * axis.sigma / axis.step + 1e-9) as usize).clamp(1, axis.bins());
        let step = axis.step * stride as f64;
        Self { axis: Axis { step, extent: (axis.bins() / stride) as f64 * step, ..axis }, stride }
    }

    /// Number of places.
    pub(super) fn bins(&self) -> usize {
        self.axis.bins()
    }

    /// The values of `row` at those places; none of an empty row.
    pub(super) fn of_row(&self, row: &[f64]) -> Vec<f64> {
        row.iter().skip(self.stride - 1).step_by(self.stride).copied().collect()
    }
}

/// What a class is to see in one view, at the sparse places.
#[derive(Debug, Clone)]
pub(super) struct Goal {
    /// The curve.
    pub(super) mean: Vec<f64>,
    /// The same as an aligned row.
    pub(super) mean_row: Vec<f32>,
    /// The triplets; empty when the exemplar has none.
    pub(super) triplets: Vec<f64>,
    /// 1/(density·M(r)) of the partners, an aligned row.
    pub(super) factors: Vec<f32>,
    /// The same of the class, for the partners looking at it.
    pub(super) reverse: Vec<f32>,
    /// How a kernel sum leaves the validity region.
    pub(super) bounds: Bounds,
}

/// By how much of a bound a kernel sum passes it: value·slope + offset, positive outside; aligned
/// rows.
#[derive(Debug, Clone)]
pub(super) struct Bounds {
    /// Slope and offset above the upper bound.
    pub(super) above: (Vec<f32>, Vec<f32>),
    /// The same below the lower bound.
    pub(super) below: (Vec<f32>, Vec<f32>),
    /// The same for kernel sums summed up to each place, below the least of the exemplar's.
    pub(super) near: (Vec<f32>, Vec<f32>),
    /// The same where circles are cut off by the border.
    pub(super) near_border: (Vec<f32>, Vec<f32>),
}

impl Bounds {
    fn new(curve: &Curve, factors: &[f64], (sparse, rows): (&Sparse, &KernelRows)) -> Self {
        let sided = |sign: f64, bound: &[f64]| {
            let bound = sparse.of_row(bound);
            let slope = bound.iter().zip(factors).map(|(b, f)| sign * f / b.max(RELATIVE_FLOOR));
            let can_lie = |f: &f64| f64::from(u8::from(*f > 0.0));
            let offset = bound.iter().zip(factors).map(|(b, f)| -sign * can_lie(f) * b / b.max(RELATIVE_FLOOR));
            (rows.aligned(slope), rows.aligned(offset))
        };
        let near = |least: &[f64]| {
            let (least, mut mass) = (sparse.of_row(least), 0.0);
            let slope = least.iter().zip(factors).map(|(least, factor)| {
                mass += if *factor > 0.0 { 1.0 / factor } else { 0.0 };
                if mass > 0.0 { -1.0 / (mass * least.max(RELATIVE_FLOOR)) } else { 0.0 }
            });
            let slope = rows.aligned(slope);
            (slope, rows.aligned(least.iter().map(|least| least / least.max(RELATIVE_FLOOR))))
        };
        Self {
            above: sided(1.0, &curve.upper),
            below: sided(-1.0, &curve.lower),
            near: near(&curve.least_near),
            near_border: near(&curve.least_near_border),
        }
    }
}

impl Goal {
    /// The goal of a curve, with the factors of the target domain.
    pub(super) fn new(
        curve: &Curve,
        (factors, reverse): (&[f64], &[f64]),
        (sparse, rows): (&Sparse, &KernelRows),
    ) -> Self {
        let factors = sparse.of_row(factors);
        Self {
            mean: sparse.of_row(&curve.mean),
            mean_row: rows.aligned(sparse.of_row(&curve.mean)),
            triplets: sparse.of_row(&curve.triplets),
            bounds: Bounds::new(curve, &factors, (sparse, rows)),
            factors: rows.aligned(factors),
            reverse: rows.aligned(sparse.of_row(reverse)),
        }
    }
}
