//! From cells to curves: straight where the ground allows, smooth, and never on closed ground.

use super::ways::Way;
use super::ways::Ways;
use crate::compute::geometry::Point;
use crate::compute::raster::Grid;

/// The terrain as one species walks it.
#[derive(Clone, Copy)]
pub(crate) struct Ground<'a> {
    pub(crate) grid: &'a Grid,
    pub(crate) ways: &'a dyn Ways,
}

impl Ground<'_> {
    /// Seconds along a run of neighbouring cells; infinite where a step is closed.
    pub(crate) fn seconds(&self, species: usize, cells: &[u32]) -> f64 {
        cells.windows(2).map(|w| self.ways.step_s(species, w[0] as usize, w[1] as usize)).sum()
    }

    /// Whether every cell that the segment from `p` to `q` touches is open to the species.
    pub(crate) fn clear(&self, species: usize, p: Point, q: Point) -> bool {
        crossed_cells(self.grid, p, q, |cell| self.ways.open(species, cell))
    }

    /// The way with every stretch that a straight run of cells passes as quickly made straight.
    ///
    /// A search over neighbouring cells knows few directions, so among its quickest ways over
    /// even ground are many crooked ones; none of them is made slower here.
    pub(crate) fn straightened(&self, species: usize, way: &Way) -> Vec<u32> {
        let step = |a: u32, b: u32| self.ways.step_s(species, a as usize, b as usize);
        self.straight_by(species, &way.cells, 1.0 + 1e-6, step)
    }

    /// The course with every stretch that a straight run replaces at most `slack` times as dear
    /// made straight; `step` gives what a step between neighbours costs.
    pub(crate) fn straight_by(
        &self,
        species: usize,
        cells: &[u32],
        slack: f64,
        step: impl Fn(u32, u32) -> f64,
    ) -> Vec<u32> {
        let mut at = vec![0.0];
        cells.windows(2).for_each(|w| at.push(at[at.len() - 1] + step(w[0], w[1])));
        if cells.len() < 3 || !at[cells.len() - 1].is_finite() {
            return cells.to_vec();
        }
        let mut straight = vec![cells[0]];
        let mut from = 0;
        while from + 1 < cells.len() {
            let attempt = |to: usize| {
                let run = straight_run(self.grid, cells[from], cells[to]);
                let mut left = (at[to] - at[from]) * slack;
                let cheap = run.windows(2).all(|w| {
                    left -= step(w[0], w[1]);
                    left >= 0.0
                });
                cheap.then_some((to, run))
            };
            let (to, run) =
                farthest(from, cells.len() - 1, attempt).unwrap_or((from + 1, cells[from..from + 2].to_vec()));
            straight.extend_from_slice(&run[1..]);
            from = to;
        }
        self.squared(species, &straight)
    }

    /// The run with a step more wherever it cuts the corner of a closed cell and can go round: a
    /// curve through such a corner could not be smoothed.
    pub(crate) fn squared(&self, species: usize, cells: &[u32]) -> Vec<u32> {
        let mut squared: Vec<u32> = cells.first().copied().into_iter().collect();
        for w in cells.windows(2) {
            let (a, b) = (self.grid.cell(w[0] as usize), self.grid.cell(w[1] as usize));
            let sides = [self.grid.index(b.column, a.row), self.grid.index(a.column, b.row)];
            let open = sides.map(|side| self.ways.open(species, side));
            let cut = a.column != b.column && a.row != b.row && open[0] != open[1];
            let side = if open[0] { sides[0] } else { sides[1] } as u32;
            if cut && self.seconds(species, &[w[0], side, w[1]]).is_finite() {
                squared.push(side);
            }
            squared.push(w[1]);
        }
        squared
    }

    /// The course made smooth, with the time at each point.
    pub(crate) fn walk(&self, species: usize, cells: &[u32]) -> Walk {
        self.timed(species, cells, self.smoothed(species, cells))
    }

    /// The centres of the cells made smooth, on open ground; the ends stay.
    pub(crate) fn smoothed(&self, species: usize, cells: &[u32]) -> Vec<Point> {
        let mut points: Vec<Point> = cells.iter().map(|&cell| self.grid.centre(cell as usize)).collect();
        let ends = [0, points.len().saturating_sub(1)];
        relax(&mut points, smoothing(self.grid.cell_m), |i| ends.contains(&i), |_, p, q| self.clear(species, p, q));
        points
    }

    /// The time at each of the points that smoothing made of the cells: each piece keeps the
    /// slowness of the step it came from, a closed one (which a search passes by a longer step)
    /// counts 1 s/m.
    pub(crate) fn timed(&self, species: usize, cells: &[u32], points: Vec<Point>) -> Walk {
        let mut at = vec![0.0];
        for (i, w) in cells.windows(2).map(|w| [w[0] as usize, w[1] as usize]).enumerate() {
            let seconds = self.ways.step_s(species, w[0], w[1]);
            let before = self.grid.centre(w[0]).distance(self.grid.centre(w[1]));
            let slowness = if seconds.is_finite() { seconds / before } else { 1.0 };
            at.push(at[i] + slowness * points[i].distance(points[i + 1]));
        }
        Walk { points, at }
    }
}

