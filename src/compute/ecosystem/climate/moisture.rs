//! Monthly **moisture** of the soil on the scale 1–9: precipitation, flow accumulation, slope and
//! standing water.
//!
//! The authors' sample gives log(drainage) + log(monthly precipitation) from −8 (1) to 2 (9). The
//! code they published (P. Ecormier-Nocca et al. 2021, MIT) says what that means: drainage is the
//! depth of the film of water that flows over the ground, as a share of the deepest on their map,
//! a river that drains 305 km²; precipitation is in millimetres; logarithms are natural:
//!
//! index = ln(h / h₀) + ln(P / 1 mm), h ∝ (a / (0.1 + √S))^⅔
//!
//! with a the drainage area per metre of contour, S the slope (rise over run) and P the month's
//! precipitation; 0.1 keeps level ground finite. h₀ is h where that river is level ([`RIVER_M`]):
//! a ridge in the driest month is then at −12, which is where the authors say their index begins.
//!
//! Ours, for the authors' map has cells of 1 m and ours need not: every place is fed by at least
//! [`MoistureRules::own_length_m`] of ground; cells too wide for slopes of that length see too
//! little of the ridges and hollows within them, and drainage per contour over slope grows in
//! proportion to their width (A. Ducharne 2009, Hydrol. Earth Syst. Sci. 13:2399: the mean of its
//! logarithm, less that of the width, hardly depends on the width), so what comes from above is
//! divided by that proportion; on ground flatter than
//! [`MoistureRules::level_grade`] water from above does not gather, so that level plains are even;
//! near water the ground is damp, by its height above it; no ground that is not under water is
//! wetter than [`SATURATED`], and what is under water is at [`UNDER_WATER`].

use crate::compute::ecosystem::climate::Climate;
use crate::compute::ecosystem::resources::MONTHS;
use crate::compute::ecosystem::resources::MonthlyMap;
use crate::compute::ecosystem::scales::MoistureScale;
use crate::compute::ecosystem::terrain::Terrain;
use crate::compute::ecosystem::water::Water;
use crate::compute::raster::Raster;
use crate::compute::raster::box_mean;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;

/// Moisture of ground that is full of water in its wettest month: 7 is "flooded for weeks" in
/// Julve's scale, and what is flooded for months (8) is no dry land.
pub const SATURATED: f64 = 7.0;
/// Moisture under water in its driest month: 9 and more are amphibious places in Julve's scale.
pub const UNDER_WATER: f64 = 9.0;

/// How moisture is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MoistureRules {
    /// Precipitation that a month at least counts for, mm: the index has no value at 0.
    pub min_precipitation_mm: f64,
    /// Length of slope that feeds any place, ridges too, and the widest cell that shows hillslopes
    /// as they are, m.
    pub own_length_m: f64,
    /// Slope below which water from above gathers the less, the flatter; rise over run.
    pub level_grade: f64,
    /// Height above water at which its damp has fallen to 1/e, m.
    pub damp_height_m: f64,
}

impl Default for MoistureRules {
    /// 1 mm, 10 m, 0.02, 1 m (all ours).
    fn default() -> Self {
        Self { min_precipitation_mm: 1.0, own_length_m: 10.0, level_grade: 0.02, damp_height_m: 1.0 }
    }
}

