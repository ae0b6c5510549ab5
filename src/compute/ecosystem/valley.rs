//! A **synthetic valley** of any size: the terrain of the close-up example and of the benchmarks.
//!
//! A meandering river runs from west to east through its flood plain. To the north a gentle
//! talus leads to a cliff that only climbers pass, and above it lies a plateau; a ramp in the
//! west and a flight of way-points in the east lead up. To the south the ground rises to rounded
//! hills cut by side gullies. The river is too deep to wade but for one ford.
//!
//! The shapes scale with the shorter side of the map, slopes and depths do not, so that a valley
//! of 390 and one of 4,096 cells look alike. All of it is ours; there is no source to cite.

use crate::compute::geometry::Point;
use crate::compute::random;
use crate::compute::random::Purpose;
use crate::compute::raster::Grid;
use crate::compute::raster::Raster;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Slope of the cliff, rise over run: 39°, between what walkers descend (31.6°) and what
/// climbers climb (45°).
pub const CLIFF_SLOPE: f64 = 0.8;
/// Slope of the ramp through the cliff: 16°.
pub const RAMP_SLOPE: f64 = 0.28;
/// Depth of the water in the middle of the river, metres: too deep for all animals of the sample.
pub const RIVER_DEPTH_M: f64 = 1.8;
/// Depth in the middle of the ford, metres: shallow enough for all of them.
pub const FORD_DEPTH_M: f64 = 0.25;
/// Fall of the river from west to east, rise over run.
const RIVER_SLOPE: f64 = 0.004;
/// Height of the river where it leaves the map, metres.
const OUTLET_M: f64 = 100.0;
/// Slope at the foot of the southern hills.
const HILL_SLOPE: f64 = 0.4;
/// Slope of the talus below the cliff.
const TALUS_SLOPE: f64 = 0.2;

const NOISE: Purpose = Purpose::new("valley.noise");
const BEND: Purpose = Purpose::new("valley.bend");

/// Which valley.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ValleyOptions {
    /// Columns, at least 64.
    pub width: usize,
    /// Rows, at least 64.
    pub height: usize,
    /// Side of a cell, metres.
    pub cell_m: f64,
    /// Seed of the bends and of the roughness.
    pub seed: u64,
}

impl Default for ValleyOptions {
    /// 512 × 512 cells of 1 m.
    fn default() -> Self {
        Self { width: 512, height: 512, cell_m: 1.0, seed: 0 }
    }
}

/// A valley.
#[derive(Debug, Clone, PartialEq)]
pub struct Valley {
    /// Height of the ground, or of the surface of the water, metres.
    pub height: Raster<f32>,
    /// Depth of the water, metres; 0 where dry.
    pub water_depth_m: Raster<f32>,
    /// The middle of the ford.
    pub ford: Point,
    /// A place in the middle of the plateau.
    pub plateau: Point,
    /// A place on the flood plain south of the river.
    pub meadow: Point,
    /// A place halfway up the cliff, away from the ramp.
    pub cliff: Point,
    /// The middle of the ramp.
    pub ramp: Point,
    /// Places up the cliff, from its foot to its top, two cells apart or less: taken as
    /// way-points they let walkers up.
    pub way_points: Vec<Point>,
}

impl Valley {
    /// Makes the valley. The same options give the same bytes on any number of threads.
    ///
    /// Sizes below 64 cells and cells that are not positive are raised to 64 and 1 m.
    pub fn generate(options: &ValleyOptions) -> Self {
        let shape = Shape::new(options);
        let columns: Vec<Section> = (0..shape.grid.width).map(|i| shape.section(shape.grid.centre(i).x)).collect();
        let rows: Vec<Vec<(f32, f32)>> = (0..shape.grid.height)
            .into_par_iter()
            .map(|row| {
                let y = shape.grid.centre(row * shape.grid.width).y;
                columns.iter().map(|section| shape.at(section, y)).collect()
            })
            .collect();
        let (height, depth) = rows.into_iter().flatten().unzip();
        Self {
            height: Raster { grid: shape.grid, data: height },
            water_depth_m: Raster { grid: shape.grid, data: depth },
            ford: shape.on_river(shape.ford_x()),
            plateau: shape.north_of_cliff(0.5, 2.2 * shape.cliff_run()),
            meadow: shape.on_river(0.3 * shape.width) - Point::new(0.0, 0.05 * shape.unit),
            cliff: shape.north_of_cliff(0.55, 0.5 * shape.cliff_run()),
            ramp: shape.north_of_cliff(RAMP_AT, 0.5 * shape.cliff_height() / RAMP_SLOPE),
            way_points: shape.way_points(),
        }
    }
}

