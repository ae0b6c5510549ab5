use crate::compute::pcf::Axis;
use crate::compute::pcf::Curve;

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
    /// The validity region's lower bound.
    pub(super) lower: Vec<f64>,
    /// Its upper bound.
    pub(super) upper: Vec<f64>,
    /// The triplets; empty when the exemplar has none.
    pub(super) triplets: Vec<f64>,
    /// 1/(density·M(r)) of the partners.
    pub(super) factors: Vec<f64>,
    /// The same of the class, for the partners looking at it.
    pub(super) reverse: Vec<f64>,
}

impl Goal {
    /// The goal of a curve, with the factors of the target domain.
    pub(super) fn new(curve: &Curve, (factors, reverse): (&[f64], &[f64]), sparse: &Sparse) -> Self {
        Self {
            mean: sparse.of_row(&curve.mean),
            lower: sparse.of_row(&curve.lower),
            upper: sparse.of_row(&curve.upper),
            triplets: sparse.of_row(&curve.triplets),
            factors: sparse.of_row(factors),
            reverse: sparse.of_row(reverse),
        }
    }
}
