//! Stages 1 and 2 of the ecosystem: water, sunlight, moisture and soil over real and made terrains.

use biotope::compute::ecosystem::climate::Climate;
use biotope::compute::ecosystem::climate::MonthClimate;
use biotope::compute::ecosystem::climate::SunPath;
use biotope::compute::ecosystem::climate::SunlightRules;
use biotope::compute::ecosystem::climate::sunlight;
use biotope::compute::ecosystem::resources::GivenMaps;
use biotope::compute::ecosystem::resources::MONTHS;
use biotope::compute::ecosystem::resources::MonthlyMap;
use biotope::compute::ecosystem::resources::ResourceError;
use biotope::compute::ecosystem::resources::ResourceRules;
use biotope::compute::ecosystem::resources::Resources;
use biotope::compute::ecosystem::scales::Scales;
use biotope::compute::ecosystem::terrain::Terrain;
use biotope::compute::ecosystem::water::Flow;
use biotope::compute::ecosystem::water::OUTLET;
use biotope::compute::ecosystem::water::Water;
use biotope::compute::ecosystem::water::WaterRules;
use biotope::compute::ecosystem::water::flood;
use biotope::compute::raster::Grid;
use biotope::compute::raster::Raster;
use biotope::compute::raster::compass::Compass;
use biotope::compute::run::Run;
use biotope::compute::run::StopFlag;
use proptest::prelude::*;
use std::f64::consts::PI;

/// The mild climate of the committed example.
fn mild(latitude_deg: f64) -> Climate {
    const MONTH: [(f64, f64, f64, f64); MONTHS] = [
        (4.3, 4.5, 65.0, 0.45),
        (4.5, 5.0, 60.0, 0.48),
        (7.5, 5.5, 60.0, 0.50),
        (10.5, 6.0, 70.0, 0.50),
        (14.2, 6.0, 65.0, 0.52),
        (18.6, 6.5, 45.0, 0.58),
        (21.2, 6.5, 30.0, 0.65),
        (21.1, 6.5, 40.0, 0.62),
        (17.1, 6.0, 60.0, 0.57),
        (13.5, 5.5, 90.0, 0.50),
        (8.0, 5.0, 75.0, 0.45),
        (4.7, 4.5, 65.0, 0.43),
    ];
    let months = MONTH.map(|(mean, half_range, precipitation_mm, sunshine_fraction)| MonthClimate {
        temperature_mean_c: mean,
        temperature_half_range_c: half_range,
        precipitation_mm,
        sunshine_fraction,
    });
    Climate { months, reference_height_m: 100.0, lapse_c_per_m: Climate::LAPSE_C_PER_M, latitude_deg }
}

fn raster(grid: Grid, height: impl Fn(f64, f64) -> f64) -> Raster<f32> {
    Raster { grid, data: (0..grid.len()).map(|i| grid.centre(i)).map(|p| height(p.x, p.y) as f32).collect() }
}

/// Rolling hills with valleys between them and a hole in the data.
fn hills(grid: Grid) -> Raster<f32> {
    let mut map = raster(grid, |x, y| {
        let wave = |k: f64, turn: f64| libm::sin(k * (x + 0.4 * y) + turn) * libm::cos(k * (0.7 * y - 0.3 * x));
        200.0 + 90.0 * wave(0.004, 0.0) + 30.0 * wave(0.011, 1.0) + 8.0 * wave(0.037, 2.0) + 0.03 * y
    });
    (0..grid.len()).filter(|i| grid.cell(*i).column.abs_diff(20) + grid.cell(*i).row.abs_diff(9) < 4).for_each(|i| {
        map.data[i] = f32::NAN;
    });
    map
}

fn assembled(height: Raster<f32>, given: GivenMaps) -> Result<Resources, ResourceError> {
    let run = Run::silent();
    let terrain = Terrain::new(height, &run)?;
    let water = Water::derived(&terrain.height, &WaterRules::default(), &run)?;
    Resources::assemble((&terrain, &water), &mild(42.85), (given, &ResourceRules::default()), &run)
}

