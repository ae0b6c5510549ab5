use super::Affine;
use super::Coding;
use super::Format;
use super::RasterError;
use super::Sheet;
use super::SheetOptions;
use super::SourceCrs;
use super::check_size;
use crate::codec::warning;
use crate::codec::warning::Warning;
use geotiff_reader::GeoTiffFile;
use rayon::prelude::*;
use tiff_reader::Ifd;
use tiff_reader::OpenOptions;
use tiff_reader::TiffFile;
use tiff_reader::TiffSample;

/// The photometric interpretations of TIFF 6.0, by their codes.
const PHOTOMETRIC: [&str; 4] = ["white is zero", "black is zero", "red, green and blue", "a colour table"];

/// GDAL's own tags.
const GDAL_METADATA: u16 = 42112;
const GDAL_NODATA: u16 = 42113;

/// GeoKeys, OGC GeoTIFF 1.1 (annex B), and the codes of units (EPSG).
const MODEL_TYPE: u16 = 1024;
const GT_CITATION: u16 = 1026;
const GEOGRAPHIC_TYPE: u16 = 2048;
const PROJECTED_TYPE: u16 = 3072;
const PROJ_LINEAR_UNITS: u16 = 3076;
const VERTICAL_UNITS: u16 = 4099;
const USER_DEFINED: u16 = 32767;
const METRE: u16 = 9001;

/// A TIFF with or without a place.
enum Tiff {
    Placed(Box<GeoTiffFile>),
    Plain(Box<TiffFile>),
}

/// Reads the first band of a TIFF of any numeric samples, with its scale, offset, no data and
/// place.
pub(super) fn read(bytes: &[u8], options: &SheetOptions) -> Result<Sheet, RasterError> {
    let tiff = Tiff::open(bytes, limits(options))?;
    let ifd = tiff.ifd()?;
    check_size(u64::from(ifd.width()), u64::from(ifd.height()), options.max_cells)?;
    let mut warnings = Vec::new();
    check_bands(ifd, &mut warnings)?;
    let place = tiff.place();
    if place.is_some() && tiff.key(1025) == Some(2) {
        let message = "the file's coordinates belong to the centres of its cells; they were moved by half a cell";
        warnings.push(Warning::new(warning::HALF_PIXEL_POINT, message));
    }
    Ok(Sheet {
        format: Format::GeoTiff,
        width: ifd.width() as usize,
        height: ifd.height() as usize,
        values: values(tiff.tiff(), ifd)?,
        coding: Coding::Values,
        place,
        crs: tiff.crs()?,
        height_unit_m: tiff.key(VERTICAL_UNITS).map(metres).transpose()?,
        warnings,
    })
}

/// What the reader may allocate: the values in their widest form, and modest metadata.
fn limits(options: &SheetOptions) -> OpenOptions {
    let mut limits = OpenOptions::default();
    let cells = usize::try_from(options.max_cells).unwrap_or(usize::MAX);
    limits.decode_output_bytes = cells.saturating_mul(8).max(1 << 20);
    limits.parse_budgets.max_ifds = 64;
    limits.parse_budgets.max_tag_value_bytes = 32 << 20;
    limits.parse_budgets.max_metadata_value_bytes = 128 << 20;
    limits
}

impl Tiff {
    fn open(bytes: &[u8], limits: OpenOptions) -> Result<Self, RasterError> {
        match GeoTiffFile::from_bytes_with_options(bytes.to_vec(), limits) {
            Ok(file) => Ok(Self::Placed(Box::new(file))),
            Err(geotiff_reader::Error::NotGeoTiff) => {
                let file = TiffFile::from_bytes_with_options(bytes.to_vec(), limits).map_err(unreadable)?;
                Ok(Self::Plain(Box::new(file)))
            }
            Err(geotiff_reader::Error::InvalidGeoTiffTag { tag: 33550 | 33922 | 34264, reason }) => {
                Err(RasterError::Georeference { found: reason })
            }
            Err(other) => Err(unreadable(other)),
        }
    }

