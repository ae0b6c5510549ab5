//! Stage 2a: the **climate** and the monthly maps it makes over a terrain: temperature,
//! sunlight with cast shadows, moisture.

pub mod horizon;
mod moisture;
mod sun;
mod sunlight;
mod temperature;

pub use moisture::MoistureRules;
pub use moisture::SATURATED;
pub use moisture::UNDER_WATER;
pub use moisture::moisture;
pub use sun::SOLAR_CONSTANT_W_PER_M2;
pub use sun::SunPath;
pub use sunlight::SunlightRules;
pub use sunlight::sunlight;
pub use temperature::Temperature;
pub use temperature::temperature;

use crate::compute::ecosystem::resources::MONTHS;

/// The climate of a month at the reference height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MonthClimate {
    /// Mean temperature, °C.
    pub temperature_mean_c: f64,
    /// Half the range between the mean daily minimum and maximum, °C, not negative.
    pub temperature_half_range_c: f64,
    /// Precipitation of the month, mm, not negative.
    pub precipitation_mm: f64,
    /// **Sunshine fraction**: the share of the possible hours of sunshine that is not lost to
    /// clouds, 0..=1.
    pub sunshine_fraction: f64,
}

/// A climate: what a year is like at one height.
#[derive(Debug, Clone, PartialEq)]
pub struct Climate {
    /// January to December.
    pub months: [MonthClimate; MONTHS],
    /// Height that the temperatures hold for, m.
    pub reference_height_m: f64,
    /// **Lapse rate**: how much colder it gets per metre of height, °C/m.
    pub lapse_c_per_m: f64,
    /// Latitude in degrees, north positive, −90..=90.
    pub latitude_deg: f64,
}

impl Climate {
    /// The mean lapse rate of the atmosphere, 0.65 °C per 100 m (ICAO standard atmosphere). The
    /// authors' sample uses 1 °C per 100 m, the dry rate.
    pub const LAPSE_C_PER_M: f64 = 0.0065;
}
