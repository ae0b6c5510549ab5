//! How far apart two elements are on the axis of a curve.

use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Point;

/// In slopes, the smaller radius of a partly overlapping pair is at least this (in r_max), so
/// that two nearly pointlike disks do not push each other with unbounded force (ours).
const MIN_RADIUS_IN_SLOPES: f64 = 0.02;

/// Where disjoint disks begin on the axis of the disk metric.
pub const DISJOINT: f64 = 3.0;

/// Which distance a curve is drawn over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Metric {
    /// Euclidean distance of centres, in r_max.
    Point,
    /// The saliency-based distance of disks (T eq. 3.9–3.12), lengths in r_max.
    Disk,
    /// How many times larger an ellipse would have to be to reach the other's centre
    /// (T eq. 4.2), seen from either ellipse of a pair in turn.
    Ellipse,
}

impl Metric {
    /// The extent a curve has by default, in the units of the metric. Points and ellipses: 5
    /// (T 3.6.1). Disks: 7, a gap of 2 r_max between rims; T's 5 is a gap of only 1 r_max.
    pub fn default_extent(self) -> f64 {
        match self {
            Self::Point | Self::Ellipse => 5.0,
            Self::Disk => 7.0,
        }
    }

    /// The place on the axis of a pair at distance `d`, of radii `a` and `b`; all three in the
    /// metric's unit. Symmetric in the radii. Only disks look at the radii.
    ///
    /// For disks, with r1 ≥ r2, T eq. 3.9–3.12 reduce to (3(r1−r2) + d)/(4(r1−r2)) when nested,
    /// 2 + (d−r1)/r2 when partly overlapping, 3 + 2(d−r1−r2) when disjoint: 1 at inner tangency,
    /// 2 with the smaller's centre on the larger's rim, 3 at outer tangency. Equal disks at one
    /// place are 1; a point passes from 1 to 3 at a disk's rim and is 2 there.
    pub fn value(self, d: f64, a: f64, b: f64) -> f64 {
        if self != Self::Disk {
            return d;
        }
        let (large, small) = (a.max(b), a.min(b));
        if d > large + small {
            DISJOINT + 2.0 * (d - large - small)
        } else if d < large - small {
            0.75 + d / (4.0 * (large - small))
        } else if small > 0.0 {
            2.0 + (d - large) / small
        } else if large > 0.0 {
            2.0
        } else {
            DISJOINT
        }
    }

    /// The slope of [`Metric::value`] over `d`, the smaller radius taken as at least 0.02.
    pub fn slope(self, d: f64, a: f64, b: f64) -> f64 {
        if self != Self::Disk {
            return 1.0;
        }
        let (large, small) = (a.max(b), a.min(b));
        if d > large + small {
            2.0
        } else if d < large - small {
            1.0 / (4.0 * (large - small).max(MIN_RADIUS_IN_SLOPES))
        } else {
            1.0 / small.max(MIN_RADIUS_IN_SLOPES)
        }
    }

    /// The largest distance at which a pair of radii `a` and at most `b` can lie at or below
    /// `value` on the axis.
    pub fn reach(self, value: f64, a: f64, b: f64) -> f64 {
        match self {
            Self::Point | Self::Ellipse => value,
            Self::Disk => a + b + ((value - DISJOINT) / 2.0).max(0.0),
        }
    }
}

/// A linear map from offsets in the plane to a frame in which the rings of a metric around an
/// element are circles: a rotation, then a scale along each axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    along: Point,
    across: Point,
    longest: f64,
}

impl Frame {
    /// The frame in which `unit` is 1.
    pub fn of_unit(unit: f64) -> Self {
        let scale = 1.0 / unit;
        Self { along: Point::new(scale, 0.0), across: Point::new(0.0, scale), longest: unit }
    }

    /// The frame in which `ellipse` is the unit circle.
    pub fn of_ellipse(ellipse: &Ellipse) -> Self {
        let heading = ellipse.heading();
        let across = Point::new(-heading.y, heading.x) * (1.0 / ellipse.b);
        Self { along: heading * (1.0 / ellipse.a), across, longest: ellipse.a.max(ellipse.b) }
    }

    /// An offset seen in the frame.
    pub fn map(&self, offset: Point) -> Point {
        Point::new(self.along.dot(offset), self.across.dot(offset))
    }

    /// The farthest an offset can be whose length in the frame is `length`.
    pub fn farthest(&self, length: f64) -> f64 {
        self.longest * length
    }

