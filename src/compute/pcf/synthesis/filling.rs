use super::border_table::BorderTable;
use super::far::Far;
use super::far::FarSums;
use super::partners::Partners;
use super::patch::Individual;
use super::patch::Patch;
use super::patch::sums_of;
use super::patch::triplet_sums;
use super::scene::Scene;
use crate::compute::pcf::windows::Windows;
use rayon::prelude::*;

/// Two ends of a triplet at a distance of 1 from its middle are this far apart in the mean: 4/π.
const ACROSS: f64 = 4.0 / std::f64::consts::PI;

/// The sums of a block so far.
#[derive(Debug, Clone)]
pub(super) struct BlockSums {
    /// Elements the block will have.
    pub(super) count: usize,
    /// Elements it has.
    pub(super) placed: usize,
    /// Σ of their individual curves, one row a view.
    pub(super) sums: Vec<Vec<f64>>,
    /// Σ of their triplets, one row a view; empty when the exemplar has none.
    pub(super) triplets: Vec<Vec<f64>>,
    /// What its elements see beyond the axis.
    pub(super) far: FarSums,
    /// Of the rings around the block's elements, the share inside the block, at every place of
    /// the axis: 1 for a block that is all of the domain.
    inside: Vec<f64>,
    /// The same for the other end of triplets around a parent.
    inside_across: Vec<f64>,
    /// The same for the bins beyond the axis.
    inside_far: Vec<f64>,
    /// The share of the neighbouring blocks that is filled.
    neighbours: f64,
}

/// A block while it is filled: its elements, what each sees of its own class, and the sums.
#[derive(Debug, Clone)]
pub(super) struct Filling {
    /// The elements so far.
    pub(super) inner: Partners,
    /// Their individual curves towards their own class, aligned rows.
    pub(super) curves: Vec<Vec<f32>>,
    /// What each partner of each view sees of the class, see [`Patch::seen_by_parents`]. Those
    /// around the block count by half, as of their triplets only one end is in the block.
    pub(super) seen: Vec<Vec<Vec<f32>>>,
    /// The border weights around its elements.
    pub(super) borders: Vec<BorderTable>,
    /// What an element sees beyond the axis, by its place.
    pub(super) far: Far,
    /// How evenly windows are filled; none before the block is complete.
    pub(super) windows: Windows,
    /// The sums.
    pub(super) sums: BlockSums,
}

impl Filling {
    /// The block of `patch` before any of its `count` elements; of its neighbours the share
    /// `neighbours` is filled.
    pub(super) fn empty(patch: &Patch<'_>, count: usize, neighbours: f64) -> Self {
        let inner = patch.inner();
        let sums = BlockSums::new(patch.scene, count, (patch.sampler.block_side(), neighbours));
        let (seen, far) = (patch.seen_by_parents(&inner, 0.5), patch.far().clone());
        Self { seen, inner, curves: Vec::new(), borders: Vec::new(), far, windows: Windows::none(), sums }
    }

    /// The block of `patch` with all its elements, all around it filled too; `individuals` are
    /// what they see.
    pub(super) fn complete(patch: &Patch<'_>, individuals: &[Individual]) -> Self {
        let scene = patch.scene;
        let inner = patch.inner();
        let mut sums = BlockSums::new(scene, individuals.len(), (patch.sampler.block_side(), 1.0));
        sums.placed = individuals.len();
        sums.sums = sums_of(individuals, scene).iter().map(|row| scene.sparse.of_row(row)).collect();
        sums.triplets = triplet_sums(individuals, scene);
        let curves = individuals.iter().map(|i| scene.rows.aligned(scene.sparse.of_row(&i.rows[0]))).collect();
        let border =
            |i: usize| scene.border_table(patch.places[i], patch.reach_of(patch.radii[i] / scene.unit, &inner));
        let borders = (0..patch.places.len()).into_par_iter().map(border).collect();
        let (seen, mut far, mut row) = (patch.seen_by_parents(&inner, 0.5), patch.far().clone(), Vec::new());
        let mut windows = patch.windows().clone();
        for p in &patch.places {
            far.read(*p, &mut row);
            sums.far.add(&row, 1.0);
            far.show(*p, 1.0);
            windows.add(*p, 1.0);
        }
        Self { seen, inner, curves, borders, far, windows, sums }
    }
}

impl BlockSums {
    /// The sums of an empty block that will have `count` elements, `side` metres wide (infinite
    /// when it is all of the domain), with a share of its `neighbours` filled.
    pub(super) fn new(scene: &Scene<'_>, count: usize, (side, neighbours): (f64, f64)) -> Self {
        let bins = scene.sparse.bins();
        let share = |bin: usize, factor: f64| {
            let largest = scene.largest_radius();
            square_covariance(
                factor * scene.metric.reach(scene.sparse.axis.r(bin), largest, largest) * scene.unit / side,
            )
        };
        let sums = vec![vec![0.0; bins]; scene.views.len()];
        let triplets = scene.views.iter().map(|v| vec![0.0; v.triplet_weights.len()]).collect();
        let inside = |factor: f64| (0..bins).map(|bin| share(bin, factor)).collect();
        Self {
            count: count.max(1),
            placed: 0,
            sums,
            triplets,
            far: FarSums::new(scene),
            inside: inside(1.0),
            inside_across: inside(ACROSS),
            inside_far: (0..scene.tail.bins)
                .map(|b| square_covariance(scene.tail.place(b) * scene.unit / side))
                .collect(),
            neighbours,
        }
    }

    /// The sum of `placed` individual curves, over the target curve: towards a parent each is
    /// complete, towards the class itself it sees the block's elements so far and what the
    /// neighbouring blocks hold.
    pub(super) fn expected(&self, v: usize, bin: usize, placed: usize) -> f64 {
        if v > 0 { placed as f64 } else { placed as f64 * self.seen(bin, placed) }
    }

    /// The sum of `placed` elements' triplets, over the target: both partners must be there; of
    /// triplets around parents the other end.
    pub(super) fn expected_triplets(&self, v: usize, bin: usize, placed: usize) -> f64 {
        let seen = if v > 0 { self.seen_of(self.inside_across[bin], placed) } else { self.seen(bin, placed).powi(2) };
        placed as f64 * seen
    }

    /// The share of an element's partners of its own class beyond the axis that is there.
    pub(super) fn seen_far(&self, v: usize, bin: usize, placed: usize) -> f64 {
        if v > 0 { 1.0 } else { self.seen_of(self.inside_far[bin], placed) }
    }

    /// The share of an element's partners of its own class that is there.
    fn seen(&self, bin: usize, placed: usize) -> f64 {
        self.seen_of(self.inside[bin], placed)
    }

    fn seen_of(&self, inside: f64, placed: usize) -> f64 {
        let partners = placed.saturating_sub(1) as f64 / (self.count.max(2) - 1) as f64;
        inside * partners + (1.0 - inside) * self.neighbours
    }
}

/// The share of the circle of radius `r` around a uniform place in the unit square that lies in
/// the square, up to r = 1.
fn square_covariance(r: f64) -> f64 {
    let r = r.min(1.0);
    1.0 - 4.0 * r / std::f64::consts::PI + r * r / std::f64::consts::PI
}
