//! Ways round obstacles: cheapest paths over the clearance map that keep their distance where
//! they can.

use super::AnimationError;
use crate::compute::geometry::Point;
use crate::compute::graph::shortest_paths::Network;
use crate::compute::graph::shortest_paths::Quest;
use crate::compute::graph::shortest_paths::shortest_paths;
use crate::compute::herds::Clearance;
use crate::compute::raster::Grid;
use crate::compute::raster::compass::LENGTHS;
use crate::compute::raster::compass::STEPS;
use crate::compute::raster::compass::opposite;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use std::cmp::Ordering;

/// A way costs up to this many times more where the herd brushes an obstacle (ours).
const CROWDING: f64 = 3.0;

/// How wide a way should be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Width {
    /// No narrower than this on either side: half a body.
    pub least_m: f64,
    /// Wider is no better: half a herd.
    pub ample_m: f64,
}

struct Passable<'a> {
    clearance: &'a Clearance,
    grid: Grid,
    width: Width,
}

impl Passable<'_> {
    fn open(&self, cell: usize) -> bool {
        self.clearance.of_cell(cell) >= self.width.least_m
    }

    fn factor(&self, cell: usize) -> f64 {
        1.0 + CROWDING * (1.0 - self.clearance.of_cell(cell) / self.width.ample_m).clamp(0.0, 1.0)
    }
}

impl Network for Passable<'_> {
    fn len(&self) -> usize {
        self.grid.len()
    }

    fn edges(&self, node: usize, mut visit: impl FnMut(u16, usize, f32)) {
        for (direction, (dx, dy)) in STEPS.into_iter().enumerate() {
            if let Some(next) = self.grid.offset(node, dx, dy).filter(|next| self.open(*next)) {
                let cost = f64::from(LENGTHS[direction]) * self.factor(next);
                visit(direction as u16, next, cost as f32);
            }
        }
    }

    fn origin(&self, node: usize, mark: u16) -> usize {
        let (dx, dy) = STEPS[opposite(usize::from(mark))];
        self.grid.offset(node, dx, dy).unwrap_or(node)
    }

    fn cheap_edge(&self) -> f32 {
        1.0
    }
}

/// Ways from everywhere to where the herd is to be next, round all obstacles.
pub(super) struct Ways {
    grid: Grid,
    /// What the cheapest way costs from each cell, in cells; infinite where there is none.
    cost: Vec<f32>,
}

impl Ways {
    /// The cheapest ways to the nearest of `goals` that is not in an obstacle.
    pub(super) fn new(
        clearance: &Clearance,
        goals: impl Iterator<Item = Point>,
        width: Width,
        run: &Run,
    ) -> Result<Self, Stopped> {
        let grid = clearance.grid();
        let network = Passable { clearance, grid, width };
        let sources: Vec<(usize, f32)> =
            goals.filter_map(|p| grid.at(p)).filter(|cell| network.open(*cell)).map(|cell| (cell, 0.0)).collect();
        let cost = shortest_paths(&network, Quest { sources: &sources, targets: &[] }, run)?.cost;
        Ok(Self { grid, cost })
    }

    /// Whether the way from `p` is longer than from `q`.
    pub(super) fn is_behind(&self, p: Point, q: Point) -> bool {
        let of = |p: Point| self.grid.at(p).map_or(f32::INFINITY, |cell| self.cost[cell]);
        of(p) > of(q)
    }

    /// The farthest place on the way from `p` that it sees, within `reach` metres of way; `None`
    /// where there is no way, or at its end.
    pub(super) fn ahead(&self, p: Point, reach: f64, sees: impl Fn(Point) -> bool) -> Option<Point> {
        let mut cell = self.grid.at(p)?;
        let mut farthest = None;
        let cells = (reach / self.grid.cell_m).ceil() as usize;
        for k in 1..=cells {
            let neighbours = STEPS.into_iter().filter_map(|(dx, dy)| self.grid.offset(cell, dx, dy));
            let next = neighbours.min_by(|a, b| self.cost[*a].total_cmp(&self.cost[*b]))?;
            if self.cost[next].partial_cmp(&self.cost[cell]) != Some(Ordering::Less) {
                break;
            }
            cell = next;
            if k % STRIDE == 0 || k == cells {
                let place = self.grid.centre(cell);
                if !sees(place) {
                    break;
                }
                farthest = Some(place);
            }
        }
        farthest
    }
}

/// Cells of a way from one look to the next (ours).
const STRIDE: usize = 4;

/// Corners of a way from `from` to `to`, both included, in metres: the cheapest path over the
/// cells, then only the corners that are needed to see from each to the next.
pub(super) fn around(
    clearance: &Clearance,
    (leg, from, to): (usize, Point, Point),
    width: Width,
    run: &Run,
) -> Result<Vec<Point>, AnimationError> {
    let grid = clearance.grid();
    let network = Passable { clearance, grid, width };
    let nowhere = |nearest| AnimationError::NoWay { from: leg, nearest };
    let (Some(start), Some(goal)) = (grid.at(from), grid.at(to)) else { return Err(nowhere(from)) };
    let targets = [goal];
    let quest = Quest { sources: &[(start, 0.0)], targets: if network.open(goal) { &targets } else { &[] } };
    let reached = shortest_paths(&network, quest, run)?;
    if !reached.cost[goal].is_finite() {
        let distance = |cell: &usize| grid.centre(*cell).distance_sq(to);
        let nearest = (0..grid.len())
            .filter(|cell| reached.cost[*cell].is_finite())
            .min_by(|a, b| distance(a).total_cmp(&distance(b)));
        return Err(nowhere(nearest.map_or(from, |cell| grid.centre(cell))));
    }
    let mut way: Vec<Point> = reached.path(&network, goal).into_iter().map(|cell| grid.centre(cell)).collect();
    if let (Some(first), 2..) = (way.first_mut(), reached.cost.len()) {
        *first = from;
    }
    way.push(to);
    Ok(corners(clearance, &way, width))
}

fn corners(clearance: &Clearance, way: &[Point], width: Width) -> Vec<Point> {
    let mut kept = vec![way[0]];
    let mut at = 0;
    while at + 1 < way.len() {
        // Prefer a view with room for the herd, then one with room for a body.
        let view = |from: usize| {
            let room = |p: Point| clearance.at(p).min(width.ample_m);
            move |to: &usize| {
                let wide = 0.8 * room(way[from]).min(room(way[*to]));
                clearance.sees(way[from], way[*to], wide.max(width.least_m))
            }
        };
        let next = (at + 2..way.len()).take_while(|to| *to < at + 4000).filter(view(at)).last().unwrap_or(at + 1);
        kept.push(way[next]);
        at = next;
    }
    kept
}
