//! Stage 5b: **travel times** and the ways they are walked (L 5.2): anisotropic shortest paths
//! over the terrain, per species.
//!
//! A step costs its length times the slowness of the slope by [`gait`]; it is closed where it
//! would leave the species' confinement region or be too steep in that direction.

mod fine;
mod gait;
mod steps;
mod tiles;

pub use gait::Gait;
pub use gait::exact_slowness;

use crate::compute::ecosystem::regions::Ground;
use crate::compute::ecosystem::regions::OpenedCells;
use crate::compute::ecosystem::regions::Passages;
use crate::compute::ecosystem::regions::Regions;
use crate::compute::ecosystem::species::AnimalSpecies;
use crate::compute::ecosystem::ways::Way;
use crate::compute::ecosystem::ways::Ways;
use crate::compute::graph::shortest_paths::Quest;
use crate::compute::graph::shortest_paths::shortest_paths;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use fine::FineNetwork;
use steps::MOVES;
use steps::NEIGHBOURS;
use steps::Steps;
use tiles::Corridor;
use tiles::Tiling;

/// Cells on a side of a tile, as a power of two.
const TILE_SHIFT: u32 = 3;

/// How every species travels over one terrain.
pub struct Travel<'a> {
    ground: Ground<'a>,
    regions: &'a Regions,
    opened: OpenedCells,
    walkers: Vec<Walker>,
}

/// What is known of one species.
struct Walker {
    gait: Gait,
    region_of_part: Vec<u32>,
}

impl<'a> Travel<'a> {
    /// How `species` travel within `regions`, which were made from the same arguments.
    pub fn new(ground: Ground<'a>, passages: &Passages, regions: &'a Regions, species: &[AnimalSpecies]) -> Self {
        let opened = OpenedCells::new(&ground.height.grid, passages);
        let walker = |(s, animal): (usize, &AnimalSpecies)| Walker {
            gait: Gait::new(&animal.mobility),
            region_of_part: regions.regions_of_parts(s),
        };
        Self { ground, regions, opened, walkers: species.iter().enumerate().map(walker).collect() }
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
}

impl Ways for Travel<'_> {
    fn ways(&self, species: usize, from: usize, to: &[usize], run: &Run) -> Result<Vec<Option<Way>>, Stopped> {
        let grid = self.ground.height.grid;
        let tiling = Tiling::new(&grid, TILE_SHIFT);
        let corridor = Corridor::new(&grid, tiling, 0..tiling.len());
        let network = FineNetwork { steps: self.steps(species), corridor: &corridor };
        let reachable = |cell: &usize| network.steps.open(*cell);
        let Some(source) = network.node(from).filter(|_| reachable(&from)) else { return Ok(vec![None; to.len()]) };
        let goals: Vec<Option<usize>> = to.iter().map(|cell| network.node(*cell).filter(|_| reachable(cell))).collect();
        let targets: Vec<usize> = goals.iter().flatten().copied().collect();
        let found = shortest_paths(&network, Quest { sources: &[(source, 0.0)], targets: &targets }, run)?;
        let way = |goal: Option<usize>| {
            let node = goal.filter(|n| found.cost[*n].is_finite())?;
            Some(Way { cells: network.cells(&found, node), seconds: f64::from(found.cost[node]) })
        };
        Ok(goals.into_iter().map(way).collect())
    }

    fn step_s(&self, species: usize, from: usize, to: usize) -> f64 {
        let steps = self.steps(species);
        let (a, b) = (steps.grid().cell(from), steps.grid().cell(to));
        let step = (b.column as isize - a.column as isize, b.row as isize - a.row as isize);
        let which = MOVES[..NEIGHBOURS].iter().position(|m| *m == step);
        match which.filter(|_| steps.open(from) && steps.open(to)) {
            Some(which) => f64::from(steps.seconds(from, to, which)),
            None => f64::INFINITY,
        }
    }

    fn open(&self, species: usize, cell: usize) -> bool {
        self.steps(species).open(cell)
    }
}

#[cfg(test)]
mod tests;
