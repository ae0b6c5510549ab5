//! Monthly **sunlight**: the light that falls on each cell, with slope, aspect and the shadows
//! that the terrain casts.
//!
//! **Light fraction.** The authors convert a "sunlit fraction" (0.01 to 0.25) to illumination 1–9.
//! We read it as energy, so that slope and aspect count: the share of the 24 hours for which the
//! sun would have to stand at its mean height over the sunlit half of the Earth (sine ½) in a
//! cloudless sky to give the ground as much light as it gets,
//!
//! light = sunshine fraction · [(1 − d) · beam + d · beam on open flat ground · sky view] / ½
//!
//! where beam is the mean over 24 hours of the cosine of the angle between the sun and the normal of
//! the ground, 0 while the sun is hidden, times the month's distance factor, and d the diffuse
//! share. Averaged over a year and the Earth, open flat ground gets half the sunshine
//! fraction, which is exactly the share of the time that the sun shines there. At 42.85° N and half
//! the possible sunshine it is about 0.09 in December, 0.23 in March and 0.35 in June.
//!
//! Atmospheric extinction is left out, as in the authors' scale.

use crate::compute::ecosystem::climate::Climate;
use crate::compute::ecosystem::climate::horizon;
use crate::compute::ecosystem::climate::horizon::Horizons;
use crate::compute::ecosystem::climate::horizon::horizons;
use crate::compute::ecosystem::climate::sun::SunPath;
use crate::compute::ecosystem::resources::MONTHS;
use crate::compute::ecosystem::resources::MonthlyMap;
use crate::compute::ecosystem::terrain::Terrain;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;
use std::f64::consts::PI;
use std::ops::Range;

/// How sunlight is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunlightRules {
    /// Directions in which the horizon is looked up, 4..=64; between them it is interpolated.
    pub directions: usize,
    /// d: the share of a cloudless day's light on open flat ground that comes from the whole
    /// sky, 0..=1.
    pub diffuse_share: f64,
}

impl Default for SunlightRules {
    /// 32 directions (ours: twice as many change the light fraction of steep terrain by 0.001 on
    /// average and by 0.02 at most, at the edges of shadows); a diffuse share of 0.15, that of
    /// clear skies (B. Y. H. Liu, R. C. Jordan 1960).
    fn default() -> Self {
        Self { directions: 32, diffuse_share: 0.15 }
    }
}

/// Lanes of a row of the table: the beam of twelve months, the sky, and three to fill up.
const LANES: usize = 16;
/// The lane of the sky.
const SKY: usize = MONTHS;
/// Directions at most: finer is lost on a grid.
const MAX_DIRECTIONS: usize = 64;
/// Instants of the day at which the sun is looked at.
const INSTANTS: usize = 720;

/// Cells of a row whose horizons are brought together at a time: maps of many directions whose
/// sizes are powers of two would push each other out of the cache.
const BLOCK: usize = 64;

/// Light by the part of the sky it comes from, as a vector (east, north, up) to be multiplied
/// with the normal of the ground.
type LightVector = [[f32; LANES]; 3];

/// The twelve light-fraction maps of a terrain; NaN where there is no data. Time and memory
/// (one byte a cell and direction while it works) grow linearly with cells × directions.
pub fn sunlight(terrain: &Terrain, climate: &Climate, rules: SunlightRules, run: &Run) -> Result<MonthlyMap, Stopped> {
    let grid = terrain.grid();
    run.progress("climate.sunlight", 0, 2)?;
    let directions = rules.directions.clamp(4, MAX_DIRECTIONS);
    let horizons = horizons(&terrain.height, directions, run)?;
    run.progress("climate.sunlight", 1, 2)?;
    let sky = Sky::new(climate, directions, rules.diffuse_share.clamp(0.0, 1.0));
    let mut maps = vec![Raster::filled(grid, 0.0f32); MONTHS];
    let mut rows: Vec<Vec<&mut [f32]>> = (0..grid.height).map(|_| Vec::with_capacity(MONTHS)).collect();
    for map in &mut maps {
        map.data.chunks_mut(grid.width).zip(&mut rows).for_each(|(chunk, row)| row.push(chunk));
    }
    rows.into_par_iter().enumerate().try_for_each(|(row, mut months)| {
        for left in (0..grid.width).step_by(BLOCK) {
            let cells = grid.index(left, row)..grid.index((left + BLOCK).min(grid.width), row);
            sky.light_block(terrain, &horizons, cells, |column, light| {
                months.iter_mut().zip(light).for_each(|(month, light)| month[left + column] = light);
            });
        }
        run.check()
    })?;
    run.progress("climate.sunlight", 2, 2)?;
    Ok(MonthlyMap::Maps(maps))
}

