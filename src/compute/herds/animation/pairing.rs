//! Who of one key-herd becomes who of the next (T 4.3.2): optimal transport of one unit of mass
//! an animal, after centroids and orientations were laid upon each other.

use super::AnimationError;
use crate::compute::geometry::Point;
use crate::compute::graph::assignment::assign;
use crate::compute::run::Run;

/// The cost of pairing two places in the herd frame, x along the trajectory (T 4.3.2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PairingMetric {
    /// The Euclidean distance.
    Euclidean,
    /// The Euclidean distance to the nth power, to avoid long moves; n from 1 to 8.
    Power {
        /// The exponent n.
        exponent: u32,
    },
    /// The Euclidean distance with moves along one axis counted `penalty` times.
    Axis {
        /// Whether the axis along the trajectory is penalised, else the one across it.
        along: bool,
        /// How many times a move along that axis counts, from 1 to 1,000.
        penalty: f64,
    },
}

impl PairingMetric {
    /// What pairing `from` with `to` costs.
    pub fn cost(self, from: Point, to: Point) -> f64 {
        self.of_distance_sq(self.stretched(from).distance_sq(self.stretched(to)))
    }

    /// The place in a plane where the penalised axis is as much longer.
    fn stretched(self, p: Point) -> Point {
        match self {
            Self::Axis { along: true, penalty } => Point::new(p.x * penalty, p.y),
            Self::Axis { along: false, penalty } => Point::new(p.x, p.y * penalty),
            Self::Euclidean | Self::Power { .. } => p,
        }
    }

    fn of_distance_sq(self, d: f64) -> f64 {
        match self {
            Self::Power { exponent } if exponent % 2 == 0 => d.powi(exponent as i32 / 2),
            Self::Power { exponent } => d.sqrt().powi(exponent as i32),
            Self::Euclidean | Self::Axis { .. } => d.sqrt(),
        }
    }

    pub(super) fn check(self) -> Result<(), AnimationError> {
        let bad = |field, expected, found| Err(AnimationError::BadOption { field, expected, found });
        match self {
            Self::Power { exponent } if !(1..=8).contains(&exponent) => {
                bad("pairing.exponent", "from 1 to 8", f64::from(exponent))
            }
            Self::Axis { penalty, .. } if !(1.0..=1000.0).contains(&penalty) => {
                bad("pairing.penalty", "from 1 to 1000", penalty)
            }
            _ => Ok(()),
        }
    }
}

/// For each place of `from` the index of its partner in `to`; both of equal number, in the herd
/// frame. Exact up to a thousand animals, above as good as
/// [`auction`](crate::compute::graph::assignment::auction).
pub fn pair(metric: PairingMetric, from: &[Point], to: &[Point], run: &Run) -> Result<Vec<usize>, AnimationError> {
    let stretched = |places: &[Point]| places.iter().map(|p| metric.stretched(*p)).collect::<Vec<_>>();
    Ok(assign(&stretched(from), &stretched(to), |d| metric.of_distance_sq(d), run)?.columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_metric_prefers_its_own_pairing() {
        // Moving both by one along x, or keeping one and moving the other by two.
        let (from, to) = ([Point::new(0.0, 0.0), Point::new(1.0, 0.0)], [Point::new(1.0, 0.0), Point::new(2.0, 0.0)]);
        let cost = |m: PairingMetric, p: &[usize]| -> f64 { (0..2).map(|i| m.cost(from[i], to[p[i]])).sum() };
        let squared = PairingMetric::Power { exponent: 2 };
        assert_eq!(pair(squared, &from, &to, &Run::silent()).unwrap(), [0, 1]);
        assert_eq!(cost(squared, &[1, 0]), 4.0);
        assert_eq!(cost(PairingMetric::Euclidean, &[0, 1]), cost(PairingMetric::Euclidean, &[1, 0]));
        // A diagonal swap: a penalty across the trajectory keeps rows, one along it keeps columns.
        let (from, to) = ([Point::new(0.0, 0.0), Point::new(1.0, 1.0)], [Point::new(1.0, 0.0), Point::new(0.0, 1.0)]);
        let across = PairingMetric::Axis { along: false, penalty: 5.0 };
        let along = PairingMetric::Axis { along: true, penalty: 5.0 };
        assert_eq!(pair(across, &from, &to, &Run::silent()).unwrap(), [0, 1]);
        assert_eq!(pair(along, &from, &to, &Run::silent()).unwrap(), [1, 0]);
    }

    #[test]
    fn metrics_out_of_range_are_refused() {
        assert!(PairingMetric::Power { exponent: 0 }.check().is_err());
        assert!(PairingMetric::Axis { along: true, penalty: f64::NAN }.check().is_err());
        assert!(PairingMetric::Euclidean.check().is_ok());
    }
}
