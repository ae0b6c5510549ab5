use super::partners::Partner;
use super::partners::Partners;
use super::patch::Patch;
use super::scene::Scene;
use crate::compute::geometry::Point;
use crate::compute::pcf::BorderWeight;
use crate::compute::pcf::RELATIVE_FLOOR;

/// Kernel rows are kept for this many places between two values of the axis.
const PHASES: usize = 16;

/// In trials the kernel is left out beyond this many σ (5·10⁻⁶ of its peak).
const CUT_OFF_SIGMAS: f64 = 3.5;

/// The error of a candidate whose centre is nearer to another than allowed.
pub(super) const BARRED: f64 = f64::INFINITY;

/// The kernel over the axis for any distance, from a table: one row a phase, each value an
/// addition.
pub(super) struct KernelRows {
    step: f64,
    half: isize,
    rows: Vec<Vec<f64>>,
}

impl KernelRows {
    pub(super) fn new(scene: &Scene<'_>) -> Self {
        let (sigma, step) = (scene.axis.sigma, scene.axis.step);
        let half = (CUT_OFF_SIGMAS * sigma / step).ceil() as isize;
        let value = |phase: usize, k: isize| {
            let x = (k as f64 - phase as f64 / PHASES as f64) * step / sigma;
            libm::exp(-x * x) / (std::f64::consts::PI.sqrt() * sigma)
        };
        let row = |phase: usize| (-half..=half + 1).map(|k| value(phase, k)).collect();
        Self { step, half, rows: (0..PHASES).map(row).collect() }
    }

    /// The first place of the axis, of `bins`, in reach of the kernel around `place`, and the
    /// kernel's values from there on.
    fn around(&self, place: f64, bins: usize) -> (usize, &[f64]) {
        let at = (place / self.step * PHASES as f64 + 0.5) as usize;
        let (bin, phase) = ((at / PHASES) as isize - 1, at % PHASES);
        let (first, last) = ((bin - self.half).max(0), (bin + self.half + 1).min(bins as isize - 1));
        if first > last {
            return (0, &[]);
        }
        let from = (first - bin + self.half) as usize;
        (first as usize, &self.rows[phase][from..=from + (last - first) as usize])
    }

    /// Adds `weight` times the kernel around `place` to `row`.
    fn add(&self, row: &mut [f64], place: f64, weight: f64) {
        let (first, kernel) = self.around(place, row.len());
        for (value, k) in row[first..].iter_mut().zip(kernel) {
            *value += weight * k;
        }
    }

    fn reach(&self, extent: f64) -> f64 {
        extent + self.half as f64 * self.step
    }
}

/// The sums of a block so far.
#[derive(Debug, Clone)]
pub(super) struct BlockSums {
    /// Elements the block will have.
    pub(super) count: usize,
    /// Elements it has.
    pub(super) placed: usize,
    /// Σ of their individual curves, one row a view.
    pub(super) sums: Vec<Vec<f64>>,
    /// Σ of their triplets; empty when the exemplar has none.
    pub(super) triplets: Vec<f64>,
    /// Of the rings around the block's elements, the share inside the block, at every place of
    /// the axis: 1 for a block that is all of the domain.
    inside: Vec<f64>,
    /// The share of the neighbouring blocks that is filled.
    neighbours: f64,
}

/// A block while it is filled: its elements, what each sees of its own class, and the sums.
#[derive(Debug, Clone)]
pub(super) struct Filling {
    /// The elements so far.
    pub(super) inner: Partners,
    /// Their individual curves towards their own class.
    pub(super) curves: Vec<Vec<f64>>,
    /// The sums.
    pub(super) sums: BlockSums,
}

/// Tries elements in a block: an error after T eq. 3.13.
pub(super) struct Trial<'a> {
    patch: &'a Patch<'a>,
    kernel: &'a KernelRows,
    /// Kernel sums of the last candidate, one row a view; of its own class without the block.
    rows: Vec<Vec<f64>>,
    /// What the block's own elements add to the first of them.
    inner: Vec<f64>,
    /// Σ of squared terms of the candidate and its own class.
    same: Vec<f64>,
    /// Σ over the block's elements of their curve times the candidate's term.
    crossed: Vec<f64>,
}

impl<'a> Trial<'a> {
    pub(super) fn new(patch: &'a Patch<'a>, kernel: &'a KernelRows) -> Self {
        let zeros = || vec![0.0; patch.scene.axis.bins()];
        let rows = patch.scene.views.iter().map(|_| zeros()).collect();
        Self { patch, kernel, rows, inner: zeros(), same: zeros(), crossed: zeros() }
    }

