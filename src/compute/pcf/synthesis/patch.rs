use super::depths::Depths;
use super::far::Around;
use super::far::Far;
use super::partners::Partner;
use super::partners::Partners;
use super::sampler::Block;
use super::sampler::Sampler;
use super::scene::Scene;
use super::scene::View;
use crate::compute::geometry::Point;
use crate::compute::pcf::curve;
use crate::compute::pcf::rms;
use crate::compute::pcf::windows::Windows;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::OnceLock;

/// What a block sees of all that is not its own, each part worked out when it is first asked for.
#[derive(Debug, Default)]
pub(super) struct Backdrop {
    far: OnceLock<Arc<Around>>,
    windows: OnceLock<Windows>,
    depths: OnceLock<Depths>,
}

/// One block of a class: what it is filled with, and what its neighbours hold.
pub(super) struct Patch<'a> {
    pub(super) scene: &'a Scene<'a>,
    pub(super) sampler: &'a Sampler<'a>,
    pub(super) block: &'a Block,
    /// Elements of the class outside the block, as far as the block can see, and those that
    /// were there before.
    pub(super) context: Partners,
    /// Places of the block's elements in metres.
    pub(super) places: Vec<Point>,
    /// Their radii in metres.
    pub(super) radii: Vec<f64>,
    /// What stays while only the block's own elements move.
    pub(super) backdrop: Arc<Backdrop>,
}

impl<'a> Patch<'a> {
    /// What elements see beyond the axis, of the block's own as they lie now.
    pub(super) fn far(&self) -> Far {
        Far::new(self.backdrop.far.get_or_init(|| Arc::new(Around::of(self))), &self.places)
    }

    /// The windows of a block that is all of the room, with what was there before; none with a
    /// painted density, which says itself how elements lie at large. None either in a large domain:
    /// how full windows are depends on how many of them are cut off by its border, of which it has
    /// fewer than the exemplar, and they would draw elements away from it or towards it.
    pub(super) fn windows(&self) -> &Windows {
        self.backdrop.windows.get_or_init(|| {
            if !self.sampler.is_undivided()
                || !self.scene.intensity.is_flat()
                || self.scene.views[0].target.root_counts.is_empty()
            {
                return Windows::none();
            }
            let mut windows = Windows::over(self.scene.domain, self.scene.domain.bounds(), self.scene.unit);
            self.context.list().iter().for_each(|p| windows.add(p.place, 1.0));
            windows
        })
    }

    /// The strips along the border of the domain without the block's own elements.
    pub(super) fn depths(&self) -> Depths {
        *self.backdrop.depths.get_or_init(|| Depths::of(self))
    }

    /// Whether an element of the block may lie at `p`.
    pub(super) fn holds(&self, p: Point) -> bool {
        self.block.bounds.contains(p) && self.sampler.allows(p)
    }

    /// Whom an element sees in view `v`, but for the block's own elements.
    pub(super) fn partners(&self, v: usize) -> &Partners {
        if v == 0 { &self.context } else { &self.scene.views[v].partners }
    }

    /// The farthest, in r_max, that an element of `radius` sees anyone below `place` on the
    /// axis, the block's elements `inner` among them.
    pub(super) fn farthest(&self, (radius, inner): (f64, &Partners), place: f64) -> f64 {
        let of_view = |v: usize| self.scene.reach(self.partners(v), radius, place);
        (0..self.scene.views.len()).map(of_view).fold(self.scene.reach(inner, radius, place), f64::max)
    }

    /// The same in trials.
    pub(super) fn reach_of(&self, radius: f64, inner: &Partners) -> f64 {
        self.farthest((radius, inner), self.scene.rows.reach(self.scene.sparse.axis.extent))
    }

