//! Settling: elements are taken out one at a time and laid out again where the curves of the
//! block come nearest to their targets, their old place among the choices (T 3.6.5, applied to
//! all elements and not to outliers alone).
//!
//! The descent moves all elements along the gradient at once and stops in the nearest hollow;
//! settling leaves hollows, and sees triplets too.

use super::filling::Filling;
use super::partners::Partner;
use super::patch::Patch;
use super::trial::Trial;
use crate::compute::geometry::Point;
use crate::compute::pcf::Metric;
use crate::compute::pcf::PcfError;
use crate::compute::random::Stream;
use crate::compute::run::Run;
use std::f64::consts::TAU;

/// Places near the old one that are tried: standard deviations of the step in r_max.
const STEPS: [f64; 4] = [0.05, 0.15, 0.4, 1.0];

/// Places anywhere in the block that are tried.
const DRAWS: usize = 6;

/// Places over or at the rim of parents that are tried for disks, parent classes in turn: where
/// parents are small, places drawn anywhere seldom hit one.
const NEAR_PARENTS: usize = 20;

/// Settles every element of `patch` once, in random order; gives how many moved. Errors count by
/// their share of `scales`: one a curve, one a row of triplets.
pub(super) fn settle(
    patch: &mut Patch<'_>,
    scales: (&[f64], &[f64]),
    mut random: Stream,
    run: &Run,
) -> Result<usize, PcfError> {
    let mut order: Vec<usize> = (0..patch.places.len()).collect();
    random.shuffle(&mut order);
    let mut settling = Settling::new(patch, scales);
    for i in order {
        run.check()?;
        let choices = choices(patch, i, &mut random);
        settling.settle(i, &choices);
    }
    let places = settling.places();
    let moved = places.iter().zip(&patch.places).filter(|(new, old)| new != old).count();
    patch.places = places;
    Ok(moved)
}

/// Places to try for element `i`.
fn choices(patch: &Patch<'_>, i: usize, random: &mut Stream) -> Vec<Point> {
    let old = patch.places[i];
    let step = |length: &f64| {
        let offset = Point::new(random.normal(), random.normal()) * (length * patch.scene.unit);
        Some(old + offset).filter(|p| patch.holds(*p))
    };
    let mut choices: Vec<Point> = STEPS.iter().filter_map(step).collect();
    if !patch.scene.intensity.is_flat() {
        // A painted density is kept by keeping elements about where they were drawn.
        let limit = random.unit() * patch.scene.intensity.at(old);
        choices.retain(|p| p.distance(old) < patch.scene.unit && patch.scene.intensity.at(*p) >= limit);
        return choices;
    }
    choices.extend((0..DRAWS).filter_map(|_| patch.sampler.draw(patch.block, random)));
    if patch.scene.metric == Metric::Disk {
        choices.extend((0..NEAR_PARENTS).filter_map(|k| near_parent(patch, (i, k), random)));
    }
    choices
}

/// A place over or at the rim of a parent drawn from one class in turn, its distance uniform, as
/// the axis is linear in it.
fn near_parent(patch: &Patch<'_>, (i, k): (usize, usize), random: &mut Stream) -> Option<Point> {
    let parents = patch.scene.views[1..].get(k % (patch.scene.views.len() - 1).max(1))?.partners.list();
    let parent = parents.get(random.below(parents.len().max(1)))?;
    let reach = parent.radius * patch.scene.unit + patch.radii[i];
    let p = parent.place + Point::from_angle(random.range(0.0, TAU)) * (random.unit() * reach);
    Some(p).filter(|p| patch.holds(*p))
}

/// An element whose individual curve leaves the validity region by more than [`FREE`] of the bound
/// counts as this many average elements' share of the errors at the beginning, times the excess.
const OUTSIDE_WEIGHT: f64 = 10.0;

/// See [`OUTSIDE_WEIGHT`]: the extremes of a few curves are often passed a little by as many new
/// ones.
const FREE: f64 = 0.3;

/// The most an excess counts.
const MOST_EXCESS: f64 = 1.0;

/// A complete block whose elements can be moved one at a time.
pub(super) struct Settling<'a> {
    patch: &'a Patch<'a>,
    filling: Filling,
    trials: [Trial<'a>; 2],
    /// What a squared error weighs: of each curve, of each row of triplets.
    weights: (Vec<f64>, Vec<f64>),
}