/// A course in time.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Walk {
    pub(crate) points: Vec<Point>,
    /// Seconds from the start to each point, ascending.
    pub(crate) at: Vec<f64>,
}

impl Walk {
    /// How long it takes.
    pub(crate) fn seconds(&self) -> f64 {
        self.at[self.at.len() - 1]
    }
}

/// How far along a line it is smoothed: the standard deviation of the B-spline's kernel, metres,
/// but at least and at most so many cells (ours: takes out the directions of the grid and the
/// corners where routes part, keeps the bends of a valley).
const SMOOTH_M: f64 = 6.0;
const SMOOTH_CELLS: (f64, f64) = (2.5, 6.0);

/// The variance of that kernel, cells².
pub(crate) fn smoothing(cell_m: f64) -> f64 {
    (SMOOTH_M / cell_m).clamp(SMOOTH_CELLS.0, SMOOTH_CELLS.1).powi(2)
}

/// The farthest place after `from`, up to `last`, at which `attempt` was seen to succeed, by
/// doubling the stride and then halving it.
fn farthest(
    from: usize,
    last: usize,
    attempt: impl Fn(usize) -> Option<(usize, Vec<u32>)>,
) -> Option<(usize, Vec<u32>)> {
    let mut best: Option<(usize, Vec<u32>)> = None;
    let mut stride = 2;
    let mut growing = true;
    while stride > 0 {
        let reached = best.as_ref().map_or(from, |found| found.0);
        let to = (if growing { from + stride } else { reached + stride }).min(last);
        match attempt(to) {
            Some(found) if found.0 > reached => best = Some(found),
            _ => growing = false,
        }
        growing &= best.as_ref().is_some_and(|found| found.0 < last);
        stride = if growing { stride * 2 } else { stride / 2 };
    }
    best
}

/// The cells of a straight run between two cells, both included, each a neighbour of the one
/// before (Bresenham's line).
pub(crate) fn straight_run(grid: &Grid, from: u32, to: u32) -> Vec<u32> {
    let (a, b) = (grid.cell(from as usize), grid.cell(to as usize));
    let (dx, dy) = (b.column as f64 - a.column as f64, b.row as f64 - a.row as f64);
    let steps = dx.abs().max(dy.abs());
    let along = |k: usize| {
        let t = if steps > 0.0 { k as f64 / steps } else { 0.0 };
        let (column, row) = ((a.column as f64 + dx * t).round(), (a.row as f64 + dy * t).round());
        grid.index(column as usize, row as usize) as u32
    };
    (0..=steps as usize).map(along).collect()
}

/// Whether `keep` holds for every cell that the segment touches (Amanatides and Woo 1987);
/// false when it leaves the map.
fn crossed_cells(grid: &Grid, p: Point, q: Point, keep: impl Fn(usize) -> bool) -> bool {
    let (Some(mut cell), Some(goal)) = (grid.at(p), grid.at(q)) else { return false };
    let size = grid.cell_m;
    let (dx, dy) = (q.x - p.x, q.y - p.y);
    let toward = |d: f64| if d > 0.0 { 1 } else { -1 };
    let (east, south) = (toward(dx), -toward(dy));
    let centre = grid.centre(cell);
    let until =
        |d: f64, offset: f64| if d == 0.0 { f64::INFINITY } else { (0.5 * size - offset * d.signum()) / d.abs() };
    let (mut next_x, mut next_y) = (until(dx, p.x - centre.x), until(dy, p.y - centre.y));
    let bound = 4 + ((dx.abs() + dy.abs()) / size) as usize;
    for _ in 0..bound {
        if !keep(cell) {
            return false;
        }
        if cell == goal {
            return true;
        }
        let step = if next_x < next_y { (east, 0) } else { (0, south) };
        if next_x < next_y {
            next_x += size / dx.abs();
        } else {
            next_y += size / dy.abs();
        }
        let Some(next) = grid.offset(cell, step.0, step.1) else { return false };
        cell = next;
    }
    keep(goal)
}