/// What comes from the sky of a climate.
struct Sky {
    /// Unit vectors (east, north) of the directions.
    towards: Vec<(f32, f32)>,
    /// For direction `s` and horizon code `c` at `s * CODES + c`: the light from above that horizon.
    above: Vec<LightVector>,
    /// Light of a wholly visible sky, by month.
    diffuse: [f32; MONTHS],
}

impl Sky {
    fn new(climate: &Climate, directions: usize, diffuse_share: f64) -> Self {
        let mut bands = vec![[[0.0; LANES]; 3]; directions * horizon::CODES];
        let mut diffuse = [0.0; MONTHS];
        for (month, diffuse) in diffuse.iter_mut().enumerate() {
            let sun = SunPath::of_month(month, climate.latitude_deg);
            let full = 2.0 * climate.months[month].sunshine_fraction * sun.distance_factor;
            *diffuse = (full * diffuse_share * sun.mean_sine()) as f32;
            add_beam(&mut bands, month, &sun, full * (1.0 - diffuse_share));
        }
        let turns = (0..directions).map(|s| 2.0 * PI * s as f64 / directions as f64);
        let towards: Vec<(f64, f64)> = turns.map(|a| (libm::cos(a), libm::sin(a))).collect();
        for (s, bands) in bands.chunks_mut(horizon::CODES).enumerate() {
            accumulate_downwards(bands);
            add_sky(bands, towards[s], 2.0 / directions as f64);
        }
        let above = bands.iter().map(|vector| vector.map(|lanes| lanes.map(|v| v as f32))).collect();
        Self { towards: towards.iter().map(|t| (t.0 as f32, t.1 as f32)).collect(), above, diffuse }
    }

    /// Shows `write` the light fractions by month of up to [`BLOCK`] cells, each with its place.
    fn light_block(
        &self,
        terrain: &Terrain,
        horizons: &Horizons,
        cells: Range<usize>,
        mut write: impl FnMut(usize, [f32; MONTHS]),
    ) {
        let mut codes = [[0u8; BLOCK]; MAX_DIRECTIONS];
        for (near, far) in codes.iter_mut().zip(&horizons.codes) {
            near[..cells.len()].copy_from_slice(&far[cells.clone()]);
        }
        let codes = &codes[..self.towards.len()];
        for (place, cell) in cells.enumerate() {
            let (slope, aspect) = (terrain.slope.data[cell], terrain.aspect.data[cell]);
            let horizon = codes.iter().map(|codes| codes[place]);
            write(place, if slope.is_nan() { [f32::NAN; MONTHS] } else { self.light((slope, aspect), horizon) });
        }
    }

    /// Light fraction by month of a cell of the given slope and aspect under its horizon.
    #[inline]
    fn light(&self, (slope, aspect): (f32, f32), horizon: impl Iterator<Item = u8>) -> [f32; MONTHS] {
        let (east, north) = (slope * libm::cosf(aspect), slope * libm::sinf(aspect));
        let mut sum: LightVector = [[0.0; LANES]; 3];
        for (s, (code, towards)) in horizon.zip(&self.towards).enumerate() {
            // The ground itself hides what lies below its own plane.
            let own = horizon::code(-(east * towards.0 + north * towards.1));
            let from = &self.above[s * horizon::CODES + usize::from(code.max(own))];
            for (sums, lanes) in sum.iter_mut().zip(from) {
                sums.iter_mut().zip(lanes).for_each(|(sum, lane)| *sum += lane);
            }
        }
        let up = 1.0 / (1.0 + slope * slope).sqrt();
        let on_ground = |lane: usize| (up * (east * sum[0][lane] + north * sum[1][lane] + sum[2][lane])).max(0.0);
        let sky_view = on_ground(SKY).min(1.0);
        std::array::from_fn(|month| rounded(on_ground(month) + self.diffuse[month] * sky_view))
    }
}

