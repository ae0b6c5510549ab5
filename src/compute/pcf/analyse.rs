use crate::compute::geometry::CellGrid;
use crate::compute::geometry::Point;
use crate::compute::geometry::Region;
use crate::compute::pcf::Axis;
use crate::compute::pcf::Body;
use crate::compute::pcf::BorderWeight;
use crate::compute::pcf::Correlator;
use crate::compute::pcf::Crowd;
use crate::compute::pcf::Curve;
use crate::compute::pcf::Dependencies;
use crate::compute::pcf::Element;
use crate::compute::pcf::Frame;
use crate::compute::pcf::Kernel;
use crate::compute::pcf::Metric;
use crate::compute::pcf::PcfError;
use crate::compute::pcf::Tail;
use crate::compute::pcf::TailAxis;
use crate::compute::pcf::WEIGHT_CAP;
use crate::compute::pcf::curve;
use crate::compute::pcf::mass;
use crate::compute::pcf::maximal_spacing;
use crate::compute::pcf::tail::TailSum;
use crate::compute::pcf::windows::Windows;
use crate::compute::run::Run;
use rayon::prelude::*;

/// Elements whose curves are held at one time when individual curves are not kept.
const CHUNK: usize = 1024;

/// How a pattern is analysed.
#[derive(Debug, Clone, PartialEq)]
pub struct AnalysisOptions {
    /// The distance of the axis.
    pub metric: Metric,
    /// The axis and its kernel.
    pub axis: Axis,
    /// The most a pair is weighted for the border. Default: [`WEIGHT_CAP`].
    pub weight_cap: f64,
    /// Whether individual curves are returned.
    pub keep_individual: bool,
    /// Whether [`Curve::triplets`], [`Curve::tail`] and [`Curve::root_counts`] are worked out, which a synthesis needs.
    pub triplets: bool,
}

impl AnalysisOptions {
    /// The defaults for `metric`.
    pub fn of(metric: Metric) -> Self {
        let axis = Axis::with_extent(metric.default_extent());
        Self { metric, axis, weight_cap: WEIGHT_CAP, keep_individual: false, triplets: false }
    }
}

/// What is known of one class of a pattern.
#[derive(Debug, Clone, PartialEq)]
pub struct ClassSummary {
    /// Number of elements.
    pub count: usize,
    /// Their radii in metres, in the order of the elements.
    pub radii: Vec<f64>,
    /// The smallest distance between two of their centres, in metres; 0 when no
    /// two are nearer than twice r_max.
    pub closest: f64,
    /// Whether any two of them overlap.
    pub overlaps: bool,
    /// The maximal spacing r_max of that many elements in the domain, in metres (T eq. 3.1).
    pub r_max: f64,
}

/// The learnt pattern: all that a synthesis needs.
#[derive(Debug, Clone)]
pub struct Analysis {
    /// The distance of the axis.
    pub metric: Metric,
    /// Area of the domain in m².
    pub area: f64,
    /// The classes, by number.
    pub classes: Vec<ClassSummary>,
    /// Which class looks at which.
    pub dependencies: Dependencies,
    /// One curve for each of [`Dependencies::curves`], in that order.
    pub curves: Vec<Curve>,
}

impl Analysis {
    /// The curve of `child` looking at `parent`.
    pub fn curve(&self, child: usize, parent: usize) -> Option<&Curve> {
        self.curves.iter().find(|c| c.child == child && c.parent == parent)
    }
}

/// The correlation curves of `elements` observed in `domain`, one for every class and every
/// dependency (T eq. 3.2–3.4, 3.8; counts as n(n−1) and n_a·n_b, ring areas as the expected
/// kernel mass, so that independent uniform patterns give 1 everywhere).
///
/// A curve of a child and a parent looks from the child's elements: distances in r_max of the
/// child, border weights of circles around the child's elements.
///
/// # Errors
/// [`PcfError::EmptyClass`] for a class of `dependencies` without elements; a bad axis; a stop.
pub fn analyse(
    elements: &[Element],
    domain: &Region,
    (dependencies, options): (&Dependencies, &AnalysisOptions),
    run: &Run,
) -> Result<Analysis, PcfError> {
    let axis = options.axis.checked()?;
    let correlator = Correlator::new(options.metric, Kernel::new(axis), options.weight_cap);
    let classes = summaries(elements, dependencies, domain.area())?;
    let mut curves = Vec::new();
    for (done, class) in dependencies.order().iter().enumerate() {
        run.progress("distribution.analysis", done as u64, classes.len() as u64)?;
        let child = Child { class: *class, elements, classes: &classes, domain, correlator: &correlator };
        curves.extend(child.curves(dependencies.parents(*class), options, run)?);
    }
    let area = domain.area();
    Ok(Analysis { metric: options.metric, area, classes, dependencies: dependencies.clone(), curves })
}

