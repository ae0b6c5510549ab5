//! Stage 5b: **travel times** and the ways they are walked (L 5.2): anisotropic shortest paths
//! over the terrain, per species.
//!
//! A step costs its length times the slowness of the slope ([`Gait`]); it is closed where it
//! would leave the species' confinement region or be too steep in that direction.
//!
//! * **Ways** are found cell by cell, with sixteen moves a cell, within a corridor of tiles.
//! * **Times** between the nodes of a territory, and the corridors, come from a search over
//!   *rooms*: the connected cells of each tile ([`rooms`]), so that fords and passes of one cell
//!   stay open at any size of tile. Between nodes in tiles that touch, and on small terrains
//!   everywhere, times are those of the search by cells.
//!
//! **Error.** Against the search by cells over the whole terrain (hills, cliffs, boulders, a river
//! with one ford, tiles of 8 and 16 cells): times over rooms are off by 4 to 8 % in the mean, and
//! by less than 30 % for 99 of 100 pairs; ways are 0.2 % slower than the best in the mean, and
//! 14 % in the worst of 360 cases, where the best way lay outside the corridor. Against the
//! shortest path over smooth ground the search by cells is at most 2.8 % too slow.

mod coarse;
mod fine;
mod gait;
mod rooms;
mod steps;
mod tiles;

pub use gait::Gait;
pub use gait::exact_slowness;

use crate::compute::ecosystem::rag::Rag;
use crate::compute::ecosystem::regions::Ground;
use crate::compute::ecosystem::regions::OpenedCells;
use crate::compute::ecosystem::regions::Passages;
use crate::compute::ecosystem::regions::Regions;
use crate::compute::ecosystem::species::AnimalSpecies;
use crate::compute::ecosystem::ways::AROUND;
use crate::compute::ecosystem::ways::Way;
use crate::compute::ecosystem::ways::Ways;
use crate::compute::graph::shortest_paths::Quest;
use crate::compute::graph::shortest_paths::Reached;
use crate::compute::graph::shortest_paths::shortest_paths;
use crate::compute::raster::Grid;
use crate::compute::raster::Tiling;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use coarse::Coarse;
use fine::FineNetwork;
use rayon::prelude::*;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering;
use steps::MOVES;
use steps::NEIGHBOURS;
use steps::Steps;
use tiles::Corridor;

/// How finely ways are searched for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TravelOptions {
    /// Terrains of no more cells are searched cell by cell. Default: 16 384.
    pub exact_cells: usize,
    /// Tiles that a larger terrain is cut into at most, of side 8, 16, … cells. Default: 65 536.
    pub most_tiles: usize,
}

impl Default for TravelOptions {
    fn default() -> Self {
        Self { exact_cells: 128 * 128, most_tiles: 256 * 256 }
    }
}

/// The smallest tiles of a coarse search have sides of 2³ cells: smaller ones are no more exact.
const LEAST_SHIFT: u32 = 3;

/// The largest have sides of 2⁷ cells, so that the rooms of a tile can be counted in 16 bits.
const MOST_SHIFT: u32 = 7;

/// How every species travels over one terrain.
pub struct Travel<'a> {
    ground: Ground<'a>,
    regions: &'a Regions,
    opened: OpenedCells,
    tiling: Tiling,
    walkers: Vec<Walker>,
}

/// What is known of one species.
struct Walker {
    gait: Gait,
    region_of_part: Vec<u32>,
    /// The rooms it walks through; `None` on small terrains, and for species that are nowhere.
    coarse: Option<Coarse>,
}

impl<'a> Travel<'a> {
    /// How `species` travel within `regions`, which were made from the same `ground`, `passages`
    /// and species.
    pub fn new(
        (ground, passages): (Ground<'a>, &Passages),
        regions: &'a Regions,
        species: &[AnimalSpecies],
        options: &TravelOptions,
        run: &Run,
    ) -> Result<Self, Stopped> {
        let grid = ground.height.grid;
        let walker = |(s, animal): (usize, &AnimalSpecies)| Walker {
            gait: Gait::new(&animal.mobility),
            region_of_part: regions.regions_of_parts(s),
            coarse: None,
        };
        let walkers = species.iter().enumerate().map(walker).collect();
        let opened = OpenedCells::new(&grid, passages);
        let small = grid.len() <= options.exact_cells;
        let mut travel = Self { ground, regions, opened, tiling: tiling(&grid, small, options), walkers };
        for s in 0..species.len() {
            run.progress("animals.rooms", s as u64, species.len() as u64)?;
            if !small && regions.count(s) > 0 {
                travel.walkers[s].coarse = Some(Coarse::new(&travel.steps(s), travel.tiling, run)?);
            }
        }
        Ok(travel)
    }

    fn steps(&self, species: usize) -> Steps<'_> {
        let walker = &self.walkers[species];
        Steps {
            ground: self.ground,
            regions: self.regions,
            opened: &self.opened,
            gait: &walker.gait,
            region_of_part: &walker.region_of_part,
        }
    }

