//! A map with its legend and its place: how results are kept, and the forms in which they leave.
//!
//! A solve keeps each map once, in the compact form of [`Map::to_bytes`]; GeoTIFF and picture
//! are made from it when somebody asks.

mod georeference;
mod geotiff;
mod legend;
mod picture;
mod shade;
mod spread;

pub use georeference::Georeference;
pub use legend::{Category, Legend, Scale};
pub use picture::PictureOptions;
pub use spread::Spread;

use crate::codec::binary;
use crate::codec::binary::Reader;
use crate::codec::binary::Writer;
use crate::compute::geometry::Point;
use crate::compute::raster::Grid;
use crate::compute::raster::Raster;
use rayon::prelude::*;

const KIND: [u8; 4] = *b"BMAP";
const VERSION: u16 = 1;

/// Why a map could not be encoded or decoded.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The compact form is not one.
    #[error(transparent)]
    Bytes(#[from] binary::Error),
    /// The GeoTIFF could not be written.
    #[error("the GeoTIFF could not be written: {0}")]
    GeoTiff(#[from] geotiff_writer::Error),
    /// The picture could not be written.
    #[error("the picture could not be written: {0}")]
    Png(#[from] png::EncodingError),
}

/// The values of a map.
#[derive(Debug, Clone, PartialEq)]
pub enum MapData {
    /// Quantities; NaN where there is no data.
    F32(Raster<f32>),
    /// Classes; 255 where there is no data.
    U8(Raster<u8>),
    /// Classes or labels; 65,535 where there is no data.
    U16(Raster<u16>),
}

impl MapData {
    /// No data among [`MapData::U8`].
    pub const NODATA_U8: u8 = u8::MAX;
    /// No data among [`MapData::U16`].
    pub const NODATA_U16: u16 = u16::MAX;

    /// Where the cells lie.
    pub const fn grid(&self) -> &Grid {
        match self {
            Self::F32(r) => &r.grid,
            Self::U8(r) => &r.grid,
            Self::U16(r) => &r.grid,
        }
    }

    /// The value of a cell; `None` where there is no data.
    pub fn value(&self, index: usize) -> Option<f64> {
        match self {
            Self::F32(r) => Some(r.data[index]).filter(|v| !v.is_nan()).map(f64::from),
            Self::U8(r) => Some(r.data[index]).filter(|v| *v != Self::NODATA_U8).map(f64::from),
            Self::U16(r) => Some(r.data[index]).filter(|v| *v != Self::NODATA_U16).map(f64::from),
        }
    }
}

/// A map, what it shows and where it lies.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// The values.
    pub data: MapData,
    /// What they mean.
    pub legend: Legend,
    /// Where they lie.
    pub georeference: Georeference,
}

/// What can be said of a map's values in four numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Statistics {
    /// Least value; `None` when there is no data at all.
    pub min: Option<f64>,
    /// Greatest value.
    pub max: Option<f64>,
    /// Mean value.
    pub mean: Option<f64>,
    /// Cells without data.
    pub nodata: usize,
}

impl Map {
    /// Where the cells lie.
    pub const fn grid(&self) -> &Grid {
        self.data.grid()
    }

    /// The compact form: lossless, packed in parallel, the same bytes on any number of threads.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut w = Writer::new(KIND, VERSION);
        self.legend.write(&mut w);
        self.georeference.write(&mut w);
        let grid = self.grid();
        w.u32(grid.width as u32).u32(grid.height as u32).f64(grid.cell_m).f64(grid.origin.x).f64(grid.origin.y);
        match &self.data {
            MapData::F32(r) => w.u8(0).f32s(&r.data),
            MapData::U8(r) => w.u8(1).u8s(&r.data),
            MapData::U16(r) => w.u8(2).u16s(&r.data),
        };
        w.finish()
    }

    /// Reads [`Map::to_bytes`]. Any other bytes give an error; memory used is bounded by 255
    /// times their number.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        let mut r = Reader::new(bytes, KIND, VERSION)?;
        let legend = Legend::read(&mut r)?;
        let georeference = Georeference::read(&mut r)?;
        let grid = read_grid(&mut r)?;
        let data = match r.u8()? {
            0 => Raster::from_data(grid, r.f32s()?).map(MapData::F32),
            1 => Raster::from_data(grid, r.u8s()?).map(MapData::U8),
            2 => Raster::from_data(grid, r.u16s()?).map(MapData::U16),
            _ => None,
        };
        r.finish()?;
        let data = data.ok_or(binary::Error::Corrupt("the values do not fit the grid"))?;
        Ok(Self { data, legend, georeference })
    }

    /// Whether quantities or labels are 0 or without data everywhere; classes never are.
    pub fn is_blank(&self) -> bool {
        let nothing = |i: usize| self.data.value(i).is_none_or(|value| value == 0.0);
        !matches!(self.legend.scale, Scale::Categories(_)) && (0..self.grid().len()).into_par_iter().all(nothing)
    }

    /// Extremes, mean and number of cells without data. The mean is folded row by row, so it
    /// does not depend on the number of threads.
    pub fn statistics(&self) -> Statistics {
        let grid = self.grid();
        let rows: Vec<Fold> =
            (0..grid.height).into_par_iter().map(|row| self.fold(row * grid.width..(row + 1) * grid.width)).collect();
        let all = rows.into_iter().fold(Fold::NONE, Fold::and);
        let some = |v: f64| (all.count > 0).then_some(v);
        Statistics {
            min: some(all.min),
            max: some(all.max),
            mean: some(all.sum / all.count.max(1) as f64),
            nodata: grid.len() - all.count,
        }
    }

    fn fold(&self, cells: std::ops::Range<usize>) -> Fold {
        cells.filter_map(|i| self.data.value(i)).map(Fold::one).fold(Fold::NONE, Fold::and)
    }
}

