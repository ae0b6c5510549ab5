//! What elements see beyond the axis of their curves ([`crate::compute::pcf::Tail`]), by fields:
//! at every node of a wide grid, how many pairs an element there would have in every bin. A
//! candidate reads its four nodes, whatever the number of partners.

use super::nodes::Nodes;
use super::partners::Partners;
use super::patch::Patch;
use super::scene::Scene;
use super::scene::View;
use crate::compute::geometry::Point;
use crate::compute::pcf::RELATIVE_FLOOR;
use crate::compute::pcf::TailAxis;
use rayon::prelude::*;
use std::sync::Arc;

/// Distance of two nodes in r_max: half a bin.
const NODE_STEP: f64 = 0.5;

/// Sections of what an element sees, of one value a bin: the part of each ring inside the domain,
/// pairs with the class's elements outside the block, then with each parent class; last, pairs with
/// the block's own elements.
const RINGS: usize = 0;
const CONTEXT: usize = 1;

/// The fields over one block without its own elements, and where their nodes are.
#[derive(Debug)]
pub(super) struct Around {
    axis: TailAxis,
    unit: f64,
    grid: Nodes,
    /// Values of a node.
    width: usize,
    nodes: Vec<f64>,
}

impl Around {
    /// The fields of `patch`.
    pub(super) fn of(patch: &Patch<'_>) -> Self {
        let (scene, axis) = (patch.scene, patch.scene.tail);
        let grid = Nodes::over(patch.block.bounds, NODE_STEP * scene.unit);
        let width = axis.bins * (CONTEXT + scene.views.len());
        let mut around = Self { axis, unit: scene.unit, grid, width, nodes: Vec::new() };
        if axis.bins == 0 {
            return around;
        }
        let row = |row: usize| {
            let nodes = (0..grid.columns).flat_map(|column| around.node(patch, grid.place(column, row)));
            nodes.collect::<Vec<f64>>()
        };
        let all: Vec<Vec<f64>> = (0..grid.rows).into_par_iter().map(row).collect();
        around.nodes = all.concat();
        around
    }

    /// What an element at `p` would see.
    fn node(&self, patch: &Patch<'_>, p: Point) -> Vec<f64> {
        let (scene, bins) = (patch.scene, self.axis.bins);
        let mut node = vec![0.0; self.width];
        let border = scene.border(p, self.axis.range().1);
        node[..bins].copy_from_slice(&self.axis.rings_inside(&border));
        for v in 0..scene.views.len() {
            let section = &mut node[(CONTEXT + v) * bins..(CONTEXT + v + 1) * bins];
            self.add_pairs(section, p, patch.partners(v));
        }
        node
    }

    fn add_pairs(&self, section: &mut [f64], p: Point, partners: &Partners) {
        partners.for_each_near(p, self.axis.range().1 * self.unit, |_, partner| {
            self.axis.add(section, partner.place.distance(p) / self.unit, 1.0);
        });
    }

    /// Adds an element `times` at `p` to the nodes of `row`, of which `inner` has one value a bin.
    fn show_row(&self, inner: &mut [f64], (p, times): (Point, f64), row: usize) {
        let (nearest, farthest) = (self.axis.range().0 * self.unit, self.axis.range().1 * self.unit);
        let (offset, bins) = (p - self.grid.place(0, row), self.axis.bins);
        let half_width_sq = farthest * farthest - offset.y * offset.y;
        if half_width_sq <= 0.0 {
            return;
        }
        let (half_width, nearest_sq) = (half_width_sq.sqrt(), nearest * nearest);
        let column = |x: f64| ((x / self.grid.step).max(0.0) as usize).min(self.grid.columns);
        for column in column(offset.x - half_width)..column(offset.x + half_width + self.grid.step) {
            let distance_sq = (Point::new(column as f64 * self.grid.step, 0.0) - offset).norm_sq();
            if distance_sq > nearest_sq {
                let node = &mut inner[column * bins..(column + 1) * bins];
                self.axis.add(node, distance_sq.sqrt() / self.unit, times);
            }
        }
    }
}

/// The fields over one block with its own elements.
#[derive(Debug, Clone)]
pub(super) struct Far {
    around: Arc<Around>,
    /// Pairs with the block's own elements, by node and bin.
    inner: Vec<f64>,
}

impl Far {
    /// The fields of `around` and of elements of the block at `places`.
    pub(super) fn new(around: &Arc<Around>, places: &[Point]) -> Self {
        let row_length = around.grid.columns * around.axis.bins;
        let mut inner = vec![0.0; row_length * around.grid.rows];
        inner.par_chunks_mut(row_length.max(1)).enumerate().for_each(|(row, inner)| {
            places.iter().for_each(|p| around.show_row(inner, (*p, 1.0), row));
        });
        Self { around: Arc::clone(around), inner }
    }

    /// Adds an element of the block `times` at `p`.
    pub(super) fn show(&mut self, p: Point, times: f64) {
        if self.inner.is_empty() {
            return;
        }
        let (around, farthest) = (&self.around, self.around.axis.range().1 * self.around.unit);
        let row = |y: f64| ((y / around.grid.step).max(0.0) as usize).min(around.grid.rows);
        let (north, row_length) = (p.y - around.grid.place(0, 0).y, around.grid.columns * around.axis.bins);
        for row in row(north - farthest)..row(north + farthest + around.grid.step) {
            around.show_row(&mut self.inner[row * row_length..(row + 1) * row_length], (p, times), row);
        }
    }