    /// The block's elements as partners.
    pub(super) fn inner(&self) -> Partners {
        let bounds = self.block.bounds;
        let partner = |(place, radius): (&Point, &f64)| Partner {
            place: *place,
            radius: radius / self.scene.unit,
            weight: self.scene.intensity.weight(*place),
        };
        Partners::new(self.places.iter().zip(&self.radii).map(partner).collect(), bounds, self.scene.unit)
    }

    /// The individual curves of all elements: one row a view.
    pub(super) fn individuals(&self) -> Vec<Individual> {
        let inner = self.inner();
        let seen = self.seen_by_parents(&inner, 1.0);
        (0..self.places.len()).into_par_iter().map(|i| self.individual(i, &inner, &seen)).collect()
    }

    /// What each element of each parent class sees of the class: the block's elements `inner`,
    /// and those around it by `share`. Kernel sums by view and partner; empty for partners that
    /// see nobody, and for views without triplets.
    pub(super) fn seen_by_parents(&self, inner: &Partners, share: f64) -> Vec<Vec<Vec<f32>>> {
        let scene = self.scene;
        let extent = scene.rows.reach(scene.sparse.axis.extent);
        let row_of = |view: &View<'_>, j: usize| {
            let (parent, border) = (&view.partners.list()[j], &view.borders[j]);
            let mut row = Vec::new();
            for (children, share) in [(inner, 1.0), (&self.context, share)] {
                let reach = scene.reach(children, parent.radius, extent) * scene.unit;
                children.for_each_near(parent.place, reach, |_, child| {
                    let distance = child.place.distance(parent.place) / scene.unit;
                    let place = scene.metric.value(distance, parent.radius, child.radius);
                    if place <= extent {
                        if row.is_empty() {
                            row = scene.rows.zeros();
                        }
                        scene.rows.add(&mut row, place, share * border.at(distance) * child.weight);
                    }
                });
            }
            row
        };
        let of_view = |view: &View<'_>| (0..view.borders.len()).into_par_iter().map(|j| row_of(view, j)).collect();
        scene.views.iter().map(of_view).collect()
    }

    /// Of the triplets around the partners of view `v`, those with element `i` (r_max) at one end.
    fn triplets_at_end(&self, v: usize, (p, radius, weight): (Point, f64, f64), seen: &[Vec<f32>]) -> Vec<f64> {
        let (scene, view) = (self.scene, &self.scene.views[v]);
        if view.borders.is_empty() {
            return vec![0.0; view.triplet_weights.len()];
        }
        let mut triplets = scene.rows.zeros();
        let extent = scene.rows.reach(scene.sparse.axis.extent);
        view.partners.for_each_near(p, scene.reach(&view.partners, radius, extent) * scene.unit, |j, parent| {
            let distance = parent.place.distance(p) / scene.unit;
            let place = scene.metric.value(distance, radius, parent.radius);
            if !seen[j].is_empty() && place <= extent {
                let (first, kernel) = scene.rows.around(place);
                let pair = (view.borders[j].at(distance) * weight) as f32;
                for (k, value) in kernel.iter().enumerate() {
                    triplets[first + k] += pair * value * (seen[j][first + k] - pair * value);
                }
            }
        });
        let per_child = view.per_child(false, scene.count);
        let complete = |(t, factor): (&f32, &f32)| f64::from(t * factor * factor) * per_child;
        triplets[scene.rows.axis()].iter().zip(&view.goal.reverse[scene.rows.axis()]).map(complete).collect()
    }

    fn individual(&self, i: usize, inner: &Partners, seen: &[Vec<Vec<f32>>]) -> Individual {
        let (scene, p, radius) = (self.scene, self.places[i], self.radii[i] / self.scene.unit);
        let border = scene.border(p, self.farthest((radius, inner), scene.axis.reach()));
        let zeros = || vec![0.0; scene.axis.bins()];
        let mut rows: Vec<Vec<f64>> = scene.views.iter().map(|_| zeros()).collect();
        for (v, row) in rows.iter_mut().enumerate() {
            scene.add_row(row, (p, radius, &border), (self.partners(v), None));
        }
        let mut own = zeros();
        scene.add_row(&mut own, (p, radius, &border), (inner, Some(i)));
        rows[0].iter_mut().zip(&own).for_each(|(row, own)| *row += own);
        for (row, view) in rows.iter_mut().zip(&scene.views) {
            row.iter_mut().zip(&view.factors).for_each(|(value, factor)| *value *= factor);
        }
        let weight = scene.intensity.weight(p);
        let at_end = |v: usize| self.triplets_at_end(v, (p, radius, weight), &seen[v]);
        let mut triplets: Vec<Vec<f64>> = (1..scene.views.len()).map(at_end).collect();
        let mut of_own = Vec::new();
        if !scene.views[0].triplet_weights.is_empty() {
            let mut same = zeros();
            scene.add_squares(&mut same, (p, radius, &border), (&self.context, None));
            scene.add_squares(&mut same, (p, radius, &border), (inner, Some(i)));
            of_own = scene.sparse.of_row(&curve::triplets(&rows[0], &same, &scene.views[0].factors));
        }
        triplets.insert(0, of_own);
        Individual { rows, triplets }
    }

    /// How far the mean triplets of each view are from the exemplar's, in standard deviations
    /// of single elements; 0 when the exemplar has none.
    pub(super) fn triplet_errors(&self, individuals: &[Individual]) -> Vec<f64> {
        let count = individuals.len().max(1) as f64;
        let error = |(sums, view): (&Vec<f64>, &View<'_>)| {
            let square = |(bin, weight): (usize, &f64)| (sums[bin] / count - view.goal.triplets[bin]).powi(2) * weight;
            let squares: f64 = view.triplet_weights.iter().enumerate().map(square).sum();
            (squares / sums.len().max(1) as f64).sqrt()
        };
        triplet_sums(individuals, self.scene).iter().zip(&self.scene.views).map(error).collect()
    }

    /// Root mean square difference of the block's mean curves to their targets, one a view.
    pub(super) fn errors_of(&self, individuals: &[Individual]) -> Vec<f64> {
        let count = individuals.len().max(1) as f64;
        let error = |(sum, view): (&Vec<f64>, &View<'_>)| {
            let mean: Vec<f64> = sum.iter().map(|s| s / count).collect();
            rms(&mean, &view.target.mean)
        };
        sums_of(individuals, self.scene).iter().zip(&self.scene.views).map(error).collect()
    }
}

