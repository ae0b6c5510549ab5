use super::meter::Meter;
use super::outliers;
use super::partners::Partner;
use super::partners::Partners;
use super::patch::Backdrop;
use super::patch::Individual;
use super::patch::Patch;
use super::sampler::Block;
use super::sampler::Sampler;
use super::scene::Scene;
use crate::compute::geometry::Point;
use crate::compute::pcf::Curve;
use crate::compute::pcf::PcfError;
use crate::compute::pcf::SynthesisOptions;
use crate::compute::pcf::analyse::CurveSum;
use crate::compute::pcf::synthesis::darts;
use crate::compute::random::Purpose;
use crate::compute::random::hash;
use crate::compute::random::unit;
use crate::compute::run::Run;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

const DEAL: Purpose = Purpose::new("distribution.deal");

/// Number of colours of the blocks.
const COLOURS: usize = 4;

/// How often the blocks of a class of `count` elements are improved: a second time where there are
/// several, as each saw its neighbours change.
pub(super) fn passes(count: usize, options: &SynthesisOptions) -> usize {
    if count > options.block_elements { 2 } else { 1 }
}

/// In how many steps each of `asked` elements of a class is laid out: one for the darts, one for
/// every round of each pass.
pub(super) fn steps(asked: usize, options: &SynthesisOptions) -> usize {
    1 + passes(asked, options) * (1 + options.outlier_rounds)
}

/// One class while it is laid out, block by block.
pub(super) struct Layout<'a> {
    scene: &'a Scene<'a>,
    sampler: &'a Sampler<'a>,
    /// New elements: (place, radius), both in metres.
    pub(super) elements: Vec<(Point, f64)>,
    /// Which of them belong to which block: (block, range).
    blocks: Vec<(usize, Range<usize>)>,
    /// All elements of the class: those that were there before, then the new ones.
    all: Partners,
    /// What the only block sees; where there are several, each sees its neighbours change.
    backdrop: Arc<Backdrop>,
    /// What the elements of the only block see as they lie now, once it was asked for.
    known: Option<Vec<Individual>>,
}

/// What was done to lay a class out.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Tally {
    pub(super) darts: usize,
    pub(super) by_grid: usize,
    pub(super) missing: usize,
    pub(super) iterations: usize,
    pub(super) replaced: usize,
    pub(super) outside: usize,
}

impl<'a> Layout<'a> {
    pub(super) fn new(scene: &'a Scene<'a>, sampler: &'a Sampler<'a>) -> Self {
        let all = scene.views[0].partners.clone();
        Self { scene, sampler, elements: Vec::new(), blocks: Vec::new(), all, backdrop: Arc::default(), known: None }
    }