/// What is known of each class before any pair is looked at.
///
/// # Errors
/// [`PcfError::EmptyClass`] for a class of `graph` without elements.
pub fn summaries(elements: &[Element], graph: &Dependencies, area: f64) -> Result<Vec<ClassSummary>, PcfError> {
    let summary = |class: usize| {
        let members: Vec<Element> = elements.iter().filter(|e| e.class == class).copied().collect();
        (!members.is_empty()).then(|| ClassSummary::of(&members, area)).ok_or(PcfError::EmptyClass { class })
    };
    (0..graph.order().len()).map(summary).collect()
}

impl ClassSummary {
    fn of(members: &[Element], area: f64) -> Self {
        let radii: Vec<f64> = members.iter().map(|e| e.radius).collect();
        let r_max = maximal_spacing(area, members.len());
        let centres: Vec<Point> = members.iter().map(|e| e.centre).collect();
        let grid = CellGrid::new(&centres, r_max);
        let largest = radii.iter().copied().fold(0.0, f64::max);
        let (mut closest, mut overlaps) = (f64::INFINITY, false);
        for (i, e) in members.iter().enumerate() {
            grid.for_each_near(e.centre, (2.0 * r_max).max(e.radius + largest), |j| {
                let distance = e.centre.distance(centres[j]);
                if j != i {
                    closest = closest.min(distance);
                    overlaps |= distance < e.radius + radii[j];
                }
            });
        }
        let closest = if closest.is_finite() { closest } else { 0.0 };
        Self { count: members.len(), radii, closest, overlaps, r_max }
    }
}

/// The bodies of one class in `unit` metres.
pub(super) fn bodies(elements: &[Element], class: usize, unit: f64) -> Vec<Body> {
    let frame = Frame::of_unit(unit);
    let body = |e: &Element| Body { centre: e.centre, radius: e.radius / unit, frame };
    elements.iter().filter(|e| e.class == class).map(body).collect()
}

/// M(r) for elements of these radii (in metres) looking at each other, in `unit` metres.
pub(super) fn expected_mass(metric: Metric, axis: &Axis, (a, b, same): (&[f64], &[f64], bool), unit: f64) -> Vec<f64> {
    let scaled = |radii: &[f64]| radii.iter().map(|r| r / unit).collect::<Vec<f64>>();
    match metric {
        Metric::Disk => mass::of_disks(axis, &mass::RadiusMoments::of(&scaled(a), &scaled(b), same)),
        Metric::Point | Metric::Ellipse => mass::of_points(axis),
    }
}

/// One class looking around.
struct Child<'a> {
    class: usize,
    elements: &'a [Element],
    classes: &'a [ClassSummary],
    domain: &'a Region,
    correlator: &'a Correlator,
}

/// What one element sees: a curve for each crowd, and its triplets among its own class.
struct Seen {
    rows: Vec<Vec<f64>>,
    /// Places of the axis, from the first, whose circles lie in the domain, by crowd.
    whole: Vec<usize>,
    triplets: Vec<f64>,
    far: Option<Far>,
}

/// What one element sees beyond the axis: pairs with each crowd, and how much of each ring around
/// it lies in the domain.
struct Far {
    pairs: Vec<Vec<f64>>,
    rings: Vec<f64>,
}

