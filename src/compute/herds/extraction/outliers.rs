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
    /// are not combed. Default: 0.2, about 20 %, so that a size
    /// between 0.55 and 1.8 of the usual passes and two animals in one region do not.
    pub least_deviation: f64,
    /// Flagged when it fills less than this share of its ellipse. Default: 0.88.
    pub least_fill: f64,
}

impl Default for OutlierOptions {
    fn default() -> Self {
        Self { deviations: 3.0, least_deviation: 0.2, least_fill: 0.88 }
    }
}

/// The fewest marked regions that can speak for all.
const LEAST_SAMPLE: usize = 5;

/// What speaks against each region being one animal. Its size and proportion are judged by the
/// regions of which `typical` says that the user marked them as animals, when there are at least
/// five, else by all.
pub(super) fn suspicions(shapes: &[&Shape], typical: &[bool], options: &OutlierOptions) -> Vec<Vec<Suspicion>> {
    let unit = Grid::new(1, 1, 1.0);
    let aspect = |s: &Shape| {
        let e = s.ellipse(unit);
        libm::log(e.a / e.b)
    };
    let size = outlying(shapes.iter().map(|s| libm::log(s.area())).collect(), typical, options);
    let proportion = outlying(shapes.iter().map(|s| aspect(s)).collect(), typical, options);
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

fn outlying(values: Vec<f64>, typical: &[bool], options: &OutlierOptions) -> Vec<bool> {
    let marked: Vec<f64> = values.iter().zip(typical).filter(|(_, typical)| **typical).map(|(v, _)| *v).collect();
    let sample = if marked.len() >= LEAST_SAMPLE { marked } else { values.clone() };
    let middle = median(sample.clone());
    let deviation = 1.4826 * median(sample.iter().map(|v| (v - middle).abs()).collect());
    let limit = options.deviations * deviation.max(options.least_deviation);
    values.into_iter().map(|v| (v - middle).abs() > limit).collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}
