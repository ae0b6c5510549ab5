//! Routes that run close together become one trail: animals follow what is already trodden.

use super::routes::Route;
use super::uneven::Unevenness;
use crate::compute::ecosystem::curve::Ground;
use crate::compute::ecosystem::ways::AROUND;
use crate::compute::graph::shortest_paths::Network;
use crate::compute::graph::shortest_paths::Quest;
use crate::compute::graph::shortest_paths::shortest_paths;
use crate::compute::raster::Grid;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;

/// How much more a straight run may cost than the course it replaces (ours): a search over
/// neighbouring cells prefers eight directions, animals do not.
const SLACK: f64 = 1.03;

/// How routes bend.
pub(crate) struct Bending {
    pub(crate) attraction: f64,
    pub(crate) roughness: f64,
    pub(crate) reach_cells: usize,
    pub(crate) seed: u64,
}

/// Lays the routes again, heaviest first, each within `reach_cells` of its first course, where a
/// step costs its time × (1 + roughness) × (1 − attraction · T / (T + w)): T is what already walks
/// on both cells, w what the route carries itself. So a lighter route gives way to a heavier one
/// and main trails emerge, as in the model of Helbing, Keltsch and Molnár (1997) where walkers
/// follow and deepen what others have trodden. Routes that cannot meet are laid at the same time.
pub(crate) fn bundle(routes: &mut [Route], ground: &Ground, bending: &Bending, run: &Run) -> Result<(), Stopped> {
    let mut field = Field {
        load: vec![0.0; ground.grid.len()],
        uneven: Unevenness::new(ground.grid, bending.seed),
        grid: ground.grid,
        bending,
    };
    let (total, mut laid) = (routes.len() as u64, 0);
    for turn in turns(routes, ground.grid, bending.reach_cells) {
        let relay = |&i: &usize| {
            run.check()?;
            relaid(&routes[i], ground, &field, run)
        };
        let courses: Vec<Option<Vec<u32>>> = turn.par_iter().map(relay).collect::<Result<_, Stopped>>()?;
        for (&i, course) in turn.iter().zip(courses) {
            let route = &mut routes[i];
            route.cells = course.unwrap_or(std::mem::take(&mut route.cells));
            route.cells.iter().for_each(|&cell| field.load[cell as usize] += route.kg as f32);
        }
        laid += turn.len() as u64;
        run.progress("trails.bundle", laid, total)?;
    }
    Ok(())
}

/// Which routes are laid together, turn by turn: each as soon as all before it that could come
/// near have been laid, so that the result is that of laying one after the other.
fn turns(routes: &[Route], grid: &Grid, reach: usize) -> Vec<Vec<usize>> {
    let boxes: Vec<[usize; 4]> = routes.iter().map(|route| bounds(grid, &route.cells, reach)).collect();
    let apart = |a: &[usize; 4], b: &[usize; 4]| a[1] < b[0] || b[1] < a[0] || a[3] < b[2] || b[3] < a[2];
    let mut turn_of: Vec<usize> = Vec::with_capacity(routes.len());
    let mut turns: Vec<Vec<usize>> = Vec::new();
    for (i, here) in boxes.iter().enumerate() {
        let before = boxes[..i].iter().zip(&turn_of).filter(|(other, _)| !apart(here, other));
        let turn = before.map(|(_, turn)| turn + 1).max().unwrap_or(0);
        turn_of.push(turn);
        turns.resize(turns.len().max(turn + 1), Vec::new());
        turns[turn].push(i);
    }
    turns
}

/// First and last column, first and last row that a route can touch (`reach` more each way).
fn bounds(grid: &Grid, cells: &[u32], reach: usize) -> [usize; 4] {
    let columns = || cells.iter().map(|cell| *cell as usize % grid.width);
    let rows = || cells.iter().map(|cell| *cell as usize / grid.width);
    let low = |least: Option<usize>| least.unwrap_or(0).saturating_sub(reach);
    let high = |most: Option<usize>| most.unwrap_or(0) + reach;
    [low(columns().min()), high(columns().max()), low(rows().min()), high(rows().max())]
}

/// What makes a cell easier or harder to walk on than the map says.
struct Field<'a> {
    /// What walks on each cell, kg a year.
    load: Vec<f32>,
    uneven: Unevenness,
    grid: &'a Grid,
    bending: &'a Bending,
}

/// The cheapest course within reach of the present one.
fn relaid(route: &Route, ground: &Ground, field: &Field, run: &Run) -> Result<Option<Vec<u32>>, Stopped> {
    let bed = Bed::new(route, ground, field);
    let ends = [route.cells.first(), route.cells.last()].map(|cell| bed.band.place(*cell? as usize));
    let [Some(start), Some(goal)] = ends else { return Ok(None) };
    let found = shortest_paths(&bed, Quest { sources: &[(start, 0.0)], targets: &[goal] }, run)?;
    let course: Vec<u32> = found.path(&bed, goal).iter().map(|place| bed.band.cells[*place]).collect();
    let step = |a: u32, b: u32| {
        let (a, b) = (a as usize, b as usize);
        let there_and_back = (ground.ways.step_s(route.species, a, b), ground.ways.step_s(route.species, b, a));
        field.eased(route, (a, b), there_and_back) * field.hardship(b)
    };
    Ok((!course.is_empty()).then(|| ground.straight_by(route.species, &course, SLACK, step)))
}