impl Child<'_> {
    fn curves(&self, parents: &[usize], options: &AnalysisOptions, run: &Run) -> Result<Vec<Curve>, PcfError> {
        let unit = self.classes[self.class].r_max;
        let crowd = |class: usize| Crowd::new(bodies(self.elements, class, unit), unit);
        let targets: Vec<usize> = std::iter::once(self.class).chain(parents.iter().copied()).collect();
        let crowds: Vec<Crowd> = targets.iter().map(|c| crowd(*c)).collect();
        let sum = |p: &usize| CurveSum::new(self.empty_curve(*p), options.keep_individual);
        let mut sums: Vec<CurveSum> = targets.iter().map(sum).collect();
        let factor = |(sum, parent): (&CurveSum, &usize)| curve::factors(&sum.curve.mass, self.density(*parent));
        let factors: Vec<Vec<f64>> = sums.iter().zip(&targets).map(factor).collect();
        let squares = options.triplets.then(|| self.correlator.squared());
        let axis = self.tail_axis();
        let mut tails: Vec<TailSum> = targets.iter().map(|_| TailSum::new(&axis)).collect();
        let count = self.classes[self.class].count;
        for start in (0..count).step_by(CHUNK) {
            let see = |i: usize| {
                (!run.is_stopped()).then(|| self.see(i, (&crowds, &factors), squares.as_ref().zip(Some(&axis))))
            };
            let seen: Vec<Option<Seen>> = (start..(start + CHUNK).min(count)).into_par_iter().map(see).collect();
            run.check()?;
            for Seen { rows, whole, triplets, far } in seen.into_iter().flatten() {
                for ((row, whole), sum) in rows.into_iter().zip(whole).zip(&mut sums) {
                    sum.look_near(&row, whole);
                    sum.add(&row);
                }
                sums[0].add_triplets(&triplets);
                if let Some(Far { pairs, rings }) = far {
                    pairs.iter().zip(&mut tails).for_each(|(pairs, sum)| sum.add(pairs, &rings));
                }
            }
        }
        if let Some(squares) = &squares {
            self.seen_by_parents(&crowds, squares, &mut sums, run)?;
            sums[0].curve.root_counts = self.root_counts(&crowds[0]);
            for ((sum, tail), parent) in sums.iter_mut().zip(&tails).zip(&targets) {
                sum.curve.tail = Tail { axis, mean: tail.finish(self.density(*parent)) };
            }
        }
        Ok(sums.into_iter().map(CurveSum::finish).collect())
    }

    /// Partners of the class `parent` per r_max² of the class.
    fn density(&self, parent: usize) -> f64 {
        let unit = self.classes[self.class].r_max;
        let partners = self.classes[parent].count - usize::from(parent == self.class);
        partners as f64 * unit * unit / self.domain.area()
    }

    /// How evenly the class fills windows.
    fn root_counts(&self, crowd: &Crowd) -> Vec<Option<f64>> {
        let mut windows = Windows::over(self.domain, self.domain.bounds(), self.classes[self.class].r_max);
        crowd.bodies().iter().for_each(|body| windows.add(body.centre, 1.0));
        windows.goals()
    }

    /// The bins beyond the axis.
    fn tail_axis(&self) -> TailAxis {
        let (summary, axis) = (&self.classes[self.class], self.correlator.kernel.axis());
        let radius = summary.radii.iter().sum::<f64>() / summary.count.max(1) as f64 / summary.r_max;
        TailAxis::beyond(&axis, (self.correlator.metric, radius), (self.domain, summary.r_max))
    }

    /// Adds to the curves towards each parent how far elements of the class come together around
    /// the parent's.
    fn seen_by_parents(
        &self,
        crowds: &[Crowd],
        squares: &Correlator,
        sums: &mut [CurveSum],
        run: &Run,
    ) -> Result<(), PcfError> {
        let unit = self.classes[self.class].r_max;
        let density = self.classes[self.class].count as f64 * unit * unit / self.domain.area();
        for (sum, crowd) in sums.iter_mut().zip(crowds).skip(1) {
            let factors = curve::factors(&sum.curve.mass, density);
            let triplets_of = |body: &Body| {
                let reach = self.correlator.reach(body, &crowds[0]);
                let weight = BorderWeight::new(self.domain, body, reach, self.correlator.weight_cap);
                let (mut row, mut same) = (vec![0.0; factors.len()], vec![0.0; factors.len()]);
                self.correlator.add_row(&mut row, (body, &weight), &crowds[0], None);
                squares.add_row(&mut same, (body, &weight), &crowds[0], None);
                row.iter_mut().zip(&factors).for_each(|(value, factor)| *value *= factor);
                curve::triplets(&row, &same, &factors)
            };
            for chunk in crowd.bodies().chunks(CHUNK) {
                run.check()?;
                let all: Vec<Vec<f64>> = chunk.par_iter().map(triplets_of).collect();
                all.iter().for_each(|triplets| sum.add_triplets(triplets));
            }
        }
        Ok(())
    }

    /// What element `i` sees of each crowd, the first of which is its own class.
    /// What lies beyond the curves, by the `more` of squared terms and far bins, if asked for.
    fn see(
        &self,
        i: usize,
        (crowds, factors): (&[Crowd], &[Vec<f64>]),
        more: Option<(&Correlator, &TailAxis)>,
    ) -> Seen {
        let body = &crowds[0].bodies()[i];
        let reach = crowds.iter().map(|c| self.correlator.reach(body, c)).fold(0.0, f64::max);
        let reach = more.map_or(reach, |(_, tail)| reach.max(tail.range().1));
        let weight = BorderWeight::new(self.domain, body, reach, self.correlator.weight_cap);
        let row = |(k, crowd): (usize, &Crowd)| {
            let mut row = vec![0.0; factors[k].len()];
            self.correlator.add_row(&mut row, (body, &weight), crowd, (k == 0).then_some(i));
            row.iter_mut().zip(&factors[k]).for_each(|(value, factor)| *value *= factor);
            row
        };
        let rows: Vec<Vec<f64>> = crowds.iter().enumerate().map(row).collect();
        let triplets = more.map(|(squares, _)| {
            let mut same = vec![0.0; factors[0].len()];
            squares.add_row(&mut same, (body, &weight), &crowds[0], Some(i));
            curve::triplets(&rows[0], &same, &factors[0])
        });
        let unit = self.classes[self.class].r_max;
        let far = more.filter(|(_, tail)| tail.bins > 0).map(|(_, tail)| Far {
            pairs: crowds.iter().map(|crowd| tail.pairs((body.centre, unit), crowd)).collect(),
            rings: tail.rings_inside(&weight),
        });
        let whole = crowds.iter().map(|crowd| self.correlator.places_within(body, crowd, weight.clearance())).collect();
        Seen { rows, whole, triplets: triplets.unwrap_or_default(), far }
    }

    fn empty_curve(&self, parent: usize) -> Curve {
        let (axis, unit) = (self.correlator.kernel.axis(), self.classes[self.class].r_max);
        let radii = (&*self.classes[self.class].radii, &*self.classes[parent].radii, parent == self.class);
        let mass = expected_mass(self.correlator.metric, &axis, radii, unit);
        Curve { child: self.class, parent, unit, axis, mass, ..Curve::empty(axis) }
    }
}

