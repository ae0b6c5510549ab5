use crate::compute::pcf::Axis;

/// Kernel rows are kept for this many places between two values of the axis.
const PHASES: usize = 16;

/// In trials the kernel is left out beyond this many σ (5·10⁻⁶ of its peak).
const CUT_OFF_SIGMAS: f64 = 3.5;

/// The kernel over the axis for any distance, from a table: one row a phase, each value an
/// addition.
#[derive(Debug)]
pub(super) struct KernelRows {
    step: f64,
    half: isize,
    rows: Vec<Vec<f64>>,
}

impl KernelRows {
    /// The table of an axis.
    pub(super) fn new(axis: Axis) -> Self {
        let (sigma, step) = (axis.sigma, axis.step);
        let half = (CUT_OFF_SIGMAS * sigma / step).ceil() as isize;
        let value = |phase: usize, k: isize| {
            let x = (k as f64 - phase as f64 / PHASES as f64) * step / sigma;
            libm::exp(-x * x) / (std::f64::consts::PI.sqrt() * sigma)
        };
        let row = |phase: usize| (-half..=half + 1).map(|k| value(phase, k)).collect();
        Self { step, half, rows: (0..PHASES).map(row).collect() }
    }

    /// The first place of the axis, of `bins`, in reach of the kernel around `place`, and the
    /// kernel's values from there on.
    pub(super) fn around(&self, place: f64, bins: usize) -> (usize, &[f64]) {
        let at = (place / self.step * PHASES as f64 + 0.5) as usize;
        let (bin, phase) = ((at / PHASES) as isize - 1, at % PHASES);
        let (first, last) = ((bin - self.half).max(0), (bin + self.half + 1).min(bins as isize - 1));
        if first > last {
            return (0, &[]);
        }
        let from = (first - bin + self.half) as usize;
        (first as usize, &self.rows[phase][from..=from + (last - first) as usize])
    }

    /// Adds `weight` times the kernel around `place` to `row`.
    pub(super) fn add(&self, row: &mut [f64], place: f64, weight: f64) {
        let (first, kernel) = self.around(place, row.len());
        for (value, k) in row[first..].iter_mut().zip(kernel) {
            *value += weight * k;
        }
    }

    /// The farthest place that still adds to a row that ends at `extent`.
    pub(super) fn reach(&self, extent: f64) -> f64 {
        extent + self.half as f64 * self.step
    }
}
