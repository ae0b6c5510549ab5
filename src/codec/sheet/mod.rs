//! A raster as it stands in a file, before anybody says what it means.
//!
//! [`Sheet::read`] finds the format by looking at the bytes, never at a name, checks the size in
//! the header before it allocates, and gives values with their place. [`super::terrain`] and
//! [`super::mask`] make heights and weights of it.

mod ascii;
mod error;
mod format;
pub(crate) mod geotiff;
pub(crate) mod png;
mod raw;

pub use error::RasterError;
pub use format::Format;
pub(super) use format::described;
pub use raw::{ByteOrder, RawLayout, RowOrder};

use crate::codec::map::Georeference;
use crate::codec::map::Map;
use crate::codec::map::MapData;
use crate::codec::warning::Warning;

/// Cells a raster may have unless the caller says otherwise: 8,192². Four times what the
/// largest solve of the papers has (L table 1: 4,096²).
pub const MAX_CELLS: u64 = 8192 * 8192;

/// What the reader must be told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SheetOptions {
    /// Cells the raster may have.
    pub max_cells: u64,
    /// How headerless samples lie; without it, bytes in no known format are refused.
    pub raw: Option<RawLayout>,
}

impl Default for SheetOptions {
    fn default() -> Self {
        Self { max_cells: MAX_CELLS, raw: None }
    }
}

/// What the samples of a file are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coding {
    /// Values in the unit of the quantity itself.
    Values,
    /// Integers from 0 to this number, which stand for a range that the file does not hold.
    Levels(u32),
}

/// The affine map from (column, row), counted in cells from the outer corner of the first cell,
/// to coordinates: x = x0 + a column + b row, y = y0 + d column + e row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Affine {
    /// x of the corner.
    pub x0: f64,
    /// x a column.
    pub a: f64,
    /// x a row.
    pub b: f64,
    /// y of the corner.
    pub y0: f64,
    /// y a column.
    pub d: f64,
    /// y a row, negative for north up.
    pub e: f64,
}

/// The coordinate system of a file.
#[derive(Debug, Clone, PartialEq)]
pub enum SourceCrs {
    /// None is named.
    Unknown,
    /// A world of its own with this name.
    Local(String),
    /// Longitude and latitude in degrees; the EPSG code, if it is named.
    Geographic(Option<u16>),
    /// Planar coordinates; the EPSG code, if it is named, and metres a unit.
    Projected(Option<u16>, f64),
}

/// A raster as it stands in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    /// Its format.
    pub format: Format,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Values row by row as in the file; NaN where there is no data.
    pub values: Vec<f32>,
    /// What the values are.
    pub coding: Coding,
    /// The highest value the samples could hold, where they are unsigned integers of at most 16
    /// bits.
    pub levels: Option<u32>,
    /// Where the cells lie; `None` when the file does not say.
    pub place: Option<Affine>,
    /// On what they lie.
    pub crs: SourceCrs,
    /// Metres a unit of height, where the file says so.
    pub height_unit_m: Option<f64>,
    /// What a reader should know.
    pub warnings: Vec<Warning>,
}

impl Sheet {
    /// Reads a raster in any of the formats of [`Format`].
    pub fn read(bytes: &[u8], options: &SheetOptions) -> Result<Self, RasterError> {
        match Format::of(bytes) {
            _ if bytes.is_empty() => Err(RasterError::Empty),
            Some(Format::GeoTiff) => geotiff::read(bytes, options),
            Some(Format::Png) => png::read(bytes, options),
            Some(Format::AsciiGrid) => ascii::read(bytes, options),
            Some(Format::Map) => Map::from_bytes(bytes)
                .map(Self::from)
                .map_err(|e| RasterError::Unreadable { format: Format::Map, reason: e.to_string() }),
            Some(Format::Raw) | None => match &options.raw {
                Some(layout) => raw::read(bytes, layout, options),
                None => Err(RasterError::UnknownFormat { found: described(bytes) }),
            },
        }
    }
}