/// A curve being gathered from individual ones.
pub(super) struct CurveSum {
    curve: Curve,
    count: usize,
    /// How many individual curves there are, by the place up to which their circles are whole.
    whole: Vec<usize>,
    middles: usize,
    keep: bool,
}

impl CurveSum {
    pub(super) fn new(curve: Curve, keep: bool) -> Self {
        Self { whole: vec![0; curve.mean.len()], curve, count: 0, middles: 0, keep }
    }

    pub(super) fn add(&mut self, row: &[f64]) {
        let curve = &mut self.curve;
        for (bin, value) in row.iter().enumerate() {
            curve.mean[bin] += value;
            curve.lower[bin] = if self.count == 0 { *value } else { curve.lower[bin].min(*value) };
            curve.upper[bin] = curve.upper[bin].max(*value);
        }
        self.count += 1;
        if self.keep {
            curve.individual.push(row.to_vec());
        }
    }

    /// Looks at how few partners an element with this curve has near, before it is added; its circles
    /// up to the first `whole` places lie in the domain.
    pub(super) fn look_near(&mut self, row: &[f64], whole: usize) {
        let (mut sum, mut mass) = (0.0, 0.0);
        let Curve { mass: masses, least_near, least_near_border, .. } = &mut self.curve;
        let bounds = least_near.iter_mut().zip(least_near_border).zip(&mut self.whole);
        for (bin, ((value, expected), ((inside, anywhere), count))) in row.iter().zip(masses).zip(bounds).enumerate() {
            mass += *expected;
            sum += value * *expected;
            let mean = if mass > 0.0 { sum / mass } else { 0.0 };
            *anywhere = if self.count == 0 { mean } else { anywhere.min(mean) };
            if bin < whole {
                *inside = if *count == 0 { mean } else { inside.min(mean) };
                *count += 1;
            }
        }
    }

    /// Adds the triplets around one element; none: they are not asked for.
    pub(super) fn add_triplets(&mut self, triplets: &[f64]) {
        let curve = &mut self.curve;
        self.middles += 1;
        curve.triplets.resize(triplets.len(), 0.0);
        curve.triplet_variance.resize(triplets.len(), 0.0);
        for (bin, value) in triplets.iter().enumerate() {
            curve.triplets[bin] += value;
            curve.triplet_variance[bin] += value * value;
        }
    }

    pub(super) fn finish(mut self) -> Curve {
        let (count, middles) = (self.count.max(1) as f64, self.middles.max(1) as f64);
        for (mean, square) in self.curve.triplets.iter_mut().zip(&mut self.curve.triplet_variance) {
            *mean /= middles;
            *square = (*square / middles - *mean * *mean).max(0.0);
        }
        let Curve { least_near, least_near_border, .. } = &mut self.curve;
        for ((inside, anywhere), whole) in least_near.iter_mut().zip(least_near_border).zip(&self.whole) {
            *inside = if 2 * whole < self.count { *anywhere } else { *inside };
        }
        self.curve.mean.iter_mut().for_each(|v| *v /= count);
        self.curve
    }
}
