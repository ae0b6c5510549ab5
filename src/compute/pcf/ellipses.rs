//! Curves of oriented ellipses (T 4.2.2): one metric more over the same sums.

use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Region;
use crate::compute::pcf::AnalysisOptions;
use crate::compute::pcf::Axis;
use crate::compute::pcf::Body;
use crate::compute::pcf::BorderWeight;
use crate::compute::pcf::Correlator;
use crate::compute::pcf::Crowd;
use crate::compute::pcf::Curve;
use crate::compute::pcf::Frame;
use crate::compute::pcf::Kernel;
use crate::compute::pcf::Metric;
use crate::compute::pcf::PcfError;
use crate::compute::pcf::analyse::CurveSum;
use crate::compute::pcf::curve;
use crate::compute::pcf::mass;
use crate::compute::run::Run;
use rayon::prelude::*;

fn body(ellipse: &Ellipse) -> Body {
    Body { centre: ellipse.centre, radius: 0.0, frame: Frame::of_ellipse(ellipse) }
}

fn check(ellipses: &[Ellipse]) -> Result<(), PcfError> {
    let bad = |e: &&Ellipse| !e.is_valid();
    if ellipses.len() < 2 {
        return Err(PcfError::TooFewElements { found: ellipses.len() });
    }
    match ellipses.iter().position(|e| bad(&e)) {
        Some(index) => Err(PcfError::BadElement {
            index,
            field: "b",
            expected: "finite axes with a ≥ b > 0",
            found: ellipses[index].b,
        }),
        None => Ok(()),
    }
}

/// The correlation curve of `ellipses` in `domain`, over r in body sizes: each ellipse looks at
/// every other's centre in its own frame, so both directions of a pair count (T eq. 4.1, 4.2).
/// Border weights are exact arcs in that frame, the expected mass is mean(a·b)·M(r) in the unit
/// of the domain's area. The curve of uniformly placed ellipses is 1.
///
/// `options.metric` is not looked at.
///
/// # Errors
/// Fewer than two ellipses, a bad axis, an ellipse with a bad size, a stop.
pub fn analyse_ellipses(
    ellipses: &[Ellipse],
    domain: &Region,
    options: &AnalysisOptions,
    run: &Run,
) -> Result<Curve, PcfError> {
    check(ellipses)?;
    let axis = options.axis.checked()?;
    let correlator = Correlator::new(Metric::Ellipse, Kernel::new(axis), options.weight_cap);
    let mean_ab = ellipses.iter().map(|e| e.a * e.b).sum::<f64>() / ellipses.len() as f64;
    let mass = mass::of_ellipses(&axis, mean_ab);
    let factors = curve::factors(&mass, (ellipses.len() - 1) as f64 / domain.area());
    let crowd = Crowd::new(ellipses.iter().map(body).collect(), mean_ab.sqrt());
    let row = |i: usize| {
        let mut row = vec![0.0; axis.bins()];
        if !run.is_stopped() {
            let body = &crowd.bodies()[i];
            let weight = BorderWeight::new(domain, body, axis.reach(), options.weight_cap);
            correlator.add_row(&mut row, (body, &weight), &crowd, Some(i));
            row.iter_mut().zip(&factors).for_each(|(value, factor)| *value *= factor);
        }
        row
    };
    let rows: Vec<Vec<f64>> = (0..ellipses.len()).into_par_iter().map(row).collect();
    run.check()?;
    let mut sum = CurveSum::new(Curve { mass, ..Curve::empty(axis) }, options.keep_individual);
    rows.iter().for_each(|row| sum.add(row));
    Ok(sum.finish())
}

/// Ellipses being laid out one by one against a target curve: says how far from it the pattern
/// would be with one more, by T eq. 4.3 with the current number of ellipses as normaliser.
///
/// A trial costs the pairs in reach, not the pattern: the sums so far are kept.
#[derive(Debug, Clone)]
pub struct EllipseTrial<'a> {
    domain: &'a Region,
    target: &'a Curve,
    correlator: Correlator,
    unit_mass: Vec<f64>,
    placed: Vec<Placed>,
    cells: Vec<Vec<u32>>,
    columns: usize,
    rows: usize,
    cell: f64,
    farthest: f64,
    sum: Vec<f64>,
    sum_ab: f64,
}

/// An ellipse in the pattern, with its view of the border.
#[derive(Debug, Clone)]
struct Placed {
    body: Body,
    weight: BorderWeight,
}

impl<'a> EllipseTrial<'a> {
    /// An empty pattern in `domain` that is to get the curve `target`, for ellipses whose
    /// semi-major axis is at most `largest_a` (metres, positive).
    pub fn new(domain: &'a Region, target: &'a Curve, largest_a: f64) -> Self {
        let axis: Axis = target.axis;
        let farthest = axis.reach() * largest_a;
        let bounds = domain.bounds();
        let cell = (farthest / 4.0).max(bounds.width().max(bounds.height()) / 512.0);
        let (columns, rows) = ((bounds.width() / cell) as usize + 1, (bounds.height() / cell) as usize + 1);
        Self {
            domain,
            target,
            correlator: Correlator::new(Metric::Ellipse, Kernel::new(axis), super::WEIGHT_CAP),
            unit_mass: mass::of_points(&axis),
            placed: Vec::new(),
            cells: vec![Vec::new(); columns * rows],
            columns,
            rows,
            cell,
            farthest,
            sum: vec![0.0; axis.bins()],
            sum_ab: 0.0,
        }
    }

    /// Number of ellipses placed.
    pub fn len(&self) -> usize {
        self.placed.len()
    }