impl Sheet {
    /// The same with its first row north and its first column west, where its place says
    /// otherwise by a sign alone.
    pub(super) fn north_up(mut self) -> Self {
        let Some(place) = self.place.filter(|p| p.b == 0.0 && p.d == 0.0) else {
            return self;
        };
        if place.e > 0.0 {
            self.values = self.values.chunks_exact(self.width).rev().flatten().copied().collect();
            self.place = Some(Affine { y0: place.y0 + place.e * self.height as f64, e: -place.e, ..place });
        }
        if place.a < 0.0 {
            self.values.chunks_exact_mut(self.width).for_each(<[f32]>::reverse);
            let moved = self.place.unwrap_or(place);
            self.place = Some(Affine { x0: place.x0 + place.a * self.width as f64, a: -place.a, ..moved });
        }
        self
    }

    /// Refuses infinite values.
    pub(super) fn check_finite(&self) -> Result<(), RasterError> {
        let mut infinite = self.values.iter().enumerate().filter(|(_, v)| v.is_infinite()).map(|(i, _)| i);
        match infinite.next() {
            None => Ok(()),
            Some(i) => {
                Err(RasterError::Infinite { count: 1 + infinite.count(), column: i % self.width, row: i / self.width })
            }
        }
    }

    /// Bilinear interpolation at (`x`, `y`), in cells from the outer corner of the first one.
    /// Holes stay where they are: the cell that holds the place decides, and neighbours without
    /// data are left out of the mean. NaN outside.
    pub(super) fn bilinear(&self, x: f64, y: f64) -> f32 {
        let (w, h) = (self.width as f64, self.height as f64);
        let inside = x >= 0.0 && y >= 0.0 && x < w && y < h;
        if !inside || self.values[y as usize * self.width + x as usize].is_nan() {
            return f32::NAN;
        }
        let (u, v) = ((x - 0.5).clamp(0.0, w - 1.0), (y - 0.5).clamp(0.0, h - 1.0));
        let (column, row) = (u as usize, v as usize);
        let (east, south) = ((column + 1).min(self.width - 1), (row + 1).min(self.height - 1));
        let (fu, fv) = (u - column as f64, v - row as f64);
        let corners = [
            (column, row, (1.0 - fu) * (1.0 - fv)),
            (east, row, fu * (1.0 - fv)),
            (column, south, (1.0 - fu) * fv),
            (east, south, fu * fv),
        ];
        let (sum, weight) = corners
            .iter()
            .map(|(c, r, weight)| (f64::from(self.values[r * self.width + c]), *weight))
            .filter(|(value, _)| !value.is_nan())
            .fold((0.0, 0.0), |(s, w), (value, weight)| (s + value * weight, w + weight));
        (sum / weight) as f32
    }
}

impl From<Map> for Sheet {
    fn from(map: Map) -> Self {
        let grid = *map.grid();
        let values = match map.data {
            MapData::F32(r) => r.data,
            MapData::U8(r) => r.data.iter().map(|v| class(u32::from(*v), u32::from(MapData::NODATA_U8))).collect(),
            MapData::U16(r) => r.data.iter().map(|v| class(u32::from(*v), u32::from(MapData::NODATA_U16))).collect(),
        };
        let north = grid.origin.y + grid.height as f64 * grid.cell_m;
        Self {
            format: Format::Map,
            width: grid.width,
            height: grid.height,
            values,
            coding: Coding::Values,
            levels: None,
            place: Some(Affine { x0: grid.origin.x, a: grid.cell_m, b: 0.0, y0: north, d: 0.0, e: -grid.cell_m }),
            crs: match map.georeference {
                Georeference::Local { name } => SourceCrs::Local(name),
                Georeference::Projected { epsg } => SourceCrs::Projected(Some(epsg), 1.0),
            },
            height_unit_m: None,
            warnings: Vec::new(),
        }
    }
}

fn class(value: u32, nodata: u32) -> f32 {
    if value == nodata { f32::NAN } else { value as f32 }
}

/// Refuses a raster before it is allocated.
fn check_size(width: u64, height: u64, max_cells: u64) -> Result<(), RasterError> {
    match width.checked_mul(height) {
        Some(0) => Err(RasterError::TooSmall { width, height }),
        Some(cells) if cells <= max_cells => Ok(()),
        _ => Err(RasterError::TooLarge { width, height, max_cells }),
    }
}
