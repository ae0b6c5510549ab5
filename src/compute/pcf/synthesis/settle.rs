//! Settling: elements are taken out one at a time and laid out again where the curves of the
//! block come nearest to their targets, their old place among the choices (T 3.6.5, applied to
//! all elements and not to outliers alone).
//!
//! The descent moves all elements along the gradient at once and stops in the nearest hollow;
//! settling leaves hollows, and sees triplets too.

use super::at_large::AtLarge;
use super::filling::Filling;
use super::limits::Limits;
use super::meter::Meter;
use super::partners::Partner;
use super::patch::Individual;
use super::patch::Patch;
use super::scene::View;
use super::trial::Rows;
use super::trial::Trial;
use crate::compute::geometry::Point;
use crate::compute::pcf::DISJOINT;
use crate::compute::pcf::Metric;
use crate::compute::pcf::PcfError;
use crate::compute::random::Stream;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Places near the old one that are tried: standard deviations of the step in r_max.
const STEPS: [f64; 4] = [0.05, 0.15, 0.4, 1.0];

/// Places anywhere in the block that are drawn; those that fit best at large are tried.
const DRAWS: usize = 24;

/// How many of them are tried.
const TRIED: usize = 6;

/// Places over or at the rim of parents that are tried for disks which keep their company, parent
/// classes in turn: where parents are small, places drawn anywhere seldom hit one.
const NEAR_PARENTS: usize = 20;

/// Disks keep the company of parents when their curve is at least this where disks overlap or
/// touch, root mean square over the pairs expected by chance (ours: nests have 2.7 and more,
/// independent disks 1.3 and less).
const COMPANY: f64 = 2.0;

/// Of so many parents drawn the one with the fewest elements of the class over it is taken.
const SUITORS: usize = 8;

/// Directions in which the rim of a parent is looked at.
const DIRECTIONS: usize = 12;

/// The most elements whose best places are looked for at one time, before any of them moves.
const MOST_AT_ONCE: usize = 16;

/// Of this many elements one is looked at at one time, so that what is found mostly still holds.
const ELEMENTS_EACH: usize = 12;

/// Of the places an element would move to, this many are looked at again when others have moved
/// since.
const RIVALS: usize = 4;

/// What a round of settling did.
#[derive(Debug, Clone, Copy)]
pub(super) struct Round {
    /// Elements that moved.
    pub(super) moved: usize,
    /// By how much an element raises the squared errors where it lies, the median before the round.
    pub(super) median: f64,
}

/// Settles every element of `patch` once, in random order, but for those that raise the squared
/// errors by less than `bearable` where they are. `individuals` are what the elements see; errors
/// of curves are measured by `limits`, those of triplets by their share of `triplet_scales`.
pub(super) fn settle(
    patch: &mut Patch<'_>,
    (individuals, limits, triplet_scales): (&[Individual], &Limits, &[f64]),
    (mut random, bearable): (Stream, f64),
    meter: &Meter<'_>,
) -> Result<Round, PcfError> {
    let mut order: Vec<usize> = (0..patch.places.len()).collect();
    random.shuffle(&mut order);
    let mut settling = Settling::new(patch, (individuals, limits, triplet_scales), bearable);
    let hosts = hosts(patch);
    let (mut moved, mut burdens) = (0, Vec::new());
    for batch in order.chunks((order.len() / ELEMENTS_EACH).clamp(1, MOST_AT_ONCE)) {
        meter.run.check()?;
        let choices: Vec<(usize, Choices)> =
            batch.iter().map(|i| (*i, choices((patch, &settling.filling, &hosts), *i, &mut random))).collect();
        let wishes = settling.wishes(&choices);
        let mut moved_here = 0;
        for ((i, _), wish) in choices.iter().zip(&wishes).filter(|(_, wish)| !wish.better.is_empty()) {
            // What was wished for most may not be the best any more once another has moved.
            let rivals = if moved_here == 0 { 1 } else { RIVALS };
            let near = wish.better.iter().take(rivals).copied().collect();
            let choices = Choices { near, anywhere: Vec::new() };
            moved_here += usize::from(settling.settle(*i, &choices) == Settled::Moved);
        }
        moved += moved_here;
        burdens.extend(wishes.iter().map(|wish| wish.burden));
        meter.advance(batch.len())?;
    }
    burdens.sort_by(f64::total_cmp);
    patch.places = settling.places();
    Ok(Round { moved, median: burdens.get(burdens.len() / 2).copied().unwrap_or(0.0) })
}