/// Where the ramp and the way-points lead up, as shares of the width.
const RAMP_AT: f64 = 0.14;
const STEPS_AT: f64 = 0.8;

/// How much of the river's bends the sides of the valley follow.
const FOLLOWED: f64 = 0.35;

/// The measures of one valley, in metres.
struct Shape {
    grid: Grid,
    seed: u64,
    width: f64,
    /// The shorter side: what shapes scale with.
    unit: f64,
    /// Half the width of the river.
    half: f64,
    phases: [f64; 3],
}

/// What is the same all along a north-south line.
struct Section {
    x: f64,
    river: Line,
    middle: Line,
    /// Height of the surface of the river.
    level: f64,
    /// Depth of the river in its middle.
    deepest: f64,
    /// Slope of the cliff, or of the ramp.
    climb: f64,
}

/// A line that runs from west to east, near one x.
struct Line {
    y: f64,
    /// Cosine of its angle with the east.
    cosine: f64,
}

impl Line {
    /// Distance of y north of it, to first order.
    fn beside(&self, y: f64) -> f64 {
        (y - self.y) * self.cosine
    }
}

impl Shape {
    fn new(options: &ValleyOptions) -> Self {
        let cell_m = if options.cell_m > 0.0 { options.cell_m } else { 1.0 };
        let grid = Grid::new(options.width.max(64), options.height.max(64), cell_m);
        let unit = grid.width.min(grid.height) as f64 * cell_m;
        let phase = |i| TAU * random::unit(random::hash(options.seed, BEND, i));
        Self {
            grid,
            seed: options.seed,
            width: grid.width as f64 * cell_m,
            unit,
            half: (unit / 110.0).max(1.6 * cell_m),
            phases: [phase(0), phase(1), phase(2)],
        }
    }

    fn section(&self, x: f64) -> Section {
        let from_ford = (x - self.ford_x()) / (3.0 * self.half);
        let from_ramp = (x / self.width - RAMP_AT) / 0.09;
        Section {
            x,
            river: self.line(x, 1.0),
            middle: self.line(x, FOLLOWED),
            level: OUTLET_M + RIVER_SLOPE * (self.width - x),
            deepest: RIVER_DEPTH_M + (FORD_DEPTH_M - RIVER_DEPTH_M) * libm::exp(-libm::pow(from_ford, 4.0)),
            climb: CLIFF_SLOPE + (RAMP_SLOPE - CLIFF_SLOPE) * libm::exp(-libm::pow(from_ramp, 4.0)),
        }
    }

    /// The middle of the river's bends, or of a damped copy of them.
    fn line(&self, x: f64, share: f64) -> Line {
        const WAVES: [(f64, f64); 3] = [(0.75, 0.045), (0.41, 0.022), (0.23, 0.006)];
        let (bend, slope) = WAVES.iter().zip(self.phases).fold((0.0, 0.0), |(y, slope), ((length, size), phase)| {
            let k = TAU / (length * self.unit);
            let a = size * self.unit * share;
            (y + a * libm::sin(k * x + phase), slope + a * k * libm::cos(k * x + phase))
        });
        let middle = 0.4 * self.grid.height as f64 * self.grid.cell_m;
        Line { y: middle + bend, cosine: 1.0 / (1.0 + slope * slope).sqrt() }
    }