/// What one element sees.
#[derive(Debug, Clone)]
pub(super) struct Individual {
    /// Its curves, one a view.
    pub(super) rows: Vec<Vec<f64>>,
    /// The triplets of its own class around it, and for each parent class the triplets around
    /// the parent's elements that it is an end of; empty where the exemplar has none.
    pub(super) triplets: Vec<Vec<f64>>,
}

/// The sums of individual triplets, one row a view.
pub(super) fn triplet_sums(individuals: &[Individual], scene: &Scene<'_>) -> Vec<Vec<f64>> {
    let mut sums: Vec<Vec<f64>> = scene.views.iter().map(|v| vec![0.0; v.triplet_weights.len()]).collect();
    for individual in individuals {
        for (sum, row) in sums.iter_mut().zip(&individual.triplets) {
            sum.iter_mut().zip(row).for_each(|(s, t)| *s += t);
        }
    }
    sums
}

/// The sums of individual curves, one a view.
pub(super) fn sums_of(individuals: &[Individual], scene: &Scene<'_>) -> Vec<Vec<f64>> {
    let mut sums = vec![vec![0.0; scene.axis.bins()]; scene.views.len()];
    for individual in individuals {
        for (sum, row) in sums.iter_mut().zip(&individual.rows) {
            sum.iter_mut().zip(row).for_each(|(s, v)| *s += v);
        }
    }
    sums
}