/// The share of the way to the middle of its neighbours that a point goes, or what is free of it.
const MOVES: [f64; 3] = [0.5, 0.2, 0.05];

/// How far apart the neighbours are at most whose middle a point moves to.
const STRIDE: usize = 4;

/// The variance that is left to strides of one step: these smooth over the gaps of the longer ones,
/// and reach where obstacles leave those no room.
const SHORT_VARIANCE: f64 = 4.0;

/// Smooths a curve by averaging each point with its neighbours, far ones first: a B-spline over
/// the points (Lane and Riesenfeld 1980) with a kernel of this `variance`, in steps². A point
/// moves only when it is not `pinned` and both segments beside it stay `clear`, which is asked
/// with the index of the segment's first point; so a curve over open cells stays on open cells.
pub(crate) fn relax(
    points: &mut [Point],
    variance: f64,
    pinned: impl Fn(usize) -> bool,
    clear: impl Fn(usize, Point, Point) -> bool,
) {
    let reach = free_reach(points.len(), pinned);
    let n = points.len();
    let settle = |points: &mut [Point], i: usize, stride: usize| {
        let near = stride.min(reach[i]);
        if near == 0 {
            return;
        }
        let (before, here, after) = (points[i - 1], points[i], points[i + 1]);
        let middles = [points[i - near].lerp(points[i + near], 0.5), before.lerp(after, 0.5)];
        let moves = middles.into_iter().flat_map(|middle| MOVES.map(|share| here.lerp(middle, share)));
        let free = |there: &Point| clear(i - 1, before, *there) && clear(i, *there, after);
        if let Some(there) = moves.into_iter().find(free) {
            points[i] = there;
        }
    };
    for (round, stride) in strides(variance).into_iter().enumerate() {
        for k in 0..n {
            settle(points, if round % 2 == 0 { k } else { n - 1 - k }, stride);
        }
    }
}

/// The strides of the rounds, largest first: one of stride k adds the variance k²/2.
fn strides(variance: f64) -> Vec<usize> {
    let mut strides = Vec::new();
    let mut left = variance.clamp(0.0, 1e4);
    for stride in [STRIDE, STRIDE / 2, 1] {
        let adds = 0.5 * (stride * stride) as f64;
        let last = if stride > 1 { SHORT_VARIANCE } else { -0.5 * adds };
        while left - adds >= last {
            strides.push(stride);
            left -= adds;
        }
    }
    strides
}

/// Steps from each point to the nearest pinned one or end, at most [`STRIDE`].
fn free_reach(n: usize, pinned: impl Fn(usize) -> bool) -> Vec<usize> {
    let mut reach = vec![0; n];
    for i in 1..n {
        reach[i] = if pinned(i) || i + 1 == n { 0 } else { STRIDE.min(reach[i - 1] + 1) };
    }
    for i in (0..n.saturating_sub(1)).rev() {
        reach[i] = reach[i].min(reach[i + 1] + 1);
    }
    reach
}

/// Which points of a line to keep so that it stays within `tolerance` of all of them (Ramer 1972,
/// Douglas and Peucker 1973); `keep` names points that stay in any case, and a straight piece
/// replaces a stretch only when it is `clear`.
pub(crate) fn thinned(
    points: &[Point],
    tolerance: f64,
    keep: impl Fn(usize) -> bool,
    clear: impl Fn(usize, Point, Point) -> bool,
) -> Vec<usize> {
    let mut kept: Vec<usize> = (0..points.len()).filter(|&i| i == 0 || i + 1 == points.len() || keep(i)).collect();
    let mut open: Vec<(usize, usize)> = kept.windows(2).map(|w| (w[0], w[1])).collect();
    while let Some((a, b)) = open.pop() {
        if b < a + 2 {
            continue;
        }
        let off = |i: &usize| distance_to_segment(points[*i], points[a], points[b]);
        let far = (a + 1..b).max_by(|i, j| off(i).total_cmp(&off(j))).unwrap_or(a + 1);
        if off(&far) > tolerance || !clear(a, points[a], points[b]) {
            kept.push(far);
            open.extend([(a, far), (far, b)]);
        }
    }
    kept.sort_unstable();
    kept.dedup();
    kept
}

