use super::border_table::BorderTable;
use super::depths;
use super::goal::Goal;
use super::goal::Sparse;
use super::intensity::Intensity;
use super::kernel_rows::KernelRows;
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
use crate::compute::pcf::TailAxis;
use crate::compute::pcf::WEIGHT_CAP;
use crate::compute::pcf::analyse::expected_mass;
use crate::compute::pcf::curve;
use crate::compute::pcf::windows::DENSITY;
use rayon::prelude::*;

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
    /// How wide a square is in which the class is to have as many elements as in the exemplar, in
    /// r_max.
    pub(super) exemplar_side: f64,
    /// Centres of the class may not come nearer than this, in metres: half the exemplar's
    /// smallest distance, scaled with r_max (for disks, which keep their size, only down).
    pub(super) closest: f64,
    largest_radius: f64,
    mean_radius: f64,
    /// The kernel squared.
    squares: Kernel,
    /// The kernel by table, for trials.
    pub(super) rows: KernelRows,
    /// The places of the axis that trials look at.
    pub(super) sparse: Sparse,
    /// The bins beyond the axis; none with a painted density, which says itself how elements lie
    /// at large.
    pub(super) tail: TailAxis,
}

/// One active curve: what the class sees of one class, and what it should see.
pub(super) struct View<'a> {
    pub(super) target: &'a Curve,
    /// 1/(density·M(r)) in the target domain.
    pub(super) factors: Vec<f64>,
    pub(super) mass: Vec<f64>,
    /// Who is looked at; of its own class, those that were there before.
    pub(super) partners: Partners,
    /// Partners per r_max² in the target domain.
    pub(super) density: f64,
    /// What trials aim at.
    pub(super) goal: Goal,
    /// What a squared difference of the summed triplets weighs at each place of the axis: the
    /// inverse of their variance in the exemplar. Empty when it has none.
    pub(super) triplet_weights: Vec<f64>,
    /// The border weights around the partners, of parents with triplets.
    pub(super) borders: Vec<BorderTable>,
}

impl View<'_> {
    /// What the triplets of this view are multiplied by so that their mean is taken over the
    /// class, of which there are `count`, instead of over those in their middle.
    pub(super) fn per_child(&self, is_own: bool, count: usize) -> f64 {
        if is_own { 1.0 } else { count as f64 / self.partners.list().len().max(1) as f64 }
    }
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
        let sparse = Sparse::of(axis);
        let rows = KernelRows::new(sparse.axis);
        let view = |target: &'a Curve| {
            let same = target.parent == class;
            let others: Vec<f64> = if same { own.clone() } else { radii_of(placed, target.parent).collect() };
            let mass = expected_mass(analysis.metric, &axis, (&own, &others, same), unit);
            let density = (others.len() as f64 - f64::from(u8::from(same))) * unit * unit / domain.area();
            let partner = |e: &Element| {
                let weight = intensity.weight(e.centre);
                Partner { place: e.centre, radius: e.radius / unit, weight }
            };
            let partners = placed.iter().filter(|e| e.class == target.parent).map(partner).collect();
            let partners = Partners::new(partners, domain.bounds(), unit);
            let factors = curve::factors(&mass, density);
            let reverse = curve::factors(&mass, own.len() as f64 * unit * unit / domain.area());
            let goal = Goal::new(target, (&factors, &reverse), (&sparse, &rows));
            let triplet_weights =
                triplet_weights(target, &sparse, if same { 1.0 } else { others.len() as f64 / own.len() as f64 });
            View { target, factors, mass, partners, density, goal, triplet_weights, borders: Vec::new() }
        };
        let summary = &analysis.classes[class];
        let scale =
            if analysis.metric == Metric::Point { unit / summary.r_max } else { (unit / summary.r_max).min(1.0) };
        let tail = if intensity.is_flat() { curves.clone().next().map(|c| c.tail.axis) } else { None };
        let mut scene = Self {
            class,
            metric: analysis.metric,
            axis,
            kernel: Kernel::new(axis),
            unit,
            domain,
            intensity,
            views: curves.map(view).collect(),
            count: own.len(),
            exemplar_side: (summary.count as f64 / DENSITY).sqrt(),
            closest: 0.5 * summary.closest * scale,
            squares: Kernel::new(axis).squared(),
            rows,
            sparse,
            tail: tail.unwrap_or_default(),
            largest_radius: own.iter().copied().fold(0.0, f64::max) / unit,
            mean_radius: own.iter().sum::<f64>() / (own.len().max(1) as f64 * unit),
        };
        for v in 1..scene.views.len() {
            scene.views[v].borders = scene.border_tables(&scene.views[v]);
        }
        scene
    }

    /// The border weights around every partner of a view with triplets.
    fn border_tables(&self, view: &View<'_>) -> Vec<BorderTable> {
        if view.triplet_weights.is_empty() {
            return Vec::new();
        }
        let table = |p: &Partner| {
            let reach = self.metric.reach(self.axis.reach(), p.radius, self.largest_radius);
            BorderTable::new(self.domain, p.place, (reach, self.unit))
        };
        view.partners.list().par_iter().map(table).collect()
    }

    /// What the triplets of view `v` count: those of the class itself 1, those around parents 1
    /// together.
    pub(super) fn triplet_share(&self, v: usize) -> f64 {
        if v == 0 { 1.0 } else { 1.0 / (self.views.len() - 1) as f64 }
    }

    /// The largest radius of the class, in r_max.
    pub(super) fn largest_radius(&self) -> f64 {
        self.largest_radius
    }

    /// The mean radius of the class, in r_max.
    pub(super) fn mean_radius(&self) -> f64 {
        self.mean_radius
    }

    /// The largest Euclidean distance, in r_max, at which an element of `radius` sees one of
    /// `partners` below `place` on the axis.
    pub(super) fn reach(&self, partners: &Partners, radius: f64, place: f64) -> f64 {
        self.metric.reach(place, radius, partners.largest_radius())
    }

    /// The places of the sparse axis, from the first, at which all of `partners` of an element of
    /// `radius` are nearer than `distance`; both in r_max.
    pub(super) fn places_within(&self, (radius, distance): (f64, f64), partners: &[&Partners]) -> usize {
        let largest = partners.iter().map(|p| p.largest_radius()).fold(0.0, f64::max);
        self.sparse.axis.bins_up_to(self.metric.value(distance, radius, largest))
    }

    /// Distance of `p` to the border of the domain, at most [`depths::FARTHEST`], in r_max.
    pub(super) fn depth(&self, p: Point) -> f64 {
        self.domain.clearance(p, depths::FARTHEST * self.unit) / self.unit
    }

    /// The border weight by table, for trials.
    pub(super) fn border_table(&self, p: Point, reach: f64) -> BorderTable {
        BorderTable::new(self.domain, p, (reach, self.unit))
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

/// The inverse variances times `share`, the number of middles an element of the class has.
fn triplet_weights(curve: &Curve, sparse: &Sparse, share: f64) -> Vec<f64> {
    let variance = sparse.of_row(&curve.triplet_variance);
    let mean = variance.iter().sum::<f64>() / variance.len().max(1) as f64;
    let least = (mean * LEAST_VARIANCE).max(1e-12);
    variance.iter().map(|v| share / v.max(least)).collect()
}