    fn tiff(&self) -> &TiffFile {
        match self {
            Self::Placed(file) => file.tiff(),
            Self::Plain(file) => file,
        }
    }

    fn ifd(&self) -> Result<&Ifd, RasterError> {
        let index = match self {
            Self::Placed(file) => file.base_ifd_index(),
            Self::Plain(_) => 0,
        };
        self.tiff().ifd(index).map_err(unreadable)
    }

    fn key(&self, key: u16) -> Option<u16> {
        match self {
            Self::Placed(file) => file.geokeys().get_short(key),
            Self::Plain(_) => None,
        }
    }

    fn place(&self) -> Option<Affine> {
        let Self::Placed(file) = self else {
            return None;
        };
        let t = file.transform()?;
        Some(Affine { x0: t.origin_x, a: t.pixel_width, b: t.skew_x, y0: t.origin_y, d: t.skew_y, e: t.pixel_height })
    }

    /// The coordinate system as the keys name it.
    fn crs(&self) -> Result<SourceCrs, RasterError> {
        let Self::Placed(file) = self else {
            return Ok(SourceCrs::Unknown);
        };
        let code = |key| self.key(key).filter(|c| *c != USER_DEFINED && *c != 0);
        let unit = self.key(PROJ_LINEAR_UNITS).filter(|c| *c != USER_DEFINED);
        match self.key(MODEL_TYPE) {
            Some(1) => Ok(SourceCrs::Projected(code(PROJECTED_TYPE), unit.map_or(Ok(1.0), metres)?)),
            Some(2) => Ok(SourceCrs::Geographic(code(GEOGRAPHIC_TYPE))),
            Some(3) => Err(RasterError::UnknownCrs { found: "geocentric coordinates".to_owned() }),
            _ => match (unit, file.geokeys().get_ascii(GT_CITATION)) {
                (None, None) => Ok(SourceCrs::Unknown),
                (Some(unit), _) if unit != METRE => Ok(SourceCrs::Projected(None, metres(unit)?)),
                (_, name) => Ok(SourceCrs::Local(name.unwrap_or("local").trim_end_matches('|').to_owned())),
            },
        }
    }
}

fn check_bands(ifd: &Ifd, warnings: &mut Vec<Warning>) -> Result<(), RasterError> {
    let bands = ifd.samples_per_pixel();
    let kind = ifd.photometric_interpretation().unwrap_or(1);
    if kind > 1 && !(kind == 3 && bands == 1) {
        let kind = PHOTOMETRIC.get(usize::from(kind)).copied().unwrap_or("colour");
        return Err(RasterError::Colour { found: format!("a TIFF in {kind} of {bands} bands") });
    }
    if bands > 1 {
        let message = format!("the first of {bands} bands was read");
        warnings.push(Warning::new(warning::FIRST_BAND, message));
    }
    Ok(())
}

/// The values of the first band in their unit; NaN for no data.
fn values(tiff: &TiffFile, ifd: &Ifd) -> Result<Vec<f32>, RasterError> {
    let layout = ifd.raster_layout().map_err(unreadable)?;
    let scaling = Scaling::of(ifd);
    match (layout.sample_format, layout.bits_per_sample) {
        (1, ..=8) => band::<u8>(tiff, ifd, |v| scaling.value(f64::from(v))),
        (1, 9..=16) => band::<u16>(tiff, ifd, |v| scaling.value(f64::from(v))),
        (1, 32) => band::<u32>(tiff, ifd, |v| scaling.value(f64::from(v))),
        (1, 64) => band::<u64>(tiff, ifd, |v| scaling.value(v as f64)),
        (2, 8) => band::<i8>(tiff, ifd, |v| scaling.value(f64::from(v))),
        (2, 16) => band::<i16>(tiff, ifd, |v| scaling.value(f64::from(v))),
        (2, 32) => band::<i32>(tiff, ifd, |v| scaling.value(f64::from(v))),
        (2, 64) => band::<i64>(tiff, ifd, |v| scaling.value(v as f64)),
        (3, 32) => band::<f32>(tiff, ifd, |v| scaling.value(f64::from(v))),
        (3, 64) => band::<f64>(tiff, ifd, |v| scaling.value(v)),
        (format, bits) => {
            let reason = format!("samples of format {format} with {bits} bits");
            Err(RasterError::Unreadable { format: Format::GeoTiff, reason })
        }
    }
}