/// Moisture of every cell and month on the scale 1–9, not clamped; NaN where there is no data.
///
/// With the authors' scale months differ by their precipitation, in the same way everywhere. Julve's
/// value is one for the year: the index at the year's mean is read as **relative extractable
/// water** by a logistic curve that is ½ in the middle of the authors' range and 0.02 at its
/// lower end (ours: the scale's source prints no numbers).
pub fn moisture(
    terrain: &Terrain,
    water: &Water,
    climate: &Climate,
    (rules, scale): (MoistureRules, MoistureScale),
    run: &Run,
) -> Result<MonthlyMap, Stopped> {
    let rain = climate.months.map(|m| libm::log(m.precipitation_mm.max(rules.min_precipitation_mm)));
    let mean = rain.iter().sum::<f64>() / MONTHS as f64;
    let (convert, offset) = conversion(scale, rain.map(|month| month - mean));
    let (wettest, driest) = offset.iter().fold((0.0, 0.0), |(w, d), o| (o.max(w), o.min(d)));
    let index = drainage_index(terrain, water, &rules);
    run.check()?;
    let index = box_mean(&index, SMOOTHING);
    run.check()?;
    let ground = |cell: usize| {
        let dry = convert(f64::from(index.data[cell]) + mean).min(SATURATED - wettest);
        let damp = libm::exp(-above_water(terrain, water, cell) / rules.damp_height_m);
        dry + damp * (SATURATED - wettest - dry)
    };
    let value = |cell: usize| match terrain.height.data[cell].is_nan() {
        true => f64::NAN,
        false if water.is_open(cell) => UNDER_WATER - driest,
        false => ground(cell),
    };
    let data = (0..terrain.grid().len()).into_par_iter().map(|cell| value(cell) as f32).collect();
    run.check()?;
    Ok(MonthlyMap::Shifted { base: Raster { grid: terrain.grid(), data }, offset: offset.map(|o| o as f32) })
}

/// How high the middle of the ground of a cell lies above the nearest water, m. In a cell with a
/// stream that is a quarter of the cell away, up its slope; the way's fiftieth counts as in
/// [`Water::above_water_m`].
fn above_water(terrain: &Terrain, water: &Water, cell: usize) -> f64 {
    let beside = if water.is_wet(cell) { 0.25 * terrain.grid().cell_m } else { 0.0 };
    f64::from(water.above_water_m.data[cell]) + beside * (f64::from(terrain.slope.data[cell]) + 0.02)
}

/// What turns the year's mean index into moisture, and what each month adds to it.
fn conversion(scale: MoistureScale, rain: [f64; MONTHS]) -> (Box<dyn Fn(f64) -> f64 + Sync>, [f64; MONTHS]) {
    match scale {
        MoistureScale::WetnessIndex { one, nine } => {
            let per_index = 8.0 / (nine - one);
            (Box::new(move |index| 1.0 + (index - one) * per_index), rain.map(|r| r * per_index))
        }
        MoistureScale::ExtractableWater(scale) => {
            (Box::new(move |index| scale.at(1.0 / (1.0 + libm::exp(-(index + 3.0) / 1.285)))), [0.0; MONTHS])
        }
    }
}

/// Radius in cells over which the index is averaged (ours): water that the grid leads from cell to
/// cell wets the ground beside it.
const SMOOTHING: usize = 1;

/// Drainage area per metre of contour in the authors' river, m: 305 km², over the width of 29.5 m
/// that the regional curve of the streams gives it.
const RIVER_M: f64 = 305e6 / 29.5;

/// What the depth of flowing water is proportional to: drainage per metre of contour, and slope.
fn film(drainage_m: f64, slope: f64) -> f64 {
    libm::pow(drainage_m / (0.1 + slope.sqrt()), 2.0 / 3.0)
}

