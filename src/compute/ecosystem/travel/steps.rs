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

/// Length of a diagonal step, cells.
const DIAGONAL: f32 = std::f32::consts::SQRT_2;

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
        let climbs = self.climbs(self.height(a), self.height(b));
        self.open(b) && (climbs || (self.opened.is_waypoint(a) && self.opened.is_waypoint(b)))
    }

    /// Whether the rise between the heights of two cells that share a side is walked in both
    /// directions.
    pub(super) fn climbs(&self, a: f32, b: f32) -> bool {
        self.gait.both_ways((a - b) / self.grid().cell_m as f32)
    }

    fn height(&self, cell: usize) -> f32 {
        self.ground.height.data[cell]
    }

    /// What lies around an open cell, `reach` (1 or 2) cells each way.
    pub(super) fn around(&self, x: usize, y: usize, reach: isize) -> Around<'_> {
        let grid = self.grid();
        let cell = grid.index(x, y);
        let (part, region, height) = (self.regions.part.data[cell], self.region(cell), self.height(cell));
        let gentle = 0.5 * self.gait.both_ways_up_to() * grid.cell_m as f32;
        let mut around =
            Around { steps: self, cell, open: [false; SIDE * SIDE], height: [0.0; SIDE * SIDE], is_easy: true };
        for dy in -reach..=reach {
            let row = y.wrapping_add_signed(dy);
            if row >= grid.height {
                around.is_easy = false;
                continue;
            }
            for dx in -reach..=reach {
                let column = x.wrapping_add_signed(dx);
                if column >= grid.width {
                    around.is_easy = false;
                    continue;
                }
                let (at, place) = (grid.index(column, row), local((dx, dy)));
                let open = self.regions.part.data[at] == part || self.region(at) == region;
                around.open[place] = open;
                around.height[place] = self.height(at);
                around.is_easy &= open && (self.height(at) - height).abs() <= gentle;
            }
        }
        around
    }
}

/// Cells on a side of what lies around a cell.
const SIDE: usize = 5;

/// The place of a cell at (columns east, rows south) in what lies around.
const fn local((dx, dy): (isize, isize)) -> usize {
    ((dy + 2) * SIDE as isize + dx + 2) as usize
}

/// The cells within a knight's move of a cell: which lie in the same region, and their heights.
pub(super) struct Around<'a> {
    steps: &'a Steps<'a>,
    cell: usize,
    open: [bool; SIDE * SIDE],
    height: [f32; SIDE * SIDE],
    /// Whether all of them are there and open, and no two differ by more than is climbed from cell
    /// to cell: then every move can be walked.
    is_easy: bool,
}