    /// Fills in the travel times, both ways, between all nodes of every territory of `rag`.
    pub fn fill_times(&self, rag: &mut Rag, run: &Run) -> Result<(), Stopped> {
        let jobs: Vec<(usize, usize)> =
            (0..rag.territories.len()).flat_map(|t| (0..rag.territories[t].nodes.len()).map(move |i| (t, i))).collect();
        let done = AtomicU64::new(0);
        let rows: Vec<Vec<f32>> = jobs
            .par_iter()
            .map(|&(t, i)| {
                let territory = &rag.territories[t];
                let cells: Vec<usize> = territory.nodes.iter().map(|n| rag.nodes[*n].cell).collect();
                let row = self.times_s(territory.species, cells[i], &cells, run)?;
                run.progress("animals.travel", done.fetch_add(1, Ordering::Relaxed) + 1, jobs.len() as u64)?;
                Ok(row)
            })
            .collect::<Result<_, Stopped>>()?;
        for (&(t, i), mut row) in jobs.iter().zip(rows) {
            row[i] = 0.0;
            let n = row.len();
            rag.territories[t].times_s[i * n..(i + 1) * n].copy_from_slice(&row);
        }
        Ok(())
    }

    /// Seconds from one cell to others; infinite where there is no way.
    pub fn times_s(&self, species: usize, from: usize, to: &[usize], run: &Run) -> Result<Vec<f32>, Stopped> {
        let Some(coarse) = &self.walkers[species].coarse else {
            return self.times_by_cells(species, from, to, (0..self.tiling.len()).collect(), run);
        };
        let far = shortest_paths(coarse, Quest { sources: &coarse.sources(from), targets: &[] }, run)?;
        let around: Vec<usize> = self.tiling.around(self.tile(from)).collect();
        let is_near = |cell: usize| around.contains(&self.tile(cell));
        let near: Vec<usize> = to.iter().copied().filter(|cell| is_near(*cell)).collect();
        let mut near = self.times_by_cells(species, from, &near, around.clone(), run)?.into_iter();
        let time = |cell: &usize| {
            let by_cells = if is_near(*cell) { near.next() } else { None };
            let by_rooms = || coarse.arrival(&far.cost, *cell).map_or(f32::INFINITY, |(_, seconds)| seconds);
            by_cells.filter(|seconds| seconds.is_finite()).unwrap_or_else(by_rooms)
        };
        Ok(to.iter().map(time).collect())
    }

    fn times_by_cells(
        &self,
        species: usize,
        from: usize,
        to: &[usize],
        tiles: Vec<usize>,
        run: &Run,
    ) -> Result<Vec<f32>, Stopped> {
        let corridor = Corridor::new(&self.grid(), self.tiling, tiles);
        let search = self.by_cells(species, from, to, &corridor, run)?;
        Ok(search.goals.iter().map(|goal| goal.map_or(f32::INFINITY, |n| search.found.cost[n])).collect())
    }

