//! Stage 4: **accessibility** and **confinement regions** (L 5.1, T 5.3.3), and their **finest
//! common partition** (L 4.3).
//!
//! 1. A cell is open to a species if nothing on it stops the species ([`ground`]).
//! 2. Its confinement regions are the connected components of the open cells: neighbours that
//!    share a side belong together when the step between them is walked in **both** directions,
//!    so that from everywhere in a region there is a way to everywhere else and back. Cells that
//!    only touch by a corner do not connect: a stream that runs diagonally is not slipped through.
//! 3. Components below a minimum area are left out.
//! 4. The partition puts two cells in the same **part** if every species finds them in the same
//!    of its regions (or in none).

mod ground;

pub use ground::Ground;
pub use ground::Passages;
pub use ground::Place;

pub(crate) use ground::OpenedCells;
pub(crate) use ground::cells_of_place;
pub(crate) use ground::is_open;

use crate::compute::ecosystem::species::AnimalSpecies;
use crate::compute::ecosystem::species::Mobility;
use crate::compute::graph::components;
use crate::compute::graph::components::Components;
use crate::compute::graph::components::Connectivity;
use crate::compute::raster::Grid;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// The part of a cell where no species can go.
pub const NOWHERE: u32 = u32::MAX;

/// What counts as a region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RegionOptions {
    /// Regions of a smaller area are left out, m². Default: 10 000, the authors' (of L).
    pub min_area_m2: f64,
    /// Regions of fewer cells are left out. Default: 16, ours: on a coarse grid what is smaller is
    /// an accident of sampling.
    pub min_cells: u32,
}

impl Default for RegionOptions {
    fn default() -> Self {
        Self { min_area_m2: 10_000.0, min_cells: 16 }
    }
}

/// The confinement regions of all species, kept as their finest common partition.
#[derive(Debug, Clone, PartialEq)]
pub struct Regions {
    /// The number of the part per cell, or [`NOWHERE`]; parts are numbered by their first cell.
    pub part: Raster<u32>,
    /// Cells of each part.
    pub part_cells: Vec<u32>,
    /// The region of each species (second index) that holds the part (first index).
    pub(crate) region_of_part: Vec<Vec<Option<u32>>>,
    /// Cells of each region (second index) of each species (first index).
    pub region_cells: Vec<Vec<u32>>,
}

impl Regions {
    /// The regions of `species` on `ground`, with `passages` opened.
    ///
    /// Regions are numbered 0, 1, … by their first cell in row-major order. Time and memory are
    /// linear in the cells; of the maps only the partition is kept.
    pub fn new(
        ground: &Ground<'_>,
        passages: &Passages,
        species: &[AnimalSpecies],
        options: &RegionOptions,
        run: &Run,
    ) -> Result<Self, Stopped> {
        let grid = ground.height.grid;
        let opened = OpenedCells::new(&grid, passages);
        let mut regions = Self::whole(grid);
        for (s, animal) in species.iter().enumerate() {
            run.progress("animals.regions", s as u64, species.len() as u64)?;
            let same = species[..s].iter().position(|other| same_obstacles(&other.mobility, &animal.mobility));
            match same {
                Some(twin) => regions.repeat(twin),
                None => {
                    let found = components_of(ground, &opened, &animal.mobility, run)?;
                    regions.refine(found, smallest(&grid, options));
                }
            }
        }
        regions.close();
        run.progress("animals.regions", species.len() as u64, species.len() as u64)?;
        Ok(regions)
    }

    /// One part that holds everything, before any species is known.
    fn whole(grid: Grid) -> Self {
        Self {
            part: Raster::filled(grid, 0),
            part_cells: vec![grid.len() as u32],
            region_of_part: vec![Vec::new()],
            region_cells: Vec::new(),
        }
    }

    /// Adds a species that is stopped by the same things as species `twin`.
    fn repeat(&mut self, twin: usize) {
        self.region_of_part.iter_mut().for_each(|regions| regions.push(regions[twin]));
        self.region_cells.push(self.region_cells[twin].clone());
    }

    /// Adds a species: cuts the parts at the borders of its components of `min_cells` or more.
    fn refine(&mut self, mut found: Components, min_cells: u32) {
        let region = renumber(&found.cells, min_cells);
        found.label.par_iter_mut().for_each(|label| {
            *label = region.get(*label as usize).copied().unwrap_or(components::NONE);
        });
        self.region_cells.push(found.cells.iter().copied().filter(|n| *n >= min_cells).collect());
        let pairs = cut(&mut self.part.data, &found.label);
        let old = std::mem::take(&mut self.region_of_part);
        for (part, region) in pairs.keys {
            let mut regions = old[part as usize].clone();
            regions.push((region != components::NONE).then_some(region));
            self.region_of_part.push(regions);
        }
        self.part_cells = pairs.cells;
    }