/// The ground on which a route is laid: the band around its first course, as a graph.
struct Bed<'a> {
    route: &'a Route,
    ground: &'a Ground<'a>,
    field: &'a Field<'a>,
    band: Band,
    /// What the unevenness of each cell of the band costs on top, as a factor.
    hardship: Vec<f32>,
}

impl<'a> Bed<'a> {
    fn new(route: &'a Route, ground: &'a Ground<'a>, field: &'a Field<'a>) -> Self {
        let band = Band::around(ground.grid, &route.cells, field.bending.reach_cells);
        let hardship = band.cells.iter().map(|&cell| field.hardship(cell as usize) as f32).collect();
        Self { route, ground, field, band, hardship }
    }
}

impl Network for Bed<'_> {
    fn len(&self) -> usize {
        self.band.cells.len()
    }

    fn edges(&self, node: usize, mut visit: impl FnMut(u16, usize, f32)) {
        let cell = self.band.cells[node] as usize;
        let to = AROUND.map(|(dx, dy)| self.ground.grid.offset(cell, dx, dy));
        let steps = self.ground.ways.steps_s(self.route.species, cell, &to);
        for (mark, (next, seconds)) in to.into_iter().zip(steps).enumerate() {
            let Some((next, place)) = next.and_then(|next| Some((next, self.band.place(next)?))) else { continue };
            let eased = self.field.eased(self.route, (cell, next), seconds);
            if eased.is_finite() {
                visit(mark as u16, place, eased as f32 * self.hardship[place]);
            }
        }
    }

    fn origin(&self, node: usize, mark: u16) -> usize {
        let (dx, dy) = AROUND[usize::from(mark)];
        let before = self.ground.grid.offset(self.band.cells[node] as usize, -dx, -dy);
        before.and_then(|cell| self.band.place(cell)).unwrap_or(node)
    }

    fn cheap_edge(&self) -> f32 {
        let seconds = self.ground.seconds(self.route.species, &self.route.cells);
        (0.5 * seconds / self.route.cells.len() as f64 * (1.0 - self.field.bending.attraction)) as f32
    }
}

impl Field<'_> {
    /// What a step that takes so many seconds there and back costs on level ground; the mean of
    /// the two where the route is walked in both directions.
    fn eased(&self, route: &Route, (a, b): (usize, usize), (there, back): (f64, f64)) -> f64 {
        let seconds = if route.both_ways { 0.5 * (there + back) } else { there };
        let trodden = f64::from(self.load[a].min(self.load[b]));
        seconds * (1.0 - self.bending.attraction * trodden / (trodden + route.kg))
    }

    /// What the unevenness of a cell costs on top, as a factor.
    fn hardship(&self, cell: usize) -> f64 {
        1.0 + self.bending.roughness * self.uneven.at(self.grid.cell(cell))
    }
}

/// The cells within a number of rows and columns of a route, numbered row by row: a search in
/// there needs memory for the band only.
struct Band {
    width: usize,
    first_row: usize,
    /// Per row: (first column, end column, number of the first cell), ascending, disjoint.
    rows: Vec<Vec<(u32, u32, u32)>>,
    /// The cell of each number.
    cells: Vec<u32>,
}

impl Band {
    fn around(grid: &Grid, cells: &[u32], reach: usize) -> Self {
        let row_of = |cell: &u32| *cell as usize / grid.width;
        let low = cells.iter().map(row_of).min().unwrap_or(0).saturating_sub(reach);
        let high = (cells.iter().map(row_of).max().unwrap_or(0) + reach).min(grid.height - 1);
        let mut spans: Vec<Vec<(u32, u32)>> = vec![Vec::new(); high - low + 1];
        for run in cells.chunk_by(|a, b| row_of(a) == row_of(b)) {
            let columns = || run.iter().map(|cell| *cell as usize % grid.width);
            let first = columns().min().unwrap_or(0).saturating_sub(reach);
            let end = (columns().max().unwrap_or(0) + reach + 1).min(grid.width);
            let row = row_of(&run[0]);
            for near in row.saturating_sub(reach)..=(row + reach).min(high) {
                spans[near - low].push((first as u32, end as u32));
            }
        }
        let mut cells = Vec::new();
        let number = |(row, spans)| numbered(grid, low + row, merged(spans), &mut cells);
        let rows = spans.into_iter().enumerate().map(number).collect();
        Self { width: grid.width, first_row: low, rows, cells }
    }

