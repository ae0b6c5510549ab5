//! The **sun's path** over a day, in local solar time.

use crate::compute::ecosystem::resources::MONTHS;
use solar_positioning::SolarPositions;
use solar_positioning::time::JulianDate;
use std::f64::consts::PI;

/// The solar constant, W/m² (G. Kopp, J. L. Lean 2011).
pub const SOLAR_CONSTANT_W_PER_M2: f64 = 1361.0;

/// The sun on the 15th of a month at a latitude: its declination is held fixed for the day.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunPath {
    latitude: f64,
    declination: f64,
    /// Sunlight against that at the mean distance of the sun.
    pub distance_factor: f64,
}

impl SunPath {
    /// The path in `month` (0..12) at `latitude_deg` (north positive). Declination and distance are
    /// those of 2001, noon at Greenwich, by the solar position algorithm of I. Reda and A. Andreas
    /// (2003); from year to year they drift by less than 0.3° and 0.1 %.
    pub fn of_month(month: usize, latitude_deg: f64) -> Self {
        let (declination_deg, distance_au) = sun_at_noon(month);
        Self {
            latitude: latitude_deg.clamp(-90.0, 90.0).to_radians(),
            declination: declination_deg.to_radians(),
            distance_factor: 1.0 / (distance_au * distance_au),
        }
    }

    /// Unit vector towards the sun (east, north, up) at `hour_angle` radians past solar noon.
    pub fn direction(&self, hour_angle: f64) -> [f64; 3] {
        let (sin_lat, cos_lat) = (libm::sin(self.latitude), libm::cos(self.latitude));
        let (sin_dec, cos_dec) = (libm::sin(self.declination), libm::cos(self.declination));
        let (sin_hour, cos_hour) = (libm::sin(hour_angle), libm::cos(hour_angle));
        [
            -cos_dec * sin_hour,
            sin_dec * cos_lat - cos_dec * sin_lat * cos_hour,
            sin_dec * sin_lat + cos_dec * cos_lat * cos_hour,
        ]
    }

    /// The share of the day between sunrise and sunset over a flat horizon, without refraction:
    /// 0 in the polar night, 1 in the polar day.
    pub fn daylight_fraction(&self) -> f64 {
        self.sunset_hour_angle() / PI
    }

    /// Mean over 24 hours of the sine of the sun's height, 0 below the horizon: what flat ground
    /// receives of the beam, without an atmosphere.
    pub fn mean_sine(&self) -> f64 {
        let sunset = self.sunset_hour_angle();
        let (sin_lat, cos_lat) = (libm::sin(self.latitude), libm::cos(self.latitude));
        let (sin_dec, cos_dec) = (libm::sin(self.declination), libm::cos(self.declination));
        (sunset * sin_dec * sin_lat + libm::sin(sunset) * cos_dec * cos_lat) / PI
    }

    /// Energy on flat ground in a day without an atmosphere, kWh/m².
    pub fn extraterrestrial_kwh_per_m2(&self) -> f64 {
        24.0 * 1e-3 * SOLAR_CONSTANT_W_PER_M2 * self.distance_factor * self.mean_sine()
    }

    /// Hour angle of sunset, 0..=π.
    fn sunset_hour_angle(&self) -> f64 {
        let cosine = -libm::tan(self.latitude) * libm::tan(self.declination);
        libm::acos(cosine.clamp(-1.0, 1.0))
    }
}

/// Declination in degrees and distance in astronomical units of the sun on the 15th of `month`.
fn sun_at_noon(month: usize) -> (f64, f64) {
    /// Terrestrial less universal time in 2001, s.
    const DELTA_T_S: f64 = 64.0;
    let noon = JulianDate::from_utc(2001, (month % MONTHS) as u32 + 1, 15, 12, 0, 0.0, DELTA_T_S);
    let sun = noon.and_then(|time| SolarPositions::new().for_time_from_julian(time));
    let sun = sun.expect("the 15th of a month is a date");
    (sun.declination(), sun.earth_radius_vector().unwrap_or(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn day_length_and_energy_are_those_of_the_almanac() {
        // Latitude 42.8°, 15th of each month; hours from the refracted sunrise, energy by pvlib.
        let hours = [9.33, 10.53, 11.85, 13.35, 14.58, 15.27, 14.97, 13.88, 12.45, 11.02, 9.70, 8.98];
        let kwh = [3.751, 5.372, 7.376, 9.514, 11.002, 11.647, 11.307, 10.051, 8.126, 6.012, 4.170, 3.322];
        for month in 0..MONTHS {
            let sun = SunPath::of_month(month, 42.8);
            assert!((24.0 * sun.daylight_fraction() - hours[month]).abs() < 0.2, "hours in month {month}");
            let ratio = sun.extraterrestrial_kwh_per_m2() / kwh[month];
            assert!((ratio - 1.0).abs() < 0.02, "energy in month {month}: {ratio}");
        }
    }

    #[test]
    fn the_path_rises_in_the_east_and_culminates_in_the_south() {
        let sun = SunPath::of_month(2, 45.0);
        let [east, north, up] = sun.direction(0.0);
        assert!(east.abs() < 1e-12 && north < 0.0 && up > 0.5);
        assert!(sun.direction(-PI / 2.0)[0] > 0.9);
        assert!(SunPath::of_month(2, -45.0).direction(0.0)[1] > 0.0, "in the north, south of the equator");
    }

    #[test]
    fn the_sun_stays_up_in_the_polar_summer_and_down_in_the_polar_winter() {
        let (june, december) = (SunPath::of_month(5, 80.0), SunPath::of_month(11, 80.0));
        assert_eq!((june.daylight_fraction(), december.daylight_fraction()), (1.0, 0.0));
        assert_eq!(december.mean_sine(), 0.0);
        assert_eq!(SunPath::of_month(11, -80.0).daylight_fraction(), 1.0);
        assert!((SunPath::of_month(5, 90.0).mean_sine() - libm::sin(23.3f64.to_radians())).abs() < 1e-3);
    }
}
