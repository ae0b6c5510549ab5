//! The height maps of the examples, and those of the shared folder where it is present.

use std::path::Path;
use std::path::PathBuf;

use biotope::codec::colours::ColourMap;
use biotope::codec::map::Georeference;
use biotope::codec::map::Legend;
use biotope::codec::map::Map;
use biotope::codec::map::MapData;
use biotope::codec::terrain::Terrain;
use biotope::codec::terrain::TerrainOptions;
use biotope::compute::ecosystem::valley::Valley;
use biotope::compute::ecosystem::valley::ValleyOptions;
use biotope::compute::raster::Raster;

fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("api/examples")
}

fn read(path: &Path) -> Terrain {
    let bytes = std::fs::read(path).unwrap();
    Terrain::read(&bytes, &TerrainOptions::default()).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn codes(terrain: &Terrain) -> Vec<&str> {
    terrain.warnings.iter().map(|w| w.code).collect()
}

/// Least, mean and greatest height.
fn extremes(terrain: &Terrain) -> (f64, f64, f64) {
    let map = Map {
        data: MapData::F32(terrain.height.clone()),
        legend: Legend::continuous("Height", "m", ColourMap::Terrain),
        georeference: terrain.georeference.clone(),
    };
    let s = map.statistics();
    (s.min.unwrap(), s.mean.unwrap(), s.max.unwrap())
}

#[test]
fn the_committed_terrain_is_projected_to_square_cells_of_90_m() {
    let terrain = read(&examples().join("jacksboro.tif"));
    let grid = terrain.height.grid;
    assert_eq!((grid.width, grid.height, grid.cell_m), (344, 363, 90.0));
    assert_eq!(
        (terrain.georeference.clone(), codes(&terrain)),
        (Georeference::epsg(32616), vec!["GEOGRAPHIC_CRS", "NODATA_PRESENT"])
    );
    assert!((terrain.latitude_deg.unwrap() - 36.59).abs() < 0.01);
    let (min, mean, max) = extremes(&terrain);
    assert!((236.0..250.0).contains(&min) && (1065.0..=1076.0).contains(&max), "{min} {max}");
    // The mean of the sample itself is 530.98 m.
    assert!((mean - 531.0).abs() < 1.0, "{mean}");
}

#[test]
fn the_committed_valley_is_what_the_generator_makes() {
    let valley = Valley::generate(&ValleyOptions::default());
    let files = [
        ("valley.tif", "Synthetic valley", ColourMap::Terrain, valley.height),
        ("valley-water.tif", "Depth of the water", ColourMap::Water, valley.water_depth_m),
    ];
    for (name, title, colours, raster) in files {
        let path = examples().join(name);
        if std::env::var_os("UPDATE").is_some() {
            std::fs::write(&path, valley_map(title, colours, raster.clone()).to_geotiff().unwrap()).unwrap();
        }
        let found = read(&path);
        assert_eq!(found.georeference, Georeference::local("valley"));
        assert!(found.height == raster, "{name} is out of date: run this test with UPDATE=1");
    }
}

fn valley_map(title: &str, colours: ColourMap, raster: Raster<f32>) -> Map {
    Map {
        data: MapData::F32(raster),
        legend: Legend::continuous(title, "m", colours),
        georeference: Georeference::local("valley"),
    }
}

#[test]
fn the_shared_height_maps_are_read_as_they_are_described() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/dem");
    if !folder.is_dir() {
        return;
    }
    let tujunga = read(&folder.join("topotoolbox_bigtujunga.tif"));
    let grid = tujunga.height.grid;
    assert_eq!((grid.width, grid.height, grid.cell_m, tujunga.georeference.code()), (1197, 643, 30.0, Some(32611)));
    assert_eq!(extremes(&tujunga).0, 315.0);
    assert!((tujunga.latitude_deg.unwrap() - 34.32).abs() < 0.01 && tujunga.warnings.is_empty());

    let boulder = read(&folder.join("landlab_SRTMGL3_boulder.asc"));
    assert_eq!((boulder.height.grid.cell_m, boulder.georeference.code()), (90.0, Some(32613)));
    assert_eq!(codes(&boulder)[0], "GEOGRAPHIC_CRS");

    let gully = read(&folder.join("landlab_bijou_gully_5m.asc"));
    assert_eq!((gully.height.grid.width, gully.height.grid.height), (105, 77));
    assert!(gully.warnings.is_empty() && (gully.height.get(0, 0) - 1726.646).abs() < 1e-3);
}
