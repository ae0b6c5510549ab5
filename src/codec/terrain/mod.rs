//! A height map comes in: from a file in any of the formats of [`super::sheet`] to heights in
//! metres on square cells, first row north.
//!
//! 1. [`Sheet::read`] – format, size limit, values, place
//! 2. [`heights`] – levels to metres, feet to metres, what is no height is refused
//! 3. [`Placing::of`] – what lies between the file's cells and square cells in metres
//! 4. [`warp::onto`] – resampling, when the cells are not square or not in metres
//! 5. the remarks: holes, coarse steps, heights of no place on Earth

mod place;
mod projection;
mod warp;

use crate::codec::map::Georeference;
use crate::codec::sheet::Coding;
use crate::codec::sheet::MAX_CELLS;
use crate::codec::sheet::RasterError;
use crate::codec::sheet::RawLayout;
use crate::codec::sheet::Sheet;
use crate::codec::sheet::SheetOptions;
use crate::codec::warning;
use crate::codec::warning::Warning;
use crate::compute::raster::Raster;
use place::Placing;

/// A step of height is remarked on where it makes steps of slope above this (rise over run).
const COARSE_SLOPE: f64 = 0.01;
/// The lowest and highest ground on Earth, metres, with some room.
const PLAUSIBLE_M: std::ops::RangeInclusive<f32> = -11_500.0..=9_500.0;
/// What most tools write where there is no data; no place on land is that low.
const USUAL_MARK: f32 = -9999.0;

/// What is said of a height map beside the file.
#[derive(Debug, Clone, PartialEq)]
pub struct TerrainOptions {
    /// Heights in metres of level 0 and of the highest level, for PNG and raw samples.
    pub range_m: Option<(f64, f64)>,
    /// Side of a cell in metres, for files that do not say it, and of the projected cells for
    /// files in degrees.
    pub cell_m: Option<f64>,
    /// The EPSG code of the coordinates, for files that do not name it.
    pub epsg: Option<u16>,
    /// Name of the local coordinate system where there is no other.
    pub name: String,
    /// How headerless samples lie.
    pub raw: Option<RawLayout>,
    /// Cells the file and the terrain may have.
    pub max_cells: u64,
}

impl Default for TerrainOptions {
    fn default() -> Self {
        Self { range_m: None, cell_m: None, epsg: None, name: "local".to_owned(), raw: None, max_cells: MAX_CELLS }
    }
}

/// A height map that can be worked on.
#[derive(Debug, Clone, PartialEq)]
pub struct Terrain {
    /// Heights in metres; NaN where there is no data. The grid's origin is the place of the
    /// south-west corner in the coordinates of `georeference`.
    pub height: Raster<f32>,
    /// On what the grid lies.
    pub georeference: Georeference,
    /// Latitude of the middle in degrees, where the coordinates tell it.
    pub latitude_deg: Option<f64>,
    /// What should be known.
    pub warnings: Vec<Warning>,
}

impl Terrain {
    /// Reads a height map.
    ///
    /// # Errors
    /// Whatever keeps the file from being one, with what was expected and what was found; see
    /// [`RasterError`]. The size is checked before anything is allocated.
    pub fn read(bytes: &[u8], options: &TerrainOptions) -> Result<Self, RasterError> {
        let sheet = Sheet::read(bytes, &SheetOptions { max_cells: options.max_cells, raw: options.raw })?;
        Self::of(sheet, options)
    }

    /// Makes a height map of a raster that was already read, such as another job's map.
    ///
    /// # Errors
    /// As [`Terrain::read`].
    pub fn of(mut sheet: Sheet, options: &TerrainOptions) -> Result<Self, RasterError> {
        if sheet.width < 2 || sheet.height < 2 {
            return Err(RasterError::TooSmall { width: sheet.width as u64, height: sheet.height as u64 });
        }
        let step_m = heights(&mut sheet, options.range_m)?;
        let placing = Placing::of(&sheet, options)?;
        let mut warnings = std::mem::take(&mut sheet.warnings);
        warnings.extend(placing.warnings.iter().cloned());
        let height = warp::onto(sheet, &placing);
        warnings.extend(remarks(&height, step_m));
        Ok(Self { height, georeference: placing.georeference, latitude_deg: placing.latitude_deg, warnings })
    }
}

