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

/// The photometric interpretation of a mask.
const MASK: u16 = 4;

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
    let mut values = values(tiff.tiff(), ifd)?;
    leave_out_masked(tiff.tiff(), ifd, &mut values)?;
    let place = tiff.place();
    if place.is_some() && tiff.key(1025) == Some(2) {
        let message = "the file's coordinates belong to the centres of its cells; they were moved by half a cell";
        warnings.push(Warning::new(warning::HALF_PIXEL_POINT, message));
    }
    Ok(Sheet {
        format: Format::GeoTiff,
        width: ifd.width() as usize,
        height: ifd.height() as usize,
        values,
        coding: Coding::Values,
        levels: levels(ifd),
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

/// The highest value of unsigned samples of at most 16 bits.
fn levels(ifd: &Ifd) -> Option<u32> {
    let layout = ifd.raster_layout().ok()?;
    (layout.sample_format == 1 && layout.bits_per_sample <= 16).then(|| (1 << layout.bits_per_sample) - 1)
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

/// Cells that an internal mask leaves out have no data: the mask is a second image of the same
/// size that is 0 there (TIFF 6.0, `TransparencyMask`).
fn leave_out_masked(tiff: &TiffFile, ifd: &Ifd, values: &mut [f32]) -> Result<(), RasterError> {
    let same_size = |other: &&Ifd| (other.width(), other.height()) == (ifd.width(), ifd.height());
    let is_mask = |other: &&Ifd| other.photometric_interpretation() == Some(MASK);
    let Some(mask) = tiff.ifds().iter().filter(is_mask).find(same_size) else { return Ok(()) };
    let seen = band::<u8>(tiff, mask, f32::from)?;
    values.iter_mut().zip(seen).filter(|(_, seen)| *seen == 0.0).for_each(|(value, _)| *value = f32::NAN);
    Ok(())
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
pub(crate) mod tests {
    use super::*;

    /// A tag of a test file.
    pub(crate) enum Tag {
        Shorts(Vec<u16>),
        Longs(Vec<u32>),
        Doubles(Vec<f64>),
        Text(&'static str),
    }

    impl Tag {
        /// Type, count and bytes, in the byte order asked for.
        fn encoded(&self, big: bool) -> (u16, usize, Vec<u8>) {
            fn all<T: Copy, const N: usize>(items: &[T], big: bool, write: impl Fn(T) -> [u8; N]) -> Vec<u8> {
                let turn = |mut b: [u8; N]| {
                    if big {
                        b.reverse();
                    }
                    b
                };
                items.iter().flat_map(|v| turn(write(*v))).collect()
            }
            match self {
                Self::Text(t) => (2, t.len() + 1, [t.as_bytes(), b"\0"].concat()),
                Self::Shorts(v) => (3, v.len(), all(v, big, u16::to_le_bytes)),
                Self::Longs(v) => (4, v.len(), all(v, big, u32::to_le_bytes)),
                Self::Doubles(v) => (12, v.len(), all(v, big, f64::to_le_bytes)),
            }
        }
    }

    /// An uncompressed TIFF of one strip; `samples` are already in the byte order.
    pub(crate) fn tiff(
        size: (u32, u32),
        kind: (u16, u16),
        samples: &[u8],
        more: Vec<(u16, Tag)>,
        big: bool,
    ) -> Vec<u8> {
        let mut tags = vec![
            (256, Tag::Longs(vec![size.0])),
            (257, Tag::Longs(vec![size.1])),
            (258, Tag::Shorts(vec![kind.1])),
            (259, Tag::Shorts(vec![1])),
            (262, Tag::Shorts(vec![1])),
            (273, Tag::Longs(vec![8])),
            (277, Tag::Shorts(vec![1])),
            (278, Tag::Longs(vec![size.1])),
            (279, Tag::Longs(vec![samples.len() as u32])),
            (339, Tag::Shorts(vec![kind.0])),
        ];
        tags.retain(|(code, _)| more.iter().all(|(other, _)| other != code));
        tags.extend(more);
        tags.sort_by_key(|t| t.0);
        let short = |v: u16| if big { v.to_be_bytes() } else { v.to_le_bytes() };
        let long = |v: u32| if big { v.to_be_bytes() } else { v.to_le_bytes() };
        let pad = samples.len().next_multiple_of(2);
        let ifd = 8 + pad;
        let mut file = if big { b"MM\0*".to_vec() } else { b"II*\0".to_vec() };
        file.extend(long(ifd as u32));
        file.extend(samples);
        file.resize(ifd, 0);
        file.extend(short(tags.len() as u16));
        let mut tail = Vec::new();
        let tail_at = ifd + 2 + 12 * tags.len() + 4;
        for (code, tag) in &tags {
            let (kind, count, mut bytes) = tag.encoded(big);
            file.extend(short(*code));
            file.extend(short(kind));
            file.extend(long(count as u32));
            if bytes.len() > 4 {
                file.extend(long((tail_at + tail.len()) as u32));
                tail.extend(bytes);
            } else {
                bytes.resize(4, 0);
                file.extend(bytes);
            }
        }
        file.extend(long(0));
        file.extend(tail);
        file
    }

    /// Tags that place cells of that size with the north-west corner at (`x`, `y`).
    pub(crate) fn placed(cell: (f64, f64), corner: (f64, f64), keys: &[[u16; 4]]) -> Vec<(u16, Tag)> {
        let directory = [&[1, 1, 0, keys.len() as u16], keys.as_flattened()].concat();
        vec![
            (33550, Tag::Doubles(vec![cell.0, cell.1, 0.0])),
            (33922, Tag::Doubles(vec![0.0, 0.0, 0.0, corner.0, corner.1, 0.0])),
            (34735, Tag::Shorts(directory)),
        ]
    }

    fn read(bytes: &[u8]) -> Result<Sheet, RasterError> {
        super::read(bytes, &SheetOptions::default())
    }

    fn samples<const N: usize>(bytes: [[u8; N]; 4]) -> Vec<u8> {
        bytes.concat()
    }

    #[test]
    fn every_numeric_sample_is_read_in_either_byte_order() {
        let values = [3.0, 0.0, 250.0, 7.0];
        let of = |kind, bytes: Vec<u8>, big| {
            let sheet = read(&tiff((2, 2), kind, &bytes, Vec::new(), big)).unwrap();
            assert_eq!(sheet.values, values, "{kind:?} {big}");
            assert_eq!((sheet.place, sheet.crs), (None, SourceCrs::Unknown));
        };
        of((1, 8), samples(values.map(|v| (v as u8).to_le_bytes())), false);
        of((1, 16), samples(values.map(|v| (v as u16).to_le_bytes())), false);
        of((1, 16), samples(values.map(|v| (v as u16).to_be_bytes())), true);
        of((1, 32), samples(values.map(|v| (v as u32).to_le_bytes())), false);
        of((1, 64), samples(values.map(|v| (v as u64).to_le_bytes())), false);
        of((2, 16), samples(values.map(|v| (v as i16).to_be_bytes())), true);
        of((2, 32), samples(values.map(|v| (v as i32).to_le_bytes())), false);
        of((2, 64), samples(values.map(|v| (v as i64).to_be_bytes())), true);
        of((3, 32), samples(values.map(|v| v.to_le_bytes())), false);
        of((3, 32), samples(values.map(|v| v.to_be_bytes())), true);
        of((3, 64), samples(values.map(|v| f64::from(v).to_le_bytes())), false);
    }

    #[test]
    fn scale_offset_and_nodata_are_honoured() {
        let xml = "<GDALMetadata><Item name=\"SCALE\" sample=\"0\" role=\"scale\">0.5</Item>\
                   <Item name=\"OFFSET\" sample=\"0\" role=\"offset\">100</Item></GDALMetadata>";
        let tags = vec![(GDAL_METADATA, Tag::Text(xml)), (GDAL_NODATA, Tag::Text("-9999"))];
        let bytes = samples([1_i16, -9999, 3, 4].map(i16::to_le_bytes));
        let sheet = read(&tiff((2, 2), (2, 16), &bytes, tags, false)).unwrap();
        assert!(sheet.values[1].is_nan());
        assert_eq!((sheet.values[0], sheet.values[3]), (100.5, 102.0));
    }

    #[test]
    fn scale_and_offset_of_other_bands_are_left_alone() {
        let xml = "<Item name=\"SCALE\" sample=\"0\" role=\"scale\">0.1</Item>\
                   <Item name=\"SCALE\" sample=\"1\" role=\"scale\">7</Item>";
        assert_eq!((item(xml, "scale"), item(xml, "offset"), item("", "scale")), (Some(0.1), None, None));
    }

    #[test]
    fn a_nodata_value_that_was_rounded_to_32_bits_is_found() {
        let scaling = Scaling { nodata: Some(-3.4028234663852886e38), scale: 1.0, offset: 0.0 };
        assert!(scaling.value(f64::from(f32::MIN)).is_nan());
        assert_eq!(scaling.value(5.0), 5.0);
    }

    #[test]
    fn a_file_whose_coordinates_belong_to_points_equals_its_twin() {
        let bytes = [0; 4];
        let area = placed((10.0, 10.0), (500.0, 900.0), &[[1024, 0, 1, 1], [1025, 0, 1, 1], [3072, 0, 1, 32631]]);
        let point = placed((10.0, 10.0), (505.0, 895.0), &[[1024, 0, 1, 1], [1025, 0, 1, 2], [3072, 0, 1, 32631]]);
        let area = read(&tiff((2, 2), (1, 8), &bytes, area, false)).unwrap();
        let point = read(&tiff((2, 2), (1, 8), &bytes, point, false)).unwrap();
        assert_eq!((area.place, &area.crs), (point.place, &point.crs));
        assert_eq!(area.crs, SourceCrs::Projected(Some(32631), 1.0));
        assert!(area.warnings.is_empty() && point.warnings[0].code == warning::HALF_PIXEL_POINT);
    }

    #[test]
    fn colour_is_refused_and_so_is_a_huge_file() {
        let rgb = vec![(262, Tag::Shorts(vec![2])), (277, Tag::Shorts(vec![3])), (258, Tag::Shorts(vec![8; 3]))];
        let error = read(&tiff((1, 1), (1, 8), &[1, 2, 3], rgb, false)).unwrap_err();
        assert_eq!(error.code(), "COLOR_PNG");
        let error = read(&tiff((40_000, 40_000), (3, 32), &[0; 4], Vec::new(), false)).unwrap_err();
        assert!(matches!(error, RasterError::TooLarge { width: 40_000, .. }), "{error}");
    }

    /// `file` with an internal mask of one bit a cell, each row a byte.
    fn masked(mut file: Vec<u8>, size: (u32, u32), rows: &[u8]) -> Vec<u8> {
        let long = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
        let ifd = long(4);
        let next = ifd + 2 + 12 * usize::from(u16::from_le_bytes([file[ifd], file[ifd + 1]]));
        let bits = file.len() as u32;
        file.extend(rows);
        file.resize(file.len().next_multiple_of(2), 0);
        let at = file.len() as u32;
        file[next..next + 4].copy_from_slice(&at.to_le_bytes());
        let tags = [(254, 4), (256, size.0), (257, size.1), (258, 1), (259, 1), (262, 4), (273, bits), (277, 1)];
        let tags = [&tags[..], &[(278, size.1), (279, rows.len() as u32)]].concat();
        file.extend((tags.len() as u16).to_le_bytes());
        for (code, value) in tags {
            file.extend([code as u16, 4].map(u16::to_le_bytes).concat());
            file.extend([1, value].map(u32::to_le_bytes).concat());
        }
        file.extend([0; 4]);
        file
    }

    #[test]
    fn cells_that_a_mask_leaves_out_have_no_data() {
        let bytes = samples([1.0_f32, 2.0, 3.0, 4.0].map(f32::to_le_bytes));
        let whole = tiff((2, 2), (3, 32), &bytes, Vec::new(), false);
        let sheet = read(&masked(whole.clone(), (2, 2), &[0b1000_0000, 0b0100_0000])).unwrap();
        let values: Vec<_> = sheet.values.iter().map(|v| Some(*v).filter(|v| !v.is_nan())).collect();
        assert_eq!(values, [Some(1.0), None, None, Some(4.0)]);
        let other = read(&masked(whole, (1, 1), &[0])).unwrap();
        assert_eq!(other.values, [1.0, 2.0, 3.0, 4.0], "a mask of another size belongs to another image");
    }

    #[test]
    fn places_that_are_not_numbers_are_refused() {
        let tags = placed((f64::NAN, 10.0), (0.0, 0.0), &[]);
        let error = read(&tiff((2, 2), (1, 8), &[0; 4], tags, false)).unwrap_err();
        assert!(matches!(error, RasterError::Georeference { .. }), "{error}");
    }

    #[test]
    fn damaged_files_are_errors_and_never_panics() {
        let tags = || placed((10.0, 10.0), (500.0, 900.0), &[[1024, 0, 1, 1], [3072, 0, 1, 32631]]);
        let file = tiff((8, 8), (3, 32), &[0; 256], tags(), false);
        let options = SheetOptions { max_cells: 10_000, raw: None };
        for at in 0..file.len() {
            for flip in [0x01, 0x80, 0xff] {
                let mut damaged = file.clone();
                damaged[at] ^= flip;
                let _ = super::read(&damaged, &options);
            }
            let _ = super::read(&file[..at], &options);
        }
    }
}