    /// Whether none is placed.
    pub fn is_empty(&self) -> bool {
        self.placed.is_empty()
    }

    /// The error of the pattern as it is (T eq. 4.3); infinite below two ellipses.
    pub fn error(&self) -> f64 {
        self.error_of(&self.sum, self.placed.len(), self.sum_ab)
    }

    /// The error the pattern would have with `candidate`.
    pub fn error_with(&self, candidate: &Ellipse) -> f64 {
        let (sum, _) = self.sums_with(candidate);
        self.error_of(&sum, self.placed.len() + 1, self.sum_ab + candidate.a * candidate.b)
    }

    /// Adds `ellipse` to the pattern.
    pub fn place(&mut self, ellipse: &Ellipse) {
        let (sum, placed) = self.sums_with(ellipse);
        self.sum = sum;
        self.sum_ab += ellipse.a * ellipse.b;
        let (column, row) = (self.column(ellipse.centre.x), self.row(ellipse.centre.y));
        self.cells[row * self.columns + column].push(self.placed.len() as u32);
        self.placed.push(placed);
    }

    /// The curve of the pattern as it is.
    pub fn mean(&self) -> Vec<f64> {
        self.curve_of(&self.sum, self.placed.len(), self.sum_ab)
    }

    fn column(&self, x: f64) -> usize {
        (((x - self.domain.bounds().min.x) / self.cell).max(0.0) as usize).min(self.columns - 1)
    }

    fn row(&self, y: f64) -> usize {
        (((y - self.domain.bounds().min.y) / self.cell).max(0.0) as usize).min(self.rows - 1)
    }

    fn sums_with(&self, ellipse: &Ellipse) -> (Vec<f64>, Placed) {
        let body = body(ellipse);
        let reach = self.target.axis.reach();
        let weight = BorderWeight::new(self.domain, &body, reach, self.correlator.weight_cap);
        let mut sum = self.sum.clone();
        let mut add = |from: &Body, weight: &BorderWeight, to: &Body| {
            let distance = from.frame.map(to.centre - from.centre).norm();
            if distance <= reach {
                self.correlator.kernel.add(&mut sum, distance, weight.at(distance));
            }
        };
        let (centre, far) = (ellipse.centre, self.farthest);
        for row in self.row(centre.y - far)..=self.row(centre.y + far) {
            for column in self.column(centre.x - far)..=self.column(centre.x + far) {
                for other in &self.cells[row * self.columns + column] {
                    let other = &self.placed[*other as usize];
                    add(&body, &weight, &other.body);
                    add(&other.body, &other.weight, &body);
                }
            }
        }
        (sum, Placed { body, weight })
    }

    fn curve_of(&self, sum: &[f64], count: usize, sum_ab: f64) -> Vec<f64> {
        let pairs = (count.max(2) - 1) as f64 * sum_ab;
        let factors = curve::factors(&self.unit_mass, pairs / self.domain.area());
        sum.iter().zip(factors).map(|(value, factor)| value * factor).collect()
    }

    fn error_of(&self, sum: &[f64], count: usize, sum_ab: f64) -> f64 {
        if count < 2 {
            return f64::INFINITY;
        }
        curve::relative_squares(&self.curve_of(sum, count, sum_ab), &self.target.mean)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::geometry::Bounds;
    use crate::compute::geometry::Point;
    use crate::compute::random::Purpose;
    use crate::compute::random::Stream;

    fn uniform(count: usize, seed: u64, side: f64) -> Vec<Ellipse> {
        let mut random = Stream::new(seed, Purpose::new("test.ellipses"), 0);
        let mut ellipse = || {
            let b = random.range(0.2, 0.4);
            Ellipse {
                centre: Point::new(random.range(0.0, side), random.range(0.0, side)),
                a: b * random.range(1.0, 3.0),
                b,
                theta: random.range(-3.0, 3.0),
            }
        };
        (0..count).map(|_| ellipse()).collect()
    }

    fn square(side: f64) -> Region {
        Region::rectangle(Bounds::new(Point::default(), Point::new(side, side))).unwrap()
    }

    #[test]
    fn the_curve_of_uniform_ellipses_is_one() {
        let options = AnalysisOptions::of(Metric::Ellipse);
        let curves: Vec<Curve> = (0..30)
            .map(|seed| analyse_ellipses(&uniform(300, seed, 20.0), &square(20.0), &options, &Run::silent()).unwrap())
            .collect();
        for bin in 1..options.axis.bins() {
            let values: Vec<f64> = curves.iter().map(|c| c.mean[bin]).collect();
            let mean = values.iter().sum::<f64>() / 30.0;
            let deviation = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 29.0 / 30.0).sqrt();
            assert!((mean - 1.0).abs() < (4.0 * deviation).max(0.01), "{bin}: {mean} ± {deviation}");
        }
    }

    #[test]
    fn placing_one_by_one_gives_the_curve_of_the_whole() {
        let (domain, ellipses) = (square(10.0), uniform(60, 3, 10.0));
        let whole =
            analyse_ellipses(&ellipses, &domain, &AnalysisOptions::of(Metric::Ellipse), &Run::silent()).unwrap();
        let mut trial = EllipseTrial::new(&domain, &whole, 1.2);
        for (k, e) in ellipses.iter().enumerate() {
            let expected = trial.error_with(e);
            trial.place(e);
            assert!(k == 0 || (trial.error() - expected).abs() < 1e-9 * expected.max(1.0));
        }
        assert!(trial.mean().iter().zip(&whole.mean).all(|(a, b)| (a - b).abs() < 1e-9));
        assert!(trial.error() < 1e-15);
    }
}
