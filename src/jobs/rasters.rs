//! Terrains and maps behind references.

use biotope_api::ecosystem::ByteOrder;
use biotope_api::ecosystem::TerrainInput;
use biotope_api::error::ErrorCode;
use biotope_api::reference::Reference;
use biotope_api::warning::Warning;

use crate::codec;
use crate::codec::map::Georeference;
use crate::codec::mask::Fit;
use crate::codec::sheet::Coding;
use crate::codec::sheet::RasterError;
use crate::codec::sheet::RawLayout;
use crate::codec::sheet::RowOrder;
use crate::codec::sheet::Sheet;
use crate::codec::sheet::SheetOptions;
use crate::codec::terrain::Terrain;
use crate::codec::terrain::TerrainOptions;
use crate::compute::raster::Grid;
use crate::compute::raster::Raster;
use crate::jobs::Artefact;
use crate::jobs::Digest;
use crate::jobs::Invalid;
use crate::jobs::Sources;
use crate::jobs::sources::Content;
use crate::jobs::sources::Source;

/// A terrain as it was given.
pub struct Land {
    /// Heights, metres.
    pub height: Raster<f32>,
    /// Where it lies.
    pub georeference: Georeference,
    /// Latitude of its middle, where its coordinates tell it.
    pub latitude_deg: Option<f64>,
    /// Digest of the bytes and of all that is said beside them.
    pub digest: Digest,
    /// What readers should know of it.
    pub warnings: Vec<Warning>,
}

/// A map as it was given.
pub struct Given {
    /// Its values.
    pub raster: Raster<f32>,
    /// Digest of its bytes.
    pub digest: Digest,
}

/// What the numbers of a map are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Meaning {
    /// Shares from 0 to 1; a grey picture from black to white.
    Share,
    /// Metres of water; a grey picture is a mask, whose white is [`MASK_DEPTH_M`] deep.
    Depth,
    /// Values in a unit of their own from the least to the most, which no grey picture holds.
    Quantity(f32, f32),
    /// Numbers of kinds.
    Code,
}

/// Depth of the water that a mask paints, metres (ours: deep enough that herds need a ford).
const MASK_DEPTH_M: f32 = 1.0;

/// More than any water on Earth is deep (Mariana Trench, 10.9 km), metres.
const MOST_DEPTH_M: f32 = 12_000.0;

/// Reads a terrain.
pub fn terrain(input: &TerrainInput, sources: &dyn Sources) -> Result<Land, Invalid> {
    let source = sources.open(&input.source).map_err(|e| e.at("/terrain/source"))?;
    let options = terrain_options(input, &source)?;
    let read = match &source.content {
        Content::Artefact(Artefact::Map(map)) => Terrain::of(Sheet::from(map.clone()), &options),
        Content::Artefact(_) => return Err(no_map("/terrain/source")),
        Content::Encoded { bytes, .. } => Terrain::read(bytes, &options),
    };
    let land = read.map_err(|e| terrain_fault(&e))?;
    let beside = serde_json::to_vec(&TerrainInput { source: Reference::to(""), ..input.clone() }).unwrap_or_default();
    let hasher = crate::jobs::Hasher::new().part("terrain", source.digest.to_string().as_bytes());
    Ok(Land {
        height: land.height,
        georeference: land.georeference,
        latitude_deg: land.latitude_deg,
        digest: hasher.part("beside", &beside).finish(),
        warnings: land.warnings.iter().map(|w| warning(w, "/terrain/source")).collect(),
    })
}

/// Reads a map that must be of the grid's size, with values that its meaning allows.
pub fn map(
    pointer: &str,
    (reference, meaning): (&Reference, Meaning),
    grid: &Grid,
    sources: &dyn Sources,
) -> Result<Given, Invalid> {
    let source = sources.open(reference).map_err(|e| e.at(pointer))?;
    let sheet = match &source.content {
        Content::Artefact(Artefact::Map(map)) => Sheet::from(map.clone()),
        Content::Artefact(_) => return Err(no_map(pointer)),
        Content::Encoded { bytes, .. } => {
            let options = SheetOptions { max_cells: codec::sheet::MAX_CELLS, raw: None };
            Sheet::read(bytes, &options).map_err(|e| fault(&e, pointer))?
        }
    };
    if matches!(meaning, Meaning::Quantity(..)) && is_grey_picture(&sheet) {
        let expected = "numbers in the unit of the map, as GeoTIFF and ASCII grids hold them";
        return Err(Invalid::new(pointer, ErrorCode::NoRange, expected, "a grey picture"));
    }
    let raster = meant(sheet, meaning, grid).map_err(|e| fault(&e, pointer))?;
    Ok(Given { raster, digest: source.digest })
}

