use super::Error;
use super::Georeference;
use super::Map;
use super::MapData;
use super::Scale;
use geotiff_writer::CogBuilder;
use geotiff_writer::ColorMap;
use geotiff_writer::Compression;
use geotiff_writer::GeoKeyValue;
use geotiff_writer::GeoTiffBuilder;
use geotiff_writer::ModelType;
use geotiff_writer::NumericSample;
use geotiff_writer::PhotometricInterpretation;
use geotiff_writer::Predictor;
use geotiff_writer::RasterType;
use geotiff_writer::Resampling;
use ndarray::ArrayView2;
use std::io::Cursor;

/// Side of a tile in cells: the usual one of cloud-optimised GeoTIFFs.
const TILE: u32 = 512;

/// GeoKeys, OGC GeoTIFF 1.1 (annex B).
const GT_CITATION: u16 = 1026;
const PROJ_LINEAR_UNITS: u16 = 3076;
const METRE: u16 = 9001;

impl Map {
    /// A **cloud-optimised GeoTIFF**: tiles of 512 cells, deflate, overviews, quantities as
    /// 32-bit floats with NaN for no data, classes as 8- or 16-bit integers.
    ///
    /// A local world carries an engineering CRS (GeoKeys 1025, 1026 and 3076, as GDAL writes
    /// it), a real place its EPSG code. Overviews average, except of classes and of maps with
    /// holes, where they take the nearest cell: an average would invent classes and widen the
    /// holes.
    pub fn to_geotiff(&self) -> Result<Vec<u8>, Error> {
        match &self.data {
            MapData::F32(r) => {
                let holes = r.data.iter().any(|v| v.is_nan());
                let resampling = if holes { Resampling::NearestNeighbor } else { Resampling::Average };
                let builder = self.builder("nan").predictor(Predictor::FloatingPoint);
                self.cog(builder, resampling, &r.data)
            }
            MapData::U8(r) => self.cog(self.painted(self.builder("255")), Resampling::NearestNeighbor, &r.data),
            MapData::U16(r) => {
                let builder = self.builder("65535").predictor(Predictor::Horizontal);
                self.cog(builder, Resampling::NearestNeighbor, &r.data)
            }
        }
    }

    /// Size, place, coordinate system, no data, compression.
    fn builder(&self, nodata: &str) -> GeoTiffBuilder {
        let grid = self.grid();
        let north = grid.origin.y + grid.height as f64 * grid.cell_m;
        let builder = GeoTiffBuilder::new(grid.width as u32, grid.height as u32)
            .tile_size(TILE, TILE)
            .compression(Compression::Deflate)
            .nodata(nodata)
            .raster_type(RasterType::PixelIsArea)
            .pixel_scale(grid.cell_m, grid.cell_m)
            .origin(grid.origin.x, north)
            .geokey(PROJ_LINEAR_UNITS, GeoKeyValue::Short(METRE));
        match &self.georeference {
            Georeference::Local { name } => builder.geokey(GT_CITATION, GeoKeyValue::Ascii(ascii(name))),
            Georeference::Projected { epsg } => builder.model_type(ModelType::Projected).projected_epsg(*epsg),
        }
    }

    /// The colours of named classes as the file's colour table.
    fn painted(&self, builder: GeoTiffBuilder) -> GeoTiffBuilder {
        let Scale::Categories(categories) = &self.legend.scale else {
            return builder;
        };
        let mut channels = [vec![0_u16; 256], vec![0; 256], vec![0; 256]];
        for category in categories.iter().filter(|c| c.value < 256) {
            for (channel, value) in channels.iter_mut().zip(category.colour) {
                channel[category.value as usize] = u16::from(value) * 257;
            }
        }
        let [red, green, blue] = channels;
        match ColorMap::new(red, green, blue) {
            Ok(colours) => builder.photometric(PhotometricInterpretation::Palette).color_map(colours),
            Err(_) => builder,
        }
    }

    fn cog<T: NumericSample>(
        &self,
        builder: GeoTiffBuilder,
        resampling: Resampling,
        data: &[T],
    ) -> Result<Vec<u8>, Error> {
        let grid = self.grid();
        let view = ArrayView2::from_shape((grid.height, grid.width), data)
            .map_err(|e| geotiff_writer::Error::Other(e.to_string()))?;
        let mut sink = Cursor::new(Vec::new());
        CogBuilder::new(builder)
            .overview_levels(overviews(grid.width.max(grid.height)))
            .resampling(resampling)
            .write_2d_to(&mut sink, view)?;
        Ok(sink.into_inner())
    }
}

/// Reductions by 2, 4, … until one tile holds the map.
fn overviews(side: usize) -> Vec<u32> {
    (1..16).map(|k| 1_u32 << k).take_while(|f| side.div_ceil(*f as usize / 2) > TILE as usize).collect()
}

/// Citations are ASCII and may not hold the separator.
fn ascii(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_graphic() && c != '|' || c == ' ' { c } else { '_' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::map::tests::classes;
    use crate::codec::map::tests::hills;
    use geotiff_reader::GeoTiffFile;

    #[test]
    fn heights_come_back_with_their_place_and_their_holes() {
        let map = hills(1100, 700);
        let file = GeoTiffFile::from_bytes(map.to_geotiff().unwrap()).unwrap();
        let back = file.read_raster::<f32>().unwrap();
        let MapData::F32(r) = &map.data else { panic!() };
        assert!(r.data.iter().zip(back.iter()).all(|(a, b)| a.to_bits() == b.to_bits()));
        assert_eq!(file.pixel_to_geo(0.0, 0.0), Some((100.0, -50.0 + 700.0 * 2.5)));
        assert_eq!((file.nodata(), file.overview_count()), (Some("nan"), 2));
        let keys = file.geokeys();
        assert_eq!((keys.get_short(1025), keys.get_short(3076)), (Some(1), Some(9001)));
        assert_eq!((keys.get_ascii(1026), keys.get_short(1024), keys.get_short(3072)), (Some("hills"), None, None));
    }

    #[test]
    fn classes_keep_their_values_in_every_overview() {
        let map = classes();
        let file = GeoTiffFile::from_bytes(map.to_geotiff().unwrap()).unwrap();
        let MapData::U8(r) = &map.data else { panic!() };
        assert_eq!(file.read_raster::<u8>().unwrap().iter().copied().collect::<Vec<_>>(), r.data);
        assert_eq!((file.epsg(), file.nodata()), (Some(32631), Some("255")));
    }

    #[test]
    fn overviews_end_where_one_tile_is_enough() {
        assert_eq!(overviews(512), Vec::<u32>::new());
        assert_eq!(overviews(513), [2]);
        assert_eq!(overviews(4096), [2, 4, 8]);
    }
}
