//! Synthesis by dart throwing (T Algorithm 2 of chapter 4, H Algorithm 1).

use super::KeyHerdError;
use super::KeyHerdOptions;
use super::maps::Maps;
use super::placement::Site;
use crate::compute::geometry::Bounds;
use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Point;
use crate::compute::geometry::Region;
use crate::compute::herds::contact::Footprint;
use crate::compute::pcf::Curve;
use crate::compute::pcf::EllipseTrial;
use crate::compute::random::Purpose;
use crate::compute::random::Stream;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use rayon::prelude::*;

const DART: Purpose = Purpose::new("key-herd.dart");

/// Darts thrown together at first, and twice as many each time none is good enough; the best of
/// them is looked at (ours: the text looks at each).
const HANDFUL: usize = 8;

/// Darts that a thread throws at least.
const CHUNK: usize = 4;

/// A dart that hits a masked part of a cell is thrown again at most this often.
const RETHROWS: usize = 64;

/// A dart that hits another animal too deep is thrown again at most this often before its error
/// is looked at (ours: the text knows no overlap, and a look for room costs little).
const ROOM_THROWS: usize = 12;

/// A herd as it is laid out.
pub(super) struct Layout {
    pub ellipses: Vec<Ellipse>,
    /// Animals for which no dart lowered the error and the best was taken.
    pub forced: usize,
}

/// What the layout is to look like.
pub(super) struct Target<'a> {
    /// The exemplar's curve, and the domain it is compared in; `None` without a hull.
    pub curve: Option<(&'a Curve, &'a Region)>,
    /// How deep animals may overlap while there is any other place, in metres.
    pub depth_m: f64,
}

/// A place thrown by chance, and what it would do to the layout.
struct Dart {
    ellipse: Ellipse,
    /// Metres by which it overlaps deeper than allowed.
    excess: f64,
    error: f64,
}

/// Where a dart hit the ground.
struct Landing {
    ellipse: Ellipse,
    /// Metres to the nearest animal.
    nearest: f64,
    /// Metres by which it overlaps deeper than allowed.
    excess: f64,
}

impl Landing {
    /// The first throw that lands with room, or the one that lacks least.
    fn with_room(mut throw: impl FnMut() -> Self) -> Self {
        let mut best = throw();
        for _ in 1..ROOM_THROWS {
            if best.excess == 0.0 {
                break;
            }
            let next = throw();
            if next.excess < best.excess {
                best = next;
            }
        }
        best
    }
}

/// Throws darts until all animals have a place: by the density map, angled by the orientation
/// field, accepted when the error of the curve (T eq. 4.3) falls, or the best of `max_fails`.
pub(super) fn throw(
    maps: &Maps,
    target: &Target<'_>,
    site: Site<'_>,
    options: &KeyHerdOptions,
    run: &Run,
) -> Result<Layout, KeyHerdError> {
    let sampler = Sampler::new(&maps.density);
    let mut trial = target.curve.map(|(curve, domain)| EllipseTrial::new(domain, curve, options.body.0));
    let mut crowd = Crowd::new(maps, options.body);
    let mut layout = Layout { ellipses: Vec::with_capacity(options.count), forced: 0 };
    for animal in 0..options.count {
        run.progress("key-herd.darts", animal as u64, options.count as u64)?;
        let now = trial.as_ref().map_or(f64::INFINITY, EllipseTrial::error);
        let aim = |throw: usize| {
            let mut random = Stream::new(options.seed, DART, (animal as u64) << 24 | throw as u64);
            let throw = || {
                let place = sampler.draw(&mut random, |p| site.admits(p, options.body.1));
                let theta = f64::from(maps.orientation.at(place).unwrap_or(0.0));
                let ellipse = Ellipse { centre: place, a: options.body.0, b: options.body.1, theta };
                let (depth, nearest) = crowd.look(&ellipse);
                Landing { ellipse, nearest, excess: (depth - target.depth_m).max(0.0) }
            };
            let Landing { ellipse, nearest, excess } = Landing::with_room(throw);
            let error = match &trial {
                Some(trial) if !trial.is_empty() => trial.error_with(&ellipse),
                // Without a curve the farthest from the others is the best.
                _ => -nearest,
            };
            Dart { ellipse, excess, error }
        };
        let mut best: Option<Dart> = None;
        let mut accepted = false;
        let (mut first, mut size) = (0, HANDFUL);
        while first < options.max_fails {
            let next = (first + size).min(options.max_fails);
            let handful: Vec<Dart> = (first..next).into_par_iter().with_min_len(CHUNK).map(aim).collect();
            (first, size) = (next, 2 * size);
            best = handful
                .into_iter()
                .chain(best)
                .min_by(|a, b| a.key().partial_cmp(&b.key()).unwrap_or(std::cmp::Ordering::Equal));
            accepted = best.as_ref().is_some_and(|d| d.excess == 0.0 && (d.error < now || trial.is_none()));
            if accepted {
                break;
            }
        }
        layout.forced += usize::from(!accepted);
        if let Some(dart) = best {
            if let Some(trial) = &mut trial {
                trial.place(&dart.ellipse);
            }
            crowd.add(&dart.ellipse);
            layout.ellipses.push(dart.ellipse);
        }
    }
    Ok(layout)
}