    /// The number of a cell of the terrain in the band.
    fn place(&self, cell: usize) -> Option<usize> {
        let (row, column) = (cell / self.width, (cell % self.width) as u32);
        let spans = self.rows.get(row.checked_sub(self.first_row)?)?;
        let (first, _, number) = spans.iter().find(|(first, end, _)| (*first..*end).contains(&column))?;
        Some((number + column - first) as usize)
    }
}

fn merged(mut spans: Vec<(u32, u32)>) -> Vec<(u32, u32)> {
    spans.sort_unstable();
    let mut all: Vec<(u32, u32)> = Vec::new();
    for (first, end) in spans {
        match all.last_mut() {
            Some(last) if first <= last.1 => last.1 = last.1.max(end),
            _ => all.push((first, end)),
        }
    }
    all
}

fn numbered(grid: &Grid, row: usize, spans: Vec<(u32, u32)>, cells: &mut Vec<u32>) -> Vec<(u32, u32, u32)> {
    let mut number = |(first, end): (u32, u32)| {
        let start = cells.len() as u32;
        cells.extend((first..end).map(|column| grid.index(column as usize, row) as u32));
        (first, end, start)
    };
    spans.into_iter().map(&mut number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::ecosystem::ways::Ways;
    use crate::compute::ecosystem::ways::sample::Plain;

    fn route(grid: &Grid, row: usize, kg: f64) -> Route {
        let cells = (0..grid.width).map(|column| grid.index(column, row) as u32).collect();
        Route { species: 0, cells, kg, both_ways: true }
    }

    fn straight() -> Bending {
        Bending { attraction: 0.5, roughness: 0.0, reach_cells: 4, seed: 1 }
    }

    #[test]
    fn the_band_holds_each_cell_within_reach_once() {
        let grid = Grid::new(30, 20, 1.0);
        let cells: Vec<u32> = [(5, 3), (6, 4), (7, 5), (8, 5), (8, 4)].map(|(c, r)| grid.index(c, r) as u32).into();
        let band = Band::around(&grid, &cells, 2);
        let near = |cell: usize| {
            let at = grid.cell(cell);
            cells.iter().any(|&c| {
                let b = grid.cell(c as usize);
                at.column.abs_diff(b.column) <= 2 && at.row.abs_diff(b.row) <= 2
            })
        };
        let mut places: Vec<usize> = (0..grid.len()).filter_map(|cell| band.place(cell)).collect();
        assert!((0..grid.len()).all(|cell| !near(cell) || band.place(cell).is_some()));
        places.sort_unstable();
        assert_eq!(places, (0..band.cells.len()).collect::<Vec<_>>());
    }

    #[test]
    fn a_light_route_joins_a_heavy_one_and_not_the_other_way_round() {
        let plain = Plain::new(60, 12, 1.0);
        let ground = Ground { grid: &plain.grid, ways: &plain };
        let mut routes = [route(&plain.grid, 4, 100.0), route(&plain.grid, 6, 1.0)];
        bundle(&mut routes, &ground, &straight(), &Run::silent()).unwrap();
        assert_eq!(routes[0].cells, route(&plain.grid, 4, 0.0).cells);
        let shared = routes[1].cells.iter().filter(|cell| routes[0].cells.contains(cell)).count();
        assert!(shared > 50, "{shared}");
    }

    #[test]
    fn routes_out_of_reach_of_each_other_stay_apart() {
        let plain = Plain::new(40, 30, 1.0);
        let ground = Ground { grid: &plain.grid, ways: &plain };
        let mut routes = [route(&plain.grid, 4, 100.0), route(&plain.grid, 20, 1.0)];
        let before = routes.clone();
        bundle(&mut routes, &ground, &straight(), &Run::silent()).unwrap();
        assert_eq!(routes, before);
    }

    #[test]
    fn routes_are_laid_after_all_heavier_ones_that_could_come_near() {
        let grid = Grid::new(60, 60, 1.0);
        let routes = [route(&grid, 5, 9.0), route(&grid, 30, 8.0), route(&grid, 12, 7.0), route(&grid, 20, 6.0)];
        assert_eq!(turns(&routes, &grid, 4), [vec![0, 1], vec![2], vec![3]]);
        assert_eq!(turns(&routes, &grid, 3), [vec![0, 1, 2, 3]]);
        assert!(turns(&[], &grid, 3).is_empty());
    }

    #[test]
    fn a_relaid_route_still_crosses_the_river_at_the_ford() {
        let plain = Plain::new(40, 30, 1.0).with_river(20, 15);
        let ground = Ground { grid: &plain.grid, ways: &plain };
        let target = [plain.grid.index(35, 15)];
        let way = plain.ways(0, plain.grid.index(3, 12), &target, &Run::silent()).unwrap().remove(0).unwrap();
        let mut routes = [Route { species: 0, cells: way.cells, kg: 1.0, both_ways: true }];
        let rough = Bending { roughness: 1.0, ..straight() };
        bundle(&mut routes, &ground, &rough, &Run::silent()).unwrap();
        assert!(routes[0].cells.contains(&(plain.grid.index(20, 15) as u32)));
        assert!(ground.seconds(0, &routes[0].cells).is_finite());
    }
}
