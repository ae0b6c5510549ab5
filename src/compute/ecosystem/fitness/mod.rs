//! **Fitness**: how well a plant does in a cell, 0 (it cannot live there) to 1 (L 4.2,
//! T eq. 5.4).
//!
//! For each resource, month by month, the part of the resource's variation that lies in the
//! species' **fitness range**; over the months the mean (T) or the minimum (L); over the
//! resources the minimum; times the viability of the soil type; 0 where the winter is colder
//! than the species survives and, for trees and shrubs, above their line (ours). Temperature varies between the month's minimum and maximum;
//! light, moisture and texture are single values a month, so a month is in the range or not.
//!
//! Fitness is kept as one byte a cell. That is also what "equal fitness" means to the
//! competition, which breaks ties by hash.

pub(in crate::compute::ecosystem) mod temperature;
mod tree_line;
mod variation;
pub(in crate::compute::ecosystem) mod window;

pub use tree_line::SCRUB_BELT_C;
pub use tree_line::TREE_LINE_C;
pub use variation::MonthRule;
pub use variation::share_in_range;

use crate::compute::ecosystem::resources::MONTHS;
use crate::compute::ecosystem::resources::MonthlyMap;
use crate::compute::ecosystem::resources::Resources;
use crate::compute::ecosystem::scales::Scales;
use crate::compute::ecosystem::slabs;
use crate::compute::ecosystem::slabs::Slab;
use crate::compute::ecosystem::species::Interval;
use crate::compute::ecosystem::species::PlantSpecies;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use std::ops::Range;
use temperature::Temperatures;
use tree_line::TreeLine;
use window::Distinct;
use window::Window;

/// The fitness of [`Fitness::levels`] that stands for 1.
pub const PERFECT: u8 = u8::MAX;

/// Which needs of the plants count. All by default; one is left out in an ablation study
/// (L 7.2, figure 8).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Needs {
    /// Light, in the fitness and below a canopy.
    pub illumination: bool,
    /// Temperature, with the survival bound and the tree line.
    pub temperature: bool,
    /// Soil moisture, in the fitness and as the amount drawn.
    pub moisture: bool,
    /// Soil texture.
    pub texture: bool,
    /// Viability of the soil type.
    pub soil: bool,
}

impl Default for Needs {
    fn default() -> Self {
        Self { illumination: true, temperature: true, moisture: true, texture: true, soil: true }
    }
}

/// How fitness is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitnessOptions {
    /// How the months make a year. Default: their mean.
    pub months: MonthRule,
    /// Which needs count. Default: all.
    pub needs: Needs,
    /// From °C and light fraction to the scales of the species' ranges. Default: the authors'.
    pub scales: Scales,
    /// Mean of the warmest month below which no tree grows, °C; shrubs bear [`SCRUB_BELT_C`]
    /// less. Default: [`TREE_LINE_C`]; `None` for no such lines.
    pub tree_line_c: Option<f64>,
}

impl Default for FitnessOptions {
    fn default() -> Self {
        Self {
            months: MonthRule::default(),
            needs: Needs::default(),
            scales: Scales::default(),
            tree_line_c: Some(TREE_LINE_C),
        }
    }
}

/// In how many cells each need of a species is met at all, and in how many all at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Met {
    /// Cells whose light is in the range in some month.
    pub illumination: u64,
    /// Cells whose temperature is in the range in some month.
    pub temperature: u64,
    /// Cells whose moisture is in the range in some month.
    pub moisture: u64,
    /// Cells whose texture is in the range.
    pub texture: u64,
    /// Cells whose soil type is viable.
    pub soil: u64,
    /// Cells whose winter is survived.
    pub survival: u64,
    /// Cells below the tree line, for shrubs below the scrub line; all cells for herbs.
    pub tree_line: u64,
    /// Cells where the fitness is above 0.
    pub all: u64,
}