impl Dart {
    fn key(&self) -> (f64, f64) {
        (self.excess, self.error)
    }
}

/// Draws places by a density map: running sums of each column, then of the columns (T 4.2.4).
struct Sampler<'a> {
    map: &'a Raster<f32>,
    /// Sums of the columns up to and with each.
    columns: Vec<f64>,
    /// Sums within each column from the north, column by column.
    cells: Vec<f64>,
}

impl<'a> Sampler<'a> {
    fn new(map: &'a Raster<f32>) -> Self {
        let (width, height) = (map.grid.width, map.grid.height);
        let (mut cells, mut columns) = (Vec::with_capacity(width * height), Vec::with_capacity(width));
        let mut all = 0.0;
        for column in 0..width {
            let mut sum = 0.0;
            for row in 0..height {
                sum += f64::from(map.get(column, row));
                cells.push(sum);
            }
            all += sum;
            columns.push(all);
        }
        Self { map, columns, cells }
    }

    /// A place by the density, evenly within its cell, where the site `admits` an animal.
    fn draw(&self, random: &mut Stream, admits: impl Fn(Point) -> bool) -> Point {
        let mut place = Point::default();
        for _ in 0..RETHROWS {
            place = self.throw(random);
            if admits(place) {
                return place;
            }
        }
        // The centre of a cell with density is always admitted.
        self.map.grid.at(place).map_or(place, |cell| self.map.grid.centre(cell))
    }

    fn throw(&self, random: &mut Stream) -> Point {
        let grid = self.map.grid;
        let find = |sums: &[f64], share: f64| {
            let goal = share * sums[sums.len() - 1];
            sums.partition_point(|s| *s <= goal).min(sums.len() - 1)
        };
        let column = find(&self.columns, random.unit());
        let row = find(&self.cells[column * grid.height..(column + 1) * grid.height], random.unit());
        let within = Point::new(random.unit() - 0.5, random.unit() - 0.5) * (grid.cell_m * (1.0 - 1e-9));
        grid.centre(grid.index(column, row)) + within
    }
}

/// The animals placed so far, by place.
struct Crowd {
    bounds: Bounds,
    cell: f64,
    columns: usize,
    cells: Vec<Vec<u32>>,
    prints: Vec<Footprint>,
}

impl Crowd {
    fn new(maps: &Maps, body: (f64, f64)) -> Self {
        let bounds =
            Bounds::of(maps.corners.iter().copied()).unwrap_or(Bounds::new(Point::default(), Point::default()));
        let cell = (2.0 * body.0).max(bounds.width().max(bounds.height()) / 1000.0);
        let (columns, rows) = ((bounds.width() / cell) as usize + 1, (bounds.height() / cell) as usize + 1);
        Self { bounds, cell, columns, cells: vec![Vec::new(); columns * rows], prints: Vec::new() }
    }

    fn place(&self, p: Point) -> (usize, usize) {
        let rows = self.cells.len() / self.columns;
        let at = |d: f64, most: usize| ((d / self.cell).max(0.0) as usize).min(most - 1);
        (at(p.x - self.bounds.min.x, self.columns), at(p.y - self.bounds.min.y, rows))
    }

    /// How deep `ellipse` would overlap another, and how far away the nearest centre is.
    fn look(&self, ellipse: &Ellipse) -> (f64, f64) {
        let print = Footprint::new(ellipse);
        let (mut depth, mut nearest) = (0f64, f64::INFINITY);
        let (column, row) = self.place(ellipse.centre);
        for r in row.saturating_sub(1)..=(row + 1).min(self.cells.len() / self.columns - 1) {
            for c in column.saturating_sub(1)..=(column + 1).min(self.columns - 1) {
                for other in &self.cells[r * self.columns + c] {
                    let other = &self.prints[*other as usize];
                    depth = depth.max(print.depth(other));
                    nearest = nearest.min(other.centre().distance(ellipse.centre));
                }
            }
        }
        if nearest.is_infinite() {
            nearest = self.prints.iter().map(|p| p.centre().distance(ellipse.centre)).fold(1e9, f64::min);
        }
        (depth, nearest)
    }

    fn add(&mut self, ellipse: &Ellipse) {
        let (column, row) = self.place(ellipse.centre);
        self.cells[row * self.columns + column].push(self.prints.len() as u32);
        self.prints.push(Footprint::new(ellipse));
    }
}