    /// Takes the part where no species can go out of the numbering.
    fn close(&mut self) {
        let Some(closed) = self.region_of_part.iter().position(|r| r.iter().all(Option::is_none)) else { return };
        self.region_of_part.remove(closed);
        self.part_cells.remove(closed);
        let closed = closed as u32;
        self.part.data.par_iter_mut().for_each(|part| match (*part).cmp(&closed) {
            std::cmp::Ordering::Less => {}
            std::cmp::Ordering::Equal => *part = NOWHERE,
            std::cmp::Ordering::Greater => *part -= 1,
        });
    }

    /// Where the cells lie.
    pub fn grid(&self) -> Grid {
        self.part.grid
    }

    /// Number of parts.
    pub fn parts(&self) -> usize {
        self.part_cells.len()
    }

    /// Number of species.
    pub fn species(&self) -> usize {
        self.region_cells.len()
    }

    /// Number of regions of `species`.
    pub fn count(&self, species: usize) -> usize {
        self.region_cells[species].len()
    }

    /// The region of `species` that holds `part`.
    pub fn region_of_part(&self, species: usize, part: usize) -> Option<usize> {
        self.region_of_part[part][species].map(|r| r as usize)
    }

    /// The region of `species` that holds `cell`.
    pub fn region(&self, species: usize, cell: usize) -> Option<usize> {
        let part = self.part.data[cell];
        if part == NOWHERE { None } else { self.region_of_part(species, part as usize) }
    }

    /// The region of `species` per part, [`NOWHERE`] where it cannot go.
    pub(crate) fn regions_of_parts(&self, species: usize) -> Vec<u32> {
        self.region_of_part.iter().map(|regions| regions[species].unwrap_or(NOWHERE)).collect()
    }

    /// Area of a region, m².
    pub fn area_m2(&self, species: usize, region: usize) -> f64 {
        f64::from(self.region_cells[species][region]) * self.grid().cell_area_m2()
    }

    /// The **region map** of `species`: 0 where it cannot go, else 1 + the number of the region.
    pub fn map(&self, species: usize) -> Raster<u32> {
        let number: Vec<u32> = self.region_of_part.iter().map(|r| r[species].map_or(0, |region| region + 1)).collect();
        let value = |part: &u32| number.get(*part as usize).copied().unwrap_or(0);
        Raster { grid: self.grid(), data: self.part.data.par_iter().map(value).collect() }
    }
}

/// Cells a region must have.
fn smallest(grid: &Grid, options: &RegionOptions) -> u32 {
    let by_area = (options.min_area_m2 / grid.cell_area_m2()).ceil().clamp(1.0, f64::from(u32::MAX)) as u32;
    by_area.max(options.min_cells)
}

fn same_obstacles(a: &Mobility, b: &Mobility) -> bool {
    let limits = |m: &Mobility| [m.max_slope_up, m.max_slope_down, m.ford_depth_m, m.max_tree_cover];
    limits(a) == limits(b)
}

fn components_of(
    ground: &Ground<'_>,
    opened: &OpenedCells,
    mobility: &Mobility,
    run: &Run,
) -> Result<Components, Stopped> {
    let height = &ground.height.data;
    let step = (mobility.max_slope_up.min(mobility.max_slope_down) * ground.height.grid.cell_m) as f32;
    let both_ways =
        |a: usize, b: usize| (height[a] - height[b]).abs() <= step || (opened.is_waypoint(a) && opened.is_waypoint(b));
    let open = |cell: usize| is_open(ground, opened, mobility, cell);
    components::components(&ground.height.grid, Connectivity::Four, open, both_ways, run)
}

/// New numbers of the components, those below `min_cells` left out.
fn renumber(cells: &[u32], min_cells: u32) -> Vec<u32> {
    let mut next = 0;
    let number = |n: &u32| {
        if *n < min_cells {
            return components::NONE;
        }
        next += 1;
        next - 1
    };
    cells.iter().map(number).collect()
}

/// Distinct pairs of labels in the order they are met.
struct Pairs {
    keys: Vec<(u32, u32)>,
    cells: Vec<u32>,
}

/// Replaces each of `parts` by the number of the pair (part, region of the same cell).
fn cut(parts: &mut [u32], regions: &[u32]) -> Pairs {
    let mut number: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    let mut pairs = Pairs { keys: Vec::new(), cells: Vec::new() };
    let mut last = ((u32::MAX, u32::MAX), 0u32);
    for (part, region) in parts.iter_mut().zip(regions) {
        let key = (*part, *region);
        if key != last.0 || pairs.keys.is_empty() {
            let next = pairs.keys.len() as u32;
            let n = *number.entry(key).or_insert(next);
            if n == next {
                pairs.keys.push(key);
                pairs.cells.push(0);
            }
            last = (key, n);
        }
        *part = last.1;
        pairs.cells[last.1 as usize] += 1;
    }
    pairs
}

#[cfg(test)]
mod tests;