impl Around<'_> {
    /// Seconds of the move `which` of [`MOVES`]; infinite where it is closed: off the map or out
    /// of the region, or too steep.
    ///
    /// A diagonal move needs the two cells it squeezes through open; a knight's move needs the
    /// two cells it passes open, and one of the two ways over them walked step by step.
    pub(super) fn seconds(&self, which: usize) -> f32 {
        let step = MOVES[which];
        match which {
            _ if !self.open[local(step)] => f32::INFINITY,
            0..NEIGHBOURS if self.is_easy => self.straight((0, 0), step),
            0..4 => self.straight((0, 0), step),
            4..NEIGHBOURS => self.diagonal((0, 0), step),
            _ => self.knight(step),
        }
    }

    /// Seconds of the move `which` to a neighbour, and of the move back.
    pub(super) fn there_and_back(&self, which: usize) -> (f32, f32) {
        let step = MOVES[which];
        let back = (-step.0, -step.1);
        match which {
            _ if !self.open[local(step)] => (f32::INFINITY, f32::INFINITY),
            _ if self.is_easy => (self.straight((0, 0), step), self.straight(step, back)),
            0..4 => (self.straight((0, 0), step), self.straight(step, back)),
            _ => (self.diagonal((0, 0), step), self.diagonal(step, back)),
        }
    }

    fn straight(&self, from: (isize, isize), (dx, dy): (isize, isize)) -> f32 {
        let to = (from.0 + dx, from.1 + dy);
        let cells = if dx != 0 && dy != 0 { DIAGONAL } else { 1.0 };
        self.climb(from, to, self.height[local(to)] - self.height[local(from)], cells)
    }

    /// Seconds over a rise between two cells `cells` apart.
    fn climb(&self, from: (isize, isize), to: (isize, isize), rise: f32, cells: f32) -> f32 {
        let run = cells * self.steps.grid().cell_m as f32;
        if self.is_easy {
            return run * self.steps.gait.unbounded(rise / run);
        }
        let slowness = self.steps.gait.slowness(rise / run);
        if slowness.is_infinite() && self.is_waypoint(from) && self.is_waypoint(to) {
            return run * self.steps.gait.forced(rise / run);
        }
        run * slowness
    }

    fn is_waypoint(&self, (dx, dy): (isize, isize)) -> bool {
        self.steps.opened.is_waypoint(self.at((dx, dy)))
    }

    /// The cell of the map at (columns east, rows south).
    fn at(&self, (dx, dy): (isize, isize)) -> usize {
        self.cell.wrapping_add_signed(dy * self.steps.grid().width as isize + dx)
    }

    fn diagonal(&self, from: (isize, isize), (dx, dy): (isize, isize)) -> f32 {
        if self.squeezes(from, (dx, dy)) { self.straight(from, (dx, dy)) } else { f32::INFINITY }
    }

    fn knight(&self, step: (isize, isize)) -> f32 {
        let (side, corner) = passed(step);
        let is_walked = || self.open[local(side)] && self.open[local(corner)] && self.is_walked(step);
        if !self.is_easy && !is_walked() {
            return f32::INFINITY;
        }
        let half = 0.5 * 5f32.sqrt();
        let middle = 0.5 * (self.height[local(side)] + self.height[local(corner)]);
        let (first, last) = (middle - self.height[local((0, 0))], self.height[local(step)] - middle);
        self.climb((0, 0), step, first, half) + self.climb((0, 0), step, last, half)
    }

    /// Whether a knight's move can be walked as two steps to neighbours: what [`Around::via`] finds,
    /// without asking how long they take.
    fn is_walked(&self, step: (isize, isize)) -> bool {
        let (side, corner) = passed(step);
        let over_side =
            || self.allows((0, 0), side, 1.0) && self.squeezes(side, corner) && self.allows(side, step, DIAGONAL);
        let over_corner =
            || self.squeezes((0, 0), corner) && self.allows((0, 0), corner, DIAGONAL) && self.allows(corner, step, 1.0);
        over_side() || over_corner()
    }

    /// Whether the rise between two cells `cells` apart is climbed.
    fn allows(&self, from: (isize, isize), to: (isize, isize), cells: f32) -> bool {
        let rise = self.height[local(to)] - self.height[local(from)];
        let run = cells * self.steps.grid().cell_m as f32;
        self.steps.gait.allows(rise / run) || (self.is_waypoint(from) && self.is_waypoint(to))
    }

    /// Whether the two cells beside a diagonal step are open.
    fn squeezes(&self, from: (isize, isize), (dx, dy): (isize, isize)) -> bool {
        self.open[local((from.0 + dx, from.1))] && self.open[local((from.0, from.1 + dy))]
    }

    /// The cell over which a knight's move is walked as two steps to neighbours, the quicker way.
    pub(super) fn via(&self, step: (isize, isize)) -> Option<usize> {
        let (side, corner) = passed(step);
        let last = (step.0 - corner.0, step.1 - corner.1);
        let over_side = self.straight((0, 0), side) + self.diagonal(side, corner);
        let over_corner = self.diagonal((0, 0), corner) + self.straight(corner, last);
        match over_side.min(over_corner) {
            best if best.is_infinite() => None,
            best if best == over_side => Some(self.at(side)),
            _ => Some(self.at(corner)),
        }
    }
}

/// The two cells a knight's move passes: the one beside its start, and the one at its corner.
const fn passed((dx, dy): (isize, isize)) -> ((isize, isize), (isize, isize)) {
    let corner = (dx.signum(), dy.signum());
    (if dx.abs() > dy.abs() { (corner.0, 0) } else { (0, corner.1) }, corner)
}
