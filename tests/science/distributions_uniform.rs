//! The curve of an independent uniform pattern is 1 within sampling error, whatever the metric, the
//! domain, the numbers and the radii.

use biotope::compute::geometry::Bounds;
use biotope::compute::geometry::Point;
use biotope::compute::geometry::Polygon;
use biotope::compute::geometry::Region;
use biotope::compute::pcf;
use biotope::compute::pcf::Analysis;
use biotope::compute::pcf::AnalysisOptions;
use biotope::compute::pcf::Axis;
use biotope::compute::pcf::Curve;
use biotope::compute::pcf::Dependencies;
use biotope::compute::pcf::Element;
use biotope::compute::pcf::Metric;
use biotope::compute::pcf::WEIGHT_CAP;
use biotope::compute::pcf::mass;
use biotope::compute::pcf::mass::RadiusMoments;
use biotope::compute::random::Purpose;
use biotope::compute::random::Stream;
use biotope::compute::raster::Grid;
use biotope::compute::raster::Raster;
use biotope::compute::raster::outline;
use biotope::compute::run::Run;
use proptest::prelude::*;

/// Patterns whose mean curve is looked at.
const PATTERNS: u64 = 30;

/// Standard errors a mean curve may be from 1. With 30 patterns a place of a curve passes this by
/// chance once in 600,000, so that a run of the test fails by chance less than once in 500.
const STANDARD_ERRORS: f64 = 6.0;

/// Places at which fewer pairs than this are expected in all patterns together are left out: their
/// mean is not normally distributed.
const LEAST_PAIRS: f64 = 100.0;

/// A random world to draw uniform patterns in: two classes, the second looking at the first.
#[derive(Debug, Clone)]
struct World {
    metric: Metric,
    domain: Shape,
    counts: [usize; 2],
    /// Radii in turn, in r_max of both classes together.
    radii: [f64; 3],
    seed: u64,
}

#[derive(Debug, Clone)]
enum Shape {
    Rectangle { aspect: f64 },
    Holes { size: f64 },
    L { arm: f64 },
    Cross { arm: f64 },
    Mask { bits: u64 },
}

impl Shape {
    fn region(&self) -> Region {
        match *self {
            Self::Rectangle { aspect } => rectangle((0.0, 0.0), (aspect, 1.0)),
            Self::Holes { size } => {
                let first = rectangle((0.2, 0.2), (0.2 + size, 0.2 + 0.7 * size));
                let second = Polygon {
                    outer: [(1.1, 0.3), (1.1 + size, 0.3 + 0.4 * size), (1.1, 0.3 + size)].map(point).to_vec(),
                    holes: vec![],
                };
                let second = Region::from_polygons(&[second]).unwrap();
                rectangle((0.0, 0.0), (1.8, 1.0)).minus(&first).unwrap().minus(&second).unwrap()
            }
            Self::L { arm } => rectangle((0.0, 0.0), (2.0, 2.0)).minus(&rectangle((arm, arm), (2.1, 2.1))).unwrap(),
            Self::Cross { arm } => [(0.0, 0.0), (1.0 + arm, 0.0), (0.0, 1.0 + arm), (1.0 + arm, 1.0 + arm)]
                .into_iter()
                .fold(rectangle((0.0, 0.0), (2.0 + arm, 2.0 + arm)), |left, (x, y)| {
                    left.minus(&rectangle((x, y), (x + 1.0, y + 1.0))).unwrap()
                }),
            Self::Mask { bits } => {
                // A coarse mask; its middle cells are always part of it.
                let grid = Grid::new(6, 6, 0.5);
                let is_in = |i: usize| {
                    let (column, row) = (grid.cell(i).column, grid.cell(i).row);
                    (2..4).contains(&column) && (2..4).contains(&row) || bits >> i & 3 != 0
                };
                let mask = Raster::from_data(grid, (0..grid.len()).map(is_in).collect()).unwrap();
                Region::from_normal_form(outline(&mask)).unwrap()
            }
        }
    }
}

fn point((x, y): (f64, f64)) -> Point {
    Point::new(x, y)
}

fn rectangle(min: (f64, f64), max: (f64, f64)) -> Region {
    Region::rectangle(Bounds::new(point(min), point(max))).unwrap()
}

fn worlds() -> impl Strategy<Value = World> {
    let shape = prop_oneof![
        (0.3..4.0).prop_map(|aspect| Shape::Rectangle { aspect }),
        (0.1..0.55).prop_map(|size| Shape::Holes { size }),
        (0.4..1.5).prop_map(|arm| Shape::L { arm }),
        (0.4..2.0).prop_map(|arm| Shape::Cross { arm }),
        any::<u64>().prop_map(|bits| Shape::Mask { bits }),
    ];
    let metric = prop_oneof![Just(Metric::Point), Just(Metric::Disk), Just(Metric::Disk)];
    // Points among disks, and disks of any size from a twentieth to one and a half of r_max.
    let radius = || prop_oneof![1 => Just(0.0), 4 => 0.05..1.5];
    let radii = [radius(), radius(), radius()];
    (metric, shape, [60..220_usize, 60..220_usize], radii, any::<u64>())
        .prop_map(|(metric, domain, counts, radii, seed)| World { metric, domain, counts, radii, seed })
}

