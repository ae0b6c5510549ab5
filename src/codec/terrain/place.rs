use super::TerrainOptions;
use super::projection;
use super::projection::Projection;
use crate::codec::map::Georeference;
use crate::codec::sheet::Affine;
use crate::codec::sheet::Coding;
use crate::codec::sheet::RasterError;
use crate::codec::sheet::Sheet;
use crate::codec::sheet::SourceCrs;
use crate::codec::warning;
use crate::codec::warning::Warning;
use crate::compute::geometry::Bounds;
use crate::compute::geometry::Point;
use crate::compute::raster::Grid;

/// Data in degrees goes by the name of its spacing at 30 m a second of arc ("90 m" for 3″):
/// cells are projected to that size.
const METRES_A_SECOND: f64 = 30.0;
/// Relative difference of the two sides of a cell that still counts as square.
const SQUARE: f64 = 1e-5;
/// A spacing below this within ±180° by ±90° is taken for degrees where nothing is named.
const DEGREES_BELOW: f64 = 0.05;

/// How the file's cells become square cells in metres.
pub(super) struct Placing {
    /// The square cells.
    pub grid: Grid,
    /// From the grid to the file.
    pub way: Way,
    /// On what the grid lies.
    pub georeference: Georeference,
    /// Latitude of the middle, degrees.
    pub latitude_deg: Option<f64>,
    /// What should be known.
    pub warnings: Vec<Warning>,
}

/// From the cells of the grid to the cells of the file.
pub(super) enum Way {
    /// The same cells, turned with the first row north.
    Turned,
    /// Resampled from cells that lie so in the file's coordinates, through a projection if there
    /// is one.
    Resampled(Affine, Option<Box<Projection>>),
}

impl Placing {
    pub(super) fn of(sheet: &Sheet, options: &TerrainOptions) -> Result<Self, RasterError> {
        if let Some(cell_m) = options.cell_m.filter(|c| !(c.is_finite() && *c > 0.0)) {
            return Err(RasterError::BadCellSize { cell_m });
        }
        let affine = match (sheet.place, options.cell_m) {
            (Some(affine), _) => checked(affine)?,
            (None, Some(cell)) => Affine { x0: 0.0, a: cell, b: 0.0, y0: sheet.height as f64 * cell, d: 0.0, e: -cell },
            (None, None) => return Err(RasterError::NoCellSize { format: sheet.format }),
        };
        let crs = named(sheet, &affine, options)?;
        let mut placing = match crs {
            SourceCrs::Geographic(code) => geographic(sheet, affine, code, options)?,
            SourceCrs::Projected(Some(code), _) if projection::is_web_mercator(code) => {
                mercator(sheet, affine, code, options)?
            }
            crs => planar(sheet, affine, &crs, options)?,
        };
        placing.note_ignored(sheet, options);
        check_cells(&placing.grid, options.max_cells)?;
        Ok(placing)
    }

    /// What was projected to, for people.
    fn said(&self) -> String {
        let zone = self.georeference.code().unwrap_or_default();
        format!("EPSG:{zone} at square cells of {} m", self.grid.cell_m)
    }

    fn note_ignored(&mut self, sheet: &Sheet, options: &TerrainOptions) {
        let (Some(asked), Some(_)) = (options.cell_m, sheet.place) else {
            return;
        };
        let found = self.grid.cell_m;
        if (asked / found - 1.0).abs() > 1e-3 {
            let message = format!("the file's own cells of {found} m were kept, not the {asked} m of the request");
            self.warnings.push(Warning::new(warning::CELL_SIZE_IGNORED, message));
        }
    }
}

/// The coordinate system: the file's, else the request's, else what the numbers look like.
fn named(sheet: &Sheet, affine: &Affine, options: &TerrainOptions) -> Result<SourceCrs, RasterError> {
    match (&sheet.crs, options.epsg) {
        (SourceCrs::Unknown, Some(code)) if projection::is_geographic(code)? => Ok(SourceCrs::Geographic(Some(code))),
        (SourceCrs::Unknown | SourceCrs::Projected(None, _), Some(code)) => {
            Ok(SourceCrs::Projected(Some(code), projection::metres_a_unit(code)?))
        }
        (SourceCrs::Unknown, None) if sheet.coding == Coding::Values && looks_like_degrees(sheet, affine) => {
            Ok(SourceCrs::Geographic(None))
        }
        (crs, _) => Ok(crs.clone()),
    }
}