    /// The error of an element of `radius` (r_max) at `p`, given the block's elements so far;
    /// whatever lies above `bound` is not worked out to the end. The individual curve towards
    /// its own class has no lower bound here, as the class is not complete yet.
    pub(super) fn error(&mut self, (p, radius): (Point, f64), filling: &Filling, bound: f64) -> f64 {
        let (scene, extent) = (self.patch.scene, self.kernel.reach(self.patch.scene.axis.extent));
        let border = scene.border(p, self.patch.farthest((radius, &filling.inner), extent));
        if !self.see_own((p, radius), &border, filling) {
            return BARRED;
        }
        let views = scene.views.len();
        let (mut growth, mut outside) = (self.triplet_growth(&filling.sums), 0.0_f64);
        for v in 0..views {
            if v > 0 {
                self.see_parent(v, (p, radius), &border);
            }
            let (of_view, out) = self.errors_of(v, &filling.sums);
            growth += of_view / views as f64;
            outside = outside.max(out);
            if outside > bound {
                break;
            }
        }
        growth.max(0.0) + outside
    }

    /// Sums over the candidate's own class; `false` when it comes too near one of it.
    fn see_own(&mut self, (p, radius): (Point, f64), border: &BorderWeight, filling: &Filling) -> bool {
        let (scene, kernel, bins) = (self.patch.scene, self.kernel, self.patch.scene.axis.bins());
        let extent = kernel.reach(scene.axis.extent);
        [&mut self.rows[0], &mut self.inner, &mut self.same, &mut self.crossed].into_iter().for_each(|r| r.fill(0.0));
        let mut barred = false;
        let mut term = |partner: &Partner| {
            let distance = partner.place.distance(p) / scene.unit;
            barred |= distance * scene.unit < scene.closest;
            let place = scene.metric.value(distance, radius, partner.radius);
            (place <= extent).then(|| (kernel.around(place, bins), border.at(distance) * partner.weight))
        };
        let far = |partners: &Partners| scene.reach(partners, radius, extent) * scene.unit;
        let context = self.patch.partners(0);
        context.for_each_near(p, far(context), |_, partner| {
            let Some(((first, kernel), weight)) = term(partner) else { return };
            for (k, value) in kernel.iter().enumerate() {
                self.rows[0][first + k] += weight * value;
                self.same[first + k] += (weight * value) * (weight * value);
            }
        });
        filling.inner.for_each_near(p, far(&filling.inner), |j, partner| {
            let Some(((first, kernel), weight)) = term(partner) else { return };
            let curve = &filling.curves[j][first..];
            for (k, value) in kernel.iter().enumerate() {
                let add = weight * value;
                self.inner[first + k] += add;
                self.same[first + k] += add * add;
                self.crossed[first + k] += add * curve[k];
            }
        });
        !barred
    }

    fn see_parent(&mut self, v: usize, (p, radius): (Point, f64), border: &BorderWeight) {
        let (scene, kernel, row) = (self.patch.scene, self.kernel, &mut self.rows[v]);
        let extent = kernel.reach(scene.axis.extent);
        row.fill(0.0);
        let partners = self.patch.partners(v);
        partners.for_each_near(p, scene.reach(partners, radius, extent) * scene.unit, |_, partner| {
            let distance = partner.place.distance(p) / scene.unit;
            let place = scene.metric.value(distance, radius, partner.radius);
            if place <= extent {
                kernel.add(row, place, border.at(distance) * partner.weight);
            }
        });
    }

    /// What the candidate adds to the block's triplets at a place: its own, and those of the
    /// elements that get one partner more.
    fn triplets_at(&self, bin: usize) -> f64 {
        let factor = self.patch.scene.views[0].factors[bin];
        let sum = (self.rows[0][bin] + self.inner[bin]) * factor;
        sum * sum - self.same[bin] * factor * factor + 2.0 * self.crossed[bin] * factor
    }

    /// The growth of the distance of the block's triplets to their target, weighted by the
    /// inverse variance among the exemplar's elements (ours: curves alone leave open whether
    /// partners come one by one or together, which is what clumps and gaps are made of).
    fn triplet_growth(&self, sums: &BlockSums) -> f64 {
        let target = self.patch.scene.views[0].target;
        let mut growth = 0.0;
        for (bin, inverse) in self.patch.scene.triplet_weights.iter().enumerate() {
            let triplets = target.triplets[bin];
            let before = sums.triplets[bin] - triplets * sums.expected_triplets(bin, sums.placed);
            let after =
                sums.triplets[bin] + self.triplets_at(bin) - triplets * sums.expected_triplets(bin, sums.placed + 1);
            growth += (after * after - before * before) * inverse;
        }
        growth / target.triplets.len().max(1) as f64
    }

