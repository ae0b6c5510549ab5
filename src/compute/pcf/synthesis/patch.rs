use super::partners::Partner;
use super::partners::Partners;
use super::sampler::Block;
use super::sampler::Sampler;
use super::scene::Scene;
use crate::compute::geometry::Point;
use crate::compute::pcf::curve;
use crate::compute::pcf::rms;
use rayon::prelude::*;

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
}

impl<'a> Patch<'a> {
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

    /// The block's elements, without those of `left_out` (ascending), as partners.
    pub(super) fn inner(&self, left_out: &[usize]) -> Partners {
        let bounds = self.sampler.block_bounds(self.block).unwrap_or_else(|| self.scene.domain.bounds());
        let mut inner = Partners::new(bounds, self.scene.unit);
        let kept = (0..self.places.len()).filter(|i| left_out.binary_search(i).is_err());
        kept.for_each(|i| inner.push(self.as_partner(i)));
        inner
    }

    pub(super) fn as_partner(&self, i: usize) -> Partner {
        let place = self.places[i];
        Partner { place, radius: self.radii[i] / self.scene.unit, weight: self.scene.intensity.weight(place) }
    }

    /// The individual curves of all elements but those of `left_out` (ascending): one row a
    /// view, and of the first view the part that the block's own elements add.
    pub(super) fn individuals(&self, left_out: &[usize]) -> Vec<Individual> {
        let inner = self.inner(left_out);
        let kept: Vec<usize> = (0..self.places.len()).filter(|i| left_out.binary_search(i).is_err()).collect();
        kept.par_iter().enumerate().map(|(k, i)| self.individual(*i, (&inner, k))).collect()
    }

    fn individual(&self, i: usize, (inner, itself): (&Partners, usize)) -> Individual {
        let (scene, p, radius) = (self.scene, self.places[i], self.radii[i] / self.scene.unit);
        let border = scene.border(p, self.farthest((radius, inner), scene.axis.reach()));
        let zeros = || vec![0.0; scene.axis.bins()];
        let mut rows: Vec<Vec<f64>> = scene.views.iter().map(|_| zeros()).collect();
        for (v, row) in rows.iter_mut().enumerate() {
            scene.add_row(row, (p, radius, &border), (self.partners(v), None));
        }
        let mut own = zeros();
        scene.add_row(&mut own, (p, radius, &border), (inner, Some(itself)));
        rows[0].iter_mut().zip(&own).for_each(|(row, own)| *row += own);
        for (row, view) in rows.iter_mut().zip(&scene.views) {
            row.iter_mut().zip(&view.factors).for_each(|(value, factor)| *value *= factor);
        }
        own.iter_mut().zip(&scene.views[0].factors).for_each(|(value, factor)| *value *= factor);
        let mut triplets = Vec::new();
        if !scene.triplet_weights.is_empty() {
            let mut same = zeros();
            scene.add_squares(&mut same, (p, radius, &border), (&self.context, None));
            scene.add_squares(&mut same, (p, radius, &border), (inner, Some(itself)));
            triplets = curve::triplets(&rows[0], &same, &scene.views[0].factors);
        }
        Individual { rows, own, triplets }
    }

    /// How far the mean triplets are from the exemplar's, in standard deviations of single
    /// elements; 0 when the exemplar has none.
    pub(super) fn triplet_error(&self, individuals: &[Individual]) -> f64 {
        let (sums, target) = (triplet_sums(individuals, self.scene), self.scene.views[0].target);
        let count = individuals.len().max(1) as f64;
        let square = |(bin, weight): (usize, &f64)| (sums[bin] / count - target.triplets[bin]).powi(2) * weight;
        let squares: f64 = self.scene.triplet_weights.iter().enumerate().map(square).sum();
        (squares / sums.len().max(1) as f64).sqrt()
    }

    /// Root mean square difference of the block's mean curves to their targets, one a view.
    pub(super) fn errors_of(&self, individuals: &[Individual]) -> Vec<f64> {
        let count = individuals.len().max(1) as f64;
        let error = |(sum, view): (&Vec<f64>, &super::scene::View<'_>)| {
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
    /// Of the first, what the block's own elements add.
    pub(super) own: Vec<f64>,
    /// Its triplets among its own class; empty when the exemplar has none.
    pub(super) triplets: Vec<f64>,
}

/// The sums of individual triplets.
pub(super) fn triplet_sums(individuals: &[Individual], scene: &Scene<'_>) -> Vec<f64> {
    let mut sums = vec![0.0; scene.triplet_weights.len()];
    for individual in individuals {
        sums.iter_mut().zip(&individual.triplets).for_each(|(s, t)| *s += t);
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
