//! Refinement: gradient descent on the curves of a block (T eq. 3.5–3.7).
//!
//! A pair's pull depends on the pair only through its place m on the axis, so an iteration needs
//! one table W(m) a curve and no sum over r a pair; the curves themselves come from a fine
//! histogram of m, smoothed once. Both make an iteration cost a few nanoseconds a pair.

use super::limits::Limits;
use super::partners::Partner;
use super::patch::Patch;
use super::scene::Scene;
use crate::compute::geometry::Point;
use crate::compute::pcf::PcfError;
use crate::compute::pcf::SynthesisOptions;
use crate::compute::pcf::rms;
use crate::compute::random::Purpose;
use crate::compute::random::hash2;
use crate::compute::random::unit;
use crate::compute::run::Run;
use rayon::prelude::*;

const DIRECTION: Purpose = Purpose::new("distribution.concentric");

/// Cells of the fine histogram between two values of the axis.
const FINE: usize = 8;

/// Pairs are gathered this far (r_max) beyond reach, so that a list stays valid while elements
/// move by half of it.
const SKIN: f64 = 0.3;

/// The kernel is left out beyond this many σ (5·10⁻⁶ of its peak).
const CUT_OFF_SIGMAS: f64 = 3.5;

/// Partners more than this many σ beyond the end of the axis are left out: of the kernel around
/// the end 2·10⁻⁴ lie there.
const TAIL_SIGMAS: f64 = 2.5;

/// Elements whose sums are taken together: fixed, so that results do not depend on threads.
const CHUNK: usize = 64;

/// The step lengths tried, in r_max (T 3.1.2: 10⁻¹ … 10⁻⁵).
const STEPS: [f64; 9] = [0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0001, 0.00001];

/// An iteration that lowers the error by less than this fraction ends the descent.
const LEAST_GAIN: f64 = 5e-3;

/// The most rounds of building lists.
const MOST_ROUNDS: usize = 40;

/// A partner in reach of an element: which one, and what the pair counts for the curve.
#[derive(Debug, Clone, Copy)]
struct Pair {
    partner: u32,
    weight: f32,
}

/// A disk in r_max.
#[derive(Debug, Clone, Copy)]
struct Body {
    place: Point,
    radius: f64,
}

/// What a descent ended with.
#[derive(Debug, Clone)]
pub(super) struct Refined {
    /// The places, in the order given.
    pub(super) places: Vec<Point>,
    /// Iterations used.
    pub(super) iterations: usize,
}

/// Moves the elements of `patch` so that their mean curves come nearer the targets, each curve
/// measured by `limits`. Gives the iterations used.
pub(super) fn refine(
    patch: &mut Patch<'_>,
    limits: &Limits,
    options: &SynthesisOptions,
    run: &Run,
) -> Result<usize, PcfError> {
    let mut descent = Descent::new(patch, limits, options);
    let refined = descent.descend(patch.places.clone(), run)?;
    patch.places = refined.places;
    Ok(refined.iterations)
}

/// The curves of a block and how far they are from their targets.
#[derive(Debug, Clone)]
struct State {
    /// What the descent lowers ([`Descent::total`]).
    total: f64,
    /// curve − target, one row a view.
    errors: Vec<Vec<f64>>,
}

struct Descent<'a> {
    patch: &'a Patch<'a>,
    scene: &'a Scene<'a>,
    /// Radii in r_max.
    radii: Vec<f64>,
    options: &'a SynthesisOptions,
    /// Width of a cell of the fine histogram.
    cell: f64,
    cells: usize,
    /// The kernel at every difference of a value of the axis and a cell, by cells.
    kernel: Vec<f64>,
    /// The farthest place on the axis that adds to a curve.
    reach: f64,
    /// For each element and view, the partners in reach, ascending. Of the first view, partners
    /// below the number of elements are elements of the block.
    pairs: Vec<Vec<Vec<Pair>>>,
    /// Those of the first view, each pair of two elements of the block only once, for both.
    once: Vec<Vec<Pair>>,
    /// Whom each view looks at, in r_max; in the first view without the block's elements.
    bodies: Vec<Vec<Body>>,
    /// How far each element may move before it must be checked against the room, in metres.
    freedom: Vec<f64>,
    gathered_at: Vec<Point>,
    /// How far the border is from each element at least, while the lists hold, in metres.
    clearance: Vec<f64>,
    limits: &'a Limits,
}