fn read_grid(r: &mut Reader) -> Result<Grid, binary::Error> {
    let (width, height) = (r.u32()? as usize, r.u32()? as usize);
    let (cell_m, origin) = (r.f64()?, Point::new(r.f64()?, r.f64()?));
    let whole = width > 0 && height > 0 && width.checked_mul(height).is_some();
    let placed = cell_m.is_finite() && cell_m > 0.0 && origin.is_finite();
    if !(whole && placed) {
        return Err(binary::Error::Corrupt("the grid is not one"));
    }
    Ok(Grid { width, height, cell_m, origin })
}

/// A running extreme and sum.
#[derive(Clone, Copy)]
struct Fold {
    min: f64,
    max: f64,
    sum: f64,
    count: usize,
}

impl Fold {
    const NONE: Self = Self { min: f64::INFINITY, max: f64::NEG_INFINITY, sum: 0.0, count: 0 };

    const fn one(value: f64) -> Self {
        Self { min: value, max: value, sum: value, count: 1 }
    }

    const fn and(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
            sum: self.sum + other.sum,
            count: self.count + other.count,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::colours::ColourMap;

    pub(super) fn hills(width: usize, height: usize) -> Map {
        let grid = Grid { width, height, cell_m: 2.5, origin: Point::new(100.0, -50.0) };
        let height_at = |i: usize| {
            let p = grid.centre(i);
            if i.is_multiple_of(97) {
                f32::NAN
            } else {
                (200.0 + 30.0 * (p.x * 0.05).sin() * (p.y * 0.04).cos()) as f32
            }
        };
        Map {
            data: MapData::F32(Raster { grid, data: (0..grid.len()).map(height_at).collect() }),
            legend: Legend::continuous("Height", "m", ColourMap::Terrain).with_range(0.0, 300.0),
            georeference: Georeference::local("hills"),
        }
    }

    pub(super) fn classes() -> Map {
        let grid = Grid::new(300, 200, 1.0);
        let data = (0..grid.len()).map(|i| if i % 1000 == 7 { 255 } else { (grid.cell(i).row / 70) as u8 }).collect();
        let category =
            |value: u32, label: &str| Category { value, label: label.into(), colour: [value as u8 * 50, 90, 200] };
        Map {
            data: MapData::U8(Raster { grid, data }),
            legend: Legend::categories(
                "Soil",
                vec![category(0, "limestone"), category(1, "marl"), category(2, "scree")],
            ),
            georeference: Georeference::epsg(32631),
        }
    }

    fn bits(map: &Map) -> Vec<u32> {
        match &map.data {
            MapData::F32(r) => r.data.iter().map(|v| v.to_bits()).collect(),
            _ => Vec::new(),
        }
    }

    #[test]
    fn the_compact_form_gives_back_every_bit() {
        for map in [hills(301, 257), classes()] {
            let back = Map::from_bytes(&map.to_bytes()).unwrap();
            assert_eq!(bits(&back), bits(&map));
            assert_eq!((&back.legend, &back.georeference, back.grid()), (&map.legend, &map.georeference, map.grid()));
        }
        let labels = MapData::U16(Raster { grid: Grid::new(2, 1, 1.0), data: vec![3, 65535] });
        let map = Map { data: labels, legend: Legend::labels("Regions"), georeference: Georeference::default() };
        assert_eq!(Map::from_bytes(&map.to_bytes()).unwrap(), map);
    }

    #[test]
    fn a_map_is_blank_when_nothing_is_on_it_and_classes_are_always_something() {
        let with = |legend, data: Vec<f32>| {
            let data = MapData::F32(Raster { grid: Grid::new(2, 1, 1.0), data });
            Map { data, legend, georeference: Georeference::default() }.is_blank()
        };
        let cover = || Legend::continuous("Cover", "", ColourMap::Green);
        assert!(with(cover(), vec![0.0, f32::NAN]));
        assert!(!with(cover(), vec![0.0, 1e-6]));
        assert!(with(Legend::labels("Regions"), vec![0.0; 2]));
        assert!(!with(Legend::categories("Soil", Vec::new()), vec![0.0; 2]));
    }

    #[test]
    fn the_compact_form_does_not_depend_on_the_number_of_threads() {
        let map = hills(700, 300);
        let on = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap().install(|| map.to_bytes());
        assert_eq!(on(1), on(2));
    }

    #[test]
    fn damaged_bytes_are_an_error_and_never_a_panic() {
        let bytes = hills(40, 30).to_bytes();
        for n in 0..bytes.len() {
            assert!(Map::from_bytes(&bytes[..n]).is_err(), "cut at {n}");
            let mut damaged = bytes.clone();
            damaged[n] ^= 0x55;
            let _ = Map::from_bytes(&damaged);
        }
    }

    #[test]
    fn statistics_leave_out_what_is_no_data() {
        let grid = Grid::new(2, 2, 1.0);
        let mut map = hills(1, 1);
        map.data = MapData::F32(Raster { grid, data: vec![1.0, f32::NAN, 2.0, 6.0] });
        let expected = Statistics { min: Some(1.0), max: Some(6.0), mean: Some(3.0), nodata: 1 };
        assert_eq!(map.statistics(), expected);
        map.data = MapData::U8(Raster { grid, data: vec![255; 4] });
        assert_eq!(map.statistics(), Statistics { min: None, max: None, mean: None, nodata: 4 });
    }
}
