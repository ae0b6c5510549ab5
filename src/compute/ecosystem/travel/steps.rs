use super::gait::Gait;
use crate::compute::ecosystem::regions::Ground;
use crate::compute::ecosystem::regions::NOWHERE;
use crate::compute::ecosystem::regions::OpenedCells;
use crate::compute::ecosystem::regions::Regions;
use crate::compute::raster::Grid;

/// The sixteen moves: to the eight neighbours and the eight cells a knight's move away, as
/// (columns east, rows south), each followed by its opposite.
pub(super) const MOVES: [(isize, isize); 16] = [
    (1, 0),
    (-1, 0),
    (0, 1),
    (0, -1),
    (1, 1),
    (-1, -1),
    (1, -1),
    (-1, 1),
    (2, 1),
    (-2, -1),
    (2, -1),
    (-2, 1),
    (1, 2),
    (-1, -2),
    (1, -2),
    (-1, 2),
];

/// Moves to the eight neighbours.
pub(super) const NEIGHBOURS: usize = 8;

/// The steps of one species over the cells of the terrain.
#[derive(Clone, Copy)]
pub(super) struct Steps<'a> {
    pub(super) ground: Ground<'a>,
    pub(super) regions: &'a Regions,
    pub(super) opened: &'a OpenedCells,
    pub(super) gait: &'a Gait,
    /// The species' region per part of the partition, [`NOWHERE`] for none.
    pub(super) region_of_part: &'a [u32],
}

impl Steps<'_> {
    pub(super) fn grid(&self) -> Grid {
        self.ground.height.grid
    }

    /// Whether the cell lies in a confinement region of the species.
    pub(super) fn open(&self, cell: usize) -> bool {
        self.region(cell) != NOWHERE
    }

    /// The confinement region that holds the cell, or [`NOWHERE`].
    pub(super) fn region(&self, cell: usize) -> u32 {
        self.region_of_part.get(self.regions.part.data[cell] as usize).copied().unwrap_or(NOWHERE)
    }

    /// Whether the step between two cells that share a side is walked in both directions, as the
    /// regions are connected.
    pub(super) fn both_ways(&self, a: usize, b: usize) -> bool {
        let slope = (self.height(a) - self.height(b)) / self.grid().cell_m as f32;
        self.open(b) && (self.gait.both_ways(slope) || (self.opened.is_waypoint(a) && self.opened.is_waypoint(b)))
    }

    /// Seconds of the move `which` of [`MOVES`] from `from` to `to`, which lies at its end, both
    /// open; infinite where it is closed.
    ///
    /// A diagonal move needs the two cells it squeezes through open; a knight's move needs the
    /// two cells it passes open, and one of the two ways over them walked step by step.
    pub(super) fn seconds(&self, from: usize, to: usize, which: usize) -> f32 {
        match which {
            0..4 => self.straight(from, to, 1.0),
            4..NEIGHBOURS => self.diagonal(from, to, MOVES[which]),
            _ => self.knight(from, to, MOVES[which]),
        }
    }

    /// Seconds between two cells `cells` apart by the rise between them.
    fn straight(&self, from: usize, to: usize, cells: f32) -> f32 {
        self.climb(from, to, self.height(to) - self.height(from), cells)
    }

    fn height(&self, cell: usize) -> f32 {
        self.ground.height.data[cell]
    }

    fn climb(&self, from: usize, to: usize, rise: f32, cells: f32) -> f32 {
        let run = cells * self.grid().cell_m as f32;
        let slope = rise / run;
        let slowness = self.gait.slowness(slope);
        if slowness.is_infinite() && self.opened.is_waypoint(from) && self.opened.is_waypoint(to) {
            return run * self.gait.forced(slope);
        }
        run * slowness
    }

    fn diagonal(&self, from: usize, to: usize, (dx, dy): (isize, isize)) -> f32 {
        let width = self.grid().width as isize;
        let sides = [from.wrapping_add_signed(dx), from.wrapping_add_signed(dy * width)];
        if sides.iter().all(|side| self.open(*side)) {
            self.straight(from, to, std::f32::consts::SQRT_2)
        } else {
            f32::INFINITY
        }
    }

    fn knight(&self, from: usize, to: usize, (dx, dy): (isize, isize)) -> f32 {
        let (by_side, by_corner) = self.between(from, (dx, dy));
        if !self.open(by_side) || !self.open(by_corner) || self.via(from, to, (dx, dy)).is_none() {
            return f32::INFINITY;
        }
        let half = 0.5 * 5f32.sqrt();
        let middle = 0.5 * (self.height(by_side) + self.height(by_corner));
        self.climb(from, to, middle - self.height(from), half) + self.climb(from, to, self.height(to) - middle, half)
    }

    /// The two cells a knight's move passes: the one beside its start, and the one at its corner.
    fn between(&self, from: usize, (dx, dy): (isize, isize)) -> (usize, usize) {
        let width = self.grid().width as isize;
        let (sx, sy) = (dx.signum(), dy.signum());
        let side = if dx.abs() > dy.abs() { sx } else { sy * width };
        (from.wrapping_add_signed(side), from.wrapping_add_signed(sx + sy * width))
    }

    /// The cell over which a knight's move is walked as two steps to neighbours, the quicker way.
    pub(super) fn via(&self, from: usize, to: usize, (dx, dy): (isize, isize)) -> Option<usize> {
        let (by_side, by_corner) = self.between(from, (dx, dy));
        let (sx, sy) = (dx.signum(), dy.signum());
        let over_side = self.straight(from, by_side, 1.0) + self.diagonal(by_side, to, (sx, sy));
        let over_corner = self.diagonal(from, by_corner, (sx, sy)) + self.straight(by_corner, to, 1.0);
        match over_side.min(over_corner) {
            best if best.is_infinite() => None,
            best if best == over_side => Some(by_side),
            _ => Some(by_corner),
        }
    }
}