    fn by_cells<'c>(
        &'c self,
        species: usize,
        from: usize,
        to: &[usize],
        corridor: &'c Corridor,
        run: &Run,
    ) -> Result<Search<'c>, Stopped> {
        let network = FineNetwork { steps: self.steps(species), corridor };
        let node = |cell: usize| network.node(cell).filter(|_| network.steps.open(cell));
        let goals: Vec<Option<usize>> = to.iter().map(|cell| node(*cell)).collect();
        let targets: Vec<usize> = goals.iter().flatten().copied().collect();
        let sources: Vec<(usize, f32)> =
            node(from).filter(|_| !targets.is_empty()).map(|n| (n, 0.0)).into_iter().collect();
        let found = shortest_paths(&network, Quest { sources: &sources, targets: &targets }, run)?;
        Ok(Search { network, found, goals })
    }

    /// The tiles to search for the ways from one cell to others: those of the rooms on the
    /// cheapest ways over rooms, and all around them.
    fn corridor(&self, species: usize, from: usize, to: &[usize], run: &Run) -> Result<Corridor, Stopped> {
        let Some(coarse) = &self.walkers[species].coarse else {
            return Ok(Corridor::new(&self.grid(), self.tiling, 0..self.tiling.len()));
        };
        let goals: Vec<usize> = to.iter().filter_map(|cell| coarse.room_of(*cell)).collect();
        let found = shortest_paths(coarse, Quest { sources: &coarse.sources(from), targets: &goals }, run)?;
        let mut tiles = vec![self.tile(from)];
        for cell in to {
            let Some((room, _)) = coarse.arrival(&found.cost, *cell) else { continue };
            tiles.push(self.tile(*cell));
            tiles.extend(found.path(coarse, room).into_iter().map(|room| coarse.tile(room)));
        }
        let wide: Vec<usize> = tiles.iter().flat_map(|tile| self.tiling.around(*tile)).collect();
        Ok(Corridor::new(&self.grid(), self.tiling, wide))
    }

    fn grid(&self) -> Grid {
        self.ground.height.grid
    }

    fn tile(&self, cell: usize) -> usize {
        let cell = self.grid().cell(cell);
        self.tiling.at(cell.column, cell.row)
    }
}

fn tiling(grid: &Grid, small: bool, options: &TravelOptions) -> Tiling {
    let shift = if small { 3 } else { Tiling::of_at_most(grid, options.most_tiles, LEAST_SHIFT).shift };
    Tiling::new(grid, shift.min(MOST_SHIFT))
}

/// A search by cells that has ended.
struct Search<'a> {
    network: FineNetwork<'a>,
    found: Reached,
    goals: Vec<Option<usize>>,
}

impl Ways for Travel<'_> {
    fn ways(&self, species: usize, from: usize, to: &[usize], run: &Run) -> Result<Vec<Option<Way>>, Stopped> {
        let corridor = self.corridor(species, from, to, run)?;
        let search = self.by_cells(species, from, to, &corridor, run)?;
        let way = |goal: &Option<usize>| {
            let node = goal.filter(|n| search.found.cost[*n].is_finite())?;
            let cells = search.network.cells(&search.found, node);
            Some(Way { cells, seconds: f64::from(search.found.cost[node]) })
        };
        Ok(search.goals.iter().map(way).collect())
    }

    fn times_s(&self, species: usize, from: usize, to: &[usize], run: &Run) -> Result<Vec<f64>, Stopped> {
        Ok(Travel::times_s(self, species, from, to, run)?.into_iter().map(f64::from).collect())
    }

    fn step_s(&self, species: usize, from: usize, to: usize) -> f64 {
        let steps = self.steps(species);
        let (a, b) = (steps.grid().cell(from), steps.grid().cell(to));
        let step = (b.column as isize - a.column as isize, b.row as isize - a.row as isize);
        let which = MOVES[..NEIGHBOURS].iter().position(|m| *m == step);
        match which.filter(|_| steps.open(from) && steps.open(to)) {
            Some(which) => f64::from(steps.around(a.column, a.row, 1).seconds(which)),
            None => f64::INFINITY,
        }
    }

    fn steps_s(&self, species: usize, from: usize, _: &[Option<usize>; 8]) -> [(f64, f64); 8] {
        let steps = self.steps(species);
        if !steps.open(from) {
            return [(f64::INFINITY, f64::INFINITY); 8];
        }
        let cell = steps.grid().cell(from);
        let around = steps.around(cell.column, cell.row, 1);
        AROUND.map(|step| {
            let which = MOVES[..NEIGHBOURS].iter().position(|m| *m == step).unwrap_or(0);
            let (there, back) = around.there_and_back(which);
            (f64::from(there), f64::from(back))
        })
    }

    fn open(&self, species: usize, cell: usize) -> bool {
        self.steps(species).open(cell)
    }
}

#[cfg(test)]
mod tests;
