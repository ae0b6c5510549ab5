use super::border_table::BorderTable;
use super::filling::BlockSums;
use super::filling::Filling;
use super::kernel_rows::KernelRows;
use super::partners::Partner;
use super::partners::Partners;
use super::patch::Patch;
use crate::compute::geometry::Point;
use crate::compute::pcf::RELATIVE_FLOOR;

/// The error of a candidate whose centre is nearer to another than allowed.
pub(super) const BARRED: f64 = f64::INFINITY;

/// Tries elements in a block: an error after T eq. 3.13.
pub(super) struct Trial<'a> {
    patch: &'a Patch<'a>,
    kernel: &'a KernelRows,
    /// Kernel sums of the last candidate, one row a view; of its own class without the block.
    rows: Vec<Vec<f64>>,
    /// What the block's own elements add to the first of them.
    inner: Vec<f64>,
    /// What each of them sees of the candidate, summed.
    back: Vec<f64>,
    /// Σ of squared terms of the candidate and its own class.
    same: Vec<f64>,
    /// Σ over the block's elements of their curve times the candidate's term; in the other views
    /// the same over the partners and what they see of the class.
    crossed: Vec<Vec<f64>>,
}

impl<'a> Trial<'a> {
    pub(super) fn new(patch: &'a Patch<'a>) -> Self {
        let zeros = || vec![0.0; patch.scene.sparse.bins()];
        let rows = || patch.scene.views.iter().map(|_| zeros()).collect();
        Self {
            patch,
            kernel: &patch.scene.rows,
            rows: rows(),
            inner: zeros(),
            back: zeros(),
            same: zeros(),
            crossed: rows(),
        }
    }

    /// The error of an element of `radius` (r_max) at `p`, given the block's elements so far;
    /// whatever lies above `bound` is not worked out to the end. The individual curve towards
    /// its own class has no lower bound here, as the class is not complete yet.
    pub(super) fn error(&mut self, (p, radius): (Point, f64), filling: &Filling, bound: f64) -> f64 {
        let scene = self.patch.scene;
        let border = scene.border_table(p, self.patch.reach_of(radius, &filling.inner));
        if !self.see_own((p, radius), &border, filling) {
            return BARRED;
        }
        let views = scene.views.len();
        let (mut growth, mut outside) = (0.0, 0.0_f64);
        for v in 0..views {
            if v > 0 {
                self.see_parent(v, (p, radius), (&border, &filling.seen[v]));
            }
            let (of_view, out) = self.errors_of(v, &filling.sums);
            growth += of_view / views as f64 + scene.triplet_share(v) * self.triplet_growth(v, &filling.sums);
            outside = outside.max(out);
            if outside > bound {
                break;
            }
        }
        growth.max(0.0) + outside
    }

    /// Sums over the candidate's own class; `false` when it comes too near one of it.
    fn see_own(&mut self, (p, radius): (Point, f64), border: &BorderTable, filling: &Filling) -> bool {
        let (scene, kernel, bins) = (self.patch.scene, self.kernel, self.patch.scene.sparse.bins());
        let extent = kernel.reach(scene.sparse.axis.extent);
        [&mut self.rows[0], &mut self.inner, &mut self.back, &mut self.same, &mut self.crossed[0]]
            .into_iter()
            .for_each(|r| r.fill(0.0));
        let (mut barred, own_weight) = (false, scene.intensity.weight(p));
        let mut term = |partner: &Partner| {
            let distance = partner.place.distance(p) / scene.unit;
            barred |= distance * scene.unit < scene.closest;
            let place = scene.metric.value(distance, radius, partner.radius);
            let pair = || (kernel.around(place, bins), border.at(distance) * partner.weight, distance);
            (place <= extent).then(pair)
        };
        let far = |partners: &Partners| scene.reach(partners, radius, extent) * scene.unit;
        let context = self.patch.partners(0);
        context.for_each_near(p, far(context), |_, partner| {
            let Some(((first, kernel), weight, _)) = term(partner) else { return };
            for (k, value) in kernel.iter().enumerate() {
                self.rows[0][first + k] += weight * value;
                self.same[first + k] += (weight * value) * (weight * value);
            }
        });
        filling.inner.for_each_near(p, far(&filling.inner), |j, partner| {
            let Some(((first, kernel), weight, distance)) = term(partner) else { return };
            let back = filling.borders[j].at(distance) * own_weight;
            let curve = &filling.curves[j][first..];
            for (k, value) in kernel.iter().enumerate() {
                let add = weight * value;
                self.inner[first + k] += add;
                self.same[first + k] += add * add;
                self.back[first + k] += back * value;
                self.crossed[0][first + k] += back * value * curve[k];
            }
        });
        !barred
    }

