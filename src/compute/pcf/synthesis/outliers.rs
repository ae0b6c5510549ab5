//! Outliers: elements that keep the curves from their targets, whose individual curve left the
//! validity region, or that came too near another, are taken out and laid out again (T 3.6.5).

use super::partners::Partner;
use super::patch::Individual;
use super::patch::Patch;
use super::patch::sums_of;
use super::patch::triplet_sums;
use super::refine::refine;
use super::trial::BARRED;
use super::trial::BlockSums;
use super::trial::Filling;
use super::trial::KernelRows;
use super::trial::Trial;
use crate::compute::geometry::Point;
use crate::compute::pcf::Curve;
use crate::compute::pcf::PcfError;
use crate::compute::pcf::RELATIVE_FLOOR;
use crate::compute::pcf::SynthesisOptions;
use crate::compute::random::Purpose;
use crate::compute::random::Stream;
use crate::compute::run::Run;

const AGAIN: Purpose = Purpose::new("distribution.outliers");

/// The same for triplets, in standard deviations of single elements.
const LEAST_TRIPLET_SCALE: f64 = 0.15;

/// At most this share of a block is laid out again in one round.
const MOST_AT_ONCE: f64 = 0.05;

/// Places tried for an element laid out again.
const TRIES: usize = 100;

/// Rounds of parting elements that are too near each other.
const PARTING_ROUNDS: usize = 4;

/// Descents after outliers were laid out again are this many times shorter.
const AGAIN_SHORTER: usize = 4;

/// How often a refinement is tried when a curve ends worse than it began.
const MOST_REFINEMENTS: usize = 4;

/// What the scale of such a curve is multiplied by.
const MORE_WEIGHT: f64 = 0.4;

/// After so many rounds that brought nothing, no more are tried.
const MOST_IN_VAIN: usize = 3;

/// A curve that begins nearer to its target than this is measured by this instead, so that one
/// that fits already does not bind the others.
const LEAST_SCALE: f64 = 0.01;

/// What became of a block.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Improved {
    /// Elements laid out again.
    pub(super) replaced: usize,
    /// Elements taken out for good, as no free place was found.
    pub(super) missing: usize,
    /// Iterations of the descents.
    pub(super) iterations: usize,
    /// Elements whose individual curve is outside the validity region at the end.
    pub(super) outside: usize,
}

/// Refines a filled block; then lays outliers out again and refines, as long as that brings the
/// curves nearer; then parts what is too near. No curve ends farther from its target than it
/// began. `stream` numbers the block.
pub(super) fn improve(
    patch: &mut Patch<'_>,
    stream: u64,
    options: &SynthesisOptions,
    run: &Run,
) -> Result<Improved, PcfError> {
    let begun = patch.individuals(&[]);
    let limits = patch.errors_of(&begun);
    let scales: Vec<f64> = limits.iter().map(|e| e.max(LEAST_SCALE)).collect();
    let triplet_scale = patch.triplet_error(&begun).max(LEAST_TRIPLET_SCALE);
    let distance = |patch: &Patch<'_>, individuals: &[Individual], errors: &[f64]| {
        let triplets = patch.triplet_error(individuals) / triplet_scale;
        errors.iter().zip(&scales).map(|(e, s)| (e / s).powi(2)).sum::<f64>() + triplets * triplets
    };
    let iterations = refine_within(patch, (scales.clone(), &limits), options, run)?;
    let mut improved = Improved { iterations, ..Improved::default() };
    let mut individuals = patch.individuals(&[]);
    let mut least = distance(patch, &individuals, &patch.errors_of(&individuals));
    let shorter = SynthesisOptions { max_iterations: options.max_iterations / AGAIN_SHORTER, ..options.clone() };
    let mut in_vain = 0;
    for round in 0..options.outlier_rounds {
        run.check()?;
        let outliers = worst(patch, &individuals, options);
        if outliers.is_empty() || in_vain >= MOST_IN_VAIN {
            break;
        }
        let before = patch.places.clone();
        replace(patch, &outliers, Stream::new(options.seed, AGAIN, stream << 8 | round as u64), run)?;
        let iterations = refine(patch, &scales, &shorter, run)?;
        let after = patch.individuals(&[]);
        let errors = patch.errors_of(&after);
        let now = distance(patch, &after, &errors);
        if errors.iter().zip(&limits).any(|(e, l)| *e > l + 1e-9) || now >= least {
            patch.places = before;
            in_vain += 1;
            continue;
        }
        (individuals, least) = (after, now);
        improved.replaced += outliers.len();
        improved.iterations += iterations;
    }
    part(patch, &mut improved, (stream, options), run)?;
    let outside = patch.individuals(&[]).iter().filter(|i| region_error(i, patch) > options.outlier_tolerance).count();
    Ok(Improved { outside, ..improved })
}

