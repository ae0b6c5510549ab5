/// A curve that begins nearer to its target than this is measured by this instead, so that one
/// that fits already does not bind the others.
const LEAST_SCALE: f64 = 0.01;

/// What is beyond the limit counts this many times more: enough that no other curve gains by it.
const EXCESS_WEIGHT: f64 = 20.0;

/// Elements are moved by curves at fewer places, of which the error differs by this share.
const MARGIN: f64 = 0.05;

/// What the errors of a block's curves are measured by, and where they are not to go: none is to
/// end farther from its target than it began.
#[derive(Debug, Clone)]
pub(super) struct Limits {
    /// The root mean square errors the curves are measured by.
    pub(super) scales: Vec<f64>,
    /// The squared errors they began with less a margin, over the squared scales.
    most: Vec<f64>,
}

impl Limits {
    /// Of curves that begin with these root mean square errors.
    pub(super) fn of(errors: &[f64]) -> Self {
        let scales: Vec<f64> = errors.iter().map(|e| e.max(LEAST_SCALE)).collect();
        let most = errors.iter().zip(&scales).map(|(e, scale)| ((1.0 - MARGIN) * e / scale).powi(2)).collect();
        Self { scales, most }
    }

    /// What a squared error of curve `v`, over its squared scale, counts.
    pub(super) fn cost(&self, v: usize, square: f64) -> f64 {
        square + EXCESS_WEIGHT * (square - self.most[v]).max(0.0)
    }

    /// How fast that grows with the squared error.
    pub(super) fn slope(&self, v: usize, square: f64) -> f64 {
        if square > self.most[v] { 1.0 + EXCESS_WEIGHT } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_squared_error_costs_itself_up_to_where_it_began_and_many_times_more_beyond() {
        let limits = Limits::of(&[0.2, 0.001]);
        assert_eq!(limits.cost(0, 0.5), 0.5);
        assert!(limits.cost(0, 1.0) > 2.0 && limits.slope(0, 1.0) > 10.0 && limits.slope(0, 0.5) == 1.0);
        // A curve that began very near is measured by the least scale, and may still not end worse.
        assert_eq!(limits.scales, [0.2, 0.01]);
        assert!(limits.slope(1, 0.005) == 1.0 && limits.slope(1, 0.01) > 10.0);
    }
}