/// All numbers of the maps as bits, for NaN is not equal to itself.
fn bits(resources: &Resources) -> Vec<u32> {
    let monthly =
        [&resources.temperature_min_c, &resources.temperature_max_c, &resources.sunlight, &resources.moisture];
    let mut bits: Vec<u32> = resources.soil.data.iter().map(|code| u32::from(*code)).collect();
    bits.extend(resources.texture.data.iter().map(|v| v.to_bits()));
    for month in 0..MONTHS {
        monthly.iter().for_each(|map| bits.extend(map.month(month).data.iter().map(|v| v.to_bits())));
    }
    bits
}

#[test]
fn the_maps_are_the_same_bytes_on_one_thread_and_on_two() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| bits(&assembled(hills(Grid::new(170, 130, 10.0)), GivenMaps::default()).unwrap()))
    };
    assert_eq!(on(1), on(2));
}

#[test]
fn a_stopped_run_stops() {
    let flag = StopFlag::default();
    flag.stop();
    let run = Run::stoppable(flag);
    let height = hills(Grid::new(60, 50, 10.0));
    assert!(Terrain::new(height.clone(), &run).is_err());
    assert!(Water::derived(&height, &WaterRules::default(), &run).is_err());
}

#[test]
fn what_has_no_data_has_none_in_any_map_and_the_rest_has_all() {
    let height = hills(Grid::new(60, 50, 10.0));
    let known: Vec<bool> = height.data.iter().map(|h| !h.is_nan()).collect();
    assert!(known.contains(&false));
    let maps = assembled(height, GivenMaps::default()).unwrap();
    for map in [&maps.temperature_min_c, &maps.temperature_max_c, &maps.sunlight, &maps.moisture] {
        for month in 0..MONTHS {
            assert!(known.iter().enumerate().all(|(cell, known)| map.value(month, cell).is_finite() == *known));
        }
    }
    assert!(known.iter().zip(&maps.texture.data).all(|(known, t)| t.is_finite() == *known));
}

#[test]
fn given_maps_are_taken_as_they_are_and_must_fit() {
    let grid = Grid::new(30, 20, 10.0);
    let sunlight = MonthlyMap::Shifted { base: Raster::filled(grid, 0.2f32), offset: [0.0; MONTHS] };
    let given = GivenMaps { sunlight: Some(sunlight.clone()), ..GivenMaps::default() };
    assert_eq!(assembled(hills(grid), given).unwrap().sunlight, sunlight);
    let given = GivenMaps { texture: Some(Raster::filled(Grid::new(3, 3, 10.0), 4.0)), ..GivenMaps::default() };
    assert_eq!(
        assembled(hills(grid), given).unwrap_err(),
        ResourceError::Size { map: "texture", expected: 600, found: 9 }
    );
    let given = GivenMaps { moisture: Some(MonthlyMap::Maps(Vec::new())), ..GivenMaps::default() };
    assert_eq!(assembled(hills(grid), given).unwrap_err(), ResourceError::Months { map: "moisture", found: 0 });
}