/// A light fraction (0..=2) to whole 1/4096: a hundredth of a unit of the authors' scale, a quarter
/// of what the number of directions leaves open. Twelve maps of such numbers take half the room.
fn rounded(light: f32) -> f32 {
    // 23 bits after the leading one: beside 3072 they end at 1/4096.
    const SHIFT: f32 = 3072.0;
    (light + SHIFT) - SHIFT
}

/// A [`LightVector`] while it is summed.
type Band = [[f64; LANES]; 3];

/// Adds the beam of a day, `full` times its mean over 24 hours, to the bands of horizon codes that
/// it stands in, split between the two nearest directions.
fn add_beam(bands: &mut [Band], month: usize, sun: &SunPath, full: f64) {
    let directions = bands.len() / horizon::CODES;
    for instant in 0..INSTANTS {
        let hour_angle = 2.0 * PI * (instant as f64 + 0.5) / INSTANTS as f64 - PI;
        let beam = sun.direction(hour_angle);
        if beam[2] <= 0.0 {
            continue;
        }
        let turn = (libm::atan2(beam[1], beam[0]) / (2.0 * PI)).rem_euclid(1.0) * directions as f64;
        let before = turn.floor();
        for (direction, share) in [(before, 1.0 - (turn - before)), (before + 1.0, turn - before)] {
            let band = &mut bands[(direction as usize % directions) * horizon::CODES + band_of(beam)];
            band.iter_mut().zip(beam).for_each(|(lanes, b)| lanes[month] += full * share * b / INSTANTS as f64);
        }
    }
}

/// The greatest horizon code above which the sun still stands.
fn band_of(beam: [f64; 3]) -> usize {
    let place = horizon::place((beam[2] / libm::hypot(beam[0], beam[1])) as f32);
    (place.ceil() as usize).clamp(1, horizon::CODES - 1) - 1
}

/// Turns the light of each band into the light of it and all higher bands.
fn accumulate_downwards(bands: &mut [Band]) {
    for band in (0..bands.len() - 1).rev() {
        let higher = bands[band + 1];
        let sums = bands[band].iter_mut().flatten().zip(higher.iter().flatten());
        sums.for_each(|(low, high)| *low += high);
    }
}

