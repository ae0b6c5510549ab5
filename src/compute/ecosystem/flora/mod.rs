//! Plants compete: one **cover** map a species, and what is left of light and moisture
//! (L 4.3, T 5.4.2).
//!
//! **Plants in a cell** (ours, for what the texts leave open). Temperature, texture, soil and
//! moisture ranges are tested against the cell's own maps (that is [`fitness`]), not against
//! what is left. A **population unit** covers a ninth of the cell per scale unit of light it
//! uses; covers add up to at most 1 within a **stratum** (tree, shrub, herb), and the last unit
//! of a stratum is cut to what is left. Light is drawn on as any resource is (L 4.3): the light
//! uses of a stratum stay within the light that reaches it over the year, on the scale, so that
//! fully lit ground (9) bears a closed stratum and darker or colder ground a thinner one. Light is
//! asymmetric: a stratum gets the cell's light times (1 - 0.8 cover) of each taller stratum, the
//! cover relative to what that one's light bears, and a species needs the mean of that over the
//! growing season to be at least its minimum. A new taller unit evicts lower units that lose their
//! minimum and thins out what the light no longer bears, and what they used comes free. Moisture
//! drawn (cover times use) stays within the capacity, the yearly mean on the scale.
//!
//! [`fitness`]: crate::compute::ecosystem::fitness

mod edit;
mod explain;
mod fittest;
mod rule;
mod sites;
mod stand;
mod survey;
mod targets;

pub use edit::Painted;
pub use edit::Shortfall;
pub use edit::clear;
pub use edit::paint;
pub use explain::Absence;
pub use explain::Crowded;
pub use rule::FULL_COVER;
pub use targets::Reached;

use crate::compute::ecosystem::fitness::Fitness;
use crate::compute::ecosystem::fitness::Needs;
use crate::compute::ecosystem::resources::Resources;
use crate::compute::ecosystem::scales::Scales;
use crate::compute::ecosystem::species::PlantSpecies;
use crate::compute::ecosystem::species::Stratum;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;
use rule::Rule;
use sites::Offer;
use sites::Sites;

/// Why plants could not be made to compete.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FloraError {
    /// Told to stop.
    #[error(transparent)]
    Stopped(#[from] Stopped),
    /// A unit of this species would cover nothing.
    #[error("the light use of {species} must be above 0, found {found}")]
    NoLightUse {
        /// The species.
        species: String,
        /// Its light use.
        found: f64,
    },
    /// Targets that are not numbers, negative, or sum to nothing.
    #[error("target proportions must be 0 or more and sum to more than 0, found a sum of {sum}")]
    Targets {
        /// Their sum.
        sum: f64,
    },
    /// A map on another grid than the resources.
    #[error("a map of {found} cells was given for a terrain of {expected}")]
    Size {
        /// Cells of the terrain.
        expected: usize,
        /// Cells of the map.
        found: usize,
    },
}

/// What the competition is told beside species and resources.
#[derive(Clone, Copy)]
pub struct FloraOptions<'a> {
    /// Seed of the draws between equals.
    pub seed: u64,
    /// Which needs count; the same as in the fitness.
    pub needs: Needs,
    /// From light fraction to the scale of the species' ranges; the same as in the fitness.
    pub scales: Scales,
    /// Share of each cell that is kept bare, 0..=1 (trails, rock, roads); not a number: 0.
    pub bare: Option<&'a Raster<f32>>,
    /// With targets: how far the proportions may stray from them, as the Euclidean distance
    /// between the two lists of shares.
    pub proportion_tolerance: f64,
    /// With targets: go on until nothing fits, whatever becomes of the proportions.
    pub fill: bool,
    /// With targets: how far one batch of units may move the proportions, as a share of the
    /// tolerance; 0 for one unit at a time.
    pub batch: f64,
}

impl Default for FloraOptions<'_> {
    fn default() -> Self {
        Self {
            seed: 0,
            needs: Needs::default(),
            scales: Scales::default(),
            bare: None,
            proportion_tolerance: PROPORTION_TOLERANCE,
            fill: false,
            batch: BATCH,
        }
    }
}

/// How far proportions may stray by default (ours): a share that is missed by two hundredths is
/// not seen on a map.
pub const PROPORTION_TOLERANCE: f64 = 0.02;

/// How far a batch may move the proportions by default, as a share of the tolerance (ours).
pub const BATCH: f64 = 0.1;