/// Fine cells that lie somewhere on the globe, and not at its origin.
fn looks_like_degrees(sheet: &Sheet, affine: &Affine) -> bool {
    let b = extent(affine, sheet);
    let on_globe = b.min.x >= -180.0 && b.max.x <= 360.0 && b.min.y >= -90.0 && b.max.y <= 90.0;
    let fine = affine.a.abs() < DEGREES_BELOW && affine.e.abs() < DEGREES_BELOW;
    fine && on_globe && b.min.distance(Point::new(0.0, 0.0)) > 1e-9
}

/// Coordinates in some unit of length.
fn planar(sheet: &Sheet, affine: Affine, crs: &SourceCrs, options: &TerrainOptions) -> Result<Placing, RasterError> {
    let mut warnings = Vec::new();
    let (code, unit, name) = match crs {
        SourceCrs::Projected(code, unit) => (*code, *unit, options.name.clone()),
        SourceCrs::Local(name) => (None, 1.0, name.clone()),
        _ => (None, 1.0, options.name.clone()),
    };
    let latitude_deg = code.and_then(|code| latitude(code, extent(&affine, sheet)));
    let affine = scaled(affine, unit);
    let georeference = match code {
        Some(code) if unit == 1.0 => Georeference::epsg(code),
        Some(code) => Georeference::local(format!("EPSG:{code} in metres")),
        None => Georeference::local(name),
    };
    if unit != 1.0 {
        let message = format!("coordinates were converted to metres by the factor {unit}");
        warnings.push(Warning::new(warning::FEET_CONVERTED, message));
    }
    let level = affine.b == 0.0 && affine.d == 0.0;
    let (across, down) = (affine.a.hypot(affine.d), affine.b.hypot(affine.e));
    let bounds = extent(&affine, sheet);
    if level && (across / down - 1.0).abs() < SQUARE {
        let grid = Grid { width: sheet.width, height: sheet.height, cell_m: across, origin: bounds.min };
        return Ok(Placing { grid, way: Way::Turned, georeference, latitude_deg, warnings });
    }
    let grid = covering(bounds, across.min(down));
    let message = match level {
        true => format!("cells of {across} by {down} m were resampled to squares of {} m", grid.cell_m),
        false => format!("a grid that is not level with the coordinates was resampled to squares of {} m", grid.cell_m),
    };
    warnings.push(Warning::new(warning::NON_SQUARE_CELL, message));
    Ok(Placing { grid, way: Way::Resampled(affine, None), georeference, latitude_deg, warnings })
}

/// Longitude and latitude: projected to the UTM zone of the middle.
fn geographic(
    sheet: &Sheet,
    affine: Affine,
    code: Option<u16>,
    options: &TerrainOptions,
) -> Result<Placing, RasterError> {
    let degrees = extent(&affine, sheet);
    if degrees.min.y < -90.001 || degrees.max.y > 90.001 || degrees.width() > 180.0 {
        let found = format!("degrees from {:?} to {:?}", degrees.min, degrees.max);
        return Err(RasterError::Georeference { found });
    }
    let middle = (degrees.min + degrees.max) * 0.5;
    let seconds = affine.b.hypot(affine.e) * 3600.0;
    let cell = options.cell_m.unwrap_or_else(|| nominal(seconds * METRES_A_SECOND));
    let mut placing = projected(sheet, affine, code, (middle, cell))?;
    let message = format!("degrees were projected to {}", placing.said());
    placing.warnings.push(Warning::new(warning::GEOGRAPHIC_CRS, message));
    Ok(placing)
}

/// Web Mercator, whose metres are longer than those on the ground: projected to the UTM zone of
/// the middle, at the size that its cells have there on the ground.
fn mercator(sheet: &Sheet, affine: Affine, code: u16, options: &TerrainOptions) -> Result<Placing, RasterError> {
    let bounds = extent(&affine, sheet);
    let found = format!("web Mercator from {:?} to {:?}", bounds.min, bounds.max);
    let to_degrees = Projection::between(None, code)?;
    let middle = to_degrees.to_file((bounds.min + bounds.max) * 0.5).ok_or(RasterError::Georeference { found })?;
    let side = affine.a.hypot(affine.d).min(affine.b.hypot(affine.e)) * middle.y.to_radians().cos();
    let mut placing = projected(sheet, affine, Some(code), (middle, options.cell_m.unwrap_or(side)))?;
    let message = format!("web Mercator stretches lengths: the terrain was projected to {}", placing.said());
    placing.warnings.push(Warning::new(warning::STRETCHED_CRS, message));
    Ok(placing)
}

