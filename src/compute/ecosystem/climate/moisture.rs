//! Monthly **moisture** of the soil on the scale 1–9: precipitation, flow accumulation, slope and
//! standing water.
//!
//! The authors' sample gives log(drainage) + log(monthly precipitation) from −8 (1) to 2 (9)
//! without units. We read it as the **wetness index** of K. Beven and M. Kirkby (1979), natural
//! logarithms, lengths in kilometres and precipitation in metres,
//!
//! index = ln(a / (tan β · 1 km)) + ln(P / 1 m)
//!
//! with a the drainage area per metre of contour, β the slope and P the month's precipitation.
//! These are the units with which hillsides, valley floors and ridges of real terrain fill the
//! range from −8 to 2 at usual precipitation, whatever the size of the cells.
//!
//! Ours: every place is fed by at least [`MoistureRules::own_length_m`] of ground; on ground
//! flatter than [`MoistureRules::level_grade`] water from above does not gather, so that level
//! plains are even; near water the ground is damp, by its height above it; no ground that is not
//! under water is wetter than [`SATURATED`], and what is under water is at [`UNDER_WATER`].

use crate::compute::ecosystem::climate::Climate;
use crate::compute::ecosystem::resources::MONTHS;
use crate::compute::ecosystem::resources::MonthlyMap;
use crate::compute::ecosystem::scales::MoistureScale;
use crate::compute::ecosystem::terrain::Terrain;
use crate::compute::ecosystem::water::Water;
use crate::compute::raster::Raster;
use crate::compute::raster::box_mean;
use rayon::prelude::*;

/// Moisture of ground that is full of water in its wettest month: 8 is "flooded for months" in
/// Julve's scale.
pub const SATURATED: f64 = 8.0;
/// Moisture under water in its driest month: 9 and more are amphibious places in Julve's scale.
pub const UNDER_WATER: f64 = 9.0;

/// How moisture is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MoistureRules {
    /// Precipitation that a month at least counts for, mm: the index has no value at 0.
    pub min_precipitation_mm: f64,
    /// Length of slope that feeds any place, ridges too, m.
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
) -> MonthlyMap {
    let rain = climate.months.map(|m| libm::log(m.precipitation_mm.max(rules.min_precipitation_mm) * 1e-3));
    let mean = rain.iter().sum::<f64>() / MONTHS as f64;
    let (convert, offset) = conversion(scale, rain.map(|month| month - mean));
    let (wettest, driest) = offset.iter().fold((0.0, 0.0), |(w, d), o| (o.max(w), o.min(d)));
    let index = box_mean(&drainage_index(terrain, water, &rules), SMOOTHING);
    let ground = |cell: usize| {
        let dry = convert(f64::from(index.data[cell]) + mean).min(SATURATED - wettest);
        let damp = libm::exp(-f64::from(water.above_water_m.data[cell]) / rules.damp_height_m);
        dry + damp * (SATURATED - wettest - dry)
    };
    let value = |cell: usize| match terrain.height.data[cell].is_nan() {
        true => f64::NAN,
        false if water.is_open(cell) => UNDER_WATER - driest,
        false => ground(cell),
    };
    let data = (0..terrain.grid().len()).into_par_iter().map(|cell| value(cell) as f32).collect();
    MonthlyMap::Shifted { base: Raster { grid: terrain.grid(), data }, offset: offset.map(|o| o as f32) }
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

/// ln(a / (tan β · 1 km)) of every cell; NaN where there is no data.
fn drainage_index(terrain: &Terrain, water: &Water, rules: &MoistureRules) -> Raster<f32> {
    let cell_m = terrain.grid().cell_m;
    let index = |(slope, drainage): (&f32, &f32)| {
        let (slope, drainage) = (f64::from(*slope), f64::from(*drainage));
        if slope.is_nan() || drainage.is_nan() {
            return f32::NAN;
        }
        // What drains to the centre of the cell.
        let above = (drainage / cell_m - 0.5 * cell_m).max(0.0);
        let gathered = above * (slope / rules.level_grade).min(1.0);
        libm::log((rules.own_length_m + gathered) * 1e-3 / slope.max(rules.level_grade)) as f32
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
    use crate::compute::run::Run;

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
        moisture(&terrain, &water, &climate(rain), (MoistureRules::default(), scales.moisture))
    }

    #[test]
    fn a_slope_has_the_index_of_its_length_and_grade() {
        // 100 cells of 10 m on a slope of 0.2: at row 50 from the top 495 m and 10 m drain to the centre.
        let found = moist(Grid::new(81, 100, 10.0), |_, y| 0.2 * y, [60.0; MONTHS], Scales::authors());
        let index = libm::log(0.505 / 0.2) + libm::log(0.06);
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
        assert!((4.0..6.0).contains(&first), "{first}");
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
            let dry = (0..MONTHS)
                .all(|m| (0..grid.len()).all(|c| map.value(m, c) <= 8.0 + 1e-5 || map.value(m, c) >= 9.0 - 1e-5));
            assert!(dry, "nothing between saturated ground and water");
        }
    }
}