/// ln(h / h₀) of every cell; NaN where there is no data.
fn drainage_index(terrain: &Terrain, water: &Water, rules: &MoistureRules) -> Raster<f32> {
    let cell_m = terrain.grid().cell_m;
    let (river, seen) = (film(RIVER_M, 0.0), (rules.own_length_m / cell_m).min(1.0));
    let index = |(slope, drainage): (&f32, &f32)| {
        let (slope, drainage) = (f64::from(*slope), f64::from(*drainage));
        if slope.is_nan() || drainage.is_nan() {
            return f32::NAN;
        }
        // What drains to the centre of the cell.
        let above = (drainage / cell_m - 0.5 * cell_m).max(0.0);
        let gathered = above * seen * (slope / rules.level_grade).min(1.0);
        libm::log(film(rules.own_length_m + gathered, slope) / river) as f32
    };
    let data = terrain.slope.data.par_iter().zip(&water.drainage_m2.data).map(index).collect();
    Raster { grid: terrain.grid(), data }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::ecosystem::climate::MonthClimate;
    use crate::compute::ecosystem::scales::Scales;
    use crate::compute::ecosystem::water::WaterRules;
    use crate::compute::raster::Grid;

    fn climate(precipitation_mm: [f64; MONTHS]) -> Climate {
        let months = precipitation_mm.map(|precipitation_mm| MonthClimate {
            temperature_mean_c: 10.0,
            temperature_half_range_c: 5.0,
            precipitation_mm,
            sunshine_fraction: 0.5,
        });
        Climate { months, reference_height_m: 0.0, lapse_c_per_m: 0.0065, latitude_deg: 45.0 }
    }

    fn moist(grid: Grid, height: impl Fn(f64, f64) -> f64, rain: [f64; MONTHS], scales: Scales) -> MonthlyMap {
        let data = (0..grid.len()).map(|i| grid.centre(i)).map(|p| height(p.x, p.y) as f32).collect();
        let terrain = Terrain::new(Raster { grid, data }, &Run::silent()).unwrap();
        let water = Water::derived(&terrain.height, &WaterRules::default(), &Run::silent()).unwrap();
        let rules = (MoistureRules::default(), scales.moisture);
        moisture(&terrain, &water, &climate(rain), rules, &Run::silent()).unwrap()
    }

    #[test]
    fn a_slope_has_the_index_of_its_length_and_grade() {
        // 100 cells of 10 m on a slope of 0.2: at row 50 from the top 495 m and 10 m drain to the centre.
        let found = moist(Grid::new(81, 100, 10.0), |_, y| 0.2 * y, [60.0; MONTHS], Scales::authors());
        let film = |drainage_m: f64, slope: f64| 2.0 / 3.0 * libm::log(drainage_m / (0.1 + slope.sqrt()));
        let index = film(505.0, 0.2) - film(305e6 / 29.5, 0.0) + libm::log(60.0);
        let expected = 1.0 + (index + 8.0) * 0.8;
        assert!((f64::from(found.value(3, 40 + 81 * 49)) - expected).abs() < 1e-3);
    }

    #[test]
    fn wetter_months_are_moister_by_the_logarithm_and_a_dry_month_has_a_floor() {
        let mut rain = [60.0; MONTHS];
        (rain[0], rain[1]) = (30.0, 0.0);
        let map = moist(Grid::new(5, 50, 10.0), |_, y| 0.2 * y, rain, Scales::authors());
        let value = |month| f64::from(map.value(month, 12));
        assert!((value(2) - value(0) - 0.8 * libm::log(2.0)).abs() < 1e-4);
        assert!((value(2) - value(1) - 0.8 * libm::log(60.0)).abs() < 1e-4);
    }

    #[test]
    fn level_ground_is_even() {
        let map = moist(Grid::new(40, 40, 10.0), |_, _| 3.0, [60.0; MONTHS], Scales::authors());
        let first = map.value(0, 0);
        assert!((0..1600).all(|c| (map.value(0, c) - first).abs() < 1e-5));
        assert!((3.0..5.0).contains(&first), "{first}");
    }

    #[test]
    fn ground_dries_with_its_height_above_a_lake_and_the_lake_is_wettest() {
        let bowl = |x: f64, y: f64| (libm::hypot(x - 500.0, y - 500.0) * 0.05).min(20.0);
        for scales in [Scales::authors(), Scales::julve()] {
            let mut rain = [60.0; MONTHS];
            rain[4] = 90.0;
            let grid = Grid::new(100, 100, 10.0);
            let valley = |x: f64, y: f64| if x > 400.0 && x < 600.0 { bowl(x, y).min(5.0) } else { bowl(x, y) };
            let map = moist(grid, valley, rain, scales);
            assert!((0..MONTHS).all(|m| map.value(m, grid.index(50, 50)) >= 9.0 - 1e-5));
            let dry = (0..MONTHS).all(|m| {
                (0..grid.len()).all(|c| map.value(m, c) <= (SATURATED + 1e-5) as f32 || map.value(m, c) >= 9.0 - 1e-5)
            });
            assert!(dry, "nothing between saturated ground and water");
        }
    }
}