/// Refines; while a curve ends above its share of `limits`, again with more weight on it; if that
/// does not help, the places stay as they were.
fn refine_within(
    patch: &mut Patch<'_>,
    (mut scales, limits): (Vec<f64>, &[f64]),
    options: &SynthesisOptions,
    run: &Run,
) -> Result<usize, PcfError> {
    let (before, mut iterations) = (patch.places.clone(), 0);
    for _ in 0..MOST_REFINEMENTS {
        iterations += refine(patch, &scales, options, run)?;
        let errors = patch.errors_of(&patch.individuals(&[]));
        let above = |k: usize| errors[k] > limits[k] + 1e-9;
        if !(0..limits.len()).any(above) {
            return Ok(iterations);
        }
        (0..limits.len()).filter(|k| above(*k)).for_each(|k| scales[k] *= MORE_WEIGHT);
    }
    patch.places = before;
    Ok(iterations)
}

/// Parts elements of the class that are nearer than allowed; what finds no place is taken out.
fn part(
    patch: &mut Patch<'_>,
    improved: &mut Improved,
    (stream, options): (u64, &SynthesisOptions),
    run: &Run,
) -> Result<(), PcfError> {
    for round in 0..PARTING_ROUNDS {
        let near = too_near(patch);
        if near.is_empty() {
            return Ok(());
        }
        let index = stream << 8 | (options.outlier_rounds + round) as u64;
        let homeless = replace(patch, &near, Stream::new(options.seed, AGAIN, index), run)?;
        improved.replaced += near.len() - homeless.len();
        improved.missing += homeless.len();
        remove(patch, &homeless);
    }
    let near = too_near(patch);
    improved.missing += near.len();
    remove(patch, &near);
    Ok(())
}

fn remove(patch: &mut Patch<'_>, gone: &[usize]) {
    let mut index = 0;
    patch.radii.retain(|_| {
        index += 1;
        gone.binary_search(&(index - 1)).is_err()
    });
    index = 0;
    patch.places.retain(|_| {
        index += 1;
        gone.binary_search(&(index - 1)).is_err()
    });
}

/// How far the individual curves leave the validity region: the second term of T eq. 3.13, with
/// both bounds on every curve.
fn region_error(individual: &Individual, patch: &Patch<'_>) -> f64 {
    let outside = |row: &[f64], target: &Curve| {
        let at = |bin: usize| {
            let (lower, upper) = (target.lower[bin], target.upper[bin]);
            let above = (row[bin] - upper) / upper.max(RELATIVE_FLOOR);
            above.max((lower - row[bin]) / lower.max(RELATIVE_FLOOR))
        };
        (0..row.len()).map(at).fold(0.0, f64::max)
    };
    let views = individual.rows.iter().zip(&patch.scene.views);
    views.map(|(row, view)| outside(row, view.target)).fold(0.0, f64::max)
}

/// The elements to lay out again, ascending: those without which the mean curves would be
/// nearest to their targets, those farthest outside the validity region, those too near.
fn worst(patch: &Patch<'_>, individuals: &[Individual], options: &SynthesisOptions) -> Vec<usize> {
    let most = (individuals.len() as f64 * MOST_AT_ONCE).ceil() as usize;
    let region: Vec<f64> = individuals.iter().map(|i| region_error(i, patch) - options.outlier_tolerance).collect();
    let mut order = highest(&region, most);
    order.extend(highest(&relief(patch, individuals), most));
    order.extend(too_near(patch));
    order.sort_unstable();
    order.dedup();
    order
}

/// The indices of the highest values above 0, at most `most`.
fn highest(values: &[f64], most: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..values.len()).filter(|i| values[*i] > 0.0).collect();
    order.sort_by(|a, b| values[*b].total_cmp(&values[*a]).then(a.cmp(b)));
    order.truncate(most);
    order
}

