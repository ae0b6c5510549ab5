//! What lies beyond the axis of a curve: how many partners an element has at distances from the
//! end of its axis to half the width of the domain, in wide bins.
//!
//! A curve that is not 1 yet where its axis ends (5 r_max) says nothing of how far the clumps and
//! gaps it comes from reach: a single void as wide as the domain and a dozen of them can have the
//! same curve. A few wide bins tell them apart. They are triangles over the distance of centres,
//! whatever the metric.

use crate::compute::geometry::Point;
use crate::compute::geometry::Region;
use crate::compute::pcf::Axis;
use crate::compute::pcf::BorderWeight;
use crate::compute::pcf::Crowd;
use crate::compute::pcf::Metric;
use std::f64::consts::TAU;

/// Distance between two bins, in r_max (ours).
const STEP: f64 = 1.0;

/// No bin reaches farther than this, in r_max, so that work stays linear (ours).
const FARTHEST: f64 = 12.0;

/// No bin reaches farther than this share of the shorter side of the exemplar's domain: beyond
/// it most circles lie outside.
const SHARE_OF_SIDE: f64 = 0.5;

/// A curve beyond its axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Tail {
    /// The bins.
    pub axis: TailAxis,
    /// Pairs in every bin over those of a uniform pattern.
    pub mean: Vec<f64>,
}

/// The bins of a tail: triangles of half-width 1 r_max around `first`, `first` + 1, …
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TailAxis {
    /// Where the first bin peaks, in r_max.
    pub first: f64,
    /// Number of bins; 0 in a domain hardly wider than the curve's axis is long.
    pub bins: usize,
}

impl TailAxis {
    /// The bins beyond `axis` for elements of mean `radius` in `domain`; both in `unit` metres.
    pub(super) fn beyond(axis: &Axis, (metric, radius): (Metric, f64), (domain, unit): (&Region, f64)) -> Self {
        let side = domain.bounds().width().min(domain.bounds().height()) / unit;
        let first = metric.reach(axis.extent, radius, radius) + 0.5 * STEP;
        let last = (side * SHARE_OF_SIDE).min(FARTHEST) - STEP;
        let bins = if last >= first { ((last - first) / STEP) as usize + 1 } else { 0 };
        Self { first, bins }
    }

    /// Where a bin peaks, in r_max.
    pub(super) fn place(&self, bin: usize) -> f64 {
        self.first + bin as f64 * STEP
    }

    /// From where to where pairs fall into any bin, in r_max.
    pub(super) fn range(&self) -> (f64, f64) {
        (self.first - STEP, self.first + self.bins as f64 * STEP)
    }

    /// The pairs of an element at `centre` with all of `crowd`, in every bin.
    pub(super) fn pairs(&self, (centre, unit): (Point, f64), crowd: &Crowd) -> Vec<f64> {
        let mut pairs = vec![0.0; self.bins];
        crowd.for_each_near(centre, self.range().1 * unit, |other| {
            self.add(&mut pairs, other.distance(centre) / unit, 1.0);
        });
        pairs
    }

    /// Adds a pair at `distance` (r_max) to the one or two bins it falls into.
    pub(super) fn add(&self, row: &mut [f64], distance: f64, weight: f64) {
        let at = (distance - self.first) / STEP + 1.0;
        if at <= 0.0 {
            return;
        }
        let (lower, share) = (at as usize, at - (at as usize) as f64);
        if let Some(value) = lower.checked_sub(1).and_then(|bin| row.get_mut(bin)) {
            *value += weight * (1.0 - share);
        }
        if let Some(value) = row.get_mut(lower) {
            *value += weight * share;
        }
    }

    /// The area of each bin's ring, in r_max²: ∫ of its triangle over the plane.
    pub(super) fn ring(&self, bin: usize) -> f64 {
        TAU * self.place(bin) * STEP
    }

    /// The part of each bin's ring around an element that lies in the domain, given the border
    /// weight around it: the trapezium rule over half steps, exact for whole rings.
    pub(super) fn rings_inside(&self, border: &BorderWeight) -> Vec<f64> {
        let at = |half: usize| {
            let r = self.first + (half as f64 - 1.0) * 0.5 * STEP;
            TAU * r / border.at(r)
        };
        let arcs: Vec<f64> = (0..2 * self.bins + 1).map(at).collect();
        (0..self.bins).map(|b| STEP * 0.5 * (0.5 * arcs[2 * b] + arcs[2 * b + 1] + 0.5 * arcs[2 * b + 2])).collect()
    }
}

/// Sums of a tail over the elements of a class.
#[derive(Debug, Clone)]
pub(super) struct TailSum {
    pairs: Vec<f64>,
    rings: Vec<f64>,
}

impl TailSum {
    /// No elements yet.
    pub(super) fn new(axis: &TailAxis) -> Self {
        Self { pairs: vec![0.0; axis.bins], rings: vec![0.0; axis.bins] }
    }

