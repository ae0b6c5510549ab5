use crate::compute::pcf::PcfError;

/// Beyond this many σ the kernel is left out: e⁻²⁵ of its peak.
const CUT_OFF_SIGMAS: f64 = 5.0;

/// The most values a curve may have.
pub const MAX_BINS: usize = 2_000;

/// Where a correlation curve is evaluated, and how it is smoothed: at `step`, 2 `step`, …
/// `extent`, all in the units of the metric (r_max for points and disks, body sizes for
/// ellipses).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// Smoothness σ of the kernel k_σ(x) = exp(−x²/σ²)/(√π·σ), a Gaussian of standard deviation
    /// σ/√2. Positive. Default: 0.25 (T 3.6.1).
    pub sigma: f64,
    /// Distance between two values of the curve. Positive. Default: 0.1 (T 3.6.1).
    pub step: f64,
    /// Where the curve ends, at least `step`. Default: 5 for points and ellipses (T 3.6.1).
    pub extent: f64,
}

impl Default for Axis {
    fn default() -> Self {
        Self { sigma: 0.25, step: 0.1, extent: 5.0 }
    }
}

impl Axis {
    /// The default axis with another extent.
    pub fn with_extent(extent: f64) -> Self {
        Self { extent, ..Self::default() }
    }

    /// Checks the three numbers.
    ///
    /// # Errors
    /// [`PcfError::Axis`] when one is not positive and finite, when step or σ exceed the extent,
    /// or when the curve would have more than [`MAX_BINS`] values.
    pub fn checked(self) -> Result<Self, PcfError> {
        let fault = |field, expected, found| Err(PcfError::Axis { field, expected, found });
        let positive = |v: f64| v.is_finite() && v > 0.0;
        match self {
            Self { sigma, .. } if !positive(sigma) => fault("sigma", "a positive number", sigma),
            Self { step, .. } if !positive(step) => fault("step", "a positive number", step),
            Self { extent, .. } if !positive(extent) => fault("extent", "a positive number", extent),
            Self { step, extent, .. } if step > extent => fault("step", "at most the extent", step),
            Self { sigma, extent, .. } if sigma > extent => fault("sigma", "at most the extent", sigma),
            Self { step, extent, .. } if extent / step > MAX_BINS as f64 => {
                fault("step", "a step that gives at most 2000 values", step)
            }
            _ => Ok(self),
        }
    }

    /// Number of values.
    pub fn bins(&self) -> usize {
        ((self.extent / self.step + 1e-9) as usize).max(1)
    }

    /// Number of values up to `place`.
    pub fn bins_up_to(&self, place: f64) -> usize {
        ((place / self.step + 1e-9).max(0.0) as usize).min(self.bins())
    }

    /// The place of value `bin`.
    pub fn r(&self, bin: usize) -> f64 {
        (bin + 1) as f64 * self.step
    }

    /// All places, ascending.
    pub fn places(&self) -> Vec<f64> {
        (0..self.bins()).map(|bin| self.r(bin)).collect()
    }

    /// The largest distance at which a pair still adds to the curve.
    pub fn reach(&self) -> f64 {
        self.extent + CUT_OFF_SIGMAS * self.sigma
    }
}

/// The kernel k_σ over the places of an [`Axis`], ready to be added for many pairs.
///
/// exp(−(x + kδ)²/σ²) is exp(−x²/σ²)·exp(−2xδ/σ²)ᵏ·exp(−k²δ²/σ²): one pair costs two
/// exponentials, whatever the number of places in reach.
#[derive(Debug, Clone)]
pub struct Kernel {
    axis: Axis,
    bins: usize,
    sigma: f64,
    peak: f64,
    steps: Vec<f64>,
}

impl Kernel {
    /// The kernel over `axis`.
    pub fn new(axis: Axis) -> Self {
        Self::gaussian(axis, axis.sigma, 1.0 / (std::f64::consts::PI.sqrt() * axis.sigma))
    }

    /// The square of the kernel at every place: a Gaussian too.
    pub fn squared(&self) -> Self {
        Self::gaussian(self.axis, self.sigma * std::f64::consts::FRAC_1_SQRT_2, self.peak * self.peak)
    }