#[test]
fn behind_a_long_wall_the_sun_is_hidden_as_the_closed_form_says() {
    // North of a wall of height h along the whole southern border, at the distance d, the horizon
    // to the azimuth ψ from south has the tangent h·cos ψ / d.
    let (wall_m, sunshine) = (12.0, 0.5);
    let grid = Grid::new(601, 61, 1.0);
    let run = Run::silent();
    let terrain = Terrain::new(raster(grid, |_, y| if y < 1.0 { wall_m } else { 0.0 }), &run).unwrap();
    let mut climate = mild(45.0);
    climate.months.iter_mut().for_each(|m| m.sunshine_fraction = sunshine);
    let rules = SunlightRules { diffuse_share: 0.0, ..SunlightRules::default() };
    let light = sunlight(&terrain, &climate, rules, &run).unwrap();
    for month in [0, 2, 5, 9] {
        let sun = SunPath::of_month(month, 45.0);
        let shadow_m = {
            let noon = sun.direction(0.0);
            wall_m * -noon[1] / noon[2]
        };
        for distance in [4.0, 8.0, 16.0, 24.0, 40.0, 56.0] {
            let beam = |hour_angle: f64| {
                let [_, north, up] = sun.direction(hour_angle);
                // Over the wall: rise to its top against the run south to it.
                if up > 0.0 && up * distance > wall_m * -north { up } else { 0.0 }
            };
            let n = 5000;
            let mean =
                (0..n).map(|i| beam(2.0 * PI * (f64::from(i) + 0.5) / f64::from(n) - PI)).sum::<f64>() / f64::from(n);
            let expected = 2.0 * sunshine * sun.distance_factor * mean;
            let found = f64::from(light.value(month, grid.index(300, 60 - distance as usize)));
            // Within a cell of the place where the noon shadow ends, the day turns from dark to lit.
            let edge = (distance - shadow_m).abs() < 1.5;
            assert!(edge || (found - expected).abs() < 0.012, "month {month} at {distance} m: {found} for {expected}");
        }
    }
}

#[test]
fn north_and_south_of_the_equator_are_mirror_images_half_a_year_apart() {
    let grid = Grid::new(50, 50, 10.0);
    let run = Run::silent();
    let hill = |x: f64, y: f64| 120.0 * libm::exp(-((x - 200.0).powi(2) + (y - 180.0).powi(2)) / 12_000.0);
    let light = |latitude: f64, mirrored: bool| {
        let height = raster(grid, |x, y| hill(x, if mirrored { 500.0 - y } else { y }));
        let mut climate = mild(latitude);
        climate.months.iter_mut().for_each(|m| m.sunshine_fraction = 0.5);
        sunlight(&Terrain::new(height, &run).unwrap(), &climate, SunlightRules::default(), &run).unwrap()
    };
    let (north, south) = (light(45.0, false), light(-45.0, true));
    for cell in 0..grid.len() {
        let mirror = grid.index(cell % 50, 49 - cell / 50);
        for month in 0..MONTHS {
            // The sun is 3 % nearer in January than in July, which makes 7 % of its light; the
            // declinations of the 15th half a year apart differ by up to 0.8°, most felt on
            // slopes that the sun grazes.
            let (a, b) = (north.value(month, cell), south.value((month + 6) % MONTHS, mirror));
            assert!((a - b).abs() < 0.09 * a.max(b) + 0.02, "cell {cell}, month {month}: {a} and {b}");
        }
    }
}

#[test]
fn a_hill_is_sunny_to_the_south_at_45_north_and_to_the_north_at_45_south() {
    let (grid, run) = (Grid::new(60, 60, 10.0), Run::silent());
    let hill = |x: f64, y: f64| 90.0 * libm::exp(-((x - 300.0).powi(2) + (y - 300.0).powi(2)) / 20_000.0);
    let year = |latitude: f64, (column, row): (usize, usize)| {
        let terrain = Terrain::new(raster(grid, hill), &run).unwrap();
        let light = sunlight(&terrain, &mild(latitude), SunlightRules::default(), &run).unwrap();
        (0..MONTHS).map(|month| light.value(month, grid.index(column, row))).sum::<f32>()
    };
    // Rows count from the north; the slopes are as steep, 0.55, a hundred metres from the top.
    let (northern, southern) = ((30, 20), (30, 39));
    assert!(year(45.0, southern) > 1.5 * year(45.0, northern));
    assert!(year(-45.0, northern) > 1.5 * year(-45.0, southern));
}