impl World {
    /// Uniform places, which do not depend on each other nor on the radii.
    fn pattern(&self, domain: &Region, number: u64) -> Vec<Element> {
        let mut random = Stream::new(self.seed, Purpose::new("test.uniform-worlds"), number);
        let (bounds, total) = (domain.bounds(), self.counts[0] + self.counts[1]);
        let unit = pcf::maximal_spacing(domain.area(), total);
        let draw = || point((random.range(bounds.min.x, bounds.max.x), random.range(bounds.min.y, bounds.max.y)));
        let places = std::iter::repeat_with(draw).filter(|p| domain.contains(*p)).take(total);
        let element = |(i, centre): (usize, Point)| Element {
            centre,
            radius: self.radii[i % 3] * unit,
            class: usize::from(i >= self.counts[0]),
        };
        places.enumerate().map(element).collect()
    }

    fn analyses(&self, domain: &Region, weight_cap: f64) -> Vec<Analysis> {
        let options = AnalysisOptions { weight_cap, ..AnalysisOptions::of(self.metric) };
        let graph = Dependencies::new(2, &[(1, 0)]).unwrap();
        let analyse =
            |number| pcf::analyse(&self.pattern(domain, number), domain, (&graph, &options), &Run::silent()).unwrap();
        (0..PATTERNS).map(analyse).collect()
    }

    /// The place where the mean of the curves is not 1 within sampling error, if there is one.
    fn fault(&self, weight_cap: f64) -> Option<String> {
        let domain = self.domain.region();
        let analyses = self.analyses(&domain, weight_cap);
        (0..analyses[0].curves.len()).find_map(|k| {
            let curves: Vec<&Curve> = analyses.iter().map(|a| &a.curves[k]).collect();
            let pairs = Pairs::of(&analyses[0], k);
            assert!((0..pairs.expected.len()).filter(|b| pairs.suffice(*b)).count() >= 30, "{self:?}");
            (0..pairs.expected.len()).filter(|b| pairs.suffice(*b)).find_map(|bin| {
                let (mean, error) = mean_and_error(&curves, bin);
                let allowed = STANDARD_ERRORS * error.max(pairs.standard_error(bin));
                let what = || format!("curve {k}, place {bin}: {mean} is not 1 within {allowed}");
                ((mean - 1.0).abs() > allowed).then(what)
            })
        })
    }
}

fn mean_and_error(curves: &[&Curve], bin: usize) -> (f64, f64) {
    let n = curves.len() as f64;
    let mean = curves.iter().map(|c| c.mean[bin]).sum::<f64>() / n;
    let variance = curves.iter().map(|c| (c.mean[bin] - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

/// How many pairs make up a curve of a uniform pattern.
struct Pairs {
    /// Pairs in the bump of the kernel at every place, in all patterns.
    expected: Vec<f64>,
}

impl Pairs {
    /// A curve is a sum over pairs, of which nearly every one is independent of the others. With
    /// n pairs of which each has its partner in the kernel's bump with the probability M/A, the
    /// variance of the curve is A·S/(n·M²), S the integral of the squared kernel, which is a
    /// kernel of width σ/√2 over √(2π)·σ: as if n·M²/(A·S) pairs counted equally. Border
    /// weights and pairs that share an element add to that, so it is a floor for what is
    /// estimated from the patterns themselves.
    fn of(analysis: &Analysis, k: usize) -> Self {
        let curve = &analysis.curves[k];
        let (child, parent) = (&analysis.classes[curve.child], &analysis.classes[curve.parent]);
        let same = curve.child == curve.parent;
        let narrow = Axis { sigma: curve.axis.sigma / 2.0_f64.sqrt(), ..curve.axis };
        let squares = match analysis.metric {
            Metric::Disk => {
                let scaled = |radii: &[f64]| radii.iter().map(|r| r / curve.unit).collect::<Vec<f64>>();
                mass::of_disks(&narrow, &RadiusMoments::of(&scaled(&child.radii), &scaled(&parent.radii), same))
            }
            _ => mass::of_points(&narrow),
        };
        let area = analysis.area / (curve.unit * curve.unit);
        let count =
            (child.count * (parent.count - usize::from(same))) as f64 * PATTERNS as f64 / if same { 2.0 } else { 1.0 };
        let per_square = std::f64::consts::TAU.sqrt() * curve.axis.sigma;
        let expected = curve
            .mass
            .iter()
            .zip(&squares)
            .map(|(m, s)| if *m > 0.0 && *s > 0.0 { count * m * m * per_square / (area * s) } else { 0.0 });
        Self { expected: expected.collect() }
    }

    fn suffice(&self, bin: usize) -> bool {
        self.expected[bin] > LEAST_PAIRS
    }

    fn standard_error(&self, bin: usize) -> f64 {
        1.0 / self.expected[bin].sqrt()
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_curve_of_an_independent_uniform_pattern_is_one_within_sampling_error(world in worlds()) {
        prop_assert_eq!(world.fault(WEIGHT_CAP), None);
    }

    #[test]
    fn without_border_weights_it_is_not(world in worlds()) {
        // The sampling error is small enough to tell.
        prop_assert!(world.fault(1.0).is_some());
    }
}
