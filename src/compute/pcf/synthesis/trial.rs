use super::absence::Absence;
use super::absence::for_each_seeing;
use super::border_table::BorderTable;
use super::filling::BlockSums;
use super::filling::Due;
use super::filling::Filling;
use super::goal::Bounds;
use super::kernel_rows::KernelRows;
use super::kernel_rows::LANES;
use super::kernel_rows::add;
use super::kernel_rows::add_products;
use super::kernel_rows::add_squares;
use super::partners::Partner;
use super::partners::Partners;
use super::patch::Patch;
use crate::compute::geometry::Point;
use crate::compute::pcf::RELATIVE_FLOOR;

/// The error of a candidate whose centre is nearer to another than allowed.
pub(super) const BARRED: f64 = f64::INFINITY;

/// Tries elements in a block: an error after T eq. 3.13. All rows are aligned.
pub(super) struct Trial<'a> {
    patch: &'a Patch<'a>,
    kernel: &'a KernelRows,
    /// Who is not there meanwhile.
    absence: Absence,
    /// Kernel sums of the last candidate, one row a view.
    rows: Vec<Vec<f32>>,
    /// What each of the block's elements sees of the candidate, summed.
    back: Vec<f32>,
    /// Σ of squared terms of the candidate and its own class.
    same: Vec<f32>,
    /// Σ over the block's elements of their curve times the candidate's term; in the other views
    /// the same over the partners and what they see of the class.
    crossed: Vec<Vec<f32>>,
    /// What the candidate adds to the sums of individual curves, one row a view.
    curves: Vec<Vec<f32>>,
    /// What it adds to the sums of triplets.
    triplets: Vec<Vec<f32>>,
    /// What a dart sees beyond the axis.
    far: Vec<f64>,
    /// What it is due to see of its own class.
    due: Due,
    /// Places of the axis, from the first, at which the last candidate's circles lie in the domain,
    /// one number a view.
    whole: Vec<usize>,
}