fn band<T: TiffSample + Copy + Send + Sync>(
    tiff: &TiffFile,
    ifd: &Ifd,
    value: impl Fn(T) -> f32 + Sync,
) -> Result<Vec<f32>, RasterError> {
    let samples = tiff.read_band_from_ifd::<T>(ifd, 0).map_err(unreadable)?;
    let (samples, offset) = samples.into_raw_vec_and_offset();
    let samples = &samples[offset.unwrap_or(0)..];
    Ok(samples.par_iter().with_min_len(1 << 16).map(|v| value(*v)).collect())
}

/// From samples to values.
struct Scaling {
    nodata: Option<f64>,
    scale: f64,
    offset: f64,
}

impl Scaling {
    fn of(ifd: &Ifd) -> Self {
        let text = |tag| ifd.tag(tag).and_then(|t| t.value.as_str()).unwrap_or("");
        let metadata = text(GDAL_METADATA);
        Self {
            nodata: text(GDAL_NODATA).trim().trim_end_matches('\0').parse().ok(),
            scale: item(metadata, "scale").unwrap_or(1.0),
            offset: item(metadata, "offset").unwrap_or(0.0),
        }
    }

    fn value(&self, sample: f64) -> f32 {
        match self.nodata {
            Some(nodata) if sample == nodata || sample as f32 == nodata as f32 => f32::NAN,
            _ => (sample * self.scale + self.offset) as f32,
        }
    }
}

/// The number of the first band's `<Item … role="scale">…</Item>` in GDAL's metadata.
fn item(xml: &str, role: &str) -> Option<f64> {
    let mark = format!("role=\"{role}\"");
    let items = xml.split("<Item").filter(|i| i.contains(&mark));
    let first = items.filter(|i| !i.contains("sample=\"") || i.contains("sample=\"0\"")).last()?;
    first.split_once('>')?.1.split('<').next()?.trim().parse().ok()
}

/// Metres a unit, by the unit's EPSG code.
fn metres(code: u16) -> Result<f64, RasterError> {
    match code {
        0 | METRE | USER_DEFINED => Ok(1.0),
        9002 => Ok(0.3048),
        9003 => Ok(1200.0 / 3937.0),
        9036 => Ok(1000.0),
        9096 => Ok(0.9144),
        other => Err(RasterError::UnknownCrs { found: format!("the unit of length EPSG:{other}") }),
    }
}

fn unreadable(error: impl std::fmt::Display) -> RasterError {
    RasterError::Unreadable { format: Format::GeoTiff, reason: error.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_and_offset_are_found_in_the_metadata() {
        let xml = "<GDALMetadata>\n  <Item name=\"AREA\">Area</Item>\n  <Item name=\"SCALE\" sample=\"0\" \
                   role=\"scale\">0.1</Item>\n  <Item name=\"OFFSET\" sample=\"0\" role=\"offset\">-273.15</Item>\n\
                   <Item name=\"SCALE\" sample=\"1\" role=\"scale\">7</Item></GDALMetadata>";
        assert_eq!((item(xml, "scale"), item(xml, "offset")), (Some(0.1), Some(-273.15)));
        assert_eq!(item("", "scale"), None);
    }

    #[test]
    fn a_nodata_value_that_was_rounded_to_32_bits_is_found() {
        let scaling = Scaling { nodata: Some(-3.4028234663852886e38), scale: 1.0, offset: 0.0 };
        assert!(scaling.value(f64::from(f32::MIN)).is_nan());
        assert_eq!(scaling.value(5.0), 5.0);
    }
}