/// Sets the light of an evenly bright sky above each horizon: the integral of the unit vector
/// over the sky above it, such that flat open ground gets 1 from all directions together
/// (`width` = 2 / number of directions; J. Dozier, J. Frew 1990 for the sky view of slopes).
fn add_sky(bands: &mut [Band], towards: (f64, f64), width: f64) {
    for (code, band) in bands.iter_mut().enumerate() {
        let h = if code + 1 == horizon::CODES { 0.5 * PI } else { horizon::angle(code) };
        let level = 0.25 * PI - 0.5 * h - 0.25 * libm::sin(2.0 * h);
        let cosine = libm::cos(h);
        band[0][SKY] = width * level * towards.0;
        band[1][SKY] = width * level * towards.1;
        band[2][SKY] = width * 0.5 * cosine * cosine;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::ecosystem::climate::MonthClimate;
    use crate::compute::raster::Grid;

    fn climate(latitude_deg: f64) -> Climate {
        let month = MonthClimate {
            temperature_mean_c: 10.0,
            temperature_half_range_c: 5.0,
            precipitation_mm: 60.0,
            sunshine_fraction: 0.5,
        };
        Climate { months: [month; MONTHS], reference_height_m: 0.0, lapse_c_per_m: 0.0065, latitude_deg }
    }

    fn light(latitude_deg: f64, grid: Grid, height: impl Fn(f64, f64) -> f64) -> MonthlyMap {
        let data = (0..grid.len()).map(|i| grid.centre(i)).map(|p| height(p.x, p.y) as f32).collect();
        let terrain = Terrain::new(Raster { grid, data }, &Run::silent()).unwrap();
        sunlight(&terrain, &climate(latitude_deg), SunlightRules::default(), &Run::silent()).unwrap()
    }

    #[test]
    fn light_is_rounded_to_the_nearest_4096th() {
        for light in [0.0, 1e-5, 0.1, 0.234_567, 0.5, 1.0, 1.999] {
            let (is, exact) = (f64::from(rounded(light)), (f64::from(light) * 4096.0).round() / 4096.0);
            assert_eq!(is, exact, "{light}");
        }
        assert!(rounded(f32::NAN).is_nan());
    }

    #[test]
    fn open_flat_ground_gets_its_sunshine_by_the_sun_s_mean_height() {
        for latitude in [-80.0, -42.85, 0.0, 42.85, 66.0] {
            let map = light(latitude, Grid::new(3, 3, 1.0), |_, _| 7.0);
            for month in 0..MONTHS {
                let sun = SunPath::of_month(month, latitude);
                let expected = 2.0 * 0.5 * sun.distance_factor * sun.mean_sine();
                assert!((f64::from(map.value(month, 4)) - expected).abs() < 2e-3, "{latitude} {month}");
            }
        }
    }

    #[test]
    fn a_plane_gets_the_closed_form_of_its_tilt() {
        // A plane that falls to the south at latitude φ by the angle β is lit at noon-symmetric
        // hours as flat ground at φ − β, as long as the sun rises behind neither.
        let beta = 20f64.to_radians();
        let map = light(45.0, Grid::new(40, 40, 10.0), |_, y| libm::tan(beta) * y);
        let (sun, flat) = (SunPath::of_month(11, 25.0), SunPath::of_month(11, 45.0));
        // In December the sun sets earlier over the true horizon: integrate up to that hour angle.
        let n = 20_000;
        let beam = (0..n).map(|i| 2.0 * PI * (f64::from(i) + 0.5) / f64::from(n) - PI);
        let beam = beam.filter(|h| flat.direction(*h)[2] > 0.0).map(|h| sun.direction(h)[2].max(0.0)).sum::<f64>();
        let sky_view = 0.5 * (1.0 + libm::cos(beta));
        let expected = sun.distance_factor * (0.85 * beam / f64::from(n) + 0.15 * flat.mean_sine() * sky_view);
        let found = f64::from(map.value(11, 20 * 40 + 20));
        assert!((found - expected).abs() < 0.01 * expected, "{found} for {expected}");
    }

    #[test]
    fn the_sunny_side_of_a_hill_is_the_one_towards_the_equator() {
        let grid = Grid::new(41, 41, 10.0);
        let hill = |x: f64, y: f64| 150.0 * libm::exp(-((x - 205.0).powi(2) + (y - 205.0).powi(2)) / 8000.0);
        let (north_side, south_side) = (grid.index(20, 14), grid.index(20, 26));
        let contrast = |latitude: f64, month: usize| {
            let map = light(latitude, grid, hill);
            map.value(month, south_side) - map.value(month, north_side)
        };
        assert!(contrast(45.0, 2) > 0.05);
        assert!(contrast(-45.0, 2) < -0.05);
    }

    #[test]
    fn a_wall_to_the_south_hides_the_winter_sun_and_not_the_summer_sun() {
        // At noon in December at 45° N the sun stands 21.7° high, in June 68.3°.
        let grid = Grid::new(401, 81, 1.0);
        let map = light(45.0, grid, |_, y| if y < 1.0 { 10.0 } else { 0.0 });
        // Shadows end at 10 m / tan 21.7° = 25 m at noon, and are longest far from noon.
        let at = |north: usize| grid.index(200, 80 - north);
        let open = map.value(11, at(79));
        assert!(map.value(11, at(15)) < 0.25 * open, "in the shadow all day");
        assert!(map.value(11, at(40)) > 0.5 * open, "sunny at noon");
        assert!(map.value(5, at(8)) > 0.85 * map.value(5, at(79)));
    }

    #[test]
    fn the_polar_night_is_dark_and_what_has_no_data_stays_so() {
        let dark = light(85.0, Grid::new(2, 2, 1.0), |_, _| 0.0);
        assert_eq!(dark.value(11, 0), 0.0);
        let none = light(45.0, Grid::new(2, 2, 1.0), |_, _| f64::NAN);
        assert!(none.value(3, 1).is_nan());
    }
}
