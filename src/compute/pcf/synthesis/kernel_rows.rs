use crate::compute::pcf::Axis;
use std::ops::Range;

/// Kernel rows are kept for this many places between two values of the axis.
const PHASES: usize = 16;

/// In trials the kernel is left out beyond this many σ (5·10⁻⁶ of its peak).
const CUT_OFF_SIGMAS: f64 = 3.5;

/// Partners more than this many σ beyond the end of the axis are left out: of the kernel around
/// the end 2·10⁻⁴ lie there.
const TAIL_SIGMAS: f64 = 2.5;

/// Values that are worked on together.
pub(super) const LANES: usize = 4;

/// The kernel over the axis for any distance, from a table: one row a phase, each value an
/// addition.
///
/// The rows it is added to are aligned: they have room for a whole kernel before and behind the
/// axis, so that no pair is a special case; what is added there is never looked at.
#[derive(Debug)]
pub(super) struct KernelRows {
    per_step: f64,
    step: f64,
    tail: f64,
    half: usize,
    width: usize,
    bins: usize,
    rows: Vec<f32>,
}

impl KernelRows {
    /// The table of an axis.
    pub(super) fn new(axis: Axis) -> Self {
        let (sigma, step) = (axis.sigma, axis.step);
        let half = (CUT_OFF_SIGMAS * sigma / step).ceil() as usize;
        let width = (2 * half + 2).next_multiple_of(LANES);
        let value = |phase: usize, k: usize| {
            let x = (k as f64 - half as f64 - phase as f64 / PHASES as f64) * step / sigma;
            let value = libm::exp(-x * x) / (std::f64::consts::PI.sqrt() * sigma);
            if k < 2 * half + 2 { value as f32 } else { 0.0 }
        };
        let row = |phase: usize| (0..width).map(move |k| value(phase, k));
        Self {
            per_step: PHASES as f64 / step,
            step,
            tail: TAIL_SIGMAS * sigma,
            half,
            width,
            bins: axis.bins(),
            rows: (0..PHASES).flat_map(row).collect(),
        }
    }

    /// A row of zeros.
    pub(super) fn zeros(&self) -> Vec<f32> {
        vec![0.0; (self.bins + 2 * self.width + 1).next_multiple_of(LANES)]
    }

    /// The row of these values, one a place of the axis; zeros when there are none.
    pub(super) fn aligned(&self, values: impl IntoIterator<Item = f64>) -> Vec<f32> {
        let mut row = self.zeros();
        row[self.axis()].iter_mut().zip(values).for_each(|(to, from)| *to = from as f32);
        row
    }

    /// Where the values of the axis are in a row.
    pub(super) fn axis(&self) -> Range<usize> {
        self.width..self.width + self.bins
    }

    /// The same, up to a whole number of [`LANES`]: behind the axis factors and weights are 0.
    pub(super) fn lanes(&self) -> Range<usize> {
        self.width..self.width + self.bins.next_multiple_of(LANES)
    }

    /// The first value of a row in reach of the kernel around `place`, at most
    /// [`KernelRows::reach`], and the kernel's values from there on.
    pub(super) fn around(&self, place: f64) -> (usize, &[f32]) {
        let at = (place * self.per_step + 0.5) as usize;
        let (bin, phase) = ((at / PHASES).min(self.bins + self.half + 1), at % PHASES);
        (bin + self.width - 1 - self.half, &self.rows[phase * self.width..(phase + 1) * self.width])
    }

    /// Adds `weight` times the kernel around `place` to `row`.
    pub(super) fn add(&self, row: &mut [f32], place: f64, weight: f64) {
        let (first, kernel) = self.around(place);
        add(&mut row[first..], kernel, weight as f32);
    }

    /// The farthest place that still adds to a row that ends at `extent`.
    pub(super) fn reach(&self, extent: f64) -> f64 {
        extent + (self.half as f64 * self.step).min(self.tail)
    }
}

/// Adds `weight` times `kernel` to the beginning of `row`.
pub(super) fn add(row: &mut [f32], kernel: &[f32], weight: f32) {
    let (kernel, _) = kernel.as_chunks::<LANES>();
    let (row, _) = row.as_chunks_mut::<LANES>();
    for (row, kernel) in row.iter_mut().zip(kernel) {
        for (value, k) in row.iter_mut().zip(kernel) {
            *value += weight * k;
        }
    }
}

/// Adds the squares of `weight` times `kernel` to the beginning of `row`.
pub(super) fn add_squares(row: &mut [f32], kernel: &[f32], weight: f32) {
    add_products(row, (kernel, kernel), weight * weight);
}

/// Adds `weight` times the products of `kernel` and `other` to the beginning of `row`.
pub(super) fn add_products(row: &mut [f32], (kernel, other): (&[f32], &[f32]), weight: f32) {
    let (row, _) = row.as_chunks_mut::<LANES>();
    let terms = kernel.as_chunks::<LANES>().0.iter().zip(other.as_chunks::<LANES>().0);
    for (row, (kernel, other)) in row.iter_mut().zip(terms) {
        for lane in 0..LANES {
            row[lane] += weight * kernel[lane] * other[lane];
        }
    }
}
