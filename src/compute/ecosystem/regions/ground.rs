use crate::compute::ecosystem::species::Mobility;
use crate::compute::geometry::Point;
use crate::compute::raster::Grid;
use crate::compute::raster::Raster;

/// What stops or slows an animal: maps on one grid, borrowed from the stages before.
#[derive(Debug, Clone, Copy)]
pub struct Ground<'a> {
    /// Height in metres; not a number where there is no data.
    pub height: &'a Raster<f32>,
    /// Slope, rise over run.
    pub slope: &'a Raster<f32>,
    /// Depth of the water in metres, be it a lake, a river or a stream narrower than the cell;
    /// 0 (or not a number) where dry.
    pub water_depth: &'a Raster<f32>,
    /// Cover of trees, 0..=1.
    pub tree_cover: &'a Raster<f32>,
}

/// A round place that the user opened to animals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Its centre, metres.
    pub centre: Point,
    /// Its radius, metres; cells with their centre inside are opened, and the cell that holds the
    /// place's centre always.
    pub radius_m: f64,
}

/// Places where animals may pass although the ground says otherwise.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Passages {
    /// **Fords**: water is crossed there whatever its depth.
    pub fords: Vec<Place>,
    /// The places of **way-points**: slope and vegetation are no obstacle there (ours; what draws
    /// animals to them is a [`crate::compute::ecosystem::rag::WayPoint`]).
    pub waypoints: Vec<Place>,
}

/// The cells that [`Passages`] open, ascending.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct OpenedCells {
    fords: Vec<u32>,
    waypoints: Vec<u32>,
}

impl OpenedCells {
    pub(crate) fn new(grid: &Grid, passages: &Passages) -> Self {
        Self { fords: cells_of(grid, &passages.fords), waypoints: cells_of(grid, &passages.waypoints) }
    }

    pub(crate) fn is_ford(&self, cell: usize) -> bool {
        self.fords.binary_search(&(cell as u32)).is_ok()
    }

    pub(crate) fn is_waypoint(&self, cell: usize) -> bool {
        !self.waypoints.is_empty() && self.waypoints.binary_search(&(cell as u32)).is_ok()
    }
}

fn cells_of(grid: &Grid, places: &[Place]) -> Vec<u32> {
    let mut cells: Vec<u32> = places.iter().flat_map(|place| disk(grid, place)).collect();
    cells.sort_unstable();
    cells.dedup();
    cells
}

/// The cells of a place, ascending.
pub(crate) fn cells_of_place(grid: &Grid, place: &Place) -> Vec<usize> {
    cells_of(grid, std::slice::from_ref(place)).into_iter().map(|cell| cell as usize).collect()
}

fn disk(grid: &Grid, place: &Place) -> Vec<u32> {
    let (c, r) = (place.centre, if place.radius_m.is_finite() { place.radius_m.max(0.0) } else { 0.0 });
    let column = |x: f64| (((x - grid.origin.x) / grid.cell_m).floor().max(0.0) as usize).min(grid.width);
    let row =
        |y: f64| ((grid.height as f64 - (y - grid.origin.y) / grid.cell_m).floor().max(0.0) as usize).min(grid.height);
    let columns = column(c.x - r)..(column(c.x + r) + 1).min(grid.width);
    let rows = row(c.y + r)..(row(c.y - r) + 1).min(grid.height);
    let inside = |i: &usize| grid.centre(*i).distance(c) <= r;
    let around = rows.flat_map(|row| columns.clone().map(move |column| grid.index(column, row)));
    around.filter(inside).chain(grid.at(c)).map(|i| i as u32).collect()
}

/// Whether an animal of this `mobility` can stand on a cell (L 5.1): known height, slope not
/// above both of its limits (at a way-point any), water not deeper than it wades (at a ford
/// any), tree cover not above its threshold (at a way-point any).
///
/// A stream narrower than the cell closes it when deeper than the ford depth, so that it cannot
/// be crossed there.
pub(crate) fn is_open(ground: &Ground<'_>, opened: &OpenedCells, mobility: &Mobility, cell: usize) -> bool {
    let steepest = mobility.max_slope_up.max(mobility.max_slope_down) as f32;
    let known = !ground.height.data[cell].is_nan();
    let gentle = ground.slope.data[cell] <= steepest || ground.slope.data[cell].is_nan();
    let dense = ground.tree_cover.data[cell] > mobility.max_tree_cover as f32;
    let deep = ground.water_depth.data[cell] > mobility.ford_depth_m as f32;
    known && (!deep || opened.is_ford(cell)) && ((gentle && !dense) || opened.is_waypoint(cell))
}
