//! Domains and painted rasters in.

use biotope_api::error::ErrorCode;
use biotope_api::points::DomainInput;
use biotope_api::points::PaintedInput;
use biotope_api::points::PolygonInput;

use crate::codec::sheet::Coding;
use crate::codec::sheet::Sheet;
use crate::codec::sheet::SheetOptions;
use crate::compute::geometry::Bounds;
use crate::compute::geometry::Point;
use crate::compute::geometry::Polygon;
use crate::compute::geometry::Region;
use crate::compute::pcf::BorderOptions;
use crate::compute::pcf::BorderRule;
use crate::compute::pcf::Element;
use crate::compute::pcf::PcfError;
use crate::compute::pcf::learn_border;
use crate::compute::raster::Grid;
use crate::compute::raster::Raster;
use crate::compute::raster::outline;
use crate::jobs::Invalid;
use crate::jobs::Sources;
use crate::jobs::points::faults;
use crate::jobs::rasters;

/// Cells of a painted raster: what a painter paints.
const MAX_CELLS: u64 = 4096 * 4096;

/// The region given at `pointer`; a free-form one is learnt from `elements`.
///
/// # Errors
/// When it is not one.
pub fn open(
    input: &DomainInput,
    pointer: &str,
    (elements, sources): (&[Element], &dyn Sources),
) -> Result<Region, Invalid> {
    match input {
        DomainInput::Rectangle { min, max } => rectangle(*min, *max, pointer),
        DomainInput::Polygons { polygons } => {
            let polygons: Vec<Polygon> = polygons.iter().map(polygon).collect();
            Region::from_polygons(&polygons).map_err(|e| faults::polygon(&e, pointer))
        }
        DomainInput::Mask { mask } => {
            let raster = painted(mask, &format!("{pointer}/mask"), (None, sources))?;
            let half = raster.data.iter().copied().filter(|v| v.is_finite()).fold(0.0, f32::max) / 2.0;
            Region::from_normal_form(outline(&raster.map(|v| v > half))).map_err(|e| faults::polygon(&e, pointer))
        }
        DomainInput::FreeForm { max_circumradius, edge_ratio, margin } => {
            learnt(elements, &border_options(*max_circumradius, *edge_ratio, *margin))
        }
    }
}

/// The options of a free-form border.
pub fn border_options(max_circumradius: Option<f64>, edge_ratio: Option<f64>, margin: Option<f64>) -> BorderOptions {
    let default = BorderOptions::default();
    let rule = match (edge_ratio, max_circumradius) {
        (Some(ratio), _) => BorderRule::EdgeRatio(ratio),
        (None, Some(radius)) => BorderRule::Circumradius(radius),
        (None, None) => default.rule,
    };
    BorderOptions { rule, margin }
}

/// The border learnt from `elements`.
///
/// # Errors
/// When none can be learnt.
pub fn learnt(elements: &[Element], options: &BorderOptions) -> Result<Region, Invalid> {
    let centres: Vec<Point> = elements.iter().map(|e| e.centre).collect();
    learn_border(&centres, options)
        .map_err(|e: PcfError| faults::pattern(&e, "/exemplar", |class| class.to_string()).unwrap_or_default())
}

fn rectangle(min: [f64; 2], max: [f64; 2], pointer: &str) -> Result<Region, Invalid> {
    if !(min[0] < max[0] && min[1] < max[1]) {
        let found = format!("from {min:?} to {max:?}");
        return Err(Invalid::new(pointer, ErrorCode::ZeroArea, "a rectangle with an area, min below max", found));
    }
    let bounds = Bounds::new(Point::new(min[0], min[1]), Point::new(max[0], max[1]));
    Region::rectangle(bounds).map_err(|e| faults::polygon(&e, pointer))
}

/// A polygon of the wire.
pub fn polygon(input: &PolygonInput) -> Polygon {
    let ring = |ring: &Vec<[f64; 2]>| {
        let mut points: Vec<Point> = ring.iter().map(|p| Point::new(p[0], p[1])).collect();
        if points.len() > 1 && points.first() == points.last() {
            points.pop();
        }
        points
    };
    Polygon { outer: ring(&input.outer), holes: input.holes.iter().map(ring).collect() }
}

/// A region as polygons on the wire.
pub fn polygons(region: &Region) -> Vec<PolygonInput> {
    let ring = |ring: &Vec<Point>| ring.iter().map(|p| [p.x, p.y]).collect::<Vec<[f64; 2]>>();
    let polygon = |p: &Polygon| PolygonInput { outer: ring(&p.outer), holes: p.holes.iter().map(ring).collect() };
    region.polygons().iter().map(polygon).collect()
}

/// The painted raster given at `pointer`; where neither the request nor the file says where its
/// cells lie, over the rectangle `around`. Cells without data are 0.
///
/// # Errors
/// When it cannot be read or placed.
pub fn painted(
    input: &PaintedInput,
    pointer: &str,
    how: (Option<Bounds>, &dyn Sources),
) -> Result<Raster<f32>, Invalid> {
    let (raster, _) = raster(input, pointer, how)?;
    Ok(raster.map(|v| if v.is_nan() { 0.0 } else { v }))
}

/// The same with NaN in cells without data, and the highest level of a grey picture.
///
/// # Errors
/// As [`painted`].
pub fn raster(
    input: &PaintedInput,
    pointer: &str,
    (around, sources): (Option<Bounds>, &dyn Sources),
) -> Result<(Raster<f32>, Option<u32>), Invalid> {
    let at = format!("{pointer}/raster");
    let source = sources.open(&input.raster).map_err(|e| e.at(&at))?;
    let sheet = match (source.map(), source.bytes()) {
        (Some(map), _) => Sheet::from(map.clone()),
        (None, Some((_, bytes))) => Sheet::read(bytes, &SheetOptions { max_cells: MAX_CELLS, raw: None })
            .map_err(|error| rasters::fault(&error, &at))?,
        (None, None) => {
            return Err(Invalid::new(&at, ErrorCode::Unreadable, "a raster", "another kind of document"));
        }
    };
    let grid = place(input, &sheet, around).ok_or_else(|| {
        Invalid::new(format!("{pointer}/cell_m"), ErrorCode::NoCellSize, "the side of a cell in metres", "none")
    })?;
    let levels = match sheet.coding {
        Coding::Levels(highest) => Some(highest),
        Coding::Values => None,
    };
    Ok((Raster { grid, data: sheet.values }, levels))
}

fn place(input: &PaintedInput, sheet: &Sheet, around: Option<Bounds>) -> Option<Grid> {
    let own = sheet.place.filter(|p| p.b == 0.0 && p.d == 0.0 && p.a > 0.0 && p.e < 0.0);
    let cell_m = input.cell_m.or(own.map(|p| p.a)).or(around.map(|b| b.width() / sheet.width as f64))?;
    let own_corner = own.map(|p| Point::new(p.x0, p.y0 + p.e * sheet.height as f64));
    let given = input.origin.map(|o| Point::new(o[0], o[1]));
    let origin = given.or(own_corner).or(around.map(|b| b.min)).unwrap_or_default();
    (cell_m.is_finite() && cell_m > 0.0).then_some(Grid { width: sheet.width, height: sheet.height, cell_m, origin })
}