    /// Sums over a parent class, and over what its elements see of the class.
    fn see_parent(&mut self, v: usize, (p, radius): (Point, f64), (border, seen): (&BorderTable, &[Vec<f64>])) {
        let (scene, kernel, bins) = (self.patch.scene, self.kernel, self.patch.scene.sparse.bins());
        let (row, crossed) = (&mut self.rows[v], &mut self.crossed[v]);
        let (extent, view, own_weight) =
            (kernel.reach(scene.sparse.axis.extent), &scene.views[v], scene.intensity.weight(p));
        row.fill(0.0);
        crossed.fill(0.0);
        let reach = scene.reach(&view.partners, radius, extent) * scene.unit;
        view.partners.for_each_near(p, reach, |j, partner| {
            let distance = partner.place.distance(p) / scene.unit;
            let place = scene.metric.value(distance, radius, partner.radius);
            if place > extent {
                return;
            }
            let (first, kernel) = kernel.around(place, bins);
            let weight = border.at(distance) * partner.weight;
            for (value, k) in row[first..].iter_mut().zip(kernel) {
                *value += weight * k;
            }
            if let Some(sees) = seen.get(j).filter(|s| !s.is_empty()) {
                let weight = view.borders[j].at(distance) * own_weight;
                for (k, value) in kernel.iter().enumerate() {
                    crossed[first + k] += weight * value * sees[first + k];
                }
            }
        });
    }

    /// What the candidate adds to the block's triplets at a place: its own and those of the
    /// elements that get one partner more; around parents those it is an end of, counted from
    /// both ends.
    pub(super) fn triplets_at(&self, v: usize, bin: usize) -> f64 {
        let view = &self.patch.scene.views[v];
        if v > 0 {
            let factor = view.goal.reverse[bin];
            return 2.0 * self.crossed[v][bin] * factor * factor * view.per_child(false, self.patch.scene.count);
        }
        let factor = view.goal.factors[bin];
        let sum = (self.rows[0][bin] + self.inner[bin]) * factor;
        sum * sum - self.same[bin] * factor * factor + 2.0 * self.crossed[0][bin] * factor
    }

    /// The growth of the distance of the block's triplets to their target, weighted by the
    /// inverse variance among the exemplar's elements (ours: curves alone leave open whether
    /// partners come one by one or together, which is what clumps and gaps are made of).
    fn triplet_growth(&self, v: usize, sums: &BlockSums) -> f64 {
        let view = &self.patch.scene.views[v];
        let mut growth = 0.0;
        for (bin, inverse) in view.triplet_weights.iter().enumerate() {
            let triplets = view.goal.triplets[bin];
            let before = sums.triplets[v][bin] - triplets * sums.expected_triplets(v, bin, sums.placed);
            let after = sums.triplets[v][bin] + self.triplets_at(v, bin)
                - triplets * sums.expected_triplets(v, bin, sums.placed + 1);
            growth += (after * after - before * before) * inverse;
        }
        growth / view.goal.triplets.len().max(1) as f64
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
        for bin in 0..view.goal.factors.len() {
            let factor = view.goal.factors[bin];
            if factor == 0.0 {
                continue;
            }
            let own = (self.rows[v][bin] + if v == 0 { self.inner[bin] } else { 0.0 }) * factor;
            let target = view.goal.mean[bin];
            let before = sums.sums[v][bin] - target * sums.expected(v, bin, sums.placed);
            let after = sums.sums[v][bin] + self.curve_at(v, bin) - target * sums.expected(v, bin, sums.placed + 1);
            growth += (after * after - before * before) / (factor * target.max(RELATIVE_FLOOR));
            let upper = view.goal.upper[bin];
            outside = outside.max((own - upper) / upper.max(RELATIVE_FLOOR));
            if v > 0 {
                let lower = view.goal.lower[bin];
                outside = outside.max((lower - own) / lower.max(RELATIVE_FLOOR));
            }
        }
        (growth / view.goal.factors.len() as f64, outside)
    }

    /// Works out everything about an element of `radius` (r_max) at `p`: whether it may lie there.
    pub(super) fn see(&mut self, (p, radius): (Point, f64), filling: &Filling) -> bool {
        let border = self.patch.scene.border_table(p, self.patch.reach_of(radius, &filling.inner));
        let free = self.see_own((p, radius), &border, filling);
        for v in 1..self.patch.scene.views.len() {
            self.see_parent(v, (p, radius), (&border, &filling.seen[v]));
        }
        free
    }

