//! Why a species grows nowhere.

use crate::compute::ecosystem::fitness::Fitness;
use crate::compute::ecosystem::fitness::Met;
use crate::compute::ecosystem::flora::rule::Rule;
use crate::compute::ecosystem::flora::sites::Sites;
use crate::compute::ecosystem::flora::stand::Stand;
use crate::compute::ecosystem::flora::survey;
use crate::compute::ecosystem::slabs;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use std::ops::Range;

/// Why a species grows nowhere: the first of these that holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Absence {
    /// Its target proportion is 0.
    NotAsked,
    /// No cell's soil type is viable.
    Soil,
    /// No cell's texture is in its range.
    Texture,
    /// No cell's temperature comes into its range in any month.
    Temperature,
    /// Every winter is colder than it survives.
    Winter,
    /// It is a tree or a shrub, and every summer is too cool for those.
    TreeLine,
    /// No cell's moisture comes into its range in any month.
    Moisture,
    /// No cell's light comes into its range in any month.
    Illumination,
    /// Each need is met somewhere, but never all in one cell.
    NeverTogether(Met),
    /// Cells suit it, but no unit fits there beside the others.
    Outcompeted(Crowded),
    /// Units would fit, but would take the proportions further from their targets than allowed.
    KeptOut,
}

/// In how many of the cells that suit a species its units are stopped by what; a cell counts for
/// the first that holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Crowded {
    /// Cells whose light, mean of the growing season, is below its minimum even in the open.
    pub dark: u64,
    /// Cells where taller strata keep the light below its minimum.
    pub shaded: u64,
    /// Cells whose stratum is full, has drawn all its light, or is wholly kept bare.
    pub full: u64,
    /// Cells without the moisture for a unit, drawn by others or never there.
    pub dry: u64,
    /// Cells where a unit fits.
    pub free: u64,
}

impl Crowded {
    fn with(mut self, other: Self) -> Self {
        self.dark += other.dark;
        self.shaded += other.shaded;
        self.full += other.full;
        self.dry += other.dry;
        self.free += other.free;
        self
    }
}

/// Why each of the `empty` species, which cover nothing, grows nowhere among `covers`.
pub(super) fn absences(
    run: &Run,
    (rules, sites, fitness): (&[Rule], &Sites, &Fitness),
    covers: &[Raster<u16>],
    empty: &[usize],
) -> Result<Vec<Absence>, Stopped> {
    let suited: Vec<usize> = empty.iter().copied().filter(|species| fitness.met[*species].all > 0).collect();
    let cells = if suited.is_empty() { 0 } else { sites.light.data.len() };
    let slabs = (0..cells).step_by(slabs::SLAB).map(|first| first..(first + slabs::SLAB).min(cells)).collect();
    let counts = slabs::each(run, "plants.absent", slabs, |slab: Range<usize>| {
        let (mut cover, mut crowded) = (vec![0; rules.len()], vec![Crowded::default(); suited.len()]);
        for cell in slab {
            let lives = |species: &usize| fitness.levels[*species].data[cell] > 0;
            if suited.iter().any(lives) {
                survey::gather(covers, cell, &mut cover);
                let stand = Stand::new(rules, sites.at(cell), &mut cover);
                for (species, crowded) in suited.iter().zip(&mut crowded).filter(|(species, _)| lives(species)) {
                    stand.count_obstacle(*species, sites.light.data[cell], crowded);
                }
            }
        }
        crowded
    })?;
    let crowded = |species: usize| {
        let place = suited.iter().position(|s| *s == species);
        place.map(|place| counts.iter().fold(Crowded::default(), |sum, slab| sum.with(slab[place])))
    };
    let why = |species: usize| match crowded(species) {
        None => unmet(fitness.met[species]),
        Some(crowded) if crowded.free > 0 => Absence::KeptOut,
        Some(crowded) => Absence::Outcompeted(crowded),
    };
    Ok(empty.iter().map(|species| why(*species)).collect())
}

fn unmet(met: Met) -> Absence {
    let needs = [
        (met.soil, Absence::Soil),
        (met.texture, Absence::Texture),
        (met.temperature, Absence::Temperature),
        (met.survival, Absence::Winter),
        (met.tree_line, Absence::TreeLine),
        (met.moisture, Absence::Moisture),
        (met.illumination, Absence::Illumination),
    ];
    needs.into_iter().find(|(cells, _)| *cells == 0).map_or(Absence::NeverTogether(met), |(_, why)| why)
}

impl Stand<'_> {
    /// Counts what stops a unit of a species here, in the `open` light of the cell.
    fn count_obstacle(&self, species: usize, open: f32, crowded: &mut Crowded) {
        let count = match () {
            () if !(open >= self.least_light(species)) => &mut crowded.dark,
            () if !self.is_lit(species) => &mut crowded.shaded,
            () if self.room(species) == 0 => &mut crowded.full,
            () if self.units(species, 0) == 0 => &mut crowded.dry,
            () => &mut crowded.free,
        };
        *count += 1;
    }
}