/// Square cells of that side in the UTM zone of `middle`, in degrees.
fn projected(
    sheet: &Sheet,
    affine: Affine,
    code: Option<u16>,
    (middle, cell): (Point, f64),
) -> Result<Placing, RasterError> {
    let zone = projection::utm(middle);
    let projection = Projection::between(code, zone)?;
    let bounds = outline(&affine, sheet, &projection).ok_or_else(|| RasterError::Georeference {
        found: format!("coordinates that the zone EPSG:{zone} does not hold"),
    })?;
    Ok(Placing {
        grid: covering(bounds, cell),
        way: Way::Resampled(affine, Some(Box::new(projection))),
        georeference: Georeference::epsg(zone),
        latitude_deg: Some(middle.y),
        warnings: Vec::new(),
    })
}

/// A size without the crumbs that degrees written in decimals leave (89.99999999 → 90).
fn nominal(cell: f64) -> f64 {
    let round = (cell * 1000.0).round() / 1000.0;
    if (round / cell - 1.0).abs() < 1e-4 && round > 0.0 { round } else { cell }
}

/// Latitude of the middle of `bounds` in the coordinates of that code.
fn latitude(code: u16, bounds: Bounds) -> Option<f64> {
    let projection = Projection::between(None, code).ok()?;
    projection.to_file((bounds.min + bounds.max) * 0.5).map(|p| p.y)
}

/// The bounds of the projected rim of the sheet.
fn outline(affine: &Affine, sheet: &Sheet, projection: &Projection) -> Option<Bounds> {
    const STEPS: usize = 64;
    let (w, h) = (sheet.width as f64, sheet.height as f64);
    let rim = (0..=STEPS).flat_map(|i| {
        let t = i as f64 / STEPS as f64;
        [(t * w, 0.0), (t * w, h), (0.0, t * h), (w, t * h)]
    });
    let points: Option<Vec<Point>> = rim.map(|(u, v)| projection.to_plane(at(affine, u, v))).collect();
    Bounds::of(points?)
}

/// Square cells centred over `bounds`. The outermost centres lie at least a sixth of a cell
/// within, so that only the turn of the coordinates leaves a rim without data. The origin is
/// rounded to a number that people can read.
fn covering(bounds: Bounds, cell: f64) -> Grid {
    let count = |extent: f64| (extent / cell).round().max(1.0);
    let (width, height) = (count(bounds.width()), count(bounds.height()));
    let crumb = 10_f64.powf((cell / 10.0).log10().floor());
    let origin = |from: f64, to: f64, n: f64| ((from + to - n * cell) / 2.0 / crumb).round() * crumb;
    Grid {
        width: width as usize,
        height: height as usize,
        cell_m: cell,
        origin: Point::new(origin(bounds.min.x, bounds.max.x, width), origin(bounds.min.y, bounds.max.y, height)),
    }
}

/// The bounds of the sheet in its own coordinates.
fn extent(affine: &Affine, sheet: &Sheet) -> Bounds {
    let (w, h) = (sheet.width as f64, sheet.height as f64);
    let corners = [(0.0, 0.0), (w, 0.0), (0.0, h), (w, h)].map(|(u, v)| at(affine, u, v));
    corners[1..].iter().fold(Bounds::new(corners[0], corners[0]), |b, p| {
        Bounds::new(Point::new(b.min.x.min(p.x), b.min.y.min(p.y)), Point::new(b.max.x.max(p.x), b.max.y.max(p.y)))
    })
}

fn at(t: &Affine, column: f64, row: f64) -> Point {
    Point::new(t.x0 + t.a * column + t.b * row, t.y0 + t.d * column + t.e * row)
}

fn scaled(t: Affine, unit: f64) -> Affine {
    Affine { x0: t.x0 * unit, a: t.a * unit, b: t.b * unit, y0: t.y0 * unit, d: t.d * unit, e: t.e * unit }
}

fn checked(t: Affine) -> Result<Affine, RasterError> {
    let finite = [t.x0, t.a, t.b, t.y0, t.d, t.e].iter().all(|v| v.is_finite());
    let area = (t.a * t.e - t.b * t.d).abs();
    if finite && area.is_finite() && area > 0.0 {
        return Ok(t);
    }
    let Affine { x0, a, b, y0, d, e } = t;
    Err(RasterError::Georeference { found: format!("x = {x0} + {a} c + {b} r, y = {y0} + {d} c + {e} r") })
}

fn check_cells(grid: &Grid, max_cells: u64) -> Result<(), RasterError> {
    let (width, height) = (grid.width as u64, grid.height as u64);
    match width.checked_mul(height) {
        Some(cells) if cells <= max_cells => Ok(()),
        _ => Err(RasterError::TooLarge { width, height, max_cells }),
    }
}
