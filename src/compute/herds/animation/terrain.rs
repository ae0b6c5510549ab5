use super::AnimationError;
use super::frames;
use super::frames::KeyFrame;
use crate::compute::geometry::Bounds;
use crate::compute::geometry::Point;
use crate::compute::herds::Clearance;
use crate::compute::herds::Obstacles;
use crate::compute::raster::Grid;
use crate::compute::raster::Raster;
use crate::compute::run::Run;

/// The most cells of the clearance map.
const MAX_CELLS: f64 = 2e6;

/// The ground the herd walks on.
pub(super) struct Ground<'a> {
    terrain: &'a Raster<f32>,
    obstacles: &'a Obstacles,
    clearance: Clearance,
    probe_m: f64,
}

impl<'a> Ground<'a> {
    /// The ground around the key-frames: their bounds and half as much again on every side, at
    /// most the terrain.
    pub(super) fn new(
        terrain: &'a Raster<f32>,
        obstacles: &'a Obstacles,
        frames: &[KeyFrame],
        run: &Run,
    ) -> Result<Self, AnimationError> {
        let places = frames.iter().flat_map(|f| f.herd().unwrap_or(&[]).iter().map(|e| e.centre).chain([f.centre()]));
        let bounds = Bounds::of(places).unwrap_or(Bounds::new(Point::default(), Point::default()));
        let margin = (0.5 * bounds.width().max(bounds.height())).max(30.0 * frames::width(frames).least_m).max(20.0);
        let grid = working_grid(bounds.grown(margin), terrain.grid, frames::width(frames).least_m);
        let mut closed = obstacles.cover(grid, run)?;
        // Holes in the terrain are obstacles too.
        for (cell, closed) in closed.data.iter_mut().enumerate() {
            *closed |= u8::from(terrain.at(grid.centre(cell)).is_none_or(f32::is_nan));
        }
        let clearance = Clearance::around(&closed, run)?;
        Ok(Self { terrain, obstacles, clearance, probe_m: (0.5 * terrain.grid.cell_m).min(1.0) })
    }

    pub(super) fn clearance(&self) -> &Clearance {
        &self.clearance
    }

    /// Whether an animal may be at `p` after having been at `before`: on the ground, in no
    /// obstacle, and with half a body's room, or no less room than it had.
    pub(super) fn admits(&self, p: Point, before: Point, half_width: f64) -> bool {
        let room = self.clearance.at(p);
        if self.clearance.is_open() {
            return room > 0.0;
        }
        (room >= half_width || room >= self.clearance.at(before)) && !self.obstacles.hold(p) && self.on_ground(p)
    }

    fn on_ground(&self, p: Point) -> bool {
        self.terrain.at(p).is_some_and(|z| !z.is_nan())
    }

    /// Height in metres; 0 off the ground, where no animal comes.
    pub(super) fn height(&self, p: Point) -> f64 {
        self.terrain.sample(p).unwrap_or(0.0)
    }

    /// Metres from `p` to `q` along the ground, if it rises evenly.
    pub(super) fn distance(&self, p: Point, q: Point) -> f64 {
        p.distance(q).hypot(self.height(q) - self.height(p))
    }

    /// Rise over run at `p` along the unit vector `u`.
    pub(super) fn slope(&self, p: Point, u: Point) -> f64 {
        let ahead = self.terrain.sample(p + u * self.probe_m).unwrap_or_else(|| self.height(p));
        (ahead - self.height(p)) / self.probe_m
    }
}

fn working_grid(wanted: Bounds, terrain: Grid, body: f64) -> Grid {
    let Bounds { min, max } = wanted.within(terrain.bounds());
    let (width, height) = ((max.x - min.x).max(1e-3), (max.y - min.y).max(1e-3));
    let cell_m = (0.5 * body).max((width * height / MAX_CELLS).sqrt()).max(width.max(height) / 20_000.0);
    // Whole cells only, so that the map never reaches past the terrain.
    let cells = |extent: f64| (extent / cell_m).floor().max(1.0) as usize;
    Grid { width: cells(width), height: cells(height), cell_m: cell_m.min(width).min(height), origin: min }
}