#[test]
fn in_the_mild_climate_open_ground_is_fit_for_trees_in_the_growing_season_and_a_north_cliff_is_not() {
    let grid = Grid::new(80, 80, 10.0);
    let run = Run::silent();
    // A plateau, a cliff that faces north, and a plain below it.
    let cliff = |y: f64| if y < 300.0 { 150.0 } else { (150.0 - 1.8 * (y - 300.0)).max(0.0) };
    let terrain = Terrain::new(raster(grid, |_, y| cliff(y)), &run).unwrap();
    let light = sunlight(&terrain, &mild(42.85), SunlightRules::default(), &run).unwrap();
    let scale = Scales::default().illumination;
    let at =
        |month: usize, y: f64| scale.clamped(f64::from(light.value(month, grid.index(40, (79.0 - y / 10.0) as usize))));
    assert!((2..9).all(|month| at(month, 700.0) >= 7.0), "March to September on the plain");
    assert!(at(11, 700.0) < 5.0, "not in December");
    let months_fit = (0..MONTHS).filter(|month| at(*month, 340.0) >= 7.0).count();
    assert!(months_fit <= 3, "the cliff: {months_fit}");
}

#[test]
fn moisture_of_a_hillside_depends_little_on_the_size_of_the_cells() {
    let run = Run::silent();
    let at = |cell_m: f64, above: f64| {
        let side = (800.0 / cell_m) as usize;
        let terrain = Terrain::new(raster(Grid::new(side, side, cell_m), |_, y| 0.25 * y), &run).unwrap();
        let water = Water::derived(&terrain.height, &WaterRules::default(), &run).unwrap();
        let maps = Resources::assemble(
            (&terrain, &water),
            &mild(42.85),
            (GivenMaps::default(), &ResourceRules::default()),
            &run,
        );
        let place = terrain.grid().at(biotope::compute::geometry::Point::new(400.0, above)).unwrap();
        maps.unwrap().moisture.value(3, place)
    };
    for above in [750.0, 550.0, 250.0] {
        assert!((at(2.0, above) - at(10.0, above)).abs() < 0.3, "{above}");
    }
}

/// A small world of rough ground: heights in steps, so that there are flats, and holes.
fn worlds() -> impl Strategy<Value = Raster<f32>> {
    (1usize..14, 1usize..14).prop_flat_map(|(width, height)| {
        prop::collection::vec(prop_oneof![8 => (0i32..12).prop_map(|h| h as f32), 1 => Just(f32::NAN)], width * height)
            .prop_map(move |data| Raster { grid: Grid::new(width, height, 50.0), data })
    })
}

