use super::border_table::BorderTable;
use super::depths::Depths;
use super::far::Far;
use super::far::FarSums;
use super::partners::Partners;
use super::patch::Individual;
use super::patch::Patch;
use super::patch::sums_of;
use super::patch::triplet_sums;
use super::scene::Scene;
use super::shares::Share;
use super::shares::Shares;
use crate::compute::geometry::Point;
use crate::compute::pcf::windows::Windows;
use crate::compute::random::Purpose;
use crate::compute::random::Stream;
use rayon::prelude::*;

/// Two ends of a triplet at a distance of 1 from its middle are this far apart in the mean: 4/π.
const ACROSS: f64 = 4.0 / std::f64::consts::PI;

const FIXED: Purpose = Purpose::new("distribution.fixed");

/// Places from which the elements that were there before are looked at.
const LOOKS: usize = 300;

/// The sums of a block so far.
#[derive(Debug, Clone)]
pub(super) struct BlockSums {
    /// Elements it has.
    pub(super) placed: usize,
    /// Σ of their individual curves, one row a view.
    pub(super) sums: Vec<Vec<f64>>,
    /// Σ of their triplets, one row a view; empty when the exemplar has none.
    pub(super) triplets: Vec<Vec<f64>>,
    /// What its elements see beyond the axis.
    pub(super) far: FarSums,
    /// What they are due to see meanwhile.
    pub(super) due: Due,
    /// Which partners its elements can have meanwhile; none once it is complete.
    there: Option<There>,
}

/// Which partners of their class the elements of a block can have while it is filled.
#[derive(Debug, Clone)]
struct There {
    shares: Shares,
    /// Radii in metres of the rings at every place of the axis.
    reaches: Vec<f64>,
    /// The same for the bins beyond the axis.
    far: Vec<f64>,
    /// What they see of the elements that were there before, at every place of the axis.
    fixed: Vec<f64>,
    /// How many partners in the block make it as dense as the whole class is in the domain.
    as_dense: f64,
    /// How dense blocks are that are filled.
    filled: f64,
}

/// What elements see in a uniform pattern of what is there while their block is filled, given where
/// they lie: sums over the elements of a block, or what one more adds. By places of the axis.
#[derive(Debug, Clone, Default)]
pub(super) struct Due {
    /// Of their own class.
    pub(super) near: Vec<f64>,
    /// Of the triplets of their own class.
    pub(super) triplets: Vec<f64>,
    /// Of the triplets around a parent, whose other end must be there.
    pub(super) across: Vec<f64>,
    /// Beyond the axis, by bin, in areas of rings.
    pub(super) far: Vec<f64>,
    /// The shares of the rings around the last place.
    rings: Vec<Share>,
}

impl Due {
    /// Adds what one more element is due.
    pub(super) fn add(&mut self, one: &Self) {
        let add = |sum: &mut Vec<f64>, more: &[f64]| {
            sum.resize(more.len(), 0.0);
            sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
        };
        add(&mut self.near, &one.near);
        add(&mut self.triplets, &one.triplets);
        add(&mut self.across, &one.across);
        add(&mut self.far, &one.far);
    }

    /// No elements at so many places of the axis and bins beyond it.
    fn none((places, bins): (usize, usize)) -> Self {
        let zeros = || vec![0.0; places];
        Self { near: zeros(), triplets: zeros(), across: zeros(), far: vec![0.0; bins], rings: Vec::new() }
    }
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
    /// How its elements lie by their distance to the border of the domain; nothing before the block
    /// is complete.
    pub(super) depths: Depths,
    /// The sums.
    pub(super) sums: BlockSums,
}

impl Filling {
    /// The block of `patch` before any of its `count` elements.
    pub(super) fn empty(patch: &Patch<'_>, count: usize) -> Self {
        let inner = patch.inner();
        let sums = BlockSums { there: Some(There::of(patch, count)), ..BlockSums::new(patch.scene) };
        let (seen, far) = (patch.seen_by_parents(&inner, 0.5), patch.far());
        Self {
            seen,
            inner,
            curves: Vec::new(),
            borders: Vec::new(),
            far,
            windows: Windows::none(),
            depths: Depths::default(),
            sums,
        }
    }

    /// The block of `patch` with all its elements, all around it filled too; `individuals` are
    /// what they see.
    pub(super) fn complete(patch: &Patch<'_>, individuals: &[Individual]) -> Self {
        let scene = patch.scene;
        let inner = patch.inner();
        let mut sums = BlockSums::new(scene);
        sums.placed = individuals.len();
        sums.sums = sums_of(individuals, scene).iter().map(|row| scene.sparse.of_row(row)).collect();
        sums.triplets = triplet_sums(individuals, scene);
        let curves = individuals.iter().map(|i| scene.rows.aligned(scene.sparse.of_row(&i.rows[0]))).collect();
        let border =
            |i: usize| scene.border_table(patch.places[i], patch.reach_of(patch.radii[i] / scene.unit, &inner));
        let borders = (0..patch.places.len()).into_par_iter().map(border).collect();
        let (seen, far) = (patch.seen_by_parents(&inner, 0.5), patch.far());
        sums.far = FarSums::of(scene, &far, &patch.places);
        let (mut windows, mut depths) = (patch.windows().clone(), patch.depths());
        for p in &patch.places {
            windows.add(*p, 1.0);
            depths.add(scene.depth(*p), 1.0);
        }
        Self { seen, inner, curves, borders, far, windows, depths, sums }
    }
}