    /// Height of the ground or the water, and depth of the water.
    fn at(&self, section: &Section, y: f64) -> (f32, f32) {
        let river = section.river.beside(y);
        let dry = (river.abs() - self.half).max(0.0);
        let bank = 0.4 * (1.0 - libm::exp(-dry / (0.5 * self.half))) + 0.015 * dry.min(0.1 * self.unit);
        let d = section.middle.beside(y);
        let relief = self.north(section, d) + self.south(section, -d);
        let rough = self.roughness(section.x, y, d) * (dry / (4.0 * self.half)).min(1.0);
        ((section.level + bank + relief + rough) as f32, self.depth(section, river) as f32)
    }

    fn on_river(&self, x: f64) -> Point {
        Point::new(x, self.line(x, 1.0).y)
    }

    fn ford_x(&self) -> f64 {
        0.55 * self.width
    }

    /// Depth of the water at `d` metres beside the middle of the river: a bed with steep banks.
    fn depth(&self, section: &Section, d: f64) -> f64 {
        let across = d.abs() / self.half;
        if across < 1.0 { section.deepest * (1.0 - across.powi(6)).max(0.05) } else { 0.0 }
    }

    fn cliff_height(&self) -> f64 {
        0.07 * self.unit
    }

    fn cliff_run(&self) -> f64 {
        self.cliff_height() / CLIFF_SLOPE
    }

    /// Distance from the middle line to the foot of the talus, and on to that of the cliff.
    fn margins(&self) -> (f64, f64) {
        (0.09 * self.unit, 0.15 * self.unit)
    }

    /// The place `d` metres north of the foot of the cliff, at a share of the width.
    fn north_of_cliff(&self, share: f64, d: f64) -> Point {
        let x = share * self.width;
        let middle = self.line(x, FOLLOWED);
        Point::new(x, middle.y + (self.margins().1 + d) / middle.cosine)
    }

    /// Talus, cliff or ramp, plateau, at `d` metres north of the middle line.
    fn north(&self, section: &Section, d: f64) -> f64 {
        let (talus, foot) = self.margins();
        let run = self.cliff_height() / section.climb;
        let lower = TALUS_SLOPE * (d - talus).clamp(0.0, foot - talus);
        let upper = section.climb * (d - foot).clamp(0.0, run);
        lower + upper + 0.01 * (d - foot - run).max(0.0)
    }

    /// Rounded hills with gullies that deepen as they rise, at `d` metres south of the middle
    /// line.
    fn south(&self, section: &Section, d: f64) -> f64 {
        let d = d - self.margins().0;
        if d <= 0.0 {
            return 0.0;
        }
        let most = 0.16 * self.unit;
        let hill = most * (1.0 - libm::exp(-HILL_SLOPE * d / most));
        let lean = 0.15 * d + 0.03 * self.unit * libm::sin(d / (0.06 * self.unit));
        let wave = libm::cos(TAU * (section.x + lean) / (0.27 * self.unit) + self.phases[1]);
        let gully = (0.5 + 0.5 * wave).powi(3) * (d / (0.12 * self.unit)).min(1.0);
        hill * (1.0 - 0.28 * gully)
    }

    /// Gentle roughness, none on the cliff, little on the plateau; `d` metres north of the
    /// middle line.
    fn roughness(&self, x: f64, y: f64, d: f64) -> f64 {
        let foot = self.margins().1;
        let calm = if d < foot { 1.0 - (d / foot).clamp(0.0, 1.0) } else { 0.0 };
        let plateau = ((d - foot - 2.0 * self.cliff_run()) / (0.1 * self.unit)).clamp(0.0, 1.0);
        let strength = calm.max(0.35 * plateau);
        if strength == 0.0 {
            return 0.0;
        }
        const OCTAVES: [(f64, f64); 3] = [(8.0, 1.0), (17.0, 0.45), (37.0, 0.2)];
        let octave = |(i, (n, a)): (usize, &(f64, f64))| a * self.noise(x * n / self.unit, y * n / self.unit, i as u64);
        0.0022 * self.unit * strength * OCTAVES.iter().enumerate().map(octave).sum::<f64>()
    }