    /// How far the candidate's individual curves leave the validity region, as a share of the
    /// bound (the second term of T eq. 3.13), with both bounds on every curve.
    pub(super) fn outside(&self) -> f64 {
        let mut outside = 0.0_f64;
        for (v, view) in self.patch.scene.views.iter().enumerate() {
            let goal = &view.goal;
            for bin in 0..goal.mean.len() {
                let own = (self.rows[v][bin] + if v == 0 { self.inner[bin] } else { 0.0 }) * goal.factors[bin];
                let (lower, upper) = (goal.lower[bin], goal.upper[bin]);
                outside = outside.max((own - upper) / upper.max(RELATIVE_FLOOR));
                outside = outside.max((lower - own) / lower.max(RELATIVE_FLOOR));
            }
        }
        outside
    }

    /// What the candidate adds to the sum of the individual curves of view `v` at a place.
    pub(super) fn curve_at(&self, v: usize, bin: usize) -> f64 {
        let own = if v == 0 { self.inner[bin] + self.back[bin] } else { 0.0 };
        (self.rows[v][bin] + own) * self.patch.scene.views[v].goal.factors[bin]
    }

    /// Adds the last candidate, seen in full, to the block as a new element.
    pub(super) fn accept(&self, partner: Partner, filling: &mut Filling) {
        let reach = self.patch.reach_of(partner.radius, &filling.inner);
        filling.borders.push(self.patch.scene.border_table(partner.place, reach));
        filling.curves.push(Vec::new());
        filling.inner.push(Partner { place: partner.place, ..partner });
        filling.sums.placed += 1;
        let last = filling.curves.len() - 1;
        self.add((last, &partner), filling);
    }

    /// Adds the last candidate, seen in full, as element `i` to the sums and to what others see.
    pub(super) fn add(&self, (i, partner): (usize, &Partner), filling: &mut Filling) {
        self.add_to_sums(1.0, filling);
        self.show((i, partner), 1.0, filling);
        let own = |bin: usize| (self.rows[0][bin] + self.inner[bin]) * self.patch.scene.views[0].goal.factors[bin];
        filling.curves[i] = (0..self.inner.len()).map(own).collect();
    }

    /// Adds the last candidate `times` to the sums.
    pub(super) fn add_to_sums(&self, times: f64, filling: &mut Filling) {
        let sums = &mut filling.sums;
        for (v, row) in sums.triplets.iter_mut().enumerate() {
            row.iter_mut().enumerate().for_each(|(bin, sum)| *sum += times * self.triplets_at(v, bin));
        }
        for (v, row) in sums.sums.iter_mut().enumerate() {
            row.iter_mut().enumerate().for_each(|(bin, sum)| *sum += times * self.curve_at(v, bin));
        }
    }

    /// Shows an element of the class `times` to its own class, but for itself, and to the parents.
    pub(super) fn show(&self, (i, new): (usize, &Partner), times: f64, filling: &mut Filling) {
        let (scene, factors) = (self.patch.scene, &self.patch.scene.views[0].goal.factors);
        let (bins, extent) = (scene.sparse.bins(), self.kernel.reach(scene.sparse.axis.extent));
        let term = |other: &Partner, weight: &dyn Fn(f64) -> f64| {
            let distance = other.place.distance(new.place) / scene.unit;
            let place = scene.metric.value(distance, new.radius, other.radius);
            (place <= extent).then(|| (self.kernel.around(place, bins), weight(distance) * new.weight * times))
        };
        let Filling { inner, curves, seen, borders, .. } = filling;
        inner.for_each_near(new.place, scene.reach(inner, new.radius, extent) * scene.unit, |j, other| {
            if j == i {
                return;
            }
            let Some(((first, kernel), weight)) = term(other, &|d| borders[j].at(d)) else { return };
            for (k, value) in kernel.iter().enumerate() {
                curves[j][first + k] += weight * value * factors[first + k];
            }
        });
        for (view, seen) in scene.views.iter().zip(seen).filter(|(_, seen)| !seen.is_empty()) {
            let reach = scene.reach(&view.partners, new.radius, extent) * scene.unit;
            view.partners.for_each_near(new.place, reach, |j, parent| {
                let Some(((first, kernel), weight)) = term(parent, &|d| view.borders[j].at(d)) else { return };
                seen[j].resize(bins, 0.0);
                seen[j][first..].iter_mut().zip(kernel).for_each(|(sum, value)| *sum += weight * value);
            });
        }
    }
}