    /// Adds the pairs of one element, and the part of each ring around it inside the domain.
    pub(super) fn add(&mut self, pairs: &[f64], rings: &[f64]) {
        self.pairs.iter_mut().zip(pairs).for_each(|(sum, value)| *sum += value);
        self.rings.iter_mut().zip(rings).for_each(|(sum, value)| *sum += value);
    }

    /// The tail: the pairs over those of a uniform pattern with `density` partners per r_max².
    pub(super) fn finish(&self, density: f64) -> Vec<f64> {
        let value = |(pairs, rings): (&f64, &f64)| if *rings > 0.0 { pairs / (rings * density) } else { 0.0 };
        self.pairs.iter().zip(&self.rings).map(value).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::geometry::Bounds;
    use crate::compute::pcf::AnalysisOptions;
    use crate::compute::pcf::Dependencies;
    use crate::compute::pcf::Element;
    use crate::compute::pcf::analyse;
    use crate::compute::random::Purpose;
    use crate::compute::random::Stream;
    use crate::compute::run::Run;

    fn rectangle(x: f64, y: f64) -> Region {
        Region::rectangle(Bounds::new(Point::default(), Point::new(x, y))).unwrap()
    }

    /// The tails of a pattern of two classes: of the second, towards itself and the first.
    fn tails(places: &[Point], domain: &Region) -> Vec<Tail> {
        let element = |(i, p): (usize, &Point)| Element { centre: *p, radius: 0.0, class: i % 2 };
        let elements: Vec<Element> = places.iter().enumerate().map(element).collect();
        let graph = Dependencies::new(2, &[(1, 0)]).unwrap();
        let options = AnalysisOptions { triplets: true, ..AnalysisOptions::of(Metric::Point) };
        let analysis = analyse(&elements, domain, (&graph, &options), &Run::silent()).unwrap();
        [(1, 1), (1, 0)].map(|(child, parent)| analysis.curve(child, parent).unwrap().tail.clone()).into()
    }

    #[test]
    fn the_tail_of_a_uniform_pattern_is_one() {
        let hole = rectangle(2.0, 2.0).minus(&rectangle(0.7, 0.9)).unwrap();
        for domain in [rectangle(2.0, 1.6), hole] {
            let mut sums = [[0.0; 2]; 2];
            for seed in 0..20 {
                let mut random = Stream::new(seed, Purpose::new("test.tail"), 0);
                let place = || Point::new(random.range(0.0, 2.0), random.range(0.0, 2.0));
                let places: Vec<Point> =
                    std::iter::repeat_with(place).filter(|p| domain.contains(*p)).take(800).collect();
                for (sum, tail) in sums.iter_mut().zip(tails(&places, &domain)) {
                    sum.iter_mut().zip(&tail.mean).for_each(|(s, value)| *s += value / 20.0);
                }
            }
            assert!(sums.iter().flatten().all(|mean| (mean - 1.0).abs() < 0.02), "{sums:?}");
        }
    }

    #[test]
    fn a_small_domain_has_no_tail() {
        let mut random = Stream::new(1, Purpose::new("test.tail"), 0);
        let places: Vec<Point> = (0..60).map(|_| Point::new(random.unit(), random.unit())).collect();
        assert!(tails(&places, &rectangle(1.0, 1.0)).iter().all(|tail| tail.mean.is_empty()));
    }

    #[test]
    fn the_bins_share_every_pair_between_them_and_their_rings_fill_the_plane() {
        let axis = TailAxis { first: 5.5, bins: 4 };
        for distance in [5.5, 6.2, 7.49, 8.5] {
            let mut row = [0.0; 4];
            axis.add(&mut row, distance, 2.0);
            assert!((row.iter().sum::<f64>() - 2.0).abs() < 1e-12);
        }
        let border = BorderWeight::new(&rectangle(100.0, 100.0), &body(Point::new(50.0, 50.0)), 20.0, 100.0);
        assert!(axis.rings_inside(&border).iter().enumerate().all(|(b, ring)| (ring - axis.ring(b)).abs() < 1e-9));
        // Seen from a straight border half of every ring is inside, from a corner a quarter.
        for (place, share) in [(Point::new(1e-9, 50.0), 0.5), (Point::new(1e-9, 1e-9), 0.25)] {
            let border = BorderWeight::new(&rectangle(100.0, 100.0), &body(place), 20.0, 100.0);
            assert!(
                axis.rings_inside(&border).iter().enumerate().all(|(b, r)| (r - share * axis.ring(b)).abs() < 1e-6)
            );
        }
    }

    fn body(centre: Point) -> crate::compute::pcf::Body {
        crate::compute::pcf::Body { centre, radius: 0.0, frame: crate::compute::pcf::Frame::of_unit(1.0) }
    }
}