impl<'a> Settling<'a> {
    /// The block of `patch`, errors measured by their share of `scales`.
    pub(super) fn new(patch: &'a Patch<'a>, (curves, triplets): (&[f64], &[f64])) -> Self {
        let weights = |scales: &[f64]| scales.iter().map(|s| 1.0 / (s * s)).collect();
        let filling = Filling::complete(patch);
        Self {
            patch,
            filling,
            trials: [Trial::new(patch), Trial::new(patch)],
            weights: (weights(curves), weights(triplets)),
        }
    }

    /// The places of all elements.
    pub(super) fn places(self) -> Vec<Point> {
        self.filling.inner.list().iter().map(|p| p.place).collect()
    }

    /// Moves element `i` to the best of its own place and `choices`, ties to the first; `false`
    /// when all of them are too near another of the class, and it stays.
    pub(super) fn settle(&mut self, i: usize, choices: &[Point]) -> bool {
        let old = self.filling.inner.list()[i];
        self.withdraw(i, &old);
        let half = choices.len() / 2;
        let (patch, filling, weights) = (self.patch, &self.filling, &self.weights);
        let best_of = |trial: &mut Trial<'a>, places: &[Point], start: Option<Point>| {
            let (mut best, mut least) = (None, f64::INFINITY);
            for p in start.iter().chain(places) {
                if trial.see((*p, old.radius), filling) {
                    let error = distance(trial, (patch, filling), weights);
                    if error < least {
                        (best, least) = (Some(*p), error);
                    }
                }
            }
            (best, least)
        };
        let [one, other] = &mut self.trials;
        let (first, second) =
            rayon::join(|| best_of(one, &choices[..half], Some(old.place)), || best_of(other, &choices[half..], None));
        let best = if second.1 < first.1 { second.0 } else { first.0 };
        self.put(i, Partner { place: best.unwrap_or(old.place), ..old });
        best.is_some()
    }

    fn withdraw(&mut self, i: usize, old: &Partner) {
        self.filling.inner.hide(i);
        self.trials[0].show((i, old), -1.0, &mut self.filling);
        self.trials[0].see((old.place, old.radius), &self.filling);
        self.trials[0].add_to_sums(-1.0, &mut self.filling);
    }

    fn put(&mut self, i: usize, new: Partner) {
        let scene = self.patch.scene;
        let new = Partner { weight: scene.intensity.weight(new.place), ..new };
        self.trials[0].see((new.place, new.radius), &self.filling);
        self.trials[0].add((i, &new), &mut self.filling);
        self.filling.borders[i] = scene.border_table(new.place, self.patch.reach_of(new.radius, &self.filling.inner));
        self.filling.inner.put(i, new);
    }
}

/// Σ of squared errors of all curves and triplets with the candidate of `trial`.
fn distance(
    trial: &Trial<'_>,
    (patch, filling): (&Patch<'_>, &Filling),
    (curves, triplets): &(Vec<f64>, Vec<f64>),
) -> f64 {
    let per_element = 1.0 / filling.sums.placed.max(1) as f64;
    let mut sum = (trial.outside() - FREE).clamp(0.0, MOST_EXCESS) * OUTSIDE_WEIGHT * per_element;
    for (v, view) in patch.scene.views.iter().enumerate() {
        let goal = &view.goal;
        let curve =
            |bin: usize| ((filling.sums.sums[v][bin] + trial.curve_at(v, bin)) * per_element - goal.mean[bin]).powi(2);
        let of_curve: f64 = (0..goal.mean.len()).map(curve).sum();
        let triplet = |(bin, weight): (usize, &f64)| {
            let mean = (filling.sums.triplets[v][bin] + trial.triplets_at(v, bin)) * per_element;
            (mean - goal.triplets[bin]).powi(2) * weight
        };
        let of_triplets: f64 = view.triplet_weights.iter().enumerate().map(triplet).sum();
        let bins = goal.mean.len().max(1) as f64;
        sum += (of_curve * curves[v] + of_triplets * triplets[v] * patch.scene.triplet_share(v)) / bins;
    }
    sum
}