/// The plants of the whole terrain.
#[derive(Debug, Clone, PartialEq)]
pub struct Flora {
    /// Cover of each species in whole numbers of 1/[`FULL_COVER`] of a cell.
    pub covers: Vec<Raster<u16>>,
    /// The physical light fraction that reaches the ground, mean of the growing season: what herbs
    /// get.
    pub left_light: Raster<f32>,
    /// Moisture not drawn, on the scale, mean of the year.
    pub left_moisture: Raster<f32>,
    /// What there is of each species.
    pub totals: Vec<Total>,
    /// With targets: the shares asked for and reached.
    pub reached: Option<Reached>,
}

/// What there is of one species.
#[derive(Debug, Clone, PartialEq)]
pub struct Total {
    /// Area covered, m².
    pub cover_m2: f64,
    /// Cells where it grows.
    pub cells: u64,
    /// Why it grows nowhere; `None` where it does grow.
    pub why_empty: Option<Absence>,
}

impl Flora {
    /// The share of a cell that a species covers, 0..=1.
    pub fn cover(&self, species: usize, cell: usize) -> f32 {
        rule::share(self.covers[species].data[cell])
    }

    /// The share of every cell that a species covers.
    pub fn cover_map(&self, species: usize) -> Raster<f32> {
        let map = &self.covers[species];
        Raster { grid: map.grid, data: map.data.par_iter().map(|c| rule::share(*c)).collect() }
    }

    /// The share of every cell that the chosen species cover together; above 1 where they stand
    /// over each other.
    pub fn total_map(&self, chosen: impl Fn(usize) -> bool) -> Raster<f32> {
        let mut sums = vec![0.0_f32; self.left_light.grid.len()];
        for (_, map) in self.covers.iter().enumerate().filter(|(s, _)| chosen(*s)) {
            sums.par_iter_mut().zip(&map.data).for_each(|(sum, c)| *sum += rule::share(*c));
        }
        Raster { grid: self.left_light.grid, data: sums }
    }

    /// The share of every cell that a stratum covers, 0..=1.
    pub fn stratum_map(&self, species: &[PlantSpecies], stratum: Stratum) -> Raster<f32> {
        self.total_map(|s| species[s].stratum == stratum)
    }

    /// **Yearly growth** of a species in a cell: kg of dry matter, by covered area, growth form
    /// and how well the species fits there.
    pub fn growth_kg(&self, plant: &PlantSpecies, fitness: &Fitness, (species, cell): (usize, usize)) -> f64 {
        let area_m2 = self.left_light.grid.cell_area_m2() * f64::from(self.cover(species, cell));
        area_m2 * plant.growth_kg_per_m2 * fitness.value(species, cell)
    }
}

/// Makes the plants compete: with targets when some species has one (L Algorithm 1; a species
/// without one is then left out), else without (L Algorithm 2).
///
/// All maps are on one grid. Time: about cells × species; memory: two bytes a cell and species,
/// with targets twice that and four bytes more for each cell a species can live in.
pub fn compete(
    run: &Run,
    species: &[PlantSpecies],
    resources: &Resources,
    fitness: &Fitness,
    options: &FloraOptions,
) -> Result<Flora, FloraError> {
    // 1. What each species asks for and what each cell offers.
    let rules = rules(species, options)?;
    let sites = Sites::new(run, &offer(resources, options)?)?;
    // 2. Who grows where.
    let (covers, reached) = match targets::shares(species)? {
        None => (fittest::compete(run, &rules, &sites, fitness, options.seed)?, None),
        Some(asked) => {
            let (covers, reached) = targets::compete(run, &rules, &sites, fitness, &(asked, options).into())?;
            (covers, Some(reached))
        }
    };
    // 3. What that leaves, what there is in all, and why some of it is nothing.
    survey::flora(run, &rules, &sites, fitness, (covers, reached)).map_err(FloraError::from)
}

fn rules(species: &[PlantSpecies], options: &FloraOptions) -> Result<Vec<Rule>, FloraError> {
    species.iter().map(|s| Rule::new(s, options.needs, &options.scales)).collect()
}

fn offer<'a>(resources: &'a Resources, options: &FloraOptions<'a>) -> Result<Offer<'a>, FloraError> {
    if let Some(bare) = options.bare {
        same_size(resources.soil.data.len(), bare.data.len())?;
    }
    Ok(Offer::new(resources, (options.needs, options.scales.illumination), options.bare))
}

fn same_size(expected: usize, found: usize) -> Result<(), FloraError> {
    if expected == found { Ok(()) } else { Err(FloraError::Size { expected, found }) }
}
