//! Painting over a cover map, and clearing ground, after the competition (L 3.3, T 5.2).
//!
//! A reduction removes plants; what they used stays as surplus. A raise grows as far as room,
//! light and moisture allow: taller plants still make lower ones give way, but nobody of the
//! same stratum moves aside; what does not fit is told, with where and how much.

use crate::compute::ecosystem::fitness::Fitness;
use crate::compute::ecosystem::flora::Flora;
use crate::compute::ecosystem::flora::FloraError;
use crate::compute::ecosystem::flora::FloraOptions;
use crate::compute::ecosystem::flora::rule;
use crate::compute::ecosystem::flora::rule::FULL_COVER;
use crate::compute::ecosystem::flora::same_size;
use crate::compute::ecosystem::flora::stand::Stand;
use crate::compute::ecosystem::flora::survey;
use crate::compute::ecosystem::resources::Resources;
use crate::compute::ecosystem::slabs;
use crate::compute::ecosystem::slabs::Slab;
use crate::compute::ecosystem::species::PlantSpecies;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;

/// What an edit did to the painted species.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Painted {
    /// Area removed, m².
    pub lowered_m2: f64,
    /// Area added, m².
    pub raised_m2: f64,
    /// Painted beyond the resources; `None` when all of it grew.
    pub shortfall: Option<Shortfall>,
}

/// Where more was painted than can grow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shortfall {
    /// Cells concerned.
    pub cells: u64,
    /// Area painted that does not grow, m².
    pub area_m2: f64,
    /// The cell that misses most, the first of equals.
    pub worst_cell: usize,
    /// What it misses, as a share of the cell.
    pub worst: f32,
}

/// Sets the cover of one species to the painted share of each cell, where the painting is a
/// number; elsewhere nothing changes. Time and memory as one pass over the maps.
pub fn paint(
    run: &Run,
    species: &[PlantSpecies],
    (resources, fitness): (&Resources, &Fitness),
    (flora, painted, wanted): (Flora, usize, &Raster<f32>),
    options: &FloraOptions,
) -> Result<(Flora, Painted), FloraError> {
    same_size(resources.soil.data.len(), wanted.data.len())?;
    let rules = super::rules(species, options)?;
    let offer = super::offer(resources, options)?;
    let brushed = |cell: usize| wanted.data[cell].is_finite();
    let brush = |cell: usize, cover: &mut [u16], tally: &mut Tally| {
        let mut stand = Stand::new(&rules, offer.at(cell), cover);
        let suits = fitness.levels[painted].data[cell] > 0;
        repaint(&mut stand, (painted, suits), rule::cover(wanted.data[cell]), (cell, tally));
    };
    let mut flora = flora;
    let tally = each_cell(run, &mut flora.covers, brushed, brush)?;
    let flora = survey::again(run, (&rules, &offer, fitness), flora, brushed)?;
    Ok((flora, tally.painted(wanted.grid.cell_area_m2())))
}

/// Takes the given share (0..=1) of all plants of each cell away, as where trails are worn; a
/// share that is not a number takes nothing.
pub fn clear(
    run: &Run,
    species: &[PlantSpecies],
    (resources, fitness): (&Resources, &Fitness),
    (flora, share): (Flora, &Raster<f32>),
    options: &FloraOptions,
) -> Result<Flora, FloraError> {
    same_size(resources.soil.data.len(), share.data.len())?;
    let rules = super::rules(species, options)?;
    let offer = super::offer(resources, options)?;
    let worn = |cell: usize| share.data[cell] > 0.0;
    let mut flora = flora;
    each_cell(run, &mut flora.covers, worn, |cell, cover, _| {
        let kept = 1.0 - share.data[cell].min(1.0);
        cover.iter_mut().for_each(|c| *c = (f32::from(*c) * kept) as u16);
    })?;
    Ok(survey::again(run, (&rules, &offer, fitness), flora, worn)?)
}

/// Lets `edit` change the covers of the cells that are `touched`.
fn each_cell(
    run: &Run,
    covers: &mut [Raster<u16>],
    touched: impl Fn(usize) -> bool + Sync,
    edit: impl Fn(usize, &mut [u16], &mut Tally) + Sync,
) -> Result<Tally, Stopped> {
    let (species, cells) = (covers.len(), covers.first().map_or(0, |map| map.data.len()));
    let slabs = slabs::cut(covers.iter_mut().map(|map| map.data.as_mut_slice()), cells);
    let tallies = slabs::each(run, "plants.edit", slabs, |mut slab: Slab<u16>| {
        let (mut cover, mut tally) = (vec![0; species], Tally::default());
        for (i, cell) in slab.cells.enumerate().filter(|(_, cell)| touched(*cell)) {
            cover.iter_mut().zip(&slab.maps).for_each(|(c, map)| *c = map[i]);
            edit(cell, &mut cover, &mut tally);
            slab.maps.iter_mut().zip(&cover).for_each(|(map, c)| map[i] = *c);
        }
        tally
    })?;
    Ok(tallies.into_iter().fold(Tally::default(), Tally::then))
}

/// Brings a species to the cover wished for, as far as it can grow, and books what happened.
fn repaint(stand: &mut Stand, (species, suits): (usize, bool), wish: u16, (cell, tally): (usize, &mut Tally)) {
    let now = stand.cover(species);
    if wish <= now {
        stand.remove(species, now - wish);
        tally.lowered += u64::from(now - wish);
        return;
    }
    let mut missing = wish - now;
    while suits && missing > 0 {
        let more = stand.most(species).min(missing);
        if more == 0 {
            break;
        }
        // Lower plants that give way free moisture, so more may fit than at first.
        stand.plant(species, more);
        tally.raised += u64::from(more);
        missing -= more;
    }
    tally.miss(cell, missing);
}

/// What an edit did so far, in cover units.
#[derive(Default)]
struct Tally {
    lowered: u64,
    raised: u64,
    cells: u64,
    missing: u64,
    worst: u16,
    worst_cell: usize,
}

impl Tally {
    fn miss(&mut self, cell: usize, missing: u16) {
        self.cells += u64::from(missing > 0);
        self.missing += u64::from(missing);
        if missing > self.worst {
            (self.worst, self.worst_cell) = (missing, cell);
        }
    }

    fn then(mut self, later: Self) -> Self {
        if later.worst > self.worst {
            (self.worst, self.worst_cell) = (later.worst, later.worst_cell);
        }
        self.lowered += later.lowered;
        self.raised += later.raised;
        self.cells += later.cells;
        self.missing += later.missing;
        self
    }

    fn painted(&self, cell_area_m2: f64) -> Painted {
        let m2 = |cover: u64| cover as f64 / f64::from(FULL_COVER) * cell_area_m2;
        let shortfall = Shortfall {
            cells: self.cells,
            area_m2: m2(self.missing),
            worst_cell: self.worst_cell,
            worst: rule::share(self.worst),
        };
        Painted {
            lowered_m2: m2(self.lowered),
            raised_m2: m2(self.raised),
            shortfall: (self.cells > 0).then_some(shortfall),
        }
    }
}
