//! Why a species grows nowhere.

use crate::compute::ecosystem::fitness::Fitness;
use crate::compute::ecosystem::fitness::Met;
use crate::compute::ecosystem::flora::rule::Rule;
use crate::compute::ecosystem::flora::sites::Sites;
use crate::compute::ecosystem::flora::stand::Stand;
use crate::compute::ecosystem::flora::survey;
use crate::compute::raster::Raster;
use rayon::prelude::*;

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

/// Why `species`, which covers nothing, grows nowhere among `covers`.
pub(super) fn absence(
    rules: &[Rule],
    sites: &Sites,
    fitness: &Fitness,
    (covers, species): (&[Raster<u16>], usize),
) -> Absence {
    let met = fitness.met[species];
    if met.all == 0 {
        return unmet(met);
    }
    let levels = &fitness.levels[species].data;
    let count = |cell: usize| {
        let mut cover = vec![0; rules.len()];
        survey::gather(covers, cell, &mut cover);
        obstacle(&Stand::new(rules, sites.at(cell), &mut cover), &rules[species], (species, sites.light.data[cell]))
    };
    let suited = (0..levels.len()).into_par_iter().filter(|cell| levels[*cell] > 0);
    let crowded = suited.map(count).reduce(Crowded::default, Crowded::with);
    if crowded.free > 0 { Absence::KeptOut } else { Absence::Outcompeted(crowded) }
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

fn obstacle(stand: &Stand, rule: &Rule, (species, open): (usize, f32)) -> Crowded {
    let mut one = Crowded::default();
    let count = match () {
        () if !(open >= rule.least_light) => &mut one.dark,
        () if !stand.is_lit(species) => &mut one.shaded,
        () if stand.room(species) == 0 => &mut one.full,
        () if stand.units(species, 0) == 0 => &mut one.dry,
        () => &mut one.free,
    };
    *count = 1;
    one
}