    /// The gradient of the length in the frame over the offset: for an ellipse, of T eq. 4.2.
    /// `None` at the null offset, where there is no direction.
    pub fn gradient(&self, offset: Point) -> Option<Point> {
        let direction = self.map(offset).normalised()?;
        Some(self.along * direction.x + self.across * direction.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DISK: Metric = Metric::Disk;

    #[test]
    fn salient_configurations_of_disks_have_their_fixed_values() {
        for (large, small) in [(1.0, 0.4), (2.0, 1.9), (0.3, 0.01), (1.0, 0.5)] {
            assert!((DISK.value(0.0, large, small) - 0.75).abs() < 1e-12);
            assert!((DISK.value(large - small, large, small) - 1.0).abs() < 1e-9);
            assert!((DISK.value(large, large, small) - 2.0).abs() < 1e-12);
            assert!((DISK.value(large + small, large, small) - 3.0).abs() < 1e-9);
            assert!((DISK.value(large + small + 1.0, large, small) - 5.0).abs() < 1e-9);
        }
    }

    /// T eq. 3.9–3.12 as printed.
    fn as_printed(d: f64, r1: f64, r2: f64) -> f64 {
        let extent = (d + r1 + r2).max(2.0 * r1);
        let overlap = (r1 + r2 - d).clamp(0.0, 2.0 * r2);
        let f = extent - overlap + d + r1 - r2;
        if d <= r1 - r2 {
            f / (4.0 * r1 - 4.0 * r2)
        } else if d <= r1 + r2 {
            (f - 4.0 * r1 + 7.0 * r2) / (3.0 * r2)
        } else {
            f - 4.0 * r1 - 2.0 * r2 + 3.0
        }
    }

    #[test]
    fn the_disk_metric_is_the_printed_one_symmetric_and_continuous() {
        for (r1, r2) in [(1.0, 0.5), (0.7, 0.1), (2.0, 1.5)] {
            let mut last = DISK.value(0.0, r1, r2);
            for k in 0..4000 {
                let d = f64::from(k) * 0.001;
                let value = DISK.value(d, r1, r2);
                assert_eq!(value, DISK.value(d, r2, r1));
                assert!((value - as_printed(d, r1, r2)).abs() < 1e-9, "{d} {r1} {r2}");
                assert!(value >= last - 1e-12 && value - last <= 0.001 / r2.min(0.25) + 1e-9);
                last = value;
            }
        }
    }

    #[test]
    fn degenerate_pairs_of_disks_have_documented_values() {
        assert_eq!(DISK.value(0.0, 0.5, 0.5), 1.0);
        assert_eq!(DISK.value(0.5, 0.5, 0.0), 2.0);
        assert!((DISK.value(0.499_999, 0.5, 0.0) - 1.0).abs() < 1e-5);
        assert!((DISK.value(0.500_001, 0.5, 0.0) - 3.0).abs() < 1e-4);
        assert_eq!(DISK.value(0.0, 0.0, 0.0), 3.0);
        assert_eq!(DISK.value(1.0, 0.0, 0.0), 5.0);
    }

    #[test]
    fn slopes_are_those_of_the_value() {
        for (d, a, b) in [(0.1, 1.0, 0.4), (0.9, 0.4, 1.0), (1.2, 1.0, 0.4), (2.0, 1.0, 0.4), (0.2, 0.3, 0.3)] {
            let numeric = (DISK.value(d + 1e-6, a, b) - DISK.value(d - 1e-6, a, b)) / 2e-6;
            assert!((DISK.slope(d, a, b) - numeric).abs() < 1e-6, "{d} {a} {b}");
        }
        assert_eq!(DISK.slope(0.5, 0.5, 0.0), 50.0);
        assert_eq!(Metric::Point.slope(0.5, 0.5, 0.0), 1.0);
    }

    #[test]
    fn nothing_beyond_the_reach_lies_below_the_value() {
        for value in [0.5, 1.0, 2.5, 3.0, 6.0] {
            for (a, b) in [(1.0, 0.4), (0.2, 0.9), (0.0, 0.5), (0.0, 0.0)] {
                let reach = DISK.reach(value, a, b);
                assert!(DISK.value(reach + 1e-6, a, b) > value);
            }
        }
    }

    #[test]
    fn in_its_own_frame_an_ellipse_is_the_unit_circle() {
        let ellipse = Ellipse { centre: Point::new(1.0, 2.0), a: 3.0, b: 1.5, theta: 0.6 };
        let frame = Frame::of_ellipse(&ellipse);
        for p in [Point::new(4.0, 2.0), Point::new(1.0, 5.0), Point::new(-2.0, 0.0)] {
            let offset = p - ellipse.centre;
            assert!((frame.map(offset).norm() - ellipse.scale_to(p)).abs() < 1e-12);
            let gradient = frame.gradient(offset).unwrap();
            let step = Point::new(1e-6, 0.0);
            let numeric = (ellipse.scale_to(p + step) - ellipse.scale_to(p - step)) / 2e-6;
            assert!((gradient.x - numeric).abs() < 1e-6);
        }
        assert_eq!(frame.gradient(Point::default()), None);
    }
}