impl<'a> Descent<'a> {
    /// Round by round: gather the pairs in reach and descend while the lists hold; a round is kept
    /// only if it holds with the border weights of the new places. The last is not looked at again:
    /// whoever refines a block works out its curves.
    fn descend(&mut self, places: Vec<Point>, run: &Run) -> Result<Refined, PcfError> {
        let mut best = Refined { places, iterations: 0 };
        let mut rank = 0;
        self.gather(&best.places);
        let mut state = self.measure(&best.places);
        for _ in 0..MOST_ROUNDS {
            run.check()?;
            let before = state.total;
            let (round, last_rank, settled) = self.round(&best, (state, rank), run)?;
            if settled || round.iterations >= self.options.max_iterations {
                return Ok(round);
            }
            self.gather(&round.places);
            state = self.measure(&round.places);
            if state.total >= before {
                break;
            }
            (best, rank) = (round, last_rank);
            if state.total > before * (1.0 - LEAST_GAIN) {
                break;
            }
        }
        Ok(best)
    }

    fn new(patch: &'a Patch<'a>, limits: &'a Limits, options: &'a SynthesisOptions) -> Self {
        let scene = patch.scene;
        let cell = scene.axis.step / FINE as f64;
        let sigma = scene.axis.sigma;
        let half = (CUT_OFF_SIGMAS * sigma / cell) as usize;
        let reach = scene.axis.extent + TAIL_SIGMAS * sigma;
        let value = |k: usize| {
            let x = k as f64 * cell / sigma;
            libm::exp(-x * x) / (std::f64::consts::PI.sqrt() * sigma)
        };
        let body = |p: &Partner| Body { place: p.place * (1.0 / scene.unit), radius: p.radius };
        let bodies = |v: usize| patch.partners(v).list().iter().map(body).collect();
        Self {
            patch,
            scene,
            radii: patch.radii.iter().map(|r| r / scene.unit).collect(),
            options,
            cell,
            cells: (reach / cell) as usize + 2,
            reach,
            kernel: (0..=half).map(value).collect(),
            pairs: Vec::new(),
            once: Vec::new(),
            bodies: (0..scene.views.len()).map(bodies).collect(),
            freedom: Vec::new(),
            gathered_at: Vec::new(),
            clearance: Vec::new(),
            limits,
        }
    }

    /// Gathers all pairs that are or may come into reach, with their border weights.
    fn gather(&mut self, places: &[Point]) {
        let (scene, skin) = (self.scene, SKIN * self.scene.unit);
        let inner = self.inner_grid(places);
        let largest = self.radii.iter().copied().fold(0.0, f64::max);
        let axis_reach = self.reach;
        let gathered: Vec<Vec<Vec<Pair>>> = (0..places.len())
            .into_par_iter()
            .map(|i| {
                let (p, radius) = (places[i], self.radii[i]);
                let own = scene.metric.reach(axis_reach, radius, largest);
                let reach = |v: usize| scene.reach(self.patch.partners(v), radius, axis_reach);
                let farthest = (0..scene.views.len()).map(reach).fold(own, f64::max);
                let border = scene.border_table(p, farthest + SKIN);
                let pair = |partner: usize, q: Point, other: (f64, f64)| {
                    let distance = q.distance(p) / scene.unit;
                    let near = distance <= scene.metric.reach(axis_reach, radius, other.0) + SKIN;
                    near.then(|| Pair { partner: partner as u32, weight: (border.at(distance) * other.1) as f32 })
                };
                let of_view = |v: usize| {
                    let mut pairs = Vec::new();
                    if v == 0 {
                        inner.for_each_near(p, own * scene.unit + skin, |j| {
                            if j != i {
                                pairs.extend(pair(j, places[j], (self.radii[j], scene.intensity.weight(places[j]))));
                            }
                        });
                    }
                    self.patch.partners(v).for_each_near(p, reach(v) * scene.unit + skin, |j, partner| {
                        let number = if v == 0 { j + places.len() } else { j };
                        pairs.extend(pair(number, partner.place, (partner.radius, partner.weight)));
                    });
                    pairs.sort_unstable_by_key(|pair| pair.partner);
                    pairs
                };
                (0..scene.views.len()).map(of_view).collect()
            })
            .collect();
        self.pairs = gathered;
        self.once = self.pairs_once();
        self.freedom = places.par_iter().map(|p| self.patch.sampler.freedom(*p, skin)).collect();
        let farthest = (largest + self.scene.largest_radius() + axis_reach) * self.scene.unit;
        let clearance = |p: &Point| self.scene.domain.clearance(*p, farthest) - skin;
        self.clearance = places.par_iter().map(clearance).collect();
        self.gathered_at = places.to_vec();
    }