/// Places to try for an element.
#[derive(Debug, Clone, Default)]
pub(super) struct Choices {
    /// Tried all.
    pub(super) near: Vec<Point>,
    /// Of these the ones that fit best at large.
    pub(super) anywhere: Vec<Point>,
}

/// Places to try for element `i`.
fn choices((patch, filling, hosts): (&Patch<'_>, &Filling, &[Host]), i: usize, random: &mut Stream) -> Choices {
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
        return Choices { near: choices, anywhere: Vec::new() };
    }
    let anywhere = (0..DRAWS).filter_map(|_| patch.sampler.draw(patch.block, random)).collect();
    let visits = hosts.iter().cycle().take(NEAR_PARENTS);
    choices.extend(visits.filter_map(|host| near_parent((patch, filling), (i, host), random)));
    Choices { near: choices, anywhere }
}

/// A parent class whose company disks of the class keep.
struct Host {
    view: usize,
    /// Those of its elements over or at the rim of which the block has places.
    parents: Vec<usize>,
}

/// The hosts of the class.
fn hosts(patch: &Patch<'_>) -> Vec<Host> {
    let scene = patch.scene;
    if scene.metric != Metric::Disk {
        return Vec::new();
    }
    let over = (DISJOINT / scene.axis.step) as usize;
    let company = |v: &usize| {
        let view = &scene.views[*v];
        let near = || view.target.mean.iter().zip(&view.mass).take(over);
        let squares: f64 = near().map(|(mean, mass)| mean * mean * mass).sum();
        squares >= COMPANY * COMPANY * near().map(|(_, mass)| mass).sum::<f64>()
    };
    let host = |view: usize| {
        let parents = scene.views[view].partners.list();
        Host { view, parents: (0..parents.len()).filter(|j| has_places(patch, &parents[*j])).collect() }
    };
    (1..scene.views.len()).filter(company).map(host).collect()
}

/// Whether the block has places over or at the rim of `parent`.
fn has_places(patch: &Patch<'_>, parent: &Partner) -> bool {
    let at = |k: usize| Point::from_angle(TAU * k as f64 / DIRECTIONS as f64) * (parent.radius * patch.scene.unit);
    patch.holds(parent.place) || (0..DIRECTIONS).any(|k| patch.holds(parent.place + at(k)))
}

/// A place over or at the rim of a parent of `host`, its distance uniform, as the axis is linear
/// in it. The parent is the loneliest of a few: where each is to have its own
/// company, the ones without are few in the end, and seldom drawn.
fn near_parent(
    (patch, filling): (&Patch<'_>, &Filling),
    (i, host): (usize, &Host),
    random: &mut Stream,
) -> Option<Point> {
    let parents = patch.scene.views.get(host.view)?.partners.list();
    let axis = patch.scene.rows.axis();
    let over = axis.start..axis.end.min(axis.start + (DISJOINT / patch.scene.sparse.axis.step) as usize);
    let company = |j: &usize| {
        let row = filling.seen[host.view].get(*j).and_then(|row| row.get(over.clone()));
        row.map_or(0.0, |row| row.iter().sum::<f32>())
    };
    let mut draw = |_: usize| host.parents.get(random.below(host.parents.len().max(1))).copied();
    let drawn: Vec<usize> = (0..SUITORS).filter_map(&mut draw).collect();
    let loneliest = drawn.into_iter().min_by(|a, b| company(a).total_cmp(&company(b)))?;
    let parent = parents.get(loneliest)?;
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

/// The same for one that lacks more than [`FREE_NEAR`] of the least the exemplar's have near: so
/// much that it lies alone only where nothing else fits (ours; with a third of it some still do in
/// most outputs of small classes).
const ALONE_WEIGHT: f64 = 100.0;

/// See [`ALONE_WEIGHT`] (ours; where every lack counts, elements are drawn together and leave
/// wider gaps than the exemplar's).
const FREE_NEAR: f64 = 0.5;

/// The most an excess counts.
const MOST_EXCESS: f64 = 1.0;

/// What became of an element that was to settle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Settled {
    /// Another place is better.
    Moved,
    /// Its own place is the best.
    Stayed,
    /// All places are too near another of the class.
    Homeless,
}

/// A complete block whose elements can be moved one at a time.
pub(super) struct Settling<'a> {
    patch: &'a Patch<'a>,
    filling: Filling,
    chooser: Chooser<'a>,
    /// What a squared error weighs.
    weights: Rows,
    limits: &'a Limits,
    /// Elements that raise the squared errors by less stay.
    bearable: f64,
}

