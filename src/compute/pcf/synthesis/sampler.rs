use super::intensity::Intensity;
use crate::compute::geometry::Bounds;
use crate::compute::geometry::Point;
use crate::compute::geometry::Region;
use crate::compute::random::Stream;
use rayon::prelude::*;

/// Tries to hit the region inside one cell before the draw counts as failed.
const TRIES: usize = 32;

/// Side of a cell of the grid search, in r_max.
const CELL_IN_R_MAX: f64 = 0.5;

/// The most cells a room is cut into.
const MOST_CELLS: f64 = 2e6;

/// Points on a side of the raster that measures how much of a border cell lies inside.
const SUBSAMPLES: usize = 4;

/// Where new elements may lie: the room cut into square cells, grouped in rectangular blocks.
#[derive(Debug)]
pub(super) struct Sampler<'a> {
    room: &'a Region,
    intensity: Intensity<'a>,
    side: f64,
    /// Where columns of cells are cut into blocks: from the first to the one behind the last.
    columns: Vec<usize>,
    /// The same for rows.
    rows: Vec<usize>,
    /// Whether no more than one block was asked for.
    is_undivided: bool,
    /// Blocks with room in them, in rows from the south-west.
    pub(super) blocks: Vec<Block>,
}

/// A part of the room that is filled at one time.
#[derive(Debug, Clone)]
pub(super) struct Block {
    /// Colour, 0 to 3: blocks of one colour do not touch.
    pub(super) colour: usize,
    /// ∫ density over the block's room, in m².
    pub(super) mass: f64,
    cells: Vec<Cell>,
    /// The smallest rectangle around its cells.
    pub(super) bounds: Bounds,
}

/// A cell of the grid search.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    corner: Point,
    is_whole: bool,
    highest: f64,
    /// ∫ density over the cell, summed over the block's cells up to this one.
    cumulative: f64,
}

impl<'a> Sampler<'a> {
    /// Cuts `room` into cells of half an r_max (`unit`), finer in a narrow room, and evenly into blocks
    /// about `wide` and at least `least` metres wide.
    pub(super) fn new(room: &'a Region, intensity: Intensity<'a>, (unit, wide, least): (f64, f64, f64)) -> Self {
        let narrow = room.area() / room.segments().iter().map(|s| s.from.distance(s.to)).sum::<f64>();
        let side = (unit * CELL_IN_R_MAX).min(narrow).max((room.bounds().area() / MOST_CELLS).sqrt());
        let cuts = |extent: f64| evenly((extent / side) as usize + 1, (wide / side, least / side));
        let cuts = (cuts(room.bounds().width()), cuts(room.bounds().height()));
        let is_undivided = wide >= room.bounds().width().max(room.bounds().height());
        Self { is_undivided, ..Self::cut(room, intensity, side, cuts) }
    }

    /// The same room cut through the middle of its blocks, but for those at its ends, which would be
    /// halved: the seams between blocks lie inside the new ones.
    pub(super) fn between(&self) -> Self {
        Self::cut(self.room, self.intensity, self.side, (between(&self.columns), between(&self.rows)))
    }

    /// Blocks between the cuts of columns and rows of cells.
    fn cut(room: &'a Region, intensity: Intensity<'a>, side: f64, (columns, rows): (Vec<usize>, Vec<usize>)) -> Self {
        let mut sampler = Self { room, intensity, side, columns, rows, is_undivided: false, blocks: Vec::new() };
        let across = sampler.columns.len() - 1;
        let all: Vec<usize> = (0..across * (sampler.rows.len() - 1)).collect();
        let block = |b: &usize| sampler.block((b % across, b / across));
        let blocks: Vec<Block> = all.par_iter().map(block).collect();
        sampler.blocks = blocks.into_iter().filter(|b| b.mass > 0.0).collect();
        sampler
    }

