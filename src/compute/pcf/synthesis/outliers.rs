//! Outliers: elements that keep the curves from their targets, whose individual curve left the
//! validity region, or that came too near another, are taken out and laid out again (T 3.6.5).

use super::limits::Limits;
use super::meter::Meter;
use super::patch::Individual;
use super::patch::Patch;
use super::refine::refine;
use super::settle::Choices;
use super::settle::Settled;
use super::settle::Settling;
use super::settle::settle;
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
const LEAST_TRIPLET_SCALE: f64 = 0.3;

/// Places tried for an element that is too near another.
const TRIES: usize = 100;

/// Rounds of parting elements that are too near each other.
const PARTING_ROUNDS: usize = 4;

/// Descents after outliers were laid out again are this many times shorter.
const AGAIN_SHORTER: usize = 6;

/// Rounds end when one lowers the squared errors by less than this share of what they were at
/// the beginning.
const LEAST_ROUND_GAIN: f64 = 0.002;

/// Rounds in which every element is looked at, and that are gone through whatever they gain: what
/// the pattern is like at large comes right in them.
const EXACT_ROUNDS: usize = 4;

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

/// Refines a filled block; then, round by round, lays its elements out again one at a time and
/// refines, as long as that brings the curves nearer; then parts what is too near. No curve ends
/// farther from its target than it began. `begun` is what its elements see, `stream` numbers it; gives
/// what they see at the end too.
pub(super) fn improve(
    patch: &mut Patch<'_>,
    begun: Vec<Individual>,
    stream: u64,
    (options, meter): (&SynthesisOptions, &Meter<'_>),
) -> Result<(Improved, Vec<Individual>), PcfError> {
    let (run, count) = (meter.run, patch.places.len());
    let errors_begun = patch.errors_of(&begun);
    let limits = Limits::of(&errors_begun);
    let is_above = |errors: &[f64]| errors.iter().zip(&errors_begun).any(|(error, begun)| *error > begun + 1e-9);
    let triplet_scales: Vec<f64> = patch.triplet_errors(&begun).iter().map(|e| e.max(LEAST_TRIPLET_SCALE)).collect();
    let before = (patch.places.clone(), begun);
    let iterations = refine(patch, &limits, options, run)?;
    let mut individuals = patch.individuals();
    if is_above(&patch.errors_of(&individuals)) {
        (patch.places, individuals) = before;
    }
    let mut kept = (patch.places.clone(), individuals.clone());
    let mut improved = Improved { iterations, ..Improved::default() };
    meter.advance(count)?;
    let shorter = SynthesisOptions { max_iterations: options.max_iterations / AGAIN_SHORTER, ..options.clone() };
    let (mut left, mut bearable) = (f64::INFINITY, f64::NEG_INFINITY);
    for round in 0..options.outlier_rounds {
        let random = Stream::new(options.seed, AGAIN, stream << 8 | round as u64);
        let settled = settle(patch, (&individuals, &limits, &triplet_scales), (random, bearable), meter)?;
        improved.replaced += settled.moved;
        bearable = if round + 1 < EXACT_ROUNDS { f64::NEG_INFINITY } else { settled.median };
        improved.iterations += refine(patch, &limits, &shorter, run)?;
        individuals = patch.individuals();
        let errors = patch.errors_of(&individuals);
        let holds = !is_above(&errors);
        if holds {
            kept = (patch.places.clone(), individuals.clone());
        }
        let before = left;
        left = mean_square(&errors, &limits.scales) + mean_square(&patch.triplet_errors(&individuals), &triplet_scales);
        if round >= EXACT_ROUNDS && holds && left > before - LEAST_ROUND_GAIN {
            meter.advance(count * (options.outlier_rounds - 1 - round))?;
            break;
        }
    }
    (patch.places, individuals) = kept;
    let before = (improved.replaced, improved.missing);
    part(patch, &mut improved, (stream, options), run)?;
    if before != (improved.replaced, improved.missing) {
        individuals = patch.individuals();
    }
    let outside = individuals.iter().filter(|i| region_error(i, patch) > options.outlier_tolerance).count();
    Ok((Improved { outside, ..improved }, individuals))
}

/// The mean square of errors over what each is measured by.
fn mean_square(errors: &[f64], scales: &[f64]) -> f64 {
    let square = |(error, scale): (&f64, &f64)| (error / scale).powi(2);
    errors.iter().zip(scales).map(square).sum::<f64>() / errors.len().max(1) as f64
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

/// The later one of each pair of elements of the class nearer than allowed, ascending.
fn too_near(patch: &Patch<'_>) -> Vec<usize> {
    let (closest, inner) = (patch.scene.closest, patch.inner());
    let is_near = |i: &usize| {
        let (p, mut near) = (patch.places[*i], false);
        inner.for_each_near(p, closest, |j, other| near |= j < *i && other.place.distance(p) < closest);
        patch.context.for_each_near(p, closest, |_, other| near |= other.place.distance(p) < closest);
        near
    };
    if closest > 0.0 { (0..patch.places.len()).filter(is_near).collect() } else { Vec::new() }
}

/// Lays the given elements (ascending) out again, each at a free place of its block chosen among
/// many; gives those for which none was free, ascending: they stay.
fn replace(patch: &mut Patch<'_>, near: &[usize], mut random: Stream, run: &Run) -> Result<Vec<usize>, PcfError> {
    let individuals = patch.individuals();
    let limits = Limits::of(&patch.errors_of(&individuals));
    let triplets = vec![1.0; limits.scales.len()];
    let mut settling = Settling::new(patch, (&individuals, &limits, &triplets), f64::NEG_INFINITY);
    let mut homeless = Vec::new();
    for i in near {
        run.check()?;
        let draws: Vec<Point> = (0..TRIES).filter_map(|_| patch.sampler.draw(patch.block, &mut random)).collect();
        if settling.settle(*i, &Choices { near: draws, ..Choices::default() }) == Settled::Homeless {
            homeless.push(*i);
        }
    }
    let places = settling.places();
    patch.places = places;
    Ok(homeless)
}