fn distance_to_segment(p: Point, a: Point, b: Point) -> f64 {
    let along = b - a;
    let t = if along.norm_sq() > 0.0 { ((p - a).dot(along) / along.norm_sq()).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(a.lerp(b, t))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::ecosystem::ways::sample::Plain;

    #[test]
    fn a_crooked_way_over_even_ground_becomes_straight() {
        let plain = Plain::new(60, 30, 1.0);
        let grid = &plain.grid;
        let corner: Vec<u32> =
            (0..30).map(|c| grid.index(c, 0)).chain((1..20).map(|k| grid.index(29 + k, k))).map(|i| i as u32).collect();
        let way = Way { seconds: 0.0, cells: corner };
        let ground = Ground { grid, ways: &plain };
        let straight = ground.straightened(0, &way);
        assert!(ground.seconds(0, &straight) <= ground.seconds(0, &way.cells) * (1.0 + 1e-9));
        let (a, b) = (grid.centre(way.cells[0] as usize), grid.centre(way.cells[48] as usize));
        for cell in straight {
            assert!(distance_to_segment(grid.centre(cell as usize), a, b) < 1.5);
        }
    }

    #[test]
    fn a_segment_is_clear_only_when_all_cells_it_crosses_are_open() {
        let plain = Plain::new(20, 20, 2.0).with_river(10, 4);
        let ground = Ground { grid: &plain.grid, ways: &plain };
        let at = |column, row| plain.grid.centre(plain.grid.index(column, row));
        assert!(ground.clear(0, at(5, 4), at(15, 4)));
        assert!(!ground.clear(0, at(5, 4), at(15, 9)));
        assert!(!ground.clear(0, at(5, 5), at(15, 5)));
        assert!(ground.clear(0, at(5, 19), at(9, 0)) && ground.clear(0, at(9, 0), at(5, 19)));
        assert!(!ground.clear(0, at(5, 5), Point::new(-1.0, 5.0)));
    }

    #[test]
    fn smoothing_never_leaves_open_ground_and_takes_out_corners() {
        let plain = Plain::new(40, 40, 1.0).with_river(20, 3);
        let ground = Ground { grid: &plain.grid, ways: &plain };
        let to = plain.grid.index(35, 30);
        let way = plain.ways(0, plain.grid.index(4, 30), &[to], &crate::compute::run::Run::silent()).unwrap().remove(0);
        let cells = ground.straightened(0, &way.unwrap());
        let mut points: Vec<Point> = cells.iter().map(|&c| plain.grid.centre(c as usize)).collect();
        let sharpest = |points: &[Point]| {
            let turn = |w: &[Point]| {
                let (a, b) = (w[1] - w[0], w[2] - w[1]);
                libm::atan2(a.cross(b), a.dot(b)).abs()
            };
            points.windows(3).map(turn).fold(0.0, f64::max)
        };
        let before = sharpest(&points);
        let last = points.len() - 1;
        relax(&mut points, 6.0, |i| i == 0 || i == last, |_, p, q| ground.clear(0, p, q));
        assert!(sharpest(&points) < 0.7 * before, "{} {before}", sharpest(&points));
        assert!(points.iter().all(|&p| plain.open(0, plain.grid.at(p).unwrap())));
    }

    #[test]
    fn smoothing_keeps_straight_lines_and_pinned_points_and_has_its_variance() {
        let mut line: Vec<Point> = (0..50).map(|i| Point::new(f64::from(i), 2.0 * f64::from(i))).collect();
        let before = line.clone();
        relax(&mut line, 36.0, |i| i == 20, |_, _, _| true);
        assert!(line.iter().zip(&before).all(|(p, q)| p.distance(*q) < 1e-9));
        for variance in [1.0, 6.25, 36.0] {
            let sum: f64 = strides(variance).iter().map(|k| 0.5 * (k * k) as f64).sum();
            assert!((sum - variance).abs() <= 0.25 + 1e-9, "{sum} {variance}");
        }
        let mut spike: Vec<Point> = (0..101).map(|i| Point::new(f64::from(i), f64::from(u8::from(i == 50)))).collect();
        relax(&mut spike, 36.0, |i| i == 30, |_, _, _| true);
        assert!(spike[50].y < 0.15 && spike[30].y == 0.0 && spike[45].y > 0.0);
    }

    #[test]
    fn a_thinned_line_stays_near_all_points() {
        let points: Vec<Point> =
            (0..200).map(|i| Point::new(f64::from(i), 10.0 * libm::sin(f64::from(i) * 0.05))).collect();
        let kept = thinned(&points, 0.3, |i| i == 77, |_, _, _| true);
        assert!(kept.len() < 60 && kept.contains(&77), "{kept:?}");
        for w in kept.windows(2) {
            for p in &points[w[0]..w[1]] {
                assert!(distance_to_segment(*p, points[w[0]], points[w[1]]) <= 0.3);
            }
        }
    }
}
