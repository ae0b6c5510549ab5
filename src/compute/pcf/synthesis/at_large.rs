//! How the elements of a block lie at large: their curves beyond the axis, how evenly they fill
//! windows, and strips along the border. Read off fields or counted, so that many places can be
//! tried at little cost.

use super::depths::Depths;
use super::far;
use super::far::FarSums;
use super::filling::Filling;
use super::patch::Patch;
use crate::compute::geometry::Point;
use crate::compute::pcf::windows::TakenOut;
use crate::compute::pcf::windows::Windows;

/// Beyond its axis a curve counts this many times as much: what lies there is the sum over many
/// pairs, and one element changes it little (ours).
const FAR_WEIGHT: f64 = 2.0;

/// Mean roots of the counts in windows are measured by this over the root of the number of
/// elements, as what they differ by among patterns of one kind (ours: a tenth of that, so that
/// they take part from the beginning).
const ROOT_SCALE: f64 = 0.07;

/// What the unevenness of the strips along the border counts beside the curves: these are measured
/// by what they begin with, strips by chance (ours: with less, elements that keep apart lie denser
/// at the border; with more, curves of disks that belong to their parents suffer).
const STRIP_WEIGHT: f64 = 0.08;

/// A block without one of its elements.
pub(super) struct AtLarge<'a> {
    patch: &'a Patch<'a>,
    /// What a squared error of each curve weighs.
    weights: Vec<f64>,
    gone: Point,
    sums: FarSums,
    windows: TakenOut,
    depths: Depths,
    /// The squared errors without it.
    before: f64,
    seen: Vec<f64>,
}

impl<'a> AtLarge<'a> {
    /// For the block of `patch`, curves measured by `scales`.
    pub(super) fn new(patch: &'a Patch<'a>, scales: &[f64]) -> Self {
        let weights = scales.iter().map(|s| FAR_WEIGHT / (s * s)).collect();
        let (sums, windows) = (FarSums::new(patch.scene), TakenOut::default());
        let (gone, depths) = (Point::default(), Depths::default());
        Self { patch, weights, gone, sums, windows, depths, before: 0.0, seen: Vec::new() }
    }

    /// Takes the element at `old` out.
    pub(super) fn take_out(&mut self, old: Point, filling: &Filling) {
        self.gone = old;
        self.sums.clone_from(&filling.sums.far);
        filling.far.read(old, &mut self.seen);
        self.sums.add(&self.seen, -1.0);
        self.windows = filling.windows.take_out(old);
        self.depths = filling.depths;
        self.depths.add(self.patch.scene.depth(old), -1.0);
        self.before = self.far(filling.sums.placed, false)
            + self.unevenness(&filling.windows, None)
            + STRIP_WEIGHT * self.depths.unevenness();
    }

    /// By how much the element raises the squared errors when it is put to `p`.
    pub(super) fn growth(&mut self, p: Point, filling: &Filling) -> f64 {
        filling.far.read(p, &mut self.seen);
        let scene = self.patch.scene;
        if !self.seen.is_empty() {
            far::hide(&scene.tail, &mut self.seen, p.distance(self.gone) / scene.unit);
        }
        let strips = STRIP_WEIGHT * self.depths.unevenness_with(scene.depth(p));
        self.far(filling.sums.placed, true) + self.unevenness(&filling.windows, Some(p)) + strips - self.before
    }

    /// The squared errors of the curves beyond their axes, with or without what was seen last.
    fn far(&self, count: usize, is_there: bool) -> f64 {
        let seen = is_there.then_some(self.seen.as_slice());
        let views = self.patch.scene.views.iter().zip(&self.weights).enumerate();
        views.map(|(v, (view, weight))| self.sums.mean_square((v, view), count, seen) * weight).sum()
    }

    /// How far the mean roots of the counts in windows are from the exemplar's, with an element at `p`.
    fn unevenness(&self, windows: &Windows, p: Option<Point>) -> f64 {
        let goal = &self.patch.scene.views[0].target.root_counts;
        let scale = ROOT_SCALE / (self.patch.scene.count.max(1) as f64).sqrt();
        let square = |(root, goal): (f64, &Option<f64>)| goal.map_or(0.0, |goal| ((root - goal) / scale).powi(2));
        windows.mean_roots_without(&self.windows, p).zip(goal).map(square).sum::<f64>() / goal.len().max(1) as f64
    }
}