    /// Fills all blocks with `radii` in their order, blocks of one colour at one time: each sees
    /// what its neighbours already hold.
    pub(super) fn fill(
        &mut self,
        radii: &[f64],
        (options, meter): (&SynthesisOptions, &Meter<'_>),
        tally: &mut Tally,
    ) -> Result<(), PcfError> {
        let hands = self.deal(radii, options.seed);
        for colour in 0..COLOURS {
            let of_colour = |b: &usize| self.sampler.blocks[*b].colour == colour && !hands[*b].is_empty();
            let blocks: Vec<usize> = (0..hands.len()).filter(of_colour).collect();
            let fill = |b: &usize| {
                meter.run.check()?;
                darts::fill(&self.patch((*b, 0..0)), (*b, hands[*b].clone()), (options, meter))
            };
            let filled: Vec<Result<darts::Filled, PcfError>> = blocks.par_iter().map(fill).collect();
            for (block, filled) in blocks.iter().zip(filled) {
                let filled = filled?;
                tally.darts += filled.darts;
                tally.by_grid += filled.by_grid;
                tally.missing += filled.missing;
                self.blocks.push((*block, self.elements.len()..self.elements.len() + filled.elements.len()));
                self.elements.extend(filled.elements);
            }
            self.renew();
        }
        Ok(())
    }

    /// Deals the radii to the blocks by their mass: each gets its share, rounded so that the
    /// total is exact.
    fn deal(&self, radii: &[f64], seed: u64) -> Vec<Vec<f64>> {
        let scale = radii.len() as f64 / self.sampler.mass();
        let start = unit(hash(seed, DEAL, self.scene.class as u64));
        let (mut mass, mut dealt, last) = (0.0, 0, self.sampler.blocks.len().saturating_sub(1));
        let mut hand = |(b, block): (usize, &Block)| {
            mass += block.mass;
            let up_to = if b == last { radii.len() } else { ((mass * scale + start) as usize).min(radii.len()) };
            let hand = radii[dealt..up_to.max(dealt)].to_vec();
            dealt = up_to.max(dealt);
            hand
        };
        self.sampler.blocks.iter().enumerate().map(&mut hand).collect()
    }

    /// Groups the elements into the blocks of another cut of the room.
    pub(super) fn regroup(&mut self, sampler: &'a Sampler<'a>) {
        self.sampler = sampler;
        let mut groups: Vec<Vec<(Point, f64)>> = vec![Vec::new(); sampler.blocks.len()];
        for element in &self.elements {
            groups[sampler.block_of(element.0)].push(*element);
        }
        let blocks: Vec<(usize, Range<usize>)> = (0..groups.len()).map(|b| (b, 0..0)).collect();
        self.take(&blocks, &groups);
    }

    /// Brings the elements of all blocks nearer to the target curves, outliers laid out again.
    pub(super) fn improve(
        &mut self,
        (options, meter): (&SynthesisOptions, &Meter<'_>),
        tally: &mut Tally,
    ) -> Result<(), PcfError> {
        let blocks = self.blocks.clone();
        let mut kept: Vec<Vec<(Point, f64)>> = blocks.iter().map(|(_, r)| self.elements[r.clone()].to_vec()).collect();
        for colour in 0..COLOURS {
            let of_colour = |k: &usize| self.sampler.blocks[blocks[*k].0].colour == colour;
            let turn: Vec<usize> = (0..blocks.len()).filter(of_colour).collect();
            let known = self.known.take();
            let improve = |k: &usize| {
                meter.run.check()?;
                let mut patch = self.patch(self.blocks[*k].clone());
                let stream = (self.scene.class as u64) << 24 | blocks[*k].0 as u64;
                let begun = known.clone().unwrap_or_else(|| patch.individuals());
                let (improved, ended) = outliers::improve(&mut patch, begun, stream, (options, meter))?;
                let elements: Vec<(Point, f64)> = patch.places.into_iter().zip(patch.radii).collect();
                Ok((improved, elements, self.sampler.is_one_block().then_some(ended)))
            };
            let results: Vec<Result<_, PcfError>> = turn.par_iter().map(improve).collect();
            for (k, result) in turn.into_iter().zip(results) {
                let (improved, elements, ended) = result?;
                self.known = ended;
                tally.iterations = tally.iterations.max(improved.iterations);
                tally.replaced += improved.replaced;
                tally.missing += improved.missing;
                tally.outside += improved.outside;
                kept[k] = elements;
            }
            self.take(&blocks, &kept);
        }
        Ok(())
    }

    /// Makes the elements those of `kept`, block by block.
    fn take(&mut self, blocks: &[(usize, Range<usize>)], kept: &[Vec<(Point, f64)>]) {
        let (mut elements, mut ranges) = (Vec::new(), Vec::new());
        for ((block, _), own) in blocks.iter().zip(kept) {
            ranges.push((*block, elements.len()..elements.len() + own.len()));
            elements.extend_from_slice(own);
        }
        (self.elements, self.blocks) = (elements, ranges);
        self.renew();
    }

    /// The block with the given elements, and what it sees around it.
    fn patch(&self, (block, range): (usize, Range<usize>)) -> Patch<'a> {
        let before = self.scene.views[0].partners.list().len();
        let own = before + range.start..before + range.end;
        let block = &self.sampler.blocks[block];
        let largest = self.all.largest_radius().max(self.scene.largest_radius());
        let sight = self.scene.metric.reach(self.scene.axis.reach(), largest, largest) + 1.0;
        let sight = sight.max(self.scene.tail.range().1);
        let context = self.all.part(block.bounds.grown(sight * self.scene.unit), |i| !own.contains(&i));
        let (places, radii) = self.elements[range].iter().copied().unzip();
        Patch {
            scene: self.scene,
            sampler: self.sampler,
            block,
            context,
            places,
            radii,
            backdrop: if self.sampler.is_one_block() { Arc::clone(&self.backdrop) } else { Arc::default() },
        }
    }

    fn renew(&mut self) {
        let before = &self.scene.views[0].partners;
        let partner = |(place, radius): &(Point, f64)| Partner {
            place: *place,
            radius: radius / self.scene.unit,
            weight: self.scene.intensity.weight(*place),
        };
        let all = before.list().iter().copied().chain(self.elements.iter().map(partner));
        self.all = Partners::new(all.collect(), self.scene.domain.bounds(), self.scene.unit);
    }

    /// The exact curves of the new elements, one a view.
    pub(super) fn curves(&mut self, run: &Run) -> Result<Vec<Curve>, PcfError> {
        let empty = |v: &super::scene::View<'_>| Curve {
            child: self.scene.class,
            parent: v.target.parent,
            unit: self.scene.unit,
            mass: v.mass.clone(),
            ..Curve::empty(self.scene.axis)
        };
        let mut sums: Vec<CurveSum> = self.scene.views.iter().map(|v| CurveSum::new(empty(v), false)).collect();
        for block in &self.blocks {
            run.check()?;
            let individuals = self.known.take().unwrap_or_else(|| self.patch(block.clone()).individuals());
            for individual in &individuals {
                sums.iter_mut().zip(&individual.rows).for_each(|(sum, row)| sum.add(row));
            }
            self.known = self.sampler.is_one_block().then_some(individuals);
        }
        Ok(sums.into_iter().map(CurveSum::finish).collect())
    }
}