impl<'a> Trial<'a> {
    pub(super) fn new(patch: &'a Patch<'a>) -> Self {
        let kernel = &patch.scene.rows;
        let rows = || patch.scene.views.iter().map(|_| kernel.zeros()).collect();
        Self {
            patch,
            kernel,
            absence: Absence::default(),
            rows: rows(),
            back: kernel.zeros(),
            same: kernel.zeros(),
            crossed: rows(),
            curves: rows(),
            triplets: rows(),
            far: Vec::new(),
            due: Due::default(),
            whole: vec![0; patch.scene.views.len()],
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
        filling.far.read(p, &mut self.far);
        filling.sums.one_more((p, &self.far), &mut self.due);
        let views = scene.views.len();
        let (mut growth, mut outside) = (0.0, 0.0_f64);
        for v in 0..views {
            if v > 0 {
                self.see_parent(v, (p, radius), (&border, &filling.seen[v]));
            }
            growth += (self.growth(v, &filling.sums) + self.far_growth(v, &filling.sums)) / views as f64
                + scene.triplet_share(v) * self.triplet_growth(v, &filling.sums);
            outside = outside.max(self.above(v));
            if v > 0 {
                outside = outside.max(self.below(v)).max(self.alone_in(v));
            }
            if outside > bound {
                break;
            }
        }
        growth.max(0.0) + outside
    }

    /// Sums over the candidate's own class; `false` when it comes too near one of it.
    fn see_own(&mut self, (p, radius): (Point, f64), border: &BorderTable, filling: &Filling) -> bool {
        let (scene, kernel) = (self.patch.scene, self.kernel);
        let extent = kernel.reach(scene.sparse.axis.extent);
        let Self { rows, back, same, crossed, absence, .. } = self;
        let (row, crossed) = (&mut rows[0], &mut crossed[0]);
        [&mut *row, &mut *back, &mut *same, &mut *crossed].into_iter().for_each(|r| r.fill(0.0));
        let (mut barred, own_weight) = (false, scene.intensity.weight(p));
        let (is_complete, mean) = (filling.sums.is_complete(), &scene.views[0].goal.mean_row);
        let mut term = |partner: &Partner| {
            let distance = partner.place.distance(p) / scene.unit;
            barred |= distance * scene.unit < scene.closest;
            let place = scene.metric.value(distance, radius, partner.radius);
            let pair = || (kernel.around(place), (border.at(distance) * partner.weight) as f32, distance);
            (place <= extent).then(pair)
        };
        let far = |partners: &Partners| (scene.reach(partners, radius, extent) * scene.unit).max(scene.closest);
        let context = self.patch.partners(0);
        context.for_each_near(p, far(context), |_, partner| {
            let Some(((first, kernel), weight, distance)) = term(partner) else { return };
            add(&mut row[first..], kernel, weight);
            add_squares(&mut same[first..], kernel, weight);
            // A move changes what both ends see, those outside the block too: were only one
            // counted, a block could change its sums by moving elements to or from its seams.
            if is_complete {
                let back_weight = (border.at(distance) * own_weight) as f32;
                add(&mut back[first..], kernel, back_weight);
                add_products(&mut crossed[first..], (kernel, &mean[first..]), back_weight);
            }
        });
        filling.inner.for_each_near(p, far(&filling.inner), |j, partner| {
            if absence.element == Some(j) {
                return;
            }
            let Some(((first, kernel), weight, distance)) = term(partner) else { return };
            let back_weight = (filling.borders[j].at(distance) * own_weight) as f32;
            add(&mut row[first..], kernel, weight);
            add_squares(&mut same[first..], kernel, weight);
            add(&mut back[first..], kernel, back_weight);
            let curve = absence.row(0, j, &filling.curves[j]);
            add_products(&mut crossed[first..], (kernel, &curve[first..]), back_weight);
        });
        self.whole[0] = scene.places_within((radius, border.clearance()), &[context, &filling.inner]);
        self.finish_own();
        !barred
    }

    /// What the candidate adds to the sums of its own class: its own curve and what the others
    /// see of it; its own triplets, and those of the elements that get one partner more.
    fn finish_own(&mut self) {
        let factors = &self.patch.scene.views[0].goal.factors;
        for at in self.kernel.axis() {
            let (sum, factor) = (self.rows[0][at], factors[at]);
            self.curves[0][at] = (sum + self.back[at]) * factor;
            self.triplets[0][at] = (sum * sum - self.same[at]) * factor * factor + 2.0 * self.crossed[0][at] * factor;
        }
    }

    /// Sums over a parent class, and over what its elements see of the class.
    fn see_parent(&mut self, v: usize, (p, radius): (Point, f64), (border, seen): (&BorderTable, &[Vec<f32>])) {
        let (scene, kernel) = (self.patch.scene, self.kernel);
        let (row, crossed, absence) = (&mut self.rows[v], &mut self.crossed[v], &self.absence);
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
            let (first, kernel) = kernel.around(place);
            add(&mut row[first..], kernel, (border.at(distance) * partner.weight) as f32);
            if let Some(sees) = seen.get(j).filter(|s| !s.is_empty()) {
                let weight = (view.borders[j].at(distance) * own_weight) as f32;
                let sees = absence.row(v, j, sees);
                add_products(&mut crossed[first..], (kernel, &sees[first..]), weight);
            }
        });
        self.whole[v] = scene.places_within((radius, border.clearance()), &[&view.partners]);
        self.finish_parent(v);
    }

    /// What the candidate adds to the sums of a parent's view: its own curve; around the
    /// parents those triplets it is an end of, counted from both ends.
    fn finish_parent(&mut self, v: usize) {
        let view = &self.patch.scene.views[v];
        let both_ends = 2.0 * view.per_child(false, self.patch.scene.count) as f32;
        for at in self.kernel.axis() {
            let reverse = view.goal.reverse[at];
            self.curves[v][at] = self.rows[v][at] * view.goal.factors[at];
            self.triplets[v][at] = both_ends * self.crossed[v][at] * reverse * reverse;
        }
    }

    /// What the candidate adds to the block's triplets at a place.
    fn triplets_at(&self, v: usize, bin: usize) -> f64 {
        f64::from(self.triplets[v][self.kernel.axis().start + bin])
    }

    /// What the candidate adds to the sum of the individual curves of view `v` at a place.
    fn curve_at(&self, v: usize, bin: usize) -> f64 {
        f64::from(self.curves[v][self.kernel.axis().start + bin])
    }

    /// The growth of the distance of the block's triplets to their target, weighted by the
    /// inverse variance among the exemplar's elements (ours: curves alone leave open whether
    /// partners come one by one or together, which is what clumps and gaps are made of).
    fn triplet_growth(&self, v: usize, sums: &BlockSums) -> f64 {
        let view = &self.patch.scene.views[v];
        let mut growth = 0.0;
        let (all, one) =
            if v == 0 { (&sums.due.triplets, &self.due.triplets) } else { (&sums.due.across, &self.due.across) };
        for (bin, inverse) in view.triplet_weights.iter().enumerate() {
            let triplets = view.goal.triplets[bin];
            let before = sums.triplets[v][bin] - triplets * all[bin];
            let after = before + self.triplets_at(v, bin) - triplets * one[bin];
            growth += (after * after - before * before) * inverse;
        }
        growth / view.goal.triplets.len().max(1) as f64
    }

    /// The same beyond the axis.
    fn far_growth(&self, v: usize, sums: &BlockSums) -> f64 {
        let view = &self.patch.scene.views[v];
        let due = |bin: usize| {
            if v == 0 { (sums.due.far[bin], self.due.far[bin]) } else { (sums.far.ring_sum(bin), self.far[bin]) }
        };
        sums.far.growth((v, view), due, &self.far)
    }

    /// For one view: the growth of the block's distance to its target curve.
    ///
    /// T's first term of eq. 3.13 is the largest relative excess of the new mean curve. It sees
    /// only one place of the axis, and neither what is still missing nor that a curve of few
    /// pairs is rough. Ours is the growth of Σ_r (sum − expected)²·(density·M/target), each
    /// place weighted by the inverse variance of independent pairs: negative when the candidate
    /// brings the pattern nearer its target, 1 or 2 in the mean when it neither helps nor harms.
    fn growth(&self, v: usize, sums: &BlockSums) -> f64 {
        let (view, start) = (&self.patch.scene.views[v], self.kernel.axis().start);
        let (placed, mut growth) = (sums.placed as f64, 0.0);
        for (bin, target) in view.goal.mean.iter().enumerate() {
            let factor = f64::from(view.goal.factors[start + bin]);
            if factor > 0.0 {
                // Towards a parent an element's curve is complete, towards the class itself it sees
                // whom of it can be there.
                let (all, one) = if v == 0 { (sums.due.near[bin], self.due.near[bin]) } else { (placed, 1.0) };
                let before = sums.sums[v][bin] - target * all;
                let after = before + self.curve_at(v, bin) - target * one;
                growth += (after * after - before * before) / (factor * target.max(RELATIVE_FLOOR));
            }
        }
        growth / view.goal.mean.len() as f64
    }

    /// Works out everything about an element of `radius` (r_max) at `p`; `false` when it may not
    /// lie there, and not all is worked out.
    pub(super) fn see(&mut self, (p, radius): (Point, f64), filling: &Filling) -> bool {
        let border = self.patch.scene.border_table(p, self.patch.reach_of(radius, &filling.inner));
        let free = self.see_own((p, radius), &border, filling);
        if free {
            self.see_parents((p, radius), &border, filling);
        }
        free
    }

    /// The same, all of it even where the element may not lie.
    pub(super) fn see_all(&mut self, (p, radius): (Point, f64), filling: &Filling) -> bool {
        let border = self.patch.scene.border_table(p, self.patch.reach_of(radius, &filling.inner));
        let free = self.see_own((p, radius), &border, filling);
        self.see_parents((p, radius), &border, filling);
        free
    }

    fn see_parents(&mut self, seen_from: (Point, f64), border: &BorderTable, filling: &Filling) {
        for v in 1..self.patch.scene.views.len() {
            self.see_parent(v, seen_from, (border, &filling.seen[v]));
        }
    }

    /// Takes element `i` of the block out until another is.
    pub(super) fn take_out(&mut self, i: usize, filling: &Filling) {
        self.absence.take_out(i, (self.patch, filling));
    }

    /// How far the candidate's individual curves leave the validity region, as a share of the
    /// bound (the second term of T eq. 3.13), with both bounds on every curve.
    pub(super) fn outside(&self) -> f64 {
        (0..self.rows.len()).map(|v| self.above(v).max(self.below(v))).fold(0.0, f64::max)
    }

    /// How far the candidate has less near than any of the exemplar's, as a share of the least, the
    /// most of any view.
    pub(super) fn alone(&self) -> f64 {
        (0..self.rows.len()).map(|v| self.alone_in(v)).fold(0.0, f64::max)
    }

    /// How far the candidate's curve of view `v` is above the validity region.
    fn above(&self, v: usize) -> f64 {
        let Bounds { above, .. } = &self.patch.scene.views[v].goal.bounds;
        self.farthest(v, above)
    }

    /// The same below it.
    fn below(&self, v: usize) -> f64 {
        let Bounds { below, .. } = &self.patch.scene.views[v].goal.bounds;
        self.farthest(v, below)
    }

    /// How far what it has near in view `v` is below the least any of the exemplar's elements has:
    /// of those within up to where all circles around it lie in the domain, beyond of all.
    fn alone_in(&self, v: usize) -> f64 {
        let (bounds, axis) = (&self.patch.scene.views[v].goal.bounds, self.kernel.axis());
        let cut = axis.start + self.whole[v];
        let (mut sum, mut most) = (0.0_f32, 0.0_f32);
        for ((slopes, offsets), places) in [(&bounds.near, axis.start..cut), (&bounds.near_border, cut..axis.end)] {
            let bounds = slopes[places.clone()].iter().zip(&offsets[places.clone()]);
            for (value, (slope, offset)) in self.rows[v][places].iter().zip(bounds) {
                sum += value;
                most = most.max(sum * slope + offset);
            }
        }
        f64::from(most)
    }

    /// The most that slope·value + offset is, at least 0.
    fn farthest(&self, v: usize, (slopes, offsets): &(Vec<f32>, Vec<f32>)) -> f64 {
        let (row, slopes, offsets) = (self.lanes(&self.rows[v]), self.lanes(slopes), self.lanes(offsets));
        let mut most = [0.0_f32; LANES];
        for ((row, slopes), offsets) in row.iter().zip(slopes).zip(offsets) {
            for lane in 0..LANES {
                let excess = row[lane] * slopes[lane] + offsets[lane];
                most[lane] = if excess > most[lane] { excess } else { most[lane] };
            }
        }
        f64::from(most.into_iter().fold(0.0, f32::max))
    }

    /// The growth of Σ (error + added/`count`)²·weight over all places when the candidate is added
    /// to a block of `count` elements; that of curve v counts `cost`(v, growth).
    pub(super) fn growth_of(
        &self,
        (errors, weights): (&Rows, &Rows),
        count: usize,
        cost: impl Fn(usize, f64) -> f64,
    ) -> f64 {
        let share = 1.0 / count.max(1) as f32;
        let growth = |added: &Vec<f32>, (errors, weights): (&Vec<f32>, &Vec<f32>)| {
            let (added, errors, weights) = (self.lanes(added), self.lanes(errors), self.lanes(weights));
            let mut sum = [0.0_f32; LANES];
            for ((added, errors), weights) in added.iter().zip(errors).zip(weights) {
                for lane in 0..LANES {
                    let step = added[lane] * share;
                    sum[lane] += (2.0 * errors[lane] + step) * step * weights[lane];
                }
            }
            f64::from(sum.into_iter().sum::<f32>())
        };
        let curves = errors.curves.iter().zip(&weights.curves).zip(&self.curves).map(|(e, a)| growth(a, e));
        let triplets = errors.triplets.iter().zip(&weights.triplets).zip(&self.triplets).map(|(e, a)| growth(a, e));
        curves.enumerate().map(|(v, growth)| cost(v, growth)).sum::<f64>() + triplets.sum::<f64>()
    }

    /// Σ error²·weight of every curve.
    pub(super) fn squares_of(&self, errors: &Rows, weights: &Rows) -> Vec<f64> {
        let square = |(errors, weights): (&Vec<f32>, &Vec<f32>)| {
            let axis = self.kernel.axis();
            errors[axis.clone()].iter().zip(&weights[axis]).map(|(e, w)| f64::from(e * e * w)).sum()
        };
        errors.curves.iter().zip(&weights.curves).map(square).collect()
    }

    /// Writes to `errors` how far the means of a block with these sums are from their goals
    /// without the last candidate, which is one of its `count` elements.
    pub(super) fn errors_without(&self, errors: &mut Rows, (sums, count): (&BlockSums, usize)) {
        let (share, start) = (1.0 / count.max(1) as f64, self.kernel.axis().start);
        for (v, view) in self.patch.scene.views.iter().enumerate() {
            for (bin, target) in view.goal.mean.iter().enumerate() {
                let mean = (sums.sums[v][bin] - self.curve_at(v, bin)) * share;
                errors.curves[v][start + bin] = (mean - target) as f32;
            }
            for (bin, target) in view.goal.triplets.iter().enumerate() {
                let mean = (sums.triplets[v][bin] - self.triplets_at(v, bin)) * share;
                errors.triplets[v][start + bin] = (mean - target) as f32;
            }
        }
    }

    fn lanes<'b>(&self, row: &'b [f32]) -> &'b [[f32; LANES]] {
        row[self.kernel.lanes()].as_chunks::<LANES>().0
    }

    /// Adds the last dart, seen in full, to the block as a new element.
    pub(super) fn accept(&self, partner: Partner, filling: &mut Filling) {
        let reach = self.patch.reach_of(partner.radius, &filling.inner);
        filling.borders.push(self.patch.scene.border_table(partner.place, reach));
        filling.curves.push(Vec::new());
        filling.inner.push(partner);
        filling.sums.placed += 1;
        filling.sums.due.add(&self.due);
        let last = filling.curves.len() - 1;
        self.add_to_sums(1.0, filling);
        filling.sums.far.add(&self.far, 1.0);
        filling.far.show(partner.place, 1.0);
        self.show((last, &partner), 1.0, filling);
        filling.curves[last] = self.own_curve();
    }

    /// The last candidate's curve towards its own class.
    pub(super) fn own_curve(&self) -> Vec<f32> {
        self.rows[0].iter().zip(&self.patch.scene.views[0].goal.factors).map(|(sum, factor)| sum * factor).collect()
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

    /// Shows element `i` of the class `times` to its own class, but for itself, and to the parents.
    pub(super) fn show(&self, (i, element): (usize, &Partner), times: f32, filling: &mut Filling) {
        let (patch, factors) = (self.patch, &self.patch.scene.views[0].goal.factors);
        let Filling { inner, borders, curves, seen, .. } = filling;
        for_each_seeing(patch, (i, element), (inner, borders), |v, j, (first, kernel, weight)| {
            if v > 0 {
                if seen[v][j].is_empty() {
                    seen[v][j] = self.kernel.zeros();
                }
                add(&mut seen[v][j][first..], kernel, times * weight);
            } else {
                add_products(&mut curves[j][first..], (kernel, &factors[first..]), times * weight);
            }
        });
    }
}

/// Rows of curves and triplets, one a view.
#[derive(Debug, Clone)]
pub(super) struct Rows {
    pub(super) curves: Vec<Vec<f32>>,
    pub(super) triplets: Vec<Vec<f32>>,
}