impl Met {
    fn add(&mut self, other: &Self) {
        self.illumination += other.illumination;
        self.temperature += other.temperature;
        self.moisture += other.moisture;
        self.texture += other.texture;
        self.soil += other.soil;
        self.survival += other.survival;
        self.tree_line += other.tree_line;
        self.all += other.all;
    }
}

/// The fitness of every species in every cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitness {
    /// One map a species: 0 exactly where the fitness is 0, else the fitness times [`PERFECT`],
    /// rounded, at least 1.
    pub levels: Vec<Raster<u8>>,
    /// One count a species.
    pub met: Vec<Met>,
}

impl Fitness {
    /// The fitness of a species in a cell, 0..=1.
    pub fn value(&self, species: usize, cell: usize) -> f64 {
        f64::from(self.levels[species].data[cell]) / f64::from(PERFECT)
    }
}

/// The byte that stands for a fitness in 0..=1.
fn level(fitness: f32) -> u8 {
    if fitness > 0.0 { ((fitness * f32::from(PERFECT)).round() as u8).max(1) } else { 0 }
}

/// Computes the fitness of every species in every cell of `resources`.
///
/// All maps are on one grid (the caller's promise). Time: cells × (twelve months × the different
/// ranges of light and moisture + species); memory: one byte a cell and species. The temperature
/// is rounded to 1/128 °C where it varies over the year alike everywhere.
pub fn fitness(
    run: &Run,
    species: &[PlantSpecies],
    resources: &Resources,
    options: &FitnessOptions,
) -> Result<Fitness, Stopped> {
    let ranges = Distinct::new(species.iter().map(|s| s.temperature.range));
    let kernel = Kernel::new(species, resources, (options, &ranges), run)?;
    let grid = resources.soil.grid;
    let mut levels = vec![Raster::filled(grid, 0_u8); species.len()];
    let slabs = slabs::cut(levels.iter_mut().map(|map| map.data.as_mut_slice()), grid.len());
    let counts = slabs::each(run, "plants.fitness", slabs, |slab| kernel.fill(slab))?;
    let mut met = vec![Met::default(); species.len()];
    for slab in &counts {
        met.iter_mut().zip(slab).for_each(|(sum, part)| sum.add(part));
    }
    Ok(Fitness { levels, met })
}

/// What the cells are worked out with: the same for all of them.
struct Kernel<'a> {
    species: &'a [PlantSpecies],
    resources: &'a Resources,
    needs: Needs,
    rule: MonthRule,
    light: Distinct<Window>,
    moisture: Distinct<Window>,
    temperature: Temperatures<'a>,
    temperature_of: &'a [usize],
    tree_line: TreeLine,
}

/// The rows of one slab, one a different range.
struct Rows {
    light: Vec<Vec<u8>>,
    moisture: Vec<Vec<u8>>,
    temperature: Vec<Vec<f32>>,
    coldest: Vec<f32>,
}

impl<'a> Kernel<'a> {
    fn new(
        species: &'a [PlantSpecies],
        resources: &'a Resources,
        (options, ranges): (&'a FitnessOptions, &'a Distinct<Interval>),
        run: &Run,
    ) -> Result<Self, Stopped> {
        let light = |s: &PlantSpecies| Window::light(s.illumination.range, &options.scales.illumination);
        Ok(Self {
            species,
            resources,
            needs: options.needs,
            rule: options.months,
            light: Distinct::new(species.iter().map(light)),
            moisture: Distinct::new(species.iter().map(|s| Window::plain(s.moisture.range))),
            temperature: Temperatures::new(resources, &ranges.items, options.months, &options.scales.temperature),
            temperature_of: &ranges.of,
            tree_line: match options.tree_line_c {
                Some(line_c) => TreeLine::new(resources, line_c, run)?,
                None => TreeLine::none(),
            },
        })
    }