/// The filled level by its definition: the least, over all ways out, of the highest cell on the
/// way. Relaxed until nothing changes.
fn filled_by_definition(height: &Raster<f32>) -> Vec<f32> {
    let grid = height.grid;
    let outlet =
        |cell: usize| grid.neighbours(cell).count() < 8 || grid.neighbours(cell).any(|(n, _)| height.data[n].is_nan());
    let mut level: Vec<f32> = (0..grid.len()).map(|c| if outlet(c) { height.data[c] } else { f32::INFINITY }).collect();
    loop {
        let before = level.clone();
        for cell in (0..grid.len()).filter(|c| !height.data[*c].is_nan()) {
            let lowest = grid.neighbours(cell).map(|(n, _)| level[n]).fold(f32::INFINITY, f32::min);
            level[cell] = level[cell].min(lowest.max(height.data[cell]));
        }
        if level.iter().zip(&before).all(|(a, b)| a == b || a.is_nan()) {
            return level.iter().zip(&height.data).map(|(l, h)| if h.is_nan() { f32::NAN } else { *l }).collect();
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn depressions_are_filled_to_the_lowest_way_out(height in worlds()) {
        let flooded = flood(&height, &Run::silent()).unwrap();
        let expected = filled_by_definition(&height);
        prop_assert!(flooded.level.data.iter().zip(&expected).all(|(a, b)| a == b || (a.is_nan() && b.is_nan())));
        let compass = Compass::new(height.grid);
        for start in (0..height.grid.len()).filter(|c| !height.data[*c].is_nan()) {
            let mut cell = start;
            for _ in 0..=height.grid.len() {
                if flooded.way_out[cell] == OUTLET {
                    break;
                }
                let next = compass.step(cell, usize::from(flooded.way_out[cell]));
                prop_assert!(flooded.level.data[next] <= flooded.level.data[cell]);
                cell = next;
            }
            prop_assert_eq!(flooded.way_out[cell], OUTLET);
        }
    }

    #[test]
    fn what_falls_on_the_land_leaves_it(height in worlds()) {
        let flooded = flood(&height, &Run::silent()).unwrap();
        let land = height.data.iter().filter(|h| !h.is_nan()).count() as f64 * 2500.0;
        for flow in [Flow::steepest(&flooded), Flow::multiple(&flooded)] {
            let area = flow.accumulate(&flooded, &Run::silent()).unwrap();
            let leaves = (0..area.data.len()).filter(|c| flow.receivers(*c).next().is_none());
            let out: f64 = leaves.map(|c| f64::from(area.data[c])).filter(|a| !a.is_nan()).sum();
            prop_assert!((out - land).abs() <= 1e-4 * land);
            prop_assert!(area.data.iter().all(|a| a.is_nan() || *a >= 2500.0 && f64::from(*a) <= 1.0001 * land));
        }
    }

    #[test]
    fn no_world_is_too_strange(data in prop::collection::vec(any::<f32>(), 1..60), width in 1usize..8, cell_m in 0.01f64..1e5) {
        let height = data.len() / width;
        prop_assume!(height > 0);
        let grid = Grid::new(width, height, cell_m);
        let strange = Raster { grid, data: data[..grid.len()].to_vec() };
        prop_assert!(assembled(strange, GivenMaps::default()).is_ok());
    }

    #[test]
    fn water_is_where_its_map_says(height in worlds(), depth in 0.1f32..5.0) {
        let wet = |cell: usize| cell.is_multiple_of(5) && !height.data[cell].is_nan();
        let map = Raster { grid: height.grid, data: (0..height.grid.len()).map(|c| if wet(c) { depth } else { -1.0 }).collect() };
        let water = Water::given(&height, &map, &Run::silent()).unwrap();
        for cell in 0..height.grid.len() {
            prop_assert_eq!(water.is_wet(cell), wet(cell));
            prop_assert_eq!(water.is_open(cell), wet(cell));
        }
    }
}

/// The Front Range sample at 3 arc-seconds, as square cells of 80 m; `None` where the checks'
/// data is not at hand.
fn front_range() -> Option<Raster<f32>> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/dem/landlab_SRTMGL3_boulder.asc");
    let text = std::fs::read_to_string(path).ok()?;
    let (header, rest): (Vec<&str>, Vec<&str>) =
        text.lines().partition(|line| line.starts_with(|c: char| c.is_alphabetic()));
    let size = |key: &str| {
        let line = header.iter().find(|line| line.to_lowercase().starts_with(key))?;
        line.split_whitespace().nth(1)?.parse::<usize>().ok()
    };
    let data = rest.iter().flat_map(|line| line.split_whitespace()).map_while(|v| v.parse().ok()).collect();
    Raster::from_data(Grid::new(size("ncols")?, size("nrows")?, 80.0), data)
}

#[test]
fn over_a_real_terrain_moisture_spreads_over_its_scale() {
    let Some(height) = front_range() else { return };
    let maps = assembled(height, GivenMaps::default()).unwrap();
    let mut year: Vec<f32> = match &maps.moisture {
        MonthlyMap::Shifted { base, .. } => base.data.clone(),
        MonthlyMap::Maps(_) => unreachable!("computed moisture is shifted"),
    };
    year.sort_by(f32::total_cmp);
    let share =
        |from: f32, to: f32| year.iter().filter(|v| (from..=to).contains(*v)).count() as f64 / year.len() as f64;
    assert!(share(1.0, 8.0) > 0.98, "grasses (1 to 8) nearly everywhere: {}", share(1.0, 8.0));
    assert!(share(3.0, 6.0) > 0.5, "oaks (3 to 6) on the slopes: {}", share(3.0, 6.0));
    assert!((0.02..0.6).contains(&share(4.0, 9.0)), "damp valleys: {}", share(4.0, 9.0));
    let (dry, damp) = (year[year.len() / 20], year[year.len() * 19 / 20]);
    assert!(damp - dry > 1.0, "{dry} {damp}");
}
