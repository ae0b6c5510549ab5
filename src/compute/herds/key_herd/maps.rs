//! The density map and the orientation field on the ground: made from an exemplar or painted.

use super::KeyHerdError;
use super::KeyHerdOptions;
use super::exemplar::Exemplar;
use super::hull;
use super::placement::Placement;
use super::placement::Site;
use crate::compute::geometry::Bounds;
use crate::compute::geometry::Point;
use crate::compute::raster::Grid;
use crate::compute::raster::Raster;
use rayon::prelude::*;

/// Cells of a map per animal along a side, and the bounds of their number (ours): fine enough
/// that a cell holds one orientation.
const CELLS_PER_ANIMAL: f64 = 6.0;
const CELLS: (f64, f64) = (160.0, 600.0);

/// Where the density map comes from.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum DensitySource {
    /// The exemplar's (T 4.2.3).
    #[default]
    Exemplar,
    /// None: even over the domain. "The density map is a completely optional parameter" (T 4.2.5).
    Even,
    /// Painted, on the ground: values ≥ 0, of which only the proportions count; nowhere else is
    /// there an animal. Domain and size of the herd are then those of the map.
    Painted(Raster<f32>),
}

/// What guides the placing of animals on the ground; both maps on one grid.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Maps {
    /// Animals per square metre; the integral is the number of animals.
    pub density: Raster<f32>,
    /// Radians counter-clockwise from east; an animal has the angle of the cell that holds it.
    pub orientation: Raster<f32>,
    /// Corners of the domain, counter-clockwise.
    pub corners: Vec<Point>,
}

/// The maps for `count` animals.
pub(super) fn on_ground(
    exemplar: &Exemplar,
    placement: Placement,
    site: Site<'_>,
    options: &KeyHerdOptions,
) -> Result<Maps, KeyHerdError> {
    let (grid, corners) = match &options.density {
        DensitySource::Painted(map) => (map.grid, painted_domain(map)),
        _ => {
            let corners: Vec<Point> = exemplar.corners.iter().map(|p| placement.to_ground(*p)).collect();
            (grid_over(&corners, options.count), corners)
        }
    };
    let cells: Vec<(f32, Point)> = (0..grid.len())
        .into_par_iter()
        .map(|cell| {
            let p = grid.centre(cell);
            let (heading, density) = exemplar.at(placement.to_exemplar(p));
            let density = match &options.density {
                _ if !site.admits(p, options.body.1) => 0.0,
                DensitySource::Painted(map) => f64::from(map.data[cell]).max(0.0),
                _ if !hull::contains(&corners, p) => 0.0,
                DensitySource::Even => 1.0,
                DensitySource::Exemplar => density,
            };
            (density as f32, placement.turned(heading))
        })
        .collect();
    let field = Raster { grid, data: cells.iter().map(|(_, v)| *v).collect() };
    Ok(Maps {
        density: normalised(Raster { grid, data: cells.into_iter().map(|(d, _)| d).collect() }, options)?,
        orientation: edited(painted_over(field, options.orientation.as_ref()), options),
        corners,
    })
}

/// A grid over a polygon, fine enough for `count` animals.
fn grid_over(corners: &[Point], count: usize) -> Grid {
    let bounds = Bounds::of(corners.iter().copied()).unwrap_or(Bounds::new(Point::default(), Point::default()));
    let across = (CELLS_PER_ANIMAL * (count as f64).sqrt()).clamp(CELLS.0, CELLS.1);
    let cell_m = bounds.width().max(bounds.height()) / across;
    let cells = |extent: f64| (extent / cell_m).ceil().max(1.0) as usize;
    Grid { width: cells(bounds.width()), height: cells(bounds.height()), cell_m, origin: bounds.min }
}

/// The hull of all cells that are painted.
fn painted_domain(map: &Raster<f32>) -> Vec<Point> {
    let half = map.grid.cell_m / 2.0;
    let painted = (0..map.grid.len()).filter(|i| map.data[*i] > 0.0).map(|i| map.grid.centre(i));
    let corners =
        |p: Point| [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| p + Point::new(x, y) * half);
    hull::convex(&painted.flat_map(corners).collect::<Vec<_>>())
}

/// The density with its integral set to the number of animals.
fn normalised(density: Raster<f32>, options: &KeyHerdOptions) -> Result<Raster<f32>, KeyHerdError> {
    let (sum, cells) =
        density.data.iter().fold((0.0, 0usize), |(s, n), d| (s + f64::from(*d), n + usize::from(*d > 0.0)));
    if !(sum.is_finite() && sum > 0.0) {
        return Err(KeyHerdError::NoDensity);
    }
    let area = density.grid.cell_area_m2();
    let body = std::f64::consts::PI * options.body.0 * options.body.1;
    let most = (cells as f64 * area / body) as usize;
    if options.count > most.max(1) {
        return Err(KeyHerdError::NoRoom { wanted: options.count, most });
    }
    let factor = options.count as f64 / (sum * area);
    Ok(density.map(|d| (f64::from(d) * factor) as f32))
}

/// The field with painted angles laid over it, where they are numbers.
fn painted_over(field: Raster<Point>, painted: Option<&Raster<f32>>) -> Raster<Point> {
    let Some(painted) = painted else { return field };
    let at = |i: usize| match painted.at(field.grid.centre(i)) {
        Some(angle) if angle.is_finite() => Point::from_angle(f64::from(angle)),
        _ => field.data[i],
    };
    Raster { grid: field.grid, data: (0..field.data.len()).map(at).collect() }
}

fn edited(field: Raster<Point>, options: &KeyHerdOptions) -> Raster<f32> {
    let edits = (0u64..).zip(&options.orientation_edits);
    edits.fold(field, |field, (index, edit)| edit.apply(&field, (options.seed, index))).map(|v| v.angle() as f32)
}