/// Turns the values into metres and refuses what is no height. Returns the step between two
/// levels in metres, and how many bits they have, for values that are levels.
fn heights(sheet: &mut Sheet, range_m: Option<(f64, f64)>) -> Result<Option<(f64, u32)>, RasterError> {
    let step = match sheet.coding {
        Coding::Levels(highest) => {
            let (min, max) = range_m.ok_or(RasterError::NoRange { format: sheet.format })?;
            if !(min.is_finite() && max.is_finite() && min < max) {
                return Err(RasterError::BadRange { min, max });
            }
            let step = (max - min) / f64::from(highest);
            sheet.values.iter_mut().for_each(|v| *v = (min + f64::from(*v) * step) as f32);
            Some((step, highest.ilog2() + 1))
        }
        Coding::Values => sheet.levels.filter(|highest| *highest <= 255).and_then(|_| Some((least_step(sheet)?, 8))),
    };
    if let Some(unit) = sheet.height_unit_m.filter(|unit| *unit != 1.0) {
        sheet.values.iter_mut().for_each(|v| *v = (f64::from(*v) * unit) as f32);
        let message = format!("heights were converted to metres by the factor {unit}");
        sheet.warnings.push(Warning::new(warning::FEET_CONVERTED, message));
    }
    sheet.check_finite()?;
    match sheet.values.iter().all(|v| v.is_nan()) {
        true => Err(RasterError::AllNodata { cells: sheet.values.len() }),
        false => Ok(step),
    }
}

/// The smallest difference between two values of a sheet of few levels.
fn least_step(sheet: &Sheet) -> Option<f64> {
    let mut values: Vec<f32> = sheet.values.iter().copied().filter(|v| v.is_finite()).collect();
    values.sort_unstable_by(f32::total_cmp);
    values.dedup();
    values.windows(2).map(|pair| f64::from(pair[1]) - f64::from(pair[0])).min_by(f64::total_cmp)
}