    /// The block in a column and row of blocks.
    fn block(&self, (bx, by): (usize, usize)) -> Block {
        let (mut cells, corner) = (Vec::new(), self.room.bounds().min);
        for row in self.rows[by]..self.rows[by + 1] {
            for column in self.columns[bx]..self.columns[bx + 1] {
                cells.extend(self.cell(corner + Point::new(column as f64, row as f64) * self.side));
            }
        }
        let mut mass = 0.0;
        for (cell, own) in &mut cells {
            mass += *own;
            cell.cumulative = mass;
        }
        let cells: Vec<Cell> = cells.into_iter().map(|(cell, _)| cell).collect();
        let corners = cells.iter().flat_map(|c| [c.corner, c.corner + Point::new(self.side, self.side)]);
        let bounds = Bounds::of(corners).unwrap_or(self.room.bounds());
        Block { colour: colour(bx, by), mass, cells, bounds }
    }

    /// The block that `p` lies in; the nearest block's number when it lies in none.
    pub(super) fn block_of(&self, p: Point) -> usize {
        let far = |b: &usize| distance_sq(&self.blocks[*b].bounds, p);
        (0..self.blocks.len()).min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(0)
    }

    /// Whether one block is all of the room.
    pub(super) fn is_one_block(&self) -> bool {
        self.columns.len() == 2 && self.rows.len() == 2
    }

    /// Whether the room is one block because so few elements are to be laid out.
    pub(super) fn is_undivided(&self) -> bool {
        self.is_undivided
    }

    /// Whether one block is all of `domain`.
    pub(super) fn is_all_of(&self, domain: &Region) -> bool {
        self.is_one_block() && std::ptr::eq(self.room, domain)
    }

    /// The colour of the block around `p`.
    pub(super) fn colour_at(&self, p: Point) -> usize {
        let at = |offset: f64, cuts: &[usize]| {
            let cell = (offset / self.side).max(0.0) as usize;
            cuts[1..cuts.len() - 1].partition_point(|cut| *cut <= cell)
        };
        let offset = p - self.room.bounds().min;
        colour(at(offset.x, &self.columns), at(offset.y, &self.rows))
    }

    /// ∫ density over the room.
    pub(super) fn mass(&self) -> f64 {
        self.blocks.iter().map(|b| b.mass).sum()
    }

    /// The cell at `corner` and its ∫ density, if any of it is in the room.
    fn cell(&self, corner: Point) -> Option<(Cell, f64)> {
        let centre = corner + Point::new(0.5, 0.5) * self.side;
        let half_diagonal = self.side * std::f64::consts::FRAC_1_SQRT_2;
        let is_whole = self.room.clearance(centre, half_diagonal * 1.01) > half_diagonal;
        if is_whole && !self.room.contains(centre) {
            return None;
        }
        let n = SUBSAMPLES;
        let place = |k: usize| Point::new((k % n) as f64 + 0.5, (k / n) as f64 + 0.5) * (self.side / n as f64) + corner;
        let inside = (0..n * n).map(place).filter(|p| is_whole || self.room.contains(*p));
        let densities: Vec<f64> = inside.map(|p| self.intensity.at(p)).collect();
        let highest = densities.iter().copied().fold(0.0, f64::max);
        let share = densities.iter().sum::<f64>() / (n * n) as f64;
        let cell = Cell { corner, is_whole, highest, cumulative: 0.0 };
        (highest > 0.0).then_some((cell, share * self.side * self.side))
    }

    /// A place in `block` drawn by the density; `None` when the draw missed the room.
    pub(super) fn draw(&self, block: &Block, random: &mut Stream) -> Option<Point> {
        self.draw_in(block.cells.get(block.draw_cell(random))?, random)
    }

    /// The middle of `cell` and the radius of the circle around it, in metres.
    pub(super) fn circle_around(&self, cell: &Cell) -> (Point, f64) {
        (cell.corner + Point::new(0.5, 0.5) * self.side, self.side * std::f64::consts::FRAC_1_SQRT_2)
    }

