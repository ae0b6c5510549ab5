use super::steps::MOVES;
use super::steps::NEIGHBOURS;
use super::steps::Steps;
use crate::compute::ecosystem::regions::NOWHERE;
use crate::compute::raster::Tiling;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;
use std::ops::Range;

/// No room.
pub(super) const NONE: u16 = u16::MAX;

/// Cells of a full tile whose slopes are looked at.
const SAMPLES: usize = 16;

/// A **room**: the cells of a tile that are connected within the tile. A tile that a river or a
/// cliff cuts holds a room on either side, and a ford of one cell joins them: nothing is lost by
/// searching over rooms instead of cells but the exact length of the way within them.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Room {
    pub(super) tile: u32,
    pub(super) cells: u32,
    /// Mean column and row of its cells.
    pub(super) centre: (f32, f32),
    /// Mean seconds per metre in each of the eight directions of [`MOVES`].
    pub(super) slowness: [f32; NEIGHBOURS],
}

/// The rooms of a map.
pub(super) struct Rooms {
    pub(super) tiling: Tiling,
    pub(super) rooms: Vec<Room>,
    /// Index of the first room of each tile, and the number of all at the end.
    pub(super) first: Vec<u32>,
    /// Number of the room within its tile per cell of the map, or [`NONE`].
    pub(super) local: Vec<u16>,
}

impl Rooms {
    pub(super) fn new(steps: &Steps<'_>, tiling: Tiling, run: &Run) -> Result<Self, Stopped> {
        let grid = steps.grid();
        let mut local = vec![NONE; grid.len()];
        let band = grid.width * tiling.side();
        let found: Vec<Vec<Vec<Room>>> = local
            .par_chunks_mut(band)
            .enumerate()
            .map(|(row, cells)| {
                run.check()?;
                Ok((0..tiling.columns).map(|column| rooms_of_tile(steps, &tiling, (column, row), cells)).collect())
            })
            .collect::<Result<_, Stopped>>()?;
        let mut first = vec![0u32];
        let mut rooms = Vec::new();
        for mut tile in found.into_iter().flatten() {
            rooms.append(&mut tile);
            first.push(rooms.len() as u32);
        }
        Ok(Self { tiling, rooms, first, local })
    }

    /// The room that holds a cell of the map.
    pub(super) fn of(&self, column: usize, row: usize, width: usize) -> Option<usize> {
        let local = self.local[row * width + column];
        (local != NONE).then(|| self.first[self.tiling.at(column, row)] as usize + usize::from(local))
    }
}

/// Labels the cells of one tile (`cells` holds its band of rows) and measures its rooms.
fn rooms_of_tile(steps: &Steps<'_>, tiling: &Tiling, (column, row): (usize, usize), cells: &mut [u16]) -> Vec<Room> {
    let grid = steps.grid();
    let (side, width) = (tiling.side(), grid.width);
    let columns = column * side..((column + 1) * side).min(width);
    let rows = row * side..((row + 1) * side).min(grid.height);
    let every = (side * side / SAMPLES).max(1);
    let number = (row * tiling.columns + column) as u32;
    if is_one_room(steps, &columns, &rows) {
        let mut tally = Tally::default();
        for y in rows.clone() {
            cells[(y - rows.start) * width..][columns.clone()].fill(0);
            columns.clone().for_each(|x| tally.add(steps, (x, y), every));
        }
        return vec![tally.room(number)];
    }
    let mut rooms: Vec<Tally> = Vec::new();
    let mut stack = Vec::new();
    for start in rows.clone().flat_map(|y| columns.clone().map(move |x| (x, y))) {
        let at = |(x, y): (usize, usize)| (y - rows.start) * width + x;
        if cells[at(start)] != NONE || !steps.open(grid.index(start.0, start.1)) {
            continue;
        }
        let name = rooms.len() as u16;
        let mut tally = Tally::default();
        cells[at(start)] = name;
        stack.push(start);
        while let Some((x, y)) = stack.pop() {
            let cell = grid.index(x, y);
            tally.add(steps, (x, y), every);
            for (dx, dy) in &MOVES[..4] {
                let next = (x.wrapping_add_signed(*dx), y.wrapping_add_signed(*dy));
                let inside = columns.contains(&next.0) && rows.contains(&next.1);
                if inside && cells[at(next)] == NONE && steps.both_ways(cell, grid.index(next.0, next.1)) {
                    cells[at(next)] = name;
                    stack.push(next);
                }
            }
        }
        rooms.push(tally);
    }
    rooms.iter().map(|tally| tally.room(number)).collect()
}

/// Whether the tile is open throughout and every step within it is walked: so most tiles are, and
/// nothing needs to be searched for.
fn is_one_room(steps: &Steps<'_>, columns: &Range<usize>, rows: &Range<usize>) -> bool {
    let grid = steps.grid();
    let region = steps.region(grid.index(columns.start, rows.start));
    let mut above: Option<&[f32]> = None;
    region != NOWHERE
        && rows.clone().all(|y| {
            let start = grid.index(columns.start, y);
            let heights = &steps.ground.height.data[start..start + columns.len()];
            let along = heights.windows(2).all(|w| steps.climbs(w[0], w[1]));
            let across = above.is_none_or(|above| above.iter().zip(heights).all(|(a, b)| steps.climbs(*a, *b)));
            above = Some(heights);
            along && across && (start..start + columns.len()).all(|cell| steps.region(cell) == region)
        })
}

/// What is summed up over the cells of a room.
#[derive(Default)]
struct Tally {
    cells: u32,
    columns: f64,
    rows: f64,
    slowness: [f64; NEIGHBOURS],
    moves: [u32; NEIGHBOURS],
}

impl Tally {
    /// Adds a cell; every so manieth one is asked for the slowness of its steps.
    fn add(&mut self, steps: &Steps<'_>, (x, y): (usize, usize), every: usize) {
        let cell_m = steps.grid().cell_m;
        let is_sample = (self.cells as usize).is_multiple_of(every);
        self.cells += 1;
        self.columns += x as f64;
        self.rows += y as f64;
        if !is_sample {
            return;
        }
        let around = steps.around(x, y, 1);
        for which in 0..NEIGHBOURS {
            let seconds = around.seconds(which);
            if seconds.is_finite() {
                let cells = if which < 4 { 1.0 } else { std::f64::consts::SQRT_2 };
                self.slowness[which] += f64::from(seconds) / (cells * cell_m);
                self.moves[which] += 1;
            }
        }
    }

    /// Directions that no cell can be left in count as slow as the slowest of the others.
    fn room(&self, tile: u32) -> Room {
        let n = f64::from(self.cells);
        let mean = |which: usize| match self.moves[which] {
            0 => f32::INFINITY,
            moves => (self.slowness[which] / f64::from(moves)) as f32,
        };
        let mut slowness = [0.0; NEIGHBOURS];
        (0..NEIGHBOURS).for_each(|which| slowness[which] = mean(which));
        let slowest = slowness.iter().copied().filter(|s| s.is_finite()).fold(0.0, f32::max);
        slowness.iter_mut().filter(|s| s.is_infinite()).for_each(|s| *s = slowest);
        Room { tile, cells: self.cells, centre: ((self.columns / n) as f32, (self.rows / n) as f32), slowness }
    }
}