    /// What an element at `p` would see, between its four nodes.
    pub(super) fn read(&self, p: Point, seen: &mut Vec<f64>) {
        let (around, bins) = (&*self.around, self.around.axis.bins);
        seen.clear();
        seen.resize(around.width + bins, 0.0);
        if around.nodes.is_empty() {
            return;
        }
        let (seen_around, seen_inner) = seen.split_at_mut(around.width);
        for (node, share) in around.grid.corners(p) {
            add(seen_around, &around.nodes[node * around.width..(node + 1) * around.width], share);
            add(seen_inner, &self.inner[node * bins..(node + 1) * bins], share);
        }
    }
}

fn add(sum: &mut [f64], values: &[f64], share: f64) {
    sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += share * value);
}

/// Takes what an element sees of another at `distance` (r_max) in its own block out of `seen`.
pub(super) fn hide(axis: &TailAxis, seen: &mut [f64], distance: f64) {
    let inner = seen.len() - axis.bins;
    axis.add(&mut seen[inner..], distance, -1.0);
}

/// The sums over a block's elements of what they see beyond the axis.
#[derive(Debug, Clone)]
pub(super) struct FarSums {
    axis: TailAxis,
    /// Pairs by view and bin.
    pairs: Vec<f64>,
    /// The parts of rings inside the domain, by bin.
    rings: Vec<f64>,
}

impl FarSums {
    /// No elements yet.
    pub(super) fn new(scene: &Scene<'_>) -> Self {
        let bins = scene.tail.bins;
        Self { axis: scene.tail, pairs: vec![0.0; scene.views.len() * bins], rings: vec![0.0; bins] }
    }

    /// Those of elements at `places`, all of them in `far`.
    pub(super) fn of(scene: &Scene<'_>, far: &Far, places: &[Point]) -> Self {
        let (mut sums, mut seen) = (Self::new(scene), Vec::new());
        for p in places {
            far.read(*p, &mut seen);
            sums.add_ends(&seen, (1.0, 1.0));
        }
        sums
    }

    /// Adds `times` what an element `seen` from [`Far::read`] adds: its own pairs and, towards its
    /// own class, those that others of the block have with it.
    pub(super) fn add(&mut self, seen: &[f64], times: f64) {
        self.add_ends(seen, (times, 2.0));
    }

    /// The same, pairs within the block counted at so many `ends`.
    fn add_ends(&mut self, seen: &[f64], (times, ends): (f64, f64)) {
        let bins = self.axis.bins;
        for (k, sum) in self.pairs.iter_mut().enumerate() {
            *sum += times * pairs(seen, (k / bins, k % bins), (bins, ends));
        }
        self.rings.iter_mut().zip(seen).for_each(|(sum, ring)| *sum += times * ring);
    }

    /// The pairs of a bin in view `v` beyond those expected, with one more element `seen`.
    fn excess(&self, (v, view): (usize, &View<'_>), bin: usize, seen: Option<&[f64]>) -> f64 {
        let bins = self.axis.bins;
        let (more, ring) = seen.map_or((0.0, 0.0), |s| (pairs(s, (v, bin), (bins, 2.0)), s[RINGS * bins + bin]));
        let expected = view.target.tail.mean[bin] * view.density;
        self.pairs[v * bins + bin] + more - expected * (self.rings[bin] + ring)
    }

    /// The mean square difference of view `v` to its target tail with one more element `seen`, over
    /// `count` elements; 0 without a tail.
    pub(super) fn mean_square(&self, (v, view): (usize, &View<'_>), count: usize, seen: Option<&[f64]>) -> f64 {
        let square = |bin: usize| {
            let all = self.axis.ring(bin) * view.density * count.max(1) as f64;
            (self.excess((v, view), bin, seen) / all).powi(2)
        };
        (0..self.axis.bins).map(square).sum::<f64>() / self.axis.bins.max(1) as f64
    }

    /// How much farther from its target tail an element `seen` brings view `v`: the growth of
    /// squares over the variance of independent pairs, as for curves. `due` says in areas of rings how
    /// many partners there can be before it, and how many more with it, by bin.
    pub(super) fn growth(&self, (v, view): (usize, &View<'_>), due: impl Fn(usize) -> (f64, f64), seen: &[f64]) -> f64 {
        let (bins, ends) = (self.axis.bins, if v == 0 { 2.0 } else { 1.0 });
        let one = |bin: usize| {
            let ((all, more), goal) = (due(bin), view.target.tail.mean[bin]);
            let before = self.pairs[v * bins + bin] - goal * view.density * all;
            let after = before + pairs(seen, (v, bin), (bins, 2.0)) - goal * view.density * more;
            let variance = self.axis.ring(bin) * view.density * goal.max(RELATIVE_FLOOR) * ends;
            (after * after - before * before) / variance
        };
        (0..bins).map(one).sum::<f64>() / bins.max(1) as f64
    }

    /// The parts of the rings of a bin around all elements that lie in the domain.
    pub(super) fn ring_sum(&self, bin: usize) -> f64 {
        self.rings[bin]
    }
}

/// What an element `seen` adds to the pairs of view `v` in a bin; those within the block counted at
/// so many `ends`.
fn pairs(seen: &[f64], (v, bin): (usize, usize), (bins, ends): (usize, f64)) -> f64 {
    let around = seen[(CONTEXT + v) * bins + bin];
    if v == 0 { ends * seen[seen.len() - bins + bin] + around } else { around }
}
