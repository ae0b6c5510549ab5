use super::ellipses::Shape;
use crate::compute::raster::Grid;

/// Why a region may not be one animal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Suspicion {
    /// Much larger or smaller than the others: several animals, or a part of one.
    Size,
    /// Much longer or rounder than the others.
    Proportion,
    /// Far from an ellipse.
    Shape,
}

/// When a region is flagged. The text looks at "the distribution of region sizes" (T 4.2.1)
/// without numbers; these are ours.
#[derive(Debug, Clone, PartialEq)]
pub struct OutlierOptions {
    /// Flagged when the logarithm of its area or aspect lies more than this many standard
    /// deviations (estimated from the median absolute deviation) from the median. Default: 3.
    pub deviations: f64,
    /// That standard deviation is taken as at least this, so that herds of near-equal animals
    /// are not combed. Default: 0.15, about 15 %.
    pub least_deviation: f64,
    /// Flagged when it fills less than this share of its ellipse. Default: 0.88.
    pub least_fill: f64,
}

impl Default for OutlierOptions {
    fn default() -> Self {
        Self { deviations: 3.0, least_deviation: 0.15, least_fill: 0.88 }
    }
}

/// What speaks against each region being one animal.
pub(super) fn suspicions(shapes: &[&Shape], options: &OutlierOptions) -> Vec<Vec<Suspicion>> {
    let unit = Grid::new(1, 1, 1.0);
    let aspect = |s: &Shape| {
        let e = s.ellipse(unit);
        libm::log(e.a / e.b)
    };
    let size = outlying(shapes.iter().map(|s| libm::log(s.area())).collect(), options);
    let proportion = outlying(shapes.iter().map(|s| aspect(s)).collect(), options);
    (0..shapes.len())
        .map(|i| {
            let reasons = [
                (size[i], Suspicion::Size),
                (proportion[i], Suspicion::Proportion),
                (shapes[i].fill() < options.least_fill, Suspicion::Shape),
            ];
            reasons.into_iter().filter(|(holds, _)| *holds).map(|(_, reason)| reason).collect()
        })
        .collect()
}

fn outlying(values: Vec<f64>, options: &OutlierOptions) -> Vec<bool> {
    let middle = median(values.clone());
    let deviation = 1.4826 * median(values.iter().map(|v| (v - middle).abs()).collect());
    let limit = options.deviations * deviation.max(options.least_deviation);
    values.into_iter().map(|v| (v - middle).abs() > limit).collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}