    /// For one view: the growth of the block's distance to its target curve, and how far the
    /// candidate's own curve leaves the validity region (the second term of T eq. 3.13).
    ///
    /// T's first term is the largest relative excess of the new mean curve. It sees only one
    /// place of the axis, and neither what is still missing nor that a curve of few pairs is
    /// rough. Ours is the growth of Σ_r (sum − expected)²·(density·M/target), each place
    /// weighted by the inverse variance of independent pairs: negative when the candidate
    /// brings the pattern nearer its target, 1 or 2 in the mean when it neither helps nor harms.
    fn errors_of(&self, v: usize, sums: &BlockSums) -> (f64, f64) {
        let view = &self.patch.scene.views[v];
        let (mut growth, mut outside) = (0.0, 0.0_f64);
        for bin in 0..view.factors.len() {
            let factor = view.factors[bin];
            if factor == 0.0 {
                continue;
            }
            let inner = if v == 0 { self.inner[bin] * factor } else { 0.0 };
            let outer = self.rows[v][bin] * factor;
            let target = view.target.mean[bin];
            let before = sums.sums[v][bin] - target * sums.expected(v, bin, sums.placed);
            let after = sums.sums[v][bin] + outer + 2.0 * inner - target * sums.expected(v, bin, sums.placed + 1);
            growth += (after * after - before * before) / (factor * target.max(RELATIVE_FLOOR));
            let upper = view.target.upper[bin];
            outside = outside.max((outer + inner - upper) / upper.max(RELATIVE_FLOOR));
            if v > 0 {
                let lower = view.target.lower[bin];
                outside = outside.max((lower - outer) / lower.max(RELATIVE_FLOOR));
            }
        }
        (growth / view.factors.len() as f64, outside)
    }

    /// Adds the last candidate, tried with no bound below its error, to the block.
    pub(super) fn accept(&self, partner: Partner, filling: &mut Filling) {
        let (scene, factors) = (self.patch.scene, &self.patch.scene.views[0].factors);
        let Filling { inner, curves, sums } = filling;
        for (bin, triplets) in sums.triplets.iter_mut().enumerate() {
            *triplets += self.triplets_at(bin);
        }
        for (v, view) in scene.views.iter().enumerate() {
            for (bin, factor) in view.factors.iter().enumerate() {
                let inner = if v == 0 { 2.0 * self.inner[bin] } else { 0.0 };
                sums.sums[v][bin] += (self.rows[v][bin] + inner) * factor;
            }
        }
        let extent = self.kernel.reach(scene.axis.extent);
        let border = scene.border(partner.place, self.patch.farthest((partner.radius, inner), extent));
        let far = scene.reach(inner, partner.radius, extent) * scene.unit;
        inner.for_each_near(partner.place, far, |j, other| {
            let distance = other.place.distance(partner.place) / scene.unit;
            let place = scene.metric.value(distance, partner.radius, other.radius);
            if place <= extent {
                let (first, kernel) = self.kernel.around(place, scene.axis.bins());
                let weight = border.at(distance) * partner.weight;
                for (k, value) in kernel.iter().enumerate() {
                    curves[j][first + k] += weight * value * factors[first + k];
                }
            }
        });
        let own = (0..factors.len()).map(|bin| (self.rows[0][bin] + self.inner[bin]) * factors[bin]);
        curves.push(own.collect());
        inner.push(partner);
        sums.placed += 1;
    }
}

impl BlockSums {
    /// The sums of an empty block that will have `count` elements, `side` metres wide (infinite
    /// when it is all of the domain), with a share of its `neighbours` filled.
    pub(super) fn new(scene: &Scene<'_>, count: usize, (side, neighbours): (f64, f64)) -> Self {
        let bins = scene.axis.bins();
        let share = |bin: usize| {
            let largest = scene.largest_radius();
            square_covariance(scene.metric.reach(scene.axis.r(bin), largest, largest) * scene.unit / side)
        };
        let sums = vec![vec![0.0; bins]; scene.views.len()];
        let triplets = vec![0.0; scene.triplet_weights.len()];
        Self { count: count.max(1), placed: 0, sums, triplets, inside: (0..bins).map(share).collect(), neighbours }
    }

    /// The sum of `placed` individual curves, over the target curve: towards a parent each is
    /// complete, towards the class itself it sees the block's elements so far and what the
    /// neighbouring blocks hold.
    fn expected(&self, v: usize, bin: usize, placed: usize) -> f64 {
        if v > 0 { placed as f64 } else { placed as f64 * self.seen(bin, placed) }
    }

    /// The sum of `placed` elements' triplets, over the target: both partners must be there.
    fn expected_triplets(&self, bin: usize, placed: usize) -> f64 {
        placed as f64 * self.seen(bin, placed).powi(2)
    }

    /// The share of an element's partners of its own class that is there.
    fn seen(&self, bin: usize, placed: usize) -> f64 {
        let partners = placed.saturating_sub(1) as f64 / (self.count.max(2) - 1) as f64;
        self.inside[bin] * partners + (1.0 - self.inside[bin]) * self.neighbours
    }
}

/// The share of the circle of radius `r` around a uniform place in the unit square that lies in
/// the square, up to r = 1.
fn square_covariance(r: f64) -> f64 {
    let r = r.min(1.0);
    1.0 - 4.0 * r / std::f64::consts::PI + r * r / std::f64::consts::PI
}