/// By how much the distance of the block's curves to their targets falls when an element is
/// taken out: Σ over all curves and places, weighted as in the trials.
fn relief(patch: &Patch<'_>, individuals: &[Individual]) -> Vec<f64> {
    let (sums, count) = (sums_of(individuals, patch.scene), individuals.len() as f64);
    let (triplets, views) = (triplet_sums(individuals, patch.scene), patch.scene.views.len() as f64);
    let of = |individual: &Individual| {
        let mut relief = 0.0;
        for (bin, weight) in patch.scene.triplet_weights.iter().enumerate() {
            // An element is one end of as many triplets at either side as it is the middle of.
            let target = patch.scene.views[0].target.triplets[bin];
            let before = triplets[bin] - target * count;
            let after = before - 3.0 * (individual.triplets[bin] - target);
            relief += views * (before * before - after * after) * weight;
        }
        for (v, view) in patch.scene.views.iter().enumerate() {
            for bin in (0..view.factors.len()).filter(|b| view.factors[*b] > 0.0) {
                let target = view.target.mean[bin];
                let own = if v == 0 { individual.own[bin] } else { 0.0 };
                let expected = if v == 0 { target * (2.0 - 1.0 / count) } else { target };
                let before = sums[v][bin] - target * count;
                let after = before - individual.rows[v][bin] - own + expected;
                relief += (before * before - after * after) / (view.factors[bin] * target.max(RELATIVE_FLOOR));
            }
        }
        relief
    };
    individuals.iter().map(of).collect()
}

/// The later one of each pair of elements of the class nearer than allowed, ascending.
fn too_near(patch: &Patch<'_>) -> Vec<usize> {
    let (closest, inner) = (patch.scene.closest, patch.inner(&[]));
    let is_near = |i: &usize| {
        let (p, mut near) = (patch.places[*i], false);
        inner.for_each_near(p, closest, |j, other| near |= j < *i && other.place.distance(p) < closest);
        patch.context.for_each_near(p, closest, |_, other| near |= other.place.distance(p) < closest);
        near
    };
    if closest > 0.0 { (0..patch.places.len()).filter(is_near).collect() } else { Vec::new() }
}

/// Lays the given elements (ascending) out again, the largest first, each at the best of many
/// random places of its block; gives those for which none was free, ascending: they stay.
fn replace(patch: &mut Patch<'_>, outliers: &[usize], mut random: Stream, run: &Run) -> Result<Vec<usize>, PcfError> {
    let kept = patch.individuals(outliers);
    let mut sums = BlockSums::new(patch.scene, patch.places.len(), (patch.sampler.block_side(), 1.0));
    sums.placed = kept.len();
    sums.sums = sums_of(&kept, patch.scene);
    sums.triplets = triplet_sums(&kept, patch.scene);
    let curves = kept.into_iter().map(|mut i| std::mem::take(&mut i.rows[0])).collect();
    let mut filling = Filling { inner: patch.inner(outliers), curves, sums };
    let kernel = KernelRows::new(patch.scene);
    let mut order = outliers.to_vec();
    order.sort_by(|a, b| patch.radii[*b].total_cmp(&patch.radii[*a]).then(a.cmp(b)));
    let mut homeless = Vec::new();
    for i in order {
        run.check()?;
        match best_place(patch, (&kernel, &mut filling), i, &mut random) {
            Some(p) => patch.places[i] = p,
            None => homeless.push(i),
        }
    }
    homeless.sort_unstable();
    Ok(homeless)
}

/// The best of many random places of element `i`, which is added there.
fn best_place(
    patch: &Patch<'_>,
    (kernel, filling): (&KernelRows, &mut Filling),
    i: usize,
    random: &mut Stream,
) -> Option<Point> {
    let mut trial = Trial::new(patch, kernel);
    let radius = patch.radii[i] / patch.scene.unit;
    let (mut best, mut least) = (None, BARRED);
    for _ in 0..TRIES {
        let Some(p) = patch.sampler.draw(patch.block, random) else { continue };
        let error = trial.error((p, radius), filling, f64::INFINITY);
        if error < least {
            (best, least) = (Some(p), error);
        }
    }
    let place = best?;
    trial.error((place, radius), filling, f64::INFINITY);
    trial.accept(Partner { place, radius, weight: patch.scene.intensity.weight(place) }, filling);
    best
}