    /// The pairs of the first view, those within the block once and with the weights of both.
    fn pairs_once(&self) -> Vec<Vec<Pair>> {
        // Lists ascend and elements are taken in order: the k-th to meet a later one of the block
        // is the k-th in that one's own list.
        let mut met = vec![0; self.pairs.len()];
        let mut once = |i: usize| {
            let later = self.pairs[i][0].iter().filter(|pair| pair.partner as usize > i);
            let both = |pair: &Pair| match met.get_mut(pair.partner as usize) {
                Some(met) => {
                    let back = self.pairs[pair.partner as usize][0].get(*met).map_or(0.0, |back| back.weight);
                    *met += 1;
                    Pair { weight: pair.weight + back, ..*pair }
                }
                None => *pair,
            };
            later.map(both).collect()
        };
        (0..self.pairs.len()).map(&mut once).collect()
    }

    /// Elements at `places`, then those around the block.
    fn own_bodies(&self, places: &[Point]) -> Vec<Body> {
        let body = |(p, radius): (&Point, &f64)| Body { place: *p * (1.0 / self.scene.unit), radius: *radius };
        places.iter().zip(&self.radii).map(body).chain(self.bodies[0].iter().copied()).collect()
    }

    fn inner_grid(&self, places: &[Point]) -> crate::compute::geometry::CellGrid {
        crate::compute::geometry::CellGrid::new(places, self.scene.unit)
    }

    /// Descends until the lists run out, nothing is gained, or the iterations are used up.
    /// Gives the places, the rank of the last step length, and whether the descent settled.
    fn round(
        &self,
        from: &Refined,
        (mut state, mut rank): (State, usize),
        run: &Run,
    ) -> Result<(Refined, usize, bool), PcfError> {
        let mut at = from.clone();
        while at.iterations < self.options.max_iterations {
            run.check()?;
            at.iterations += 1;
            let directions = self.directions(&at.places, &state);
            let Some(step) = self.best_step(&at.places, &directions, (&state, rank)) else {
                return Ok((at, rank, true));
            };
            let gain = (state.total - step.state.total) / state.total;
            let moved: f64 = at.places.iter().zip(&step.places).map(|(a, b)| a.distance(*b)).sum();
            // Longer steps are tried again only where the longest tried was the best.
            rank = if step.rank == rank { rank.saturating_sub(1) } else { step.rank };
            (at.places, state) = (step.places, step.state);
            let still = moved < self.options.least_move * self.scene.unit * at.places.len() as f64;
            if still || gain < LEAST_GAIN {
                return Ok((at, rank, true));
            }
            let farthest = at.places.iter().zip(&self.gathered_at).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            if farthest > SKIN / 2.0 * self.scene.unit {
                break;
            }
        }
        Ok((at, rank, false))
    }

    /// The best of the step lengths: from the one of rank `rank` on to shorter ones until one
    /// helps, then on while the next is better still.
    fn best_step(&self, places: &[Point], directions: &[Point], from: (&State, usize)) -> Option<Step> {
        let mut best: Option<Step> = None;
        for (rank, step) in STEPS.iter().enumerate().skip(from.1) {
            let moved = self.moved(places, directions, step * self.scene.unit);
            let state = self.measure(&moved);
            let better = best.as_ref().map_or(from.0.total, |b| b.state.total);
            if state.total < better {
                best = Some(Step { places: moved, state, rank });
            } else if best.is_some() {
                break;
            }
        }
        best
    }