impl<'a> Settling<'a> {
    /// The block of `patch`, whose elements see `individuals`; errors of curves are measured by
    /// `limits`, those of triplets by their share of the scales. Elements that raise them by less than
    /// `bearable` stay.
    pub(super) fn new(
        patch: &'a Patch<'a>,
        (individuals, limits, triplets): (&[Individual], &'a Limits, &[f64]),
        bearable: f64,
    ) -> Self {
        let scene = patch.scene;
        let bins = scene.sparse.bins() as f64;
        let views = || scene.views.iter().enumerate();
        let of_curve = |(v, _): (usize, &View<'_>)| {
            let weight = 1.0 / (limits.scales[v] * limits.scales[v] * bins);
            scene.rows.aligned((0..scene.sparse.bins()).map(|_| weight))
        };
        let of_triplets = |(v, view): (usize, &View<'_>)| {
            let weight = scene.triplet_share(v) / (triplets[v] * triplets[v] * bins);
            scene.rows.aligned(view.triplet_weights.iter().map(|inverse| inverse * weight))
        };
        let weights = Rows { curves: views().map(of_curve).collect(), triplets: views().map(of_triplets).collect() };
        let (filling, chooser) = (Filling::complete(patch, individuals), Chooser::new(patch, limits));
        Self { patch, filling, chooser, weights, limits, bearable }
    }

    /// The places of all elements.
    pub(super) fn places(self) -> Vec<Point> {
        self.filling.inner.list().iter().map(|p| p.place).collect()
    }

    /// For each of some elements, where among its choices it had better be as things stand.
    fn wishes(&self, choices: &[(usize, Choices)]) -> Vec<Wish> {
        let wish = |chooser: &mut Chooser<'a>, (i, choices): &(usize, Choices)| {
            chooser.best((&self.filling, &self.weights, self.bearable), *i, choices)
        };
        choices.par_iter().map_init(|| Chooser::new(self.patch, self.limits), wish).collect()
    }

    /// Moves element `i` to the best of its own place and `choices`, ties to the first.
    pub(super) fn settle(&mut self, i: usize, choices: &Choices) -> Settled {
        let wish = self.chooser.best((&self.filling, &self.weights, self.bearable), i, choices);
        match wish.better.first() {
            Some(place) => {
                let old = self.filling.inner.list()[i];
                self.put(i, &old, *place);
                Settled::Moved
            }
            None if wish.may_stay => Settled::Stayed,
            None => Settled::Homeless,
        }
    }

