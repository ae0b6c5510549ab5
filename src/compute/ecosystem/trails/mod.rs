//! Stage 7: the trails that animals wear (L 6.1, T 5.5.1).
//!
//! 1. `journeys` – who walks between which nodes, and how much (equation 3)
//! 2. `spanner` – which of these edges are walked directly, and which over other nodes
//! 3. `routes` – the way along each edge
//! 4. `bundle` – close routes become one trail
//! 5. `network` – portions between junctions with their load; greedy chaining from the heaviest
//! 6. `lines` – smooth lines on open ground
//! 7. `wear` – width, depth, and the maps of use, worn ground and carving

mod bundle;
mod journeys;
mod lines;
mod network;
mod routes;
mod spanner;
mod uneven;
mod wear;

pub use wear::Wear;

use super::curve::Ground;
use super::habitat::Habitat;
use super::paths::Paths;
use super::presence::Drinking;
use crate::compute::geometry::Point;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use std::ops::RangeInclusive;

/// How trails are made. Values outside their limits are moved to the nearest limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// How much of the active time goes to drinking (equation 1).
    pub drinking: Drinking,
    /// Mean stay at a node, seconds, for the number of moves a day. Default: 7 200, the middle of
    /// the authors' 90–150 minutes.
    pub stay_s: f64,
    /// How many times longer than the direct way animals walk to go by other nodes, at least 1.
    /// Default: 1.2 (ours: trodden ground makes up for a fifth; see [`Options::attraction`]).
    pub detour: f64,
    /// The most edges that wear a trail, the heaviest first; bounds the cost. Default: 20 000.
    pub most_edges: usize,
    /// How much of the effort a trodden trail saves, 0..=0.9. Default: 0.5 (ours).
    pub attraction: f64,
    /// How much the unevenness that no map shows may cost on top, 0..=2. Default: 1 (ours: lets trails
    /// wind a little on even ground, as real ones do).
    pub roughness: f64,
    /// How far aside a trodden trail draws animals, metres. Default: 40. Rounded to cells, at
    /// least 3 and at most 12 of them, which bounds the cost.
    pub reach_m: f64,
    /// What traffic does to the ground.
    pub wear: Wear,
    /// The seed of the unevenness.
    pub seed: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            drinking: Drinking::default(),
            stay_s: 7200.0,
            detour: 1.2,
            most_edges: 20_000,
            attraction: 0.5,
            roughness: 1.0,
            reach_m: 40.0,
            wear: Wear::default(),
            seed: 0,
        }
    }
}

/// A contiguous trail, from the longest and most used ones on.
#[derive(Debug, Clone, PartialEq)]
pub struct Trail {
    /// The line, metres.
    pub points: Vec<Point>,
    /// What walks on each part of it; consecutive stretches share a point.
    pub stretches: Vec<Stretch>,
}

impl Trail {
    /// Length in metres.
    pub fn length_m(&self) -> f64 {
        self.points.windows(2).map(|w| w[0].distance(w[1])).sum()
    }

    /// Traffic of its busiest stretch, kg a year.
    pub fn kg_per_year(&self) -> f64 {
        self.stretches.iter().map(|stretch| stretch.kg_per_year).fold(0.0, f64::max)
    }
}

/// A part of a trail with the same traffic throughout.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch {
    /// Its points in [`Trail::points`].
    pub points: RangeInclusive<usize>,
    /// Mass of animals that pass in a year, both directions, kg.
    pub kg_per_year: f64,
    /// (species, its share of that mass), by ascending species; the shares sum to 1.
    pub species: Vec<(usize, f64)>,
    /// Width, metres.
    pub width_m: f64,
    /// Depth, metres.
    pub depth_m: f64,
}

impl Stretch {
    fn new(points: RangeInclusive<usize>, loads: &[(usize, f64)], wear: &Wear) -> Self {
        let kg: f64 = loads.iter().map(|load| load.1).sum();
        let species = loads.iter().map(|&(species, part)| (species, part / kg)).collect();
        Self { points, kg_per_year: kg, species, width_m: wear.width(kg), depth_m: wear.depth(kg) }
    }

    /// The species with the largest share.
    fn main_species(&self) -> usize {
        self.species.iter().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0))).map_or(0, |most| most.0)
    }
}

/// All trails of a habitat.
#[derive(Debug, Clone, PartialEq)]
pub struct Trails {
    /// The lines, each part of the ground once.
    pub lines: Vec<Trail>,
    /// **Usage**: kg of animals a year × metres walked per m² of ground. Along a trail inside one
    /// cell that is its traffic over the width of the cell; times the cell's area it sums to
    /// traffic × length, whatever the size of the cells.
    pub usage: Raster<f32>,
    /// **Vegetation removed**: the share of the cell that trails cover, 0..=1, to be taken off
    /// the plants of the cell (by `flora::clear`).
    pub worn: Raster<f32>,
    /// How far the terrain is lowered, metres: depth of the trail × its share of the cell.
    pub carving_m: Raster<f32>,
    /// What is walked between places next to each other, for the plannings.
    pub paths: Paths,
    /// The share of the weight of all edges that the trails carry (see [`Options::most_edges`]).
    pub kept_share: f64,
    /// Journeys that found no way although the graph has a time for them.
    pub without_way: usize,
}

/// Makes the trails of a habitat. Reports as `trails.bundle`; the cost is bounded by
/// [`Options::most_edges`] searches and as many corridors of [`Options::reach_m`].
///
/// # Errors
/// [`Stopped`] when the run was asked to stop.
pub fn trails(habitat: &Habitat, options: &Options, run: &Run) -> Result<Trails, Stopped> {
    let ground = Ground { grid: habitat.grid, ways: habitat.ways };
    let wear = &options.wear;
    let chosen = journeys::journeys(habitat.rag, habitat.animals, &choice(options), run)?;
    let (mut routes, without_way) = routes::routes(&chosen.list, habitat.rag, &ground, run)?;
    bundle::bundle(&mut routes, &ground, &bending(options, habitat.grid.cell_m), run)?;
    let paths = routes::paths(&routes, &ground, run)?;
    let portions = network::portions(&routes);
    let chains = network::chains(&portions);
    let stops = network::ends(&routes);
    let lines = lines::lines(&lines::Plot { portions: &portions, stops: &stops, ground: &ground, wear }, &chains, run)?;
    let maps = wear::maps(&lines, &ground, wear);
    Ok(Trails {
        lines,
        usage: maps.usage,
        worn: maps.worn,
        carving_m: maps.carving_m,
        paths,
        kept_share: chosen.kept_share,
        without_way,
    })
}

/// The terrain with the trails carved in: height − carving; NaN stays NaN.
pub fn carved(height: &Raster<f32>, trails: &Trails) -> Raster<f32> {
    let lowered = height.data.iter().zip(&trails.carving_m.data).map(|(h, c)| h - c);
    Raster { grid: height.grid, data: lowered.collect() }
}

fn choice(options: &Options) -> journeys::Choice {
    journeys::Choice {
        drinking: options.drinking,
        stay_s: options.stay_s.max(60.0),
        detour: options.detour.clamp(1.0, 10.0),
        most: options.most_edges,
    }
}

fn bending(options: &Options, cell_m: f64) -> bundle::Bending {
    bundle::Bending {
        attraction: options.attraction.clamp(0.0, 0.9),
        roughness: options.roughness.clamp(0.0, 2.0),
        reach_cells: ((options.reach_m / cell_m).round() as usize).clamp(3, 12),
        seed: options.seed,
    }
}