    /// Smooth value noise in −1..1 with a knot at every whole (u, v).
    fn noise(&self, u: f64, v: f64, octave: u64) -> f64 {
        let (column, row) = (u.floor(), v.floor());
        let smooth = |t: f64| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
        let (fu, fv) = (smooth(u - column), smooth(v - row));
        let knot = |dx: u64, dy: u64| {
            let at = octave << 60 | (column as u64 + dx) << 30 | (row as u64 + dy);
            2.0 * random::unit(random::hash(self.seed, NOISE, at)) - 1.0
        };
        let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
        mix(mix(knot(0, 0), knot(1, 0), fu), mix(knot(0, 1), knot(1, 1), fu), fv)
    }

    fn way_points(&self) -> Vec<Point> {
        let (from, to) = (-2.0 * self.grid.cell_m, self.cliff_run() + 2.0 * self.grid.cell_m);
        let n = ((to - from) / (1.5 * self.grid.cell_m)).ceil() as usize;
        (0..=n).map(|i| self.north_of_cliff(STEPS_AT, from + (to - from) * i as f64 / n as f64)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rise over run at a cell by central differences.
    fn slope(height: &Raster<f32>, p: Point) -> f64 {
        let cell = height.grid.cell_m;
        let at = |dx: f64, dy: f64| f64::from(height.at(p + Point::new(dx * cell, dy * cell)).unwrap());
        (at(1.0, 0.0) - at(-1.0, 0.0)).hypot(at(0.0, 1.0) - at(0.0, -1.0)) / (2.0 * cell)
    }

    fn valleys() -> Vec<Valley> {
        let sizes = [(256, 256, 2.0, 0), (128, 128, 30.0, 1), (190, 150, 5.0, 2), (100, 200, 2.0, 3)];
        sizes
            .map(|(width, height, cell_m, seed)| Valley::generate(&ValleyOptions { width, height, cell_m, seed }))
            .into()
    }

    /// Whether the ground is nowhere steeper than `limit` in a cell, cell by cell.
    fn gentle(height: &Raster<f32>, limit: f64) -> Vec<bool> {
        let grid = height.grid;
        let inner = |i: usize| {
            let c = grid.cell(i);
            c.column > 0 && c.row > 0 && c.column + 1 < grid.width && c.row + 1 < grid.height
        };
        (0..grid.len()).map(|i| inner(i) && slope(height, grid.centre(i)) <= limit).collect()
    }

    /// The cells that can be reached from `start` through cells that `open` lets pass.
    fn reached(grid: Grid, start: Vec<usize>, open: impl Fn(usize, usize) -> bool) -> Vec<bool> {
        let mut seen = vec![false; grid.len()];
        let mut next = start;
        while let Some(i) = next.pop() {
            if std::mem::replace(&mut seen[i], true) {
                continue;
            }
            next.extend(grid.neighbours(i).map(|(j, _)| j).filter(|j| !seen[*j] && open(i, *j)));
        }
        seen
    }

    #[test]
    fn the_river_runs_unbroken_from_west_to_east_and_falls_all_the_way() {
        for v in valleys() {
            let grid = v.height.grid;
            let wet = |i: usize| v.water_depth_m.data[i] > 0.0;
            let west: Vec<usize> = (0..grid.height).map(|r| grid.index(0, r)).filter(|i| wet(*i)).collect();
            let seen = reached(grid, west, |_, j| wet(j));
            assert!((0..grid.height).any(|r| seen[grid.index(grid.width - 1, r)]));
            assert_eq!((0..grid.len()).filter(|i| wet(*i)).count(), seen.iter().filter(|s| **s).count());
            let level = |c: usize| {
                (0..grid.height)
                    .map(|r| grid.index(c, r))
                    .filter(|i| wet(*i))
                    .map(|i| v.height.data[i])
                    .fold(f32::MIN, f32::max)
            };
            assert!((1..grid.width).all(|c| level(c) < level(c - 1)));
        }
    }

    #[test]
    fn the_ford_is_shallow_and_all_other_crossings_are_deep() {
        for v in valleys() {
            let grid = v.height.grid;
            assert!(f64::from(v.water_depth_m.at(v.ford).unwrap()) <= FORD_DEPTH_M + 0.02);
            // Cells waded through at half a metre part north from south but at the ford.
            let wade = |deep: f64, blocked: bool| {
                let south = grid.at(v.meadow).unwrap();
                let near_ford = |i: usize| (grid.centre(i).x - v.ford.x).abs() < 0.1 * grid.width as f64 * grid.cell_m;
                let open = |_: usize, j: usize| {
                    f64::from(v.water_depth_m.data[j]) <= deep
                        && !(blocked && near_ford(j) && v.water_depth_m.data[j] > 0.0)
                };
                reached(grid, vec![south], open)[grid.at(v.plateau).unwrap()]
            };
            assert!(wade(0.35, false) && !wade(0.35, true) && !wade(0.9, true));
        }
    }

    #[test]
    fn only_climbers_pass_the_cliff_but_walkers_have_the_ramp() {
        for v in valleys() {
            let grid = v.height.grid;
            let found = slope(&v.height, v.cliff);
            assert!((0.65..1.0).contains(&found), "{found}");
            let foot = grid.at(v.way_points[0]).unwrap();
            let climbs = |limit: f64, ramp: bool| {
                let gentle = gentle(&v.height, limit);
                let away = |i: usize| grid.centre(i).x > 0.4 * grid.width as f64 * grid.cell_m;
                let open = |_: usize, j: usize| gentle[j] && (ramp || away(j));
                reached(grid, vec![foot], open)[grid.at(v.plateau).unwrap()]
            };
            assert!(climbs(0.615, true) && !climbs(0.615, false) && climbs(1.0, false));
            assert!(slope(&v.height, v.ramp) < 0.35);
        }
    }

    #[test]
    fn the_plateau_is_flat_and_the_hills_rise_above_the_meadow() {
        for v in valleys() {
            let grid = v.height.grid;
            let unit = grid.width.min(grid.height) as f64 * grid.cell_m;
            let flat = gentle(&v.height, 0.12);
            let near = (0..grid.len()).filter(|i| grid.centre(*i).distance(v.plateau) < 0.08 * unit);
            assert!(near.into_iter().all(|i| flat[i]));
            let south: f32 = (0..grid.width).map(|c| v.height.get(c, grid.height - 1)).sum::<f32>() / grid.width as f32;
            let meadow = v.height.at(v.meadow).unwrap();
            assert!(
                f64::from(south - meadow) > 0.05 * unit
                    && f64::from(v.height.at(v.plateau).unwrap() - meadow) > 0.05 * unit
            );
            assert_eq!(v.water_depth_m.at(v.meadow), Some(0.0));
        }
    }

    #[test]
    fn way_points_lead_up_the_cliff_without_a_gap() {
        for v in valleys() {
            let cell = v.height.grid.cell_m;
            assert!(v.way_points.windows(2).all(|w| w[0].distance(w[1]) <= 2.0 * cell));
            let ends = [v.way_points[0], v.way_points[v.way_points.len() - 1]].map(|p| v.height.at(p).unwrap());
            let rise = f64::from(ends[1] - ends[0]) / (cell * v.height.grid.width.min(v.height.grid.height) as f64);
            assert!(rise > 0.06, "{rise}");
        }
    }

    #[test]
    fn the_same_options_give_the_same_bytes_and_another_seed_another_valley() {
        let options = ValleyOptions { width: 96, height: 80, ..ValleyOptions::default() };
        let on = |n, o: ValleyOptions| {
            rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap().install(|| Valley::generate(&o))
        };
        assert_eq!(on(1, options), on(2, options));
        assert_ne!(on(1, options), on(1, ValleyOptions { seed: 1, ..options }));
        assert!(on(2, options).height.data.iter().all(|h| h.is_finite()));
    }
}