fn is_grey_picture(sheet: &Sheet) -> bool {
    matches!(sheet.coding, Coding::Levels(_))
}

/// The values of a sheet, as they are meant.
fn meant(sheet: Sheet, meaning: Meaning, grid: &Grid) -> Result<Raster<f32>, RasterError> {
    let levels = is_grey_picture(&sheet);
    match meaning {
        Meaning::Share => codec::mask::weights(sheet, grid, Fit::Exact),
        Meaning::Depth if levels => {
            Ok(codec::mask::weights(sheet, grid, Fit::Exact)?.map(|share| share * MASK_DEPTH_M))
        }
        Meaning::Depth => within(codec::mask::values(sheet, grid, Fit::Exact)?, 0.0, MOST_DEPTH_M),
        Meaning::Quantity(min, max) => within(codec::mask::values(sheet, grid, Fit::Exact)?, min, max),
        Meaning::Code => codec::mask::values(sheet, grid, Fit::Exact),
    }
}

/// The map, unless one of its values lies outside a range.
fn within(map: Raster<f32>, min: f32, max: f32) -> Result<Raster<f32>, RasterError> {
    let outside = map.data.iter().find(|v| !v.is_nan() && !(min..=max).contains(*v));
    match outside {
        None => Ok(map),
        Some(found) => {
            let (min, max) = (f64::from(min), f64::from(max));
            Err(RasterError::OutOfRange { min, max, found: f64::from(*found) })
        }
    }
}

fn no_map(pointer: &str) -> Invalid {
    Invalid::new(pointer, ErrorCode::Unreadable, "a map", "an output that is not a map")
}

fn terrain_options(input: &TerrainInput, source: &Source) -> Result<TerrainOptions, Invalid> {
    let range_m = match (input.height_min_m, input.height_max_m) {
        (Some(min), Some(max)) => Some((min, max)),
        (None, None) => None,
        (Some(_), None) => return Err(missing("/terrain/height_max_m")),
        (None, Some(_)) => return Err(missing("/terrain/height_min_m")),
    };
    Ok(TerrainOptions { range_m, cell_m: input.cell_m, raw: raw_layout(input, source), ..TerrainOptions::default() })
}

fn missing(pointer: &str) -> Invalid {
    Invalid::new(pointer, ErrorCode::Missing, "both ends of the range of heights", "one of them")
}

/// Headerless samples are taken for such when a layout is named, or by their media type.
fn raw_layout(input: &TerrainInput, source: &Source) -> Option<RawLayout> {
    let (media_type, bytes) = source.bytes()?;
    let named = input.columns.is_some() || input.rows.is_some() || input.byte_order.is_some();
    if !named && !["application/x-r16", "image/x-r16"].contains(&media_type) {
        return None;
    }
    let side = ((bytes.len() / 2) as f64).sqrt().round() as usize;
    let width = input.columns.map_or(side, |n| n as usize);
    let rows_of_rest = (bytes.len() / 2).checked_div(width).unwrap_or(0);
    let order = match input.byte_order {
        Some(ByteOrder::Big) => codec::sheet::ByteOrder::BigEndian,
        _ => codec::sheet::ByteOrder::LittleEndian,
    };
    let height = input.rows.map_or(rows_of_rest, |n| n as usize);
    Some(RawLayout { width, height, order, rows: RowOrder::NorthFirst })
}

/// The fields of a terrain that its problems concern.
fn terrain_fault(error: &RasterError) -> Invalid {
    let pointer = match error.field() {
        "range_m" => "/terrain/height_min_m",
        "cell_m" => "/terrain/cell_m",
        _ => "/terrain/source",
    };
    fault(error, pointer)
}

/// A raster that cannot be used, as a fault of the field at `pointer`.
pub fn fault(error: &RasterError, pointer: &str) -> Invalid {
    let code = ErrorCode::from_code(error.code()).unwrap_or(ErrorCode::Unreadable);
    Invalid::new(pointer, code, error.expected(), error.found())
}

fn warning(warning: &codec::warning::Warning, pointer: &str) -> Warning {
    Warning {
        code: warning.code.to_owned(),
        pointer: pointer.to_owned(),
        message: warning.message.clone(),
        count: warning.count.max(1),
    }
}
