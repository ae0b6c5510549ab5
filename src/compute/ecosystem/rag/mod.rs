//! The **Resource Access Graph (RAG)**: localised resources, level by level of the food chain,
//! and what it costs each species to go from one to another (L 3.2 and 5, T 5.3).

mod atoms;
pub(crate) mod field;
pub(crate) mod level;
mod patches;
pub(crate) mod pools;
mod way_points;

pub use field::PlantGrowth;
pub use way_points::WayPoint;
pub use way_points::reached;

pub(crate) use way_points::way_point_nodes;

use crate::compute::ecosystem::species::Food;
use crate::compute::geometry::Point;

/// What a node of the graph offers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Resource {
    /// Water to drink; infinite.
    Water,
    /// Food: the growth that can be spared of a plant or an animal species.
    Food(Food),
    /// A place that animals pass, not for what it offers: the **way-point** with this number.
    WayPoint(usize),
}

/// A set of cells of the terrain, as runs of consecutive cells in row-major order.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Area {
    /// (first cell, number of cells), ascending, disjoint.
    pub runs: Vec<(u32, u32)>,
}

impl Area {
    /// The area of `cells`, which ascend.
    pub fn of(cells: impl Iterator<Item = usize>) -> Self {
        let mut area = Self::default();
        cells.for_each(|cell| area.push(cell));
        area
    }

    /// Adds a cell after all others.
    pub(crate) fn push(&mut self, cell: usize) {
        match self.runs.last_mut() {
            Some((first, n)) if (*first + *n) as usize == cell => *n += 1,
            _ => self.runs.push((cell as u32, 1)),
        }
    }

    /// The cells, ascending.
    pub fn cells(&self) -> impl Iterator<Item = usize> + '_ {
        self.runs.iter().flat_map(|&(first, n)| first as usize..(first + n) as usize)
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.runs.iter().map(|r| r.1 as usize).sum()
    }

    /// Whether there are no cells.
    pub fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }
}

/// A localised resource.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// The level of the animals that use it: 1 for herbivores, 2 for carnivores.
    pub level: usize,
    /// What it offers.
    pub resource: Resource,
    /// The region of the map where it is found.
    pub area: Area,
    /// The cell that stands for it: the one of `area` nearest its centroid.
    pub cell: usize,
    /// Centre of that cell, metres.
    pub place: Point,
    /// Area in m² (of a water node: of the bank cells).
    pub area_m2: f64,
    /// q(r, v): kg a year that can be taken without loss; infinite for water, 0 for way-points.
    pub quantity_kg: f64,
    /// The share of their moves that its users make to it for its own sake, 0..=1: that of a
    /// [`WayPoint`], 0 for what is used.
    pub draws: f64,
    /// **Hierarchical edges**: indices of the nodes of the level below that made this one.
    pub below: Vec<usize>,
}

/// The nodes that one species can reach within one of its confinement regions, the **spatial
/// edges** between them, and the herds that live there.
#[derive(Debug, Clone, PartialEq)]
pub struct Territory {
    /// Index of the species.
    pub species: usize,
    /// Number of the species' own confinement region (0, 1, …).
    pub region: usize,
    /// Indices of nodes in [`Rag::nodes`], ascending.
    pub nodes: Vec<usize>,
    /// Travel time in seconds from `nodes[i]` to `nodes[j]` at `i * nodes.len() + j`; infinite
    /// where there is no way, 0 on the diagonal.
    pub times_s: Vec<f32>,
    /// Number of individuals of each herd that lives here.
    pub herds: Vec<u32>,
}

impl Territory {
    /// Travel time in seconds from the `i`-th to the `j`-th node of the territory.
    pub fn time_s(&self, i: usize, j: usize) -> f64 {
        f64::from(self.times_s[i * self.nodes.len() + j])
    }

    /// Individuals of all herds.
    pub fn individuals(&self) -> u64 {
        self.herds.iter().map(|n| u64::from(*n)).sum()
    }
}

/// The graph.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Rag {
    /// The nodes of all levels, lower levels first.
    pub nodes: Vec<Node>,
    /// What each species makes of them, by species, then region.
    pub territories: Vec<Territory>,
}

/// How resources are cut into nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeOptions {
    /// Fragments smaller than this join a larger node near by; a resource that covers less than
    /// this of a region is left alone there, m². Default: 10 000, ours: as for regions.
    pub min_area_m2: f64,
    /// Nodes that a territory has at most. Default: 64, ours: travel times are as many searches,
    /// and as many numbers squared.
    pub max_nodes: usize,
}

impl Default for NodeOptions {
    fn default() -> Self {
        Self { min_area_m2: 10_000.0, max_nodes: 64 }
    }
}