    fn gaussian(axis: Axis, sigma: f64, peak: f64) -> Self {
        let half = (CUT_OFF_SIGMAS * axis.sigma / axis.step) as usize + 1;
        let step = |k: usize| libm::exp(-(k as f64 * axis.step / sigma).powi(2));
        Self { axis, bins: axis.bins(), sigma, peak, steps: (0..=half).map(step).collect() }
    }

    /// The axis.
    pub fn axis(&self) -> Axis {
        self.axis
    }

    /// Adds `weight`·k_σ(r − distance) to `row` at every place r; `row` has one value a place.
    pub fn add(&self, row: &mut [f64], distance: f64, weight: f64) {
        let (sigma, step) = (self.sigma, self.axis.step);
        let nearest = (distance / step).round() as isize - 1;
        let half = self.steps.len() as isize - 1;
        let (first, last) = ((nearest - half).max(0), (nearest + half).min(self.bins as isize - 1));
        if first > last {
            return;
        }
        let middle = nearest.clamp(first, last);
        let x = (middle + 1) as f64 * step - distance;
        let peak = weight * self.peak * libm::exp(-(x / sigma).powi(2));
        let ratio = libm::exp(-2.0 * x * step / (sigma * sigma));
        let mut upward = peak;
        for bin in middle..=last {
            row[bin as usize] += upward * self.steps[(bin - middle) as usize];
            upward *= ratio;
        }
        let back = 1.0 / ratio;
        let mut downward = peak * back;
        for bin in (first..middle).rev() {
            row[bin as usize] += downward * self.steps[(middle - bin) as usize];
            downward *= back;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn adding_a_pair_gives_the_kernel_at_every_place() {
        let axis = Axis { sigma: 0.25, step: 0.1, extent: 5.0 };
        let kernel = Kernel::new(axis);
        for distance in [0.0, 0.04, 0.1, 1.234, 2.05, 4.97, 5.3, 6.1, 7.0] {
            let mut row = vec![0.0; axis.bins()];
            kernel.add(&mut row, distance, 2.0);
            for (bin, value) in row.iter().enumerate() {
                let x = axis.r(bin) - distance;
                let exact = 2.0 * (-(x / 0.25_f64).powi(2)).exp() / (std::f64::consts::PI.sqrt() * 0.25);
                assert!((value - exact).abs() < 1e-9, "{distance} {bin}: {value} {exact}");
            }
        }
    }

    #[test]
    fn the_square_of_the_kernel_is_its_square() {
        let kernel = Kernel::new(Axis::default());
        for distance in [0.33, 1.0, 4.9] {
            let (mut row, mut square) = (vec![0.0; 50], vec![0.0; 50]);
            kernel.add(&mut row, distance, 1.5);
            kernel.squared().add(&mut square, distance, 2.25);
            assert!(row.iter().zip(&square).all(|(k, s)| (k * k - s).abs() < 1e-9));
        }
    }

    #[test]
    fn the_default_axis_has_fifty_places_from_a_tenth_to_five() {
        let places = Axis::default().places();
        assert_eq!(places.len(), 50);
        assert!((places[0] - 0.1).abs() < 1e-12 && (places[49] - 5.0).abs() < 1e-12);
    }

    #[test]
    fn an_axis_that_makes_no_sense_is_refused() {
        let axis = |sigma, step, extent| Axis { sigma, step, extent }.checked();
        for (bad, at) in [
            (axis(0.0, 0.1, 5.0), "sigma"),
            (axis(-1.0, 0.1, 5.0), "sigma"),
            (axis(1e9, 0.1, 5.0), "sigma"),
            (axis(0.25, f64::NAN, 5.0), "step"),
            (axis(0.25, 6.0, 5.0), "step"),
            (axis(0.25, 1e-9, 5.0), "step"),
            (axis(0.25, 0.1, f64::INFINITY), "extent"),
        ] {
            assert!(matches!(bad, Err(PcfError::Axis { field, .. }) if field == at));
        }
    }
}