    /// All places moved along their directions by `length` metres; who would leave the room
    /// stays.
    fn moved(&self, places: &[Point], directions: &[Point], length: f64) -> Vec<Point> {
        let step = |i: usize| {
            let (old, new) = (places[i], places[i] + directions[i] * length);
            let free = new.distance(self.gathered_at[i]) < self.freedom[i] && self.freedom[i] > 0.0;
            if free || self.patch.sampler.allows(new) { new } else { old }
        };
        (0..places.len()).map(step).collect()
    }

    /// The curves of the block with its elements at `places`.
    fn measure(&self, places: &[Point]) -> State {
        let views = self.scene.views.len();
        let own = self.own_bodies(places);
        let chunks: Vec<Vec<f64>> =
            (0..places.len().div_ceil(CHUNK)).into_par_iter().map(|c| self.histogram(&own, places.len(), c)).collect();
        let mut histogram = vec![0.0; views * self.cells];
        for chunk in chunks {
            histogram.iter_mut().zip(chunk).for_each(|(sum, value)| *sum += value);
        }
        let curve = |v: usize| {
            let view = &self.scene.views[v];
            let smooth = self.smoothed(&histogram[v * self.cells..(v + 1) * self.cells]);
            let count = places.len().max(1) as f64;
            smooth.iter().zip(&view.factors).map(|(s, f)| s * f / count).collect::<Vec<f64>>()
        };
        let curves: Vec<Vec<f64>> = (0..views).into_par_iter().map(curve).collect();
        let targets = || self.scene.views.iter().map(|v| &v.target.mean);
        let rms: Vec<f64> = curves.iter().zip(targets()).map(|(c, t)| rms(c, t)).collect();
        let errors: Vec<Vec<f64>> =
            curves.iter().zip(targets()).map(|(c, t)| c.iter().zip(t).map(|(c, t)| c - t).collect()).collect();
        State { total: self.total(&rms), errors }
    }

    /// What the descent lowers: Σ of squared errors, each curve's over what it began with, so
    /// that a curve with high peaks does not drown the others.
    fn total(&self, rms: &[f64]) -> f64 {
        let square = |(v, rms): (usize, &f64)| self.limits.cost(v, (rms / self.limits.scales[v]).powi(2));
        rms.iter().enumerate().map(square).sum()
    }

    /// The fine histogram of one chunk of the block's `count` elements: each pair's weight split
    /// between the two nearest cells.
    fn histogram(&self, own: &[Body], count: usize, chunk: usize) -> Vec<f64> {
        let mut histogram = vec![0.0; self.scene.views.len() * self.cells];
        let per_cell = 1.0 / self.cell;
        for i in chunk * CHUNK..((chunk + 1) * CHUNK).min(count) {
            for (v, histogram) in histogram.chunks_exact_mut(self.cells).enumerate() {
                let (pairs, bodies) = if v == 0 { (&self.once[i], own) } else { (&self.pairs[i][v], &*self.bodies[v]) };
                for pair in pairs {
                    let other = &bodies[pair.partner as usize];
                    let distance = other.place.distance(own[i].place);
                    let at = self.scene.metric.value(distance, own[i].radius, other.radius) * per_cell;
                    let cell = at as usize;
                    if cell + 1 < self.cells {
                        let (weight, share) = (f64::from(pair.weight), at - cell as f64);
                        histogram[cell] += weight * (1.0 - share);
                        histogram[cell + 1] += weight * share;
                    }
                }
            }
        }
        histogram
    }

    /// The kernel sum at every place of the axis.
    fn smoothed(&self, histogram: &[f64]) -> Vec<f64> {
        let half = self.kernel.len() - 1;
        let value = |bin: usize| {
            let middle = (bin + 1) * FINE;
            let (first, last) = (middle.saturating_sub(half), (middle + half).min(self.cells - 1));
            let term = |cell: usize| histogram[cell] * self.kernel[cell.abs_diff(middle)];
            (first..=last).map(term).sum()
        };
        (0..self.scene.axis.bins()).map(value).collect()
    }