    fn fill(&self, mut slab: Slab<u8>) -> Vec<Met> {
        let rows = Rows {
            light: window::months_inside(&self.resources.sunlight, &self.light.items, slab.cells.clone()),
            moisture: window::months_inside(&self.resources.moisture, &self.moisture.items, slab.cells.clone()),
            temperature: self.temperature.shares(slab.cells.clone()),
            coldest: self.coldest(slab.cells.clone()),
        };
        let cells = slab.cells.clone();
        slab.maps.iter_mut().enumerate().map(|(s, map)| self.species_row(s, &rows, cells.clone(), map)).collect()
    }

    fn species_row(&self, s: usize, rows: &Rows, cells: Range<usize>, out: &mut [u8]) -> Met {
        let species = &self.species[s];
        let (light, moisture) = (&rows.light[self.light.of[s]], &rows.moisture[self.moisture.of[s]]);
        let temperature = &rows.temperature[self.temperature_of[s]];
        let texture = Window::plain(species.texture.range);
        let winter = species.survival_min_c.map_or(f32::NEG_INFINITY, |c| c as f32);
        let mut met = Met::default();
        for (i, cell) in cells.enumerate() {
            let share = Shares {
                illumination: self.rule.combine_inside(light[i]),
                temperature: temperature[i],
                moisture: self.rule.combine_inside(moisture[i]),
                texture: f32::from(u8::from(texture.holds(self.resources.texture.data[cell]))),
                soil: viability(species, self.resources.soil.data[cell]),
                survival: rows.coldest.get(i).is_none_or(|c| *c >= winter),
                tree_line: self.tree_line.is_below(cell, species.stratum),
            };
            out[i] = level(share.fitness(self.needs));
            share.count(&mut met, out[i]);
        }
        met
    }

    /// The lowest monthly minimum of each cell; nothing when no species has a bound.
    fn coldest(&self, cells: Range<usize>) -> Vec<f32> {
        if self.species.iter().all(|s| s.survival_min_c.is_none()) {
            return Vec::new();
        }
        let map = &self.resources.temperature_min_c;
        let lowest = |cell| (0..MONTHS).map(|m| map.value(m, cell)).fold(f32::INFINITY, f32::min);
        match map {
            MonthlyMap::Shifted { base, offset } => {
                let winter = offset.iter().copied().fold(f32::INFINITY, f32::min);
                base.data[cells].iter().map(|b| b + winter).collect()
            }
            MonthlyMap::Maps(_) => cells.map(lowest).collect(),
        }
    }
}

/// What each need of one species finds in one cell.
struct Shares {
    illumination: f32,
    temperature: f32,
    moisture: f32,
    texture: f32,
    soil: f32,
    survival: bool,
    tree_line: bool,
}

impl Shares {
    fn fitness(&self, needs: Needs) -> f32 {
        let of = |counts: bool, share: f32| if counts { share } else { 1.0 };
        let survives = self.survival && self.tree_line || !needs.temperature;
        let least = of(needs.illumination, self.illumination)
            .min(of(needs.temperature, self.temperature))
            .min(of(needs.moisture, self.moisture))
            .min(of(needs.texture, self.texture));
        if survives { least * of(needs.soil, self.soil) } else { 0.0 }
    }

    fn count(&self, met: &mut Met, level: u8) {
        met.illumination += u64::from(self.illumination > 0.0);
        met.temperature += u64::from(self.temperature > 0.0);
        met.moisture += u64::from(self.moisture > 0.0);
        met.texture += u64::from(self.texture > 0.0);
        met.soil += u64::from(self.soil > 0.0);
        met.survival += u64::from(self.survival);
        met.tree_line += u64::from(self.tree_line);
        met.all += u64::from(level > 0);
    }
}

/// The viability of a species on the soil type with this code; 0 for an unknown code.
fn viability(species: &PlantSpecies, code: u8) -> f32 {
    species.viability.get(usize::from(code)).map_or(0.0, |v| *v as f32)
}
