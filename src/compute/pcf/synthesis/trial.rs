use super::partners::Partners;
use super::patch::Patch;
use super::scene::Scene;
use crate::compute::geometry::Point;
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

    /// Adds `weight` times the kernel around `place` to `row`.
    fn add(&self, row: &mut [f64], place: f64, weight: f64) {
        let at = (place / self.step * PHASES as f64 + 0.5) as usize;
        let (bin, phase) = ((at / PHASES) as isize - 1, at % PHASES);
        let (first, last) = ((bin - self.half).max(0), (bin + self.half + 1).min(row.len() as isize - 1));
        if first > last {
            return;
        }
        let from = (first - bin + self.half) as usize;
        let kernel = &self.rows[phase][from..=from + (last - first) as usize];
        for (value, k) in row[first as usize..=last as usize].iter_mut().zip(kernel) {
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
    /// Of the rings around the block's elements, the share inside the block, at every place of
    /// the axis: 1 for a block that is all of the domain.
    inside: Vec<f64>,
    /// The share of the neighbouring blocks that is filled.
    neighbours: f64,
}

/// Tries elements in a block: an error after T eq. 3.13.
pub(super) struct Trial<'a> {
    patch: &'a Patch<'a>,
    kernel: &'a KernelRows,
    /// Individual curves of the last candidate, one a view; its own class without the block.
    rows: Vec<Vec<f64>>,
    /// What the block's own elements add to the first of them.
    inner: Vec<f64>,
}

impl<'a> Trial<'a> {
    pub(super) fn new(patch: &'a Patch<'a>, kernel: &'a KernelRows) -> Self {
        let zeros = vec![0.0; patch.scene.axis.bins()];
        Self { patch, kernel, rows: vec![zeros.clone(); patch.scene.views.len()], inner: zeros }
    }

    /// The error of an element of `radius` (r_max) at `p`, given the block's elements so far;
    /// whatever lies above `bound` is not worked out to the end. The individual curve towards
    /// its own class has no lower bound here, as the class is not complete yet.
    pub(super) fn error(&mut self, (p, radius): (Point, f64), block: (&Partners, &BlockSums), bound: f64) -> f64 {
        let (scene, extent) = (self.patch.scene, self.kernel.reach(self.patch.scene.axis.extent));
        let border = scene.border(p, self.patch.farthest((radius, block.0), extent));
        let (mut growth, mut outside, mut barred) = (0.0, 0.0_f64, false);
        for v in 0..scene.views.len() {
            let (kernel, row, inner) = (self.kernel, &mut self.rows[v], &mut self.inner);
            row.fill(0.0);
            let mut add = |row: &mut [f64], partner: &super::partners::Partner| {
                let distance = partner.place.distance(p) / scene.unit;
                let place = scene.metric.value(distance, radius, partner.radius);
                if place <= extent {
                    kernel.add(row, place, border.at(distance) * partner.weight);
                }
                barred |= v == 0 && distance * scene.unit < scene.closest;
            };
            let partners = self.patch.partners(v);
            let far = scene.reach(partners, radius, extent) * scene.unit;
            partners.for_each_near(p, far, |_, partner| add(row, partner));
            if v == 0 {
                inner.fill(0.0);
                let far = scene.reach(block.0, radius, extent) * scene.unit;
                block.0.for_each_near(p, far, |_, partner| add(inner, partner));
            }
            if barred {
                return BARRED;
            }
            let (of_view, out) = self.errors_of(v, block.1);
            growth += of_view / scene.views.len() as f64;
            outside = outside.max(out);
            if outside > bound {
                break;
            }
        }
        growth.max(0.0) + outside
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

    /// Adds the last candidate, tried with no bound below its error, to the block's sums.
    pub(super) fn accept(&self, sums: &mut BlockSums) {
        sums.placed += 1;
        for (v, view) in self.patch.scene.views.iter().enumerate() {
            for (bin, factor) in view.factors.iter().enumerate() {
                let inner = if v == 0 { 2.0 * self.inner[bin] } else { 0.0 };
                sums.sums[v][bin] += (self.rows[v][bin] + inner) * factor;
            }
        }
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
        Self { count: count.max(1), placed: 0, sums, inside: (0..bins).map(share).collect(), neighbours }
    }

    /// The sum of `placed` individual curves, over the target curve: towards a parent each is
    /// complete, towards the class itself it sees the block's elements so far and what the
    /// neighbouring blocks hold.
    fn expected(&self, v: usize, bin: usize, placed: usize) -> f64 {
        if v > 0 {
            return placed as f64;
        }
        let partners = placed.saturating_sub(1) as f64 / (self.count.max(2) - 1) as f64;
        placed as f64 * (self.inside[bin] * partners + (1.0 - self.inside[bin]) * self.neighbours)
    }
}

/// The share of the circle of radius `r` around a uniform place in the unit square that lies in
/// the square, up to r = 1.
fn square_covariance(r: f64) -> f64 {
    let r = r.min(1.0);
    1.0 - 4.0 * r / std::f64::consts::PI + r * r / std::f64::consts::PI
}