fn remarks(height: &Raster<f32>, step: Option<(f64, u32)>) -> Vec<Warning> {
    let mut all = Vec::new();
    if let Some((step_m, bits)) = step {
        if bits <= 8 {
            let message = format!("heights of {bits} bits rise in steps of {step_m:.3} m: the ground will be terraced");
            all.push(Warning::new(warning::EIGHT_BIT, message));
        } else if step_m / height.grid.cell_m > COARSE_SLOPE {
            let slope = step_m / height.grid.cell_m;
            let message =
                format!("the smallest step of height is {:.0} mm: slopes rise in steps of {slope:.3}", step_m * 1e3);
            all.push(Warning::new(warning::HEIGHT_STEP, message));
        }
    }
    let holes = height.data.iter().filter(|v| v.is_nan()).count();
    if holes > 0 {
        let message = format!("{holes} of {} cells have no height; nothing lives there", height.data.len());
        all.push(Warning::new(warning::NODATA_PRESENT, message).with_count(holes));
    }
    let odd = height.data.iter().filter(|v| !v.is_nan() && (!PLAUSIBLE_M.contains(v) || **v == USUAL_MARK)).count();
    if odd > 0 {
        let message = format!(
            "{odd} heights are −9999 or outside −11,500 to 9,500 m: perhaps a mark for no data that is not declared"
        );
        all.push(Warning::new(warning::IMPLAUSIBLE_HEIGHT, message).with_count(odd));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::colours::ColourMap;
    use crate::codec::map::Legend;
    use crate::codec::map::Map;
    use crate::codec::map::MapData;
    use crate::codec::sheet::geotiff::tests::Tag;
    use crate::codec::sheet::geotiff::tests::placed;
    use crate::codec::sheet::geotiff::tests::tiff;
    use crate::codec::sheet::png::tests::claiming;
    use crate::codec::sheet::png::tests::png;
    use crate::compute::geometry::Point;
    use png::BitDepth;
    use png::ColorType;

    const UTM: [[u16; 4]; 3] = [[1024, 0, 1, 1], [1025, 0, 1, 1], [3072, 0, 1, 32631]];
    const LON_LAT: [[u16; 4]; 3] = [[1024, 0, 1, 2], [1025, 0, 1, 1], [2048, 0, 1, 4326]];

    /// A 32-bit TIFF of these heights.
    fn floats(size: (u32, u32), heights: &[f32], tags: Vec<(u16, Tag)>) -> Vec<u8> {
        let bytes: Vec<u8> = heights.iter().flat_map(|v| v.to_le_bytes()).collect();
        tiff(size, (3, 32), &bytes, tags, false)
    }

    fn read(bytes: &[u8]) -> Result<Terrain, RasterError> {
        Terrain::read(bytes, &TerrainOptions::default())
    }

    fn codes(terrain: &Terrain) -> Vec<&str> {
        terrain.warnings.iter().map(|w| w.code).collect()
    }

    #[test]
    fn a_projected_geotiff_keeps_its_cells_place_and_latitude() {
        let heights: Vec<f32> = (0..6_u8).map(f32::from).collect();
        let terrain = read(&floats((3, 2), &heights, placed((30.0, 30.0), (500_000.0, 4_750_060.0), &UTM))).unwrap();
        assert_eq!(terrain.height.data, heights);
        assert_eq!(terrain.height.grid.origin, Point::new(500_000.0, 4_750_000.0));
        assert_eq!((terrain.height.grid.cell_m, terrain.georeference.code()), (30.0, Some(32631)));
        assert!((terrain.latitude_deg.unwrap() - 42.9).abs() < 0.01 && terrain.warnings.is_empty());
    }

    #[test]
    fn rows_from_the_south_are_turned_round() {
        let matrix = |e: f64, y: f64| {
            let mut m = vec![0.0; 16];
            (m[0], m[3], m[5], m[7], m[15]) = (10.0, 0.0, e, y, 1.0);
            vec![(34264, Tag::Doubles(m)), (34735, Tag::Shorts([&[1, 1, 0, 3], UTM.as_flattened()].concat()))]
        };
        let north = read(&floats((2, 2), &[1.0, 2.0, 3.0, 4.0], matrix(-10.0, 20.0))).unwrap();
        let south = read(&floats((2, 2), &[3.0, 4.0, 1.0, 2.0], matrix(10.0, 0.0))).unwrap();
        assert_eq!(north, south);
        assert_eq!(north.height.data, [1.0, 2.0, 3.0, 4.0]);
    }

    #[test]
    fn degrees_become_square_cells_of_the_right_zone_with_data_wherever_the_file_has_it() {
        let (w, h) = (120, 90);
        let plane = |i: u32| 300.0 + (i % w) as f32 * 2.0 + (i / w) as f32 * 3.0;
        let heights: Vec<f32> = (0..w * h).map(plane).collect();
        let second3 = 3.0 / 3600.0;
        let terrain = read(&floats((w, h), &heights, placed((second3, second3), (-84.4, 36.7), &LON_LAT))).unwrap();
        let grid = terrain.height.grid;
        assert_eq!((grid.cell_m, terrain.georeference.code()), (90.0, Some(32616)));
        assert!(codes(&terrain).starts_with(&[warning::GEOGRAPHIC_CRS]));
        assert!((terrain.latitude_deg.unwrap() - 36.6625).abs() < 1e-6);
        // A cell is without data just where its centre lies outside the file's own rim.
        let zone = projection::Projection::between(None, 32616).unwrap();
        for i in 0..grid.len() {
            let q = zone.to_file(grid.centre(i)).unwrap();
            let (u, v) = ((q.x + 84.4) / second3, (36.7 - q.y) / second3);
            let depth = u.min(v).min(f64::from(w) - u).min(f64::from(h) - v);
            assert!(depth.abs() < 0.01 || terrain.height.data[i].is_nan() == (depth < 0.0), "{depth} cells deep");
        }
        let row = |r: usize| (0..grid.width).filter(|c| !terrain.height.get(*c, r).is_nan()).count();
        let column = |c: usize| (0..grid.height).filter(|r| !terrain.height.get(c, *r).is_nan()).count();
        assert!(row(0) > 0 && row(grid.height - 1) > 0 && column(0) > 0 && column(grid.width - 1) > 0);
    }

    #[test]
    fn a_projected_height_is_the_height_of_its_place() {
        let (w, h) = (60, 50);
        let degrees = |i: u32| (10.0 + (f64::from(i % w) + 0.5) * 0.001, -19.95 - (f64::from(i / w) + 0.5) * 0.001);
        let height = |lon: f64, lat: f64| 1000.0 * (lon - 10.0) - 700.0 * (lat + 20.0);
        let heights: Vec<f32> = (0..w * h).map(degrees).map(|(lon, lat)| height(lon, lat) as f32).collect();
        let terrain = read(&floats((w, h), &heights, placed((0.001, 0.001), (10.0, -19.95), &LON_LAT))).unwrap();
        assert_eq!(terrain.georeference.code(), Some(32732));
        let zone = projection::Projection::between(None, 32732).unwrap();
        let grid = terrain.height.grid;
        for i in (0..grid.len()).filter(|i| !terrain.height.data[*i].is_nan()) {
            let q = zone.to_file(grid.centre(i)).unwrap();
            let inside = (10.001..10.059).contains(&q.x) && (-19.999..-19.951).contains(&q.y);
            let error = f64::from(terrain.height.data[i]) - height(q.x, q.y);
            assert!(!inside || error.abs() < 5e-3, "{error} at {q:?}");
        }
    }

    #[test]
    fn web_mercator_is_brought_to_true_metres() {
        let (w, h) = (60, 50);
        let corner = Point::new(306_000.0, 5_290_000.0);
        let height = |x: f64, y: f64| 0.05 * (x - corner.x) + 0.03 * (corner.y - y);
        let at = |i: u32| (corner.x + (f64::from(i % w) + 0.5) * 40.0, corner.y - (f64::from(i / w) + 0.5) * 40.0);
        let heights: Vec<f32> = (0..w * h).map(at).map(|(x, y)| height(x, y) as f32).collect();
        let keys = [[1024, 0, 1, 1], [3072, 0, 1, 3857]];
        let terrain = read(&floats((w, h), &heights, placed((40.0, 40.0), (corner.x, corner.y), &keys))).unwrap();
        assert!(codes(&terrain).starts_with(&[warning::STRETCHED_CRS]));
        let (grid, latitude) = (terrain.height.grid, terrain.latitude_deg.unwrap());
        assert!((latitude - 42.848_892_8).abs() < 1e-6, "{latitude}");
        assert_eq!((grid.cell_m, terrain.georeference.code()), (40.0 * latitude.to_radians().cos(), Some(32631)));
        let zone = projection::Projection::between(Some(3857), 32631).unwrap();
        let middle = zone.to_plane(Point::new(307_200.0, 5_289_000.0)).unwrap();
        assert!(middle.distance(Point::new(480_359.445_95, 4_744_062.839_39)) < 0.01, "{middle:?} against PROJ");
        let seen: Vec<_> = (0..grid.len()).filter(|i| !terrain.height.data[*i].is_nan()).collect();
        assert!(seen.len() > 2800, "{}", seen.len());
        for i in seen {
            let q = zone.to_file(grid.centre(i)).unwrap();
            let (u, v) = ((q.x - corner.x) / 40.0, (corner.y - q.y) / 40.0);
            let inside = (0.5..59.5).contains(&u) && (0.5..49.5).contains(&v);
            let error = f64::from(terrain.height.data[i]) - height(q.x, q.y);
            assert!(!inside || error.abs() < 0.02, "{error} at {q:?}");
        }
    }

    #[test]
    fn cells_that_are_not_square_are_resampled_to_the_finer_side() {
        let heights: Vec<f32> = (0..12_u8).map(|i| f32::from(i % 3)).collect();
        let terrain = read(&floats((3, 4), &heights, placed((30.0, 10.0), (0.0, 40.0), &UTM))).unwrap();
        assert_eq!((terrain.height.grid.width, terrain.height.grid.height, terrain.height.grid.cell_m), (9, 4, 10.0));
        assert_eq!(codes(&terrain), [warning::NON_SQUARE_CELL]);
        let across = &terrain.height.data[..9];
        assert!(across.windows(2).all(|w| w[0] <= w[1]) && across[0] == 0.0 && across[8] == 2.0 && across[4] == 1.0);
    }

    #[test]
    fn feet_are_converted_both_ways() {
        let keys = [[1024, 0, 1, 1], [1025, 0, 1, 1], [3076, 0, 1, 9003], [4099, 0, 1, 9002]];
        let terrain = read(&floats((2, 2), &[1000.0; 4], placed((100.0, 100.0), (0.0, 200.0), &keys))).unwrap();
        assert!((terrain.height.grid.cell_m - 30.48006).abs() < 1e-5);
        assert!((terrain.height.data[0] - 304.8).abs() < 1e-4);
        assert_eq!(codes(&terrain), [warning::FEET_CONVERTED; 2]);
    }

    #[test]
    fn a_hole_stays_where_it_is_through_a_projection() {
        let (w, h) = (40_u32, 40_u32);
        let mut heights = vec![100.0; (w * h) as usize];
        for (row, column) in (15..20).flat_map(|r| (15..20).map(move |c| (r, c))) {
            heights[row * 40 + column] = f32::NAN;
        }
        let second3 = 3.0 / 3600.0;
        let terrain = read(&floats((w, h), &heights, placed((second3, second3), (3.0, 0.5), &LON_LAT))).unwrap();
        let grid = terrain.height.grid;
        let inner = |i: &usize| {
            let c = grid.cell(*i);
            (5..grid.width - 5).contains(&c.column) && (5..grid.height - 5).contains(&c.row)
        };
        let holes = (0..grid.len()).filter(|i| inner(i) && terrain.height.data[*i].is_nan()).count();
        assert!((22..=32).contains(&holes), "{holes} for 25 of 92.7 m");
        assert!(terrain.height.data.iter().all(|v| v.is_nan() || *v == 100.0));
    }

    #[test]
    fn levels_span_the_range_that_is_given() {
        let bytes = png((2, 2), ColorType::Grayscale, BitDepth::Sixteen, &[0, 0, 255, 255, 128, 0, 0, 1]);
        let options = TerrainOptions { range_m: Some((-10.0, 1300.7)), cell_m: Some(1.0), ..TerrainOptions::default() };
        let terrain = Terrain::read(&bytes, &options).unwrap();
        assert_eq!((terrain.height.data[0], terrain.height.data[1]), (-10.0, 1300.7));
        assert_eq!(terrain.height.grid, crate::compute::raster::Grid::new(2, 2, 1.0));
        assert_eq!(codes(&terrain), [warning::HEIGHT_STEP]);
        assert!(terrain.warnings[0].message.contains("20 mm"));
        let eight = png((2, 2), ColorType::Grayscale, BitDepth::Eight, &[0, 255, 1, 2]);
        assert_eq!(codes(&Terrain::read(&eight, &options).unwrap()), [warning::EIGHT_BIT]);
    }

    #[test]
    fn what_is_missing_is_asked_for_by_its_field() {
        let bytes = png((2, 2), ColorType::Grayscale, BitDepth::Sixteen, &[0; 8]);
        let with = |range_m, cell_m| {
            let options = TerrainOptions { range_m, cell_m, ..TerrainOptions::default() };
            let error = Terrain::read(&bytes, &options).unwrap_err();
            (error.code(), error.field())
        };
        assert_eq!(with(None, Some(1.0)), ("NO_RANGE", "range_m"));
        assert_eq!(with(Some((5.0, 5.0)), Some(1.0)), ("out-of-range", "range_m"));
        assert_eq!(with(Some((0.0, f64::INFINITY)), Some(1.0)), ("out-of-range", "range_m"));
        assert_eq!(with(Some((0.0, 5.0)), None), ("no-cell-size", "cell_m"));
        assert_eq!(with(Some((0.0, 5.0)), Some(-1.0)), ("out-of-range", "cell_m"));
    }

    #[test]
    fn what_is_no_terrain_is_refused_with_its_facts() {
        let utm = || placed((30.0, 30.0), (0.0, 60.0), &UTM);
        let code = |bytes: &[u8]| read(bytes).unwrap_err().code();
        assert_eq!(code(b""), "unreadable");
        assert_eq!(code(b"\xff\xd8\xff\xe0 and more"), "unreadable");
        assert_eq!(code(&floats((1, 1), &[5.0], utm())), "raster-too-small");
        assert_eq!(code(&floats((2, 2), &[f32::NAN; 4], utm())), "no-data");
        let infinite = read(&floats((2, 2), &[1.0, 2.0, f32::NEG_INFINITY, 3.0], utm())).unwrap_err();
        assert_eq!(infinite, RasterError::Infinite { count: 1, column: 0, row: 1 });
        assert_eq!(code(&floats((40_000, 40_000), &[0.0], utm())), "raster-too-large");
        let small = png((1, 1), ColorType::Grayscale, BitDepth::Sixteen, &[0, 0]);
        assert_eq!(code(&claiming(&small, 40_000, 40_000)), "raster-too-large");
        assert_eq!(code(b"ncols 40000\nnrows 40000\ncellsize 1\n"), "raster-too-large");
        assert_eq!(code(&png((2, 2), ColorType::Rgb, BitDepth::Eight, &[0; 12])), "COLOR_PNG");
        let matrix = placed((30.0, 30.0), (f64::INFINITY, 60.0), &UTM);
        assert_eq!(code(&floats((2, 2), &[1.0; 4], matrix)), "georeference-unusable");
    }

    #[test]
    fn holes_and_heights_of_no_place_on_earth_are_remarked_on() {
        for mark in [-32768.0, -9999.0] {
            let heights = [1.0, mark, f32::NAN, 3.0];
            let terrain = read(&floats((2, 2), &heights, placed((30.0, 30.0), (0.0, 60.0), &UTM))).unwrap();
            assert_eq!(codes(&terrain), [warning::NODATA_PRESENT, warning::IMPLAUSIBLE_HEIGHT]);
            assert_eq!(terrain.warnings.iter().map(|w| w.count).collect::<Vec<_>>(), [1, 1]);
        }
    }

    #[test]
    fn a_geotiff_of_8_bits_is_remarked_on_with_its_step() {
        let bytes = tiff((2, 2), (1, 8), &[10, 40, 14, 90], placed((30.0, 30.0), (0.0, 60.0), &UTM), false);
        let terrain = read(&bytes).unwrap();
        assert_eq!((terrain.height.data[1], codes(&terrain)), (40.0, vec![warning::EIGHT_BIT]));
        assert!(terrain.warnings[0].message.contains("4.000 m"), "{}", terrain.warnings[0].message);
    }

    #[test]
    fn a_grid_in_degrees_without_a_name_is_recognised_and_a_small_model_is_not() {
        let ascii = |corner: f64, cell: f64| {
            format!("ncols 3\nnrows 3\nxllcorner {corner}\nyllcorner {corner}\ncellsize {cell}\n1 2 3 4 5 6 7 8 9")
        };
        assert_eq!(codes(&read(ascii(12.5, 0.000_833_333_3).as_bytes()).unwrap())[0], warning::GEOGRAPHIC_CRS);
        let model = read(ascii(0.0, 0.01).as_bytes()).unwrap();
        assert_eq!((model.height.grid.cell_m, model.georeference), (0.01, Georeference::local("local")));
        let stated = TerrainOptions { epsg: Some(32631), ..TerrainOptions::default() };
        let stated = Terrain::read(ascii(12.5, 0.01).as_bytes(), &stated).unwrap();
        assert_eq!((stated.height.grid.cell_m, stated.georeference.code()), (0.01, Some(32631)));
    }

    #[test]
    fn another_jobs_map_is_a_terrain_in_either_form() {
        let grid = crate::compute::raster::Grid {
            origin: Point::new(7.0, 9.0),
            ..crate::compute::raster::Grid::new(3, 2, 5.0)
        };
        let height = Raster { grid, data: vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0] };
        let map = Map {
            data: MapData::F32(height.clone()),
            legend: Legend::continuous("Height", "m", ColourMap::Terrain),
            georeference: Georeference::local("carved"),
        };
        for bytes in [map.to_bytes(), map.to_geotiff().unwrap()] {
            let terrain = read(&bytes).unwrap();
            assert_eq!((&terrain.height, &terrain.georeference), (&height, &map.georeference));
            assert!(terrain.warnings.is_empty());
        }
    }
}