    /// A place in `cell` drawn by the density.
    pub(super) fn draw_in(&self, cell: &Cell, random: &mut Stream) -> Option<Point> {
        let accepts = |p: &Point, coin: f64| {
            (cell.is_whole || self.room.contains(*p))
                && (self.intensity.is_flat() || self.intensity.at(*p) > coin * cell.highest)
        };
        (0..TRIES).find_map(|_| {
            let p = cell.corner + Point::new(random.unit(), random.unit()) * self.side;
            accepts(&p, random.unit()).then_some(p)
        })
    }

    /// Whether an element may lie at `p`.
    pub(super) fn allows(&self, p: Point) -> bool {
        self.room.contains(p) && self.intensity.at(p) > 0.0
    }

    /// Distance of `p` to the border of the room, at most `at_most`; 0 with a painted density,
    /// which may bar any place.
    pub(super) fn freedom(&self, p: Point, at_most: f64) -> f64 {
        if self.intensity.is_flat() { self.room.clearance(p, at_most) } else { 0.0 }
    }
}

/// Where `cells` in a row are cut into even blocks, of about `wide` cells and at least `least`.
fn evenly(cells: usize, (wide, least): (f64, f64)) -> Vec<usize> {
    let blocks = (cells as f64 / wide).round().min(cells as f64 / least).max(1.0) as usize;
    (0..=blocks).map(|k| k * cells / blocks).collect()
}

/// The cuts through the middles of all blocks between `cuts` but the first and the last.
fn between(cuts: &[usize]) -> Vec<usize> {
    let inner = cuts.windows(2).map(|pair| pair[0].midpoint(pair[1]));
    let inner = inner.skip(1).take(cuts.len().saturating_sub(3));
    cuts.first().copied().into_iter().chain(inner).chain(cuts.last().copied()).collect()
}

/// The colour of the block in a column and row of blocks.
fn colour(column: usize, row: usize) -> usize {
    column % 2 + 2 * (row % 2)
}

/// Squared distance of `p` to a rectangle, 0 inside.
fn distance_sq(bounds: &Bounds, p: Point) -> f64 {
    let off = |v: f64, low: f64, high: f64| (low - v).max(v - high).max(0.0);
    Point::new(off(p.x, bounds.min.x, bounds.max.x), off(p.y, bounds.min.y, bounds.max.y)).norm_sq()
}

impl Block {
    /// The number of a cell, drawn by the density; there is none in a block without cells.
    pub(super) fn draw_cell(&self, random: &mut Stream) -> usize {
        let at = random.unit() * self.mass;
        self.cells.partition_point(|c| c.cumulative <= at).min(self.cells.len().saturating_sub(1))
    }

    /// The cells of the grid search.
    pub(super) fn cells(&self) -> &[Cell] {
        &self.cells
    }
}

impl Cell {
    /// ∫ density over the block's cells up to this one.
    pub(super) fn up_to(&self) -> f64 {
        self.cumulative
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_even_and_at_least_as_wide_as_asked() {
        assert_eq!(evenly(10, (100.0, 5.0)), [0, 10]);
        assert_eq!(evenly(10, (4.0, 1.0)), [0, 3, 6, 10]);
        assert_eq!(evenly(10, (4.0, 4.0)), [0, 5, 10]);
        assert_eq!(evenly(1, (0.2, 1.0)), [0, 1]);
    }

    #[test]
    fn the_second_cut_goes_through_blocks_and_halves_none_at_the_ends() {
        assert_eq!(between(&[0, 10]), [0, 10]);
        assert_eq!(between(&[0, 10, 20]), [0, 20]);
        assert_eq!(between(&[0, 10, 20, 30]), [0, 15, 30]);
        assert_eq!(between(&[0, 10, 20, 30, 40]), [0, 15, 25, 40]);
    }
}