    /// Moves element `i`, which the chooser has taken out, from `old` to `place`.
    fn put(&mut self, i: usize, old: &Partner, place: Point) {
        let (scene, trial) = (self.patch.scene, &mut self.chooser.trial);
        let new = Partner { place, weight: scene.intensity.weight(place), ..*old };
        let (mut seen, Filling { far, windows, depths, sums, .. }) = (Vec::new(), &mut self.filling);
        far.show(old.place, -1.0);
        for (p, times) in [(old.place, -1.0), (place, 1.0)] {
            far.read(p, &mut seen);
            sums.far.add(&seen, times);
            windows.add(p, times);
            depths.add(scene.depth(p), times);
        }
        far.show(place, 1.0);
        for (partner, times) in [(old, -1.0), (&new, 1.0)] {
            trial.see_all((partner.place, partner.radius), &self.filling);
            trial.add_to_sums(times, &mut self.filling);
        }
        trial.show((i, old), -1.0, &mut self.filling);
        self.filling.inner.put(i, new);
        trial.show((i, &new), 1.0, &mut self.filling);
        self.filling.curves[i] = trial.own_curve();
        self.filling.borders[i] = scene.border_table(place, self.patch.reach_of(new.radius, &self.filling.inner));
    }
}

/// Where an element had better be.
#[derive(Debug, Clone)]
struct Wish {
    /// Whether its own place is not too near another of the class.
    may_stay: bool,
    /// The places that are better than its own, the best first.
    better: Vec<Point>,
    /// By how much it raises the squared errors where it is.
    burden: f64,
}

/// Finds the best place for an element of a block.
struct Chooser<'a> {
    trial: Trial<'a>,
    at_large: AtLarge<'a>,
    limits: &'a Limits,
    /// How far the block is from its goals without the element.
    errors: Rows,
    /// The squared errors of its curves.
    squares: Vec<f64>,
}

impl<'a> Chooser<'a> {
    fn new(patch: &'a Patch<'a>, limits: &'a Limits) -> Self {
        let rows = || patch.scene.views.iter().map(|_| patch.scene.rows.zeros()).collect();
        Self {
            trial: Trial::new(patch),
            at_large: AtLarge::new(patch, &limits.scales),
            limits,
            errors: Rows { curves: rows(), triplets: rows() },
            squares: Vec::new(),
        }
    }

    /// Which of the choices are better for element `i` than its own place.
    fn best(&mut self, (filling, weights, bearable): (&Filling, &Rows, f64), i: usize, choices: &Choices) -> Wish {
        let (old, count) = (filling.inner.list()[i], filling.sums.placed);
        self.trial.take_out(i, filling);
        let free = self.trial.see_all((old.place, old.radius), filling);
        self.trial.errors_without(&mut self.errors, (&filling.sums, count));
        self.squares = self.trial.squares_of(&self.errors, weights);
        self.at_large.take_out(old.place, filling);
        let burden = self.error(weights, count) + self.at_large.growth(old.place, filling);
        let mut better: Vec<(f64, Point)> = Vec::new();
        if !free || burden >= bearable {
            let most = if free { burden } else { f64::INFINITY };
            for p in choices.near.iter().chain(&self.best_at_large(&choices.anywhere, filling)) {
                if self.trial.see((*p, old.radius), filling) {
                    let error = self.error(weights, count) + self.at_large.growth(*p, filling);
                    better.extend((error < most).then_some((error, *p)));
                }
            }
        }
        better.sort_by(|a, b| a.0.total_cmp(&b.0));
        Wish { may_stay: free, better: better.into_iter().map(|(_, p)| p).collect(), burden }
    }

    /// The best of `places` by what is read off fields, which costs little.
    fn best_at_large(&mut self, places: &[Point], filling: &Filling) -> Vec<Point> {
        let mut ranked: Vec<(f64, Point)> = places.iter().map(|p| (self.at_large.growth(*p, filling), *p)).collect();
        ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
        ranked.into_iter().take(TRIED).map(|(_, p)| p).collect()
    }

    /// By how much the last candidate raises the squared errors of a block of `count` elements.
    fn error(&self, weights: &Rows, count: usize) -> f64 {
        let outside = (self.trial.outside() - FREE).clamp(0.0, MOST_EXCESS) * OUTSIDE_WEIGHT
            + (self.trial.alone() - FREE_NEAR).max(0.0) * ALONE_WEIGHT;
        let cost = |v: usize, growth: f64| {
            let before = self.squares[v];
            self.limits.cost(v, before + growth) - self.limits.cost(v, before)
        };
        outside / count as f64 + self.trial.growth_of((&self.errors, weights), count, cost)
    }
}
