//! Monthly temperature: the mean ± half the monthly range, less the lapse rate (T 5.2, papers'
//! method after Gain et al. 2017).

use crate::compute::ecosystem::climate::Climate;
use crate::compute::ecosystem::resources::MonthlyMap;
use crate::compute::raster::Raster;

/// Both monthly temperature maps, °C.
#[derive(Debug, Clone, PartialEq)]
pub struct Temperature {
    /// Mean of the daily minima.
    pub min_c: MonthlyMap,
    /// Mean of the daily maxima.
    pub max_c: MonthlyMap,
}

/// Monthly temperatures over `height` (m, NaN for no data): the climate's own at its reference
/// height, and `lapse_c_per_m` colder for every metre above it.
pub fn temperature(height: &Raster<f32>, climate: &Climate) -> Temperature {
    let (reference, lapse) = (climate.reference_height_m, climate.lapse_c_per_m);
    let base = height.map(|h| (-lapse * (f64::from(h) - reference)) as f32);
    let min = climate.months.map(|m| (m.temperature_mean_c - m.temperature_half_range_c) as f32);
    let max = climate.months.map(|m| (m.temperature_mean_c + m.temperature_half_range_c) as f32);
    Temperature {
        min_c: MonthlyMap::Shifted { base: base.clone(), offset: min },
        max_c: MonthlyMap::Shifted { base, offset: max },
    }
}