impl BlockSums {
    /// The sums of a block without elements.
    pub(super) fn new(scene: &Scene<'_>) -> Self {
        let sums = vec![vec![0.0; scene.sparse.bins()]; scene.views.len()];
        let triplets = scene.views.iter().map(|v| vec![0.0; v.triplet_weights.len()]).collect();
        Self {
            placed: 0,
            sums,
            triplets,
            far: FarSums::new(scene),
            due: Due::none((scene.sparse.bins(), scene.tail.bins)),
            there: None,
        }
    }

    /// Whether the block has all its elements.
    pub(super) fn is_complete(&self) -> bool {
        self.there.is_none()
    }

    /// Writes to `due` what one more element at `p` is due to see, the parts of the rings beyond the
    /// axis around which lie in the domain by `rings`.
    ///
    /// It depends on the place: at a seam to a block that is still empty an element sees less, and
    /// were that not expected of it, elements would be drawn to seams or kept from them.
    pub(super) fn one_more(&self, (p, rings): (Point, &[f64]), due: &mut Due) {
        let Some(there) = &self.there else { return };
        there.shares.around(p, &mut due.rings);
        let placed = self.placed;
        let grows =
            |share: &dyn Fn(usize) -> f64| (placed + 1) as f64 * share(placed + 1) - placed as f64 * share(placed);
        due.near.clear();
        due.triplets.clear();
        due.across.clear();
        due.far.clear();
        for (reach, fixed) in there.reaches.iter().zip(&there.fixed) {
            let (near, across) = (there.shares.at(&due.rings, *reach), there.shares.at(&due.rings, reach * ACROSS));
            due.near.push(grows(&|placed| there.share(&near, *fixed, placed)));
            due.triplets.push(grows(&|placed| there.share_squared(&near, *fixed, placed)));
            due.across.push(grows(&|placed| there.share(&across, *fixed, placed)));
        }
        let fixed = there.fixed.last().copied().unwrap_or(0.0);
        for (bin, reach) in there.far.iter().enumerate() {
            let share = there.shares.at(&due.rings, *reach);
            let (before, after) = (there.share(&share, fixed, placed), there.share(&share, fixed, placed + 1));
            let all = self.far.ring_sum(bin);
            due.far.push((all + rings[bin]) * after - all * before);
        }
    }
}

impl There {
    /// For the block of `patch`, which will have `count` elements.
    fn of(patch: &Patch<'_>, count: usize) -> Self {
        let (scene, bins) = (patch.scene, patch.scene.sparse.bins());
        let largest = scene.largest_radius();
        let reach = |bin: usize| scene.metric.reach(scene.sparse.axis.r(bin), largest, largest) * scene.unit;
        let farthest = (reach(bins.saturating_sub(1)) * ACROSS).max(scene.tail.range().1 * scene.unit);
        let others = (scene.count.max(2) - 1) as f64;
        let whole = patch.sampler.is_all_of(scene.domain);
        let as_dense = if whole { others } else { others * patch.block.mass / scene.domain.area() };
        Self {
            shares: Shares::of(patch, farthest),
            reaches: (0..bins).map(reach).collect(),
            far: (0..scene.tail.bins).map(|bin| scene.tail.place(bin) * scene.unit).collect(),
            fixed: fixed_seen(patch),
            as_dense,
            filled: count as f64 / as_dense,
        }
    }

    /// The share of its partners that an element sees, with `placed` of them in the block.
    fn share(&self, share: &Share, fixed: f64, placed: usize) -> f64 {
        share.own * self.own_density(placed) + share.filled * self.filled + fixed
    }

    /// Its square.
    fn share_squared(&self, share: &Share, fixed: f64, placed: usize) -> f64 {
        let (own, filled) = (self.own_density(placed), self.filled);
        let of_new = share.own * own + share.filled * filled;
        share.own_sq * own * own
            + 2.0 * share.both * own * filled
            + share.filled_sq * filled * filled
            + fixed * (2.0 * of_new + fixed)
    }

    fn own_density(&self, placed: usize) -> f64 {
        placed.saturating_sub(1) as f64 / self.as_dense
    }
}

/// What elements anywhere in the block see of those of the class that were there before the first
/// was laid out, at every place of the axis, in the mean.
fn fixed_seen(patch: &Patch<'_>) -> Vec<f64> {
    let (scene, fixed) = (patch.scene, &patch.scene.views[0].partners);
    let mut sum = vec![0.0; scene.axis.bins()];
    if fixed.list().is_empty() {
        return scene.sparse.of_row(&sum);
    }
    let mut random = Stream::new(0, FIXED, scene.class as u64);
    let places: Vec<Point> = (0..LOOKS).filter_map(|_| patch.sampler.draw(patch.block, &mut random)).collect();
    let radius = scene.mean_radius();
    for p in &places {
        let border = scene.border(*p, scene.reach(fixed, radius, scene.axis.reach()));
        scene.add_row(&mut sum, (*p, radius, &border), (fixed, None));
    }
    let count = places.len().max(1) as f64;
    sum.iter_mut().zip(&scene.views[0].factors).for_each(|(sum, factor)| *sum *= factor / count);
    scene.sparse.of_row(&sum)
}
