use super::intensity::Intensity;
use super::partners::Partner;
use super::partners::Partners;
use crate::compute::geometry::Point;
use crate::compute::geometry::Region;
use crate::compute::pcf::Analysis;
use crate::compute::pcf::Axis;
use crate::compute::pcf::Body;
use crate::compute::pcf::BorderWeight;
use crate::compute::pcf::Curve;
use crate::compute::pcf::Element;
use crate::compute::pcf::Frame;
use crate::compute::pcf::Kernel;
use crate::compute::pcf::Metric;
use crate::compute::pcf::WEIGHT_CAP;
use crate::compute::pcf::analyse::expected_mass;
use crate::compute::pcf::curve;

/// The class being laid out, among all that is there already.
pub(super) struct Scene<'a> {
    pub(super) class: usize,
    pub(super) metric: Metric,
    pub(super) axis: Axis,
    pub(super) kernel: Kernel,
    /// Metres in one r_max of the class in the target domain.
    pub(super) unit: f64,
    pub(super) domain: &'a Region,
    pub(super) intensity: Intensity<'a>,
    /// The active curves: its own first, then one for each parent.
    pub(super) views: Vec<View<'a>>,
    /// Elements of the class in the result, those that were there included.
    pub(super) count: usize,
    /// Centres of the class may not come nearer than this, in metres: half the exemplar's
    /// smallest distance, scaled with r_max (for disks, which keep their size, only down).
    pub(super) closest: f64,
    largest_radius: f64,
    /// What a squared difference of triplets weighs at each place of the axis: the inverse of
    /// their variance in the exemplar. Empty when it has none.
    pub(super) triplet_weights: Vec<f64>,
    /// The kernel squared.
    squares: Kernel,
}

/// One active curve: what the class sees of one class, and what it should see.
pub(super) struct View<'a> {
    pub(super) target: &'a Curve,
    /// 1/(density·M(r)) in the target domain.
    pub(super) factors: Vec<f64>,
    pub(super) mass: Vec<f64>,
    /// Who is looked at; of its own class, those that were there before.
    pub(super) partners: Partners,
}

impl<'a> Scene<'a> {
    /// The scene of `class` with `radii` (metres) to come, among `placed`.
    pub(super) fn new(
        analysis: &'a Analysis,
        (domain, intensity): (&'a Region, Intensity<'a>),
        (class, radii): (usize, &[f64]),
        placed: &[Element],
    ) -> Self {
        let own: Vec<f64> = radii_of(placed, class).chain(radii.iter().copied()).collect();
        let unit = crate::compute::pcf::maximal_spacing(domain.area(), own.len());
        let curves = analysis.curves.iter().filter(|c| c.child == class);
        let axis = analysis.curves.iter().find(|c| c.child == class).map_or_else(Axis::default, |c| c.axis);
        let view = |target: &'a Curve| {
            let same = target.parent == class;
            let others: Vec<f64> = if same { own.clone() } else { radii_of(placed, target.parent).collect() };
            let mass = expected_mass(analysis.metric, &axis, (&own, &others, same), unit);
            let density = (others.len() as f64 - f64::from(u8::from(same))) * unit * unit / domain.area();
            let mut partners = Partners::new(domain.bounds(), unit);
            for e in placed.iter().filter(|e| e.class == target.parent) {
                let weight = intensity.weight(e.centre);
                partners.push(Partner { place: e.centre, radius: e.radius / unit, weight });
            }
            View { target, factors: curve::factors(&mass, density), mass, partners }
        };
        let summary = &analysis.classes[class];
        let scale =
            if analysis.metric == Metric::Point { unit / summary.r_max } else { (unit / summary.r_max).min(1.0) };
        Self {
            class,
            metric: analysis.metric,
            axis,
            kernel: Kernel::new(axis),
            unit,
            domain,
            intensity,
            views: curves.map(view).collect(),
            count: own.len(),
            closest: 0.5 * summary.closest * scale,
            triplet_weights: analysis.curve(class, class).map(triplet_weights).unwrap_or_default(),
            squares: Kernel::new(axis).squared(),
            largest_radius: own.iter().copied().fold(0.0, f64::max) / unit,
        }
    }

    /// The largest radius of the class, in r_max.
    pub(super) fn largest_radius(&self) -> f64 {
        self.largest_radius
    }

    /// The largest Euclidean distance, in r_max, at which an element of `radius` sees one of
    /// `partners` below `place` on the axis.
    pub(super) fn reach(&self, partners: &Partners, radius: f64, place: f64) -> f64 {
        self.metric.reach(place, radius, partners.largest_radius())
    }

    /// The border weight around `p`, for pairs up to `reach` r_max.
    pub(super) fn border(&self, p: Point, reach: f64) -> BorderWeight {
        let body = Body { centre: p, radius: 0.0, frame: Frame::of_unit(self.unit) };
        BorderWeight::new(self.domain, &body, reach, WEIGHT_CAP)
    }

    /// Adds to `row` what an element at `p` sees of `partners`, but for the one at `itself`.
    pub(super) fn add_row(&self, row: &mut [f64], seen_from: Eye<'_>, partners: (&Partners, Option<usize>)) {
        self.for_each_pair(seen_from, partners, |place, weight| self.kernel.add(row, place, weight));
    }

    /// The same for the squares of the terms.
    pub(super) fn add_squares(&self, row: &mut [f64], seen_from: Eye<'_>, partners: (&Partners, Option<usize>)) {
        self.for_each_pair(seen_from, partners, |place, weight| self.squares.add(row, place, weight * weight));
    }

    /// Calls `visit` with the place on the axis and the weight of every pair.
    fn for_each_pair(
        &self,
        (p, radius, border): Eye<'_>,
        (partners, itself): (&Partners, Option<usize>),
        mut visit: impl FnMut(f64, f64),
    ) {
        let places = self.axis.reach();
        partners.for_each_near(p, self.reach(partners, radius, places) * self.unit, |j, partner| {
            let distance = partner.place.distance(p) / self.unit;
            let place = self.metric.value(distance, radius, partner.radius);
            if place <= places && itself != Some(j) {
                visit(place, border.at(distance) * partner.weight);
            }
        });
    }
}

/// From where an element looks: its place in metres, its radius in r_max, the border around it.
pub(super) type Eye<'a> = (Point, f64, &'a BorderWeight);

fn radii_of(elements: &[Element], class: usize) -> impl Iterator<Item = f64> {
    elements.iter().filter(move |e| e.class == class).map(|e| e.radius)
}

/// A place where the exemplar's triplets hardly vary weighs as if they varied by this share of
/// their mean variance.
const LEAST_VARIANCE: f64 = 0.01;

fn triplet_weights(curve: &Curve) -> Vec<f64> {
    let mean = curve.triplet_variance.iter().sum::<f64>() / curve.triplet_variance.len().max(1) as f64;
    let least = (mean * LEAST_VARIANCE).max(1e-12);
    curve.triplet_variance.iter().map(|v| 1.0 / v.max(least)).collect()
}