    /// W(m) = Σ_r e(r)/M(r)·(m − r)·k_σ(m − r) at every cell: how a pair at m pulls (T eq. 3.7
    /// with M(r) for r); positive pushes apart.
    fn pull(&self, errors: &[f64], v: usize) -> Vec<f64> {
        let per_square = 1.0 / (self.limits.scales[v] * self.limits.scales[v]);
        let square = errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64 * per_square;
        let weight = per_square * self.limits.slope(v, square);
        let factors = &self.scene.views[v].factors;
        let half = self.kernel.len() - 1;
        let value = |cell: usize| {
            let bins =
                (cell.saturating_sub(half) / FINE).saturating_sub(1)..self.scene.axis.bins().min((cell + half) / FINE);
            bins.map(|bin| {
                let middle = (bin + 1) * FINE;
                let apart = (cell as f64 - middle as f64) * self.cell;
                let kernel = self.kernel.get(cell.abs_diff(middle)).copied().unwrap_or(0.0);
                weight * errors[bin] * factors[bin] * apart * kernel
            })
            .sum()
        };
        (0..self.cells).map(value).collect()
    }

    /// Where each element is to move: against the gradient of the summed squared errors,
    /// normalised by the sum of absolute pulls (T eq. 3.5), so at most 1 long. The slope of the
    /// metric is squared in the normaliser, so that a step is a step along the axis: among disks
    /// that overlap partly the axis runs over a radius, among disjoint ones over r_max/2. For
    /// points it is T's.
    fn directions(&self, places: &[Point], state: &State) -> Vec<Point> {
        let tables: Vec<Vec<f64>> =
            (0..state.errors.len()).into_par_iter().map(|v| self.pull(&state.errors[v], v)).collect();
        let own = self.own_bodies(places);
        (0..places.len()).into_par_iter().map(|i| self.direction(i, (places[i], &own), &tables)).collect()
    }

    fn direction(&self, i: usize, (place, own): (Point, &[Body]), tables: &[Vec<f64>]) -> Point {
        let (mut sum, mut absolute) = (Point::default(), 0.0);
        let (clearance, per_cell) = (self.clearance[i] / self.scene.unit, 1.0 / self.cell);
        for (v, table) in tables.iter().enumerate() {
            let bodies = if v == 0 { own } else { &self.bodies[v] };
            for pair in &self.pairs[i][v] {
                let other = &bodies[pair.partner as usize];
                let offset = own[i].place - other.place;
                let distance = offset.norm();
                // Beyond the border there is nobody to pull back: only partners whose mirror
                // image, seen from here, lies in the domain too are balanced.
                if distance > clearance && !self.scene.domain.contains(place + offset * self.scene.unit) {
                    continue;
                }
                let at = self.scene.metric.value(distance, own[i].radius, other.radius) * per_cell;
                let cell = at as usize;
                if cell + 1 >= self.cells {
                    continue;
                }
                let share = at - cell as f64;
                let slope = self.scene.metric.slope(distance, own[i].radius, other.radius);
                let pull = (table[cell] * (1.0 - share) + table[cell + 1] * share) * f64::from(pair.weight);
                let away = if distance > 0.0 { offset * (1.0 / distance) } else { self.any_direction(i, pair.partner) };
                sum = sum + away * (pull * slope);
                absolute += pull.abs() * slope * slope;
            }
        }
        if absolute > 0.0 { sum * (1.0 / absolute) } else { Point::default() }
    }

    /// Concentric pairs have no gradient direction: a random one, opposite for the two.
    fn any_direction(&self, i: usize, partner: u32) -> Point {
        let (a, b) = ((i as u64).min(u64::from(partner)), (i as u64).max(u64::from(partner)));
        let angle = unit(hash2(self.options.seed, DIRECTION, a, b)) * std::f64::consts::TAU;
        let direction = Point::from_angle(angle);
        if i as u64 == a { direction } else { -direction }
    }
}

struct Step {
    places: Vec<Point>,
    state: State,
    rank: usize,
}
