use crate::compute::pcf::Axis;
use crate::compute::pcf::Tail;

/// Below this fraction of the largest expected mass a place of the axis is out of reach: no
/// pair of these sizes can lie there, and the curve is 0.
const OUT_OF_REACH: f64 = 1e-12;

/// The smallest value a curve is divided by when an error is taken relative to it (ours: papers
/// leave the floor open).
pub const RELATIVE_FLOOR: f64 = 0.05;

/// A pair correlation curve: how many partners an element has at each distance, over the number
/// it would have in a uniform pattern.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// The class whose elements look around.
    pub child: usize,
    /// The class they look at.
    pub parent: usize,
    /// Metres in one unit of the axis: r_max of the child class, 1 for ellipses.
    pub unit: f64,
    /// Where the curve is evaluated.
    pub axis: Axis,
    /// The expected kernel mass M(r), in the square of the unit.
    pub mass: Vec<f64>,
    /// Mean of the individual curves.
    pub mean: Vec<f64>,
    /// Their pointwise least value: with `upper` the validity region (T 3.5.1).
    pub lower: Vec<f64>,
    /// Their pointwise greatest value.
    pub upper: Vec<f64>,
    /// The least running mean Σ curve·M/ΣM of the individual curves up to each place, among those
    /// whose circles up to there lie in the domain; among all where fewer than half of them do. A
    /// part of the validity region (ours): pointwise bounds do not tell an element that has nobody
    /// near from one whose partners stand a little elsewhere.
    pub least_near: Vec<f64>,
    /// The same among all elements, for those at the border: 0 where one of the exemplar's there has
    /// nobody near, as in a pattern that is cut off.
    pub least_near_border: Vec<f64>,
    /// Mean over the elements of the parent class of Σ over pairs of two different elements of
    /// the child class, both at r: how far those come together (third order). Only if asked for;
    /// else empty.
    pub triplets: Vec<f64>,
    /// The variance of the parent's elements' own sums, at each place of `triplets`.
    pub triplet_variance: Vec<f64>,
    /// What lies beyond the axis; empty like `triplets`, and in domains hardly wider than the axis
    /// is long.
    pub tail: Tail,
    /// How evenly windows are filled, by their radius (`windows.rs`); only if asked for, and
    /// of a class that looks at itself.
    pub root_counts: Vec<Option<f64>>,
    /// The individual curves, in the order of the class's elements; empty unless kept.
    pub individual: Vec<Vec<f64>>,
}

impl Curve {
    /// Root mean square difference to another curve on the same axis.
    pub fn rms_error(&self, other: &Self) -> f64 {
        rms(&self.mean, &other.mean)
    }
}

/// Root mean square difference.
pub fn rms(a: &[f64], b: &[f64]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum();
    (squares / a.len().max(1) as f64).sqrt()
}

/// Σ (new − target)²/max(target, 0.05) (T eq. 4.3).
pub fn relative_squares(new: &[f64], target: &[f64]) -> f64 {
    new.iter().zip(target).map(|(x, t)| (x - t) * (x - t) / t.max(RELATIVE_FLOOR)).sum()
}

/// An element's triplets at every place: (Σ of its terms)² − Σ of their squares, where `row` is
/// its own curve and `same` the sum of squared terms before `factors`.
pub fn triplets(row: &[f64], same: &[f64], factors: &[f64]) -> Vec<f64> {
    row.iter().zip(same).zip(factors).map(|((sum, same), factor)| sum * sum - same * factor * factor).collect()
}

/// What a kernel sum is multiplied by at every place to become a curve: 1/(density·M(r)), or 0
/// where no pair can lie.
pub fn factors(mass: &[f64], density: f64) -> Vec<f64> {
    let floor = mass.iter().fold(0.0, |a: f64, b| a.max(*b)) * OUT_OF_REACH;
    mass.iter().map(|m| if *m > floor && density > 0.0 { 1.0 / (m * density) } else { 0.0 }).collect()
}

impl Curve {
    /// A curve of zeros on `axis`.
    pub(super) fn empty(axis: Axis) -> Self {
        let zeros = vec![0.0; axis.bins()];
        Self {
            child: 0,
            parent: 0,
            unit: 1.0,
            axis,
            mass: zeros.clone(),
            mean: zeros.clone(),
            lower: zeros.clone(),
            upper: zeros.clone(),
            least_near: zeros.clone(),
            least_near_border: zeros,
            triplets: Vec::new(),
            triplet_variance: Vec::new(),
            tail: Tail::default(),
            root_counts: Vec::new(),
            individual: Vec::new(),
        }
    }
}
