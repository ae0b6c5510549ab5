//! What the cells offer before anything grows there.
//!
//! The text leaves open which light a cell has, month by month as it varies, but for this: what a
//! unit draws of it is a yearly amount (L 4.1). Light that falls on frozen ground keeps nothing
//! alive, so we count it from 5 °C (the threshold of the growing season length of the ETCCDI
//! climate indices, P. Frich et al. 2002). What is drawn on is the light of the year, each month's
//! by the part of its temperatures that is so warm. Whether a plant has the light it needs is told
//! by the mean over the **growing season**, the months whose mean temperature is; where no month
//! is so warm, the warmest one.

use crate::compute::ecosystem::fitness::Needs;
use crate::compute::ecosystem::fitness::share_in_range;
use crate::compute::ecosystem::fitness::temperature::mean_c;
use crate::compute::ecosystem::flora::rule;
use crate::compute::ecosystem::flora::rule::FULL_COVER;
use crate::compute::ecosystem::flora::stand::Site;
use crate::compute::ecosystem::resources::MONTHS;
use crate::compute::ecosystem::resources::MonthlyMap;
use crate::compute::ecosystem::resources::Resources;
use crate::compute::ecosystem::scales::Scale;
use crate::compute::ecosystem::species::Interval;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;

/// Mean temperature from which plants grow, °C.
const GROWTH_C: f32 = 5.0;

/// Temperatures at which plants grow, °C.
const GROWS: Interval = Interval::new(GROWTH_C as f64, f64::MAX);

/// The **capacity** of every cell for light and moisture, and the part of it kept bare.
pub(super) struct Sites<'a> {
    /// Physical light fraction, mean of the growing season.
    pub light: Raster<f32>,
    /// Physical light fraction that can be used over the year, and its scale; `None` where light
    /// does not count.
    light_drawn: Option<(Raster<f32>, Scale)>,
    /// Moisture on the scale, mean of the year.
    pub moisture: Raster<f32>,
    bare: Option<&'a Raster<f32>>,
}

impl<'a> Sites<'a> {
    pub(super) fn new(
        run: &Run,
        resources: &Resources,
        (needs, illumination): (Needs, Scale),
        bare: Option<&'a Raster<f32>>,
    ) -> Result<Self, Stopped> {
        let light = growing_season_light(resources);
        run.check()?;
        let light_drawn = needs.illumination.then(|| (usable_light(resources, needs), illumination));
        run.check()?;
        let moisture = yearly_mean(&resources.moisture);
        run.check()?;
        Ok(Self { light, light_drawn, moisture, bare })
    }

    pub(super) fn at(&self, cell: usize) -> Site<'_> {
        Site {
            light: self.light.data[cell],
            light_drawn: self.light_drawn.as_ref().map(|(light, scale)| (light.data[cell], scale)),
            moisture: self.moisture.data[cell],
            room: self.room(cell),
        }
    }

    fn room(&self, cell: usize) -> u16 {
        let bare = self.bare.map_or(0.0, |map| map.data[cell]);
        if bare.is_nan() { FULL_COVER } else { FULL_COVER - rule::cover(bare) }
    }
}

/// The mean light of the growing season of every cell; NaN where light or temperature has no data.
fn growing_season_light(resources: &Resources) -> Raster<f32> {
    let grid = resources.soil.grid;
    let light = |cell: usize| {
        let (mut sum, mut months, mut warmest) = (0.0, 0.0, (f32::NEG_INFINITY, f32::NAN));
        for month in 0..MONTHS {
            let (mean_c, light) = (mean_c(resources, month, cell), resources.sunlight.value(month, cell));
            if mean_c >= GROWTH_C {
                (sum, months) = (sum + light, months + 1.0);
            }
            if mean_c > warmest.0 {
                warmest = (mean_c, light);
            }
        }
        if months > 0.0 { sum / months } else { warmest.1 }
    };
    Raster { grid, data: (0..grid.len()).into_par_iter().map(light).collect() }
}

/// The mean over the year of the light that falls while it is warm enough to grow; all light where
/// temperature does not count. NaN where light has no data.
fn usable_light(resources: &Resources, needs: Needs) -> Raster<f32> {
    if !needs.temperature {
        return yearly_mean(&resources.sunlight);
    }
    let grid = resources.soil.grid;
    let warm = |month: usize, cell: usize| {
        let (coldest, warmest) = (&resources.temperature_min_c, &resources.temperature_max_c);
        let (low, high) = (coldest.value(month, cell), warmest.value(month, cell));
        share_in_range(GROWS, f64::from(low), f64::from(high)) as f32
    };
    let year = |cell: usize| {
        (0..MONTHS).map(|m| warm(m, cell) * resources.sunlight.value(m, cell)).sum::<f32>() / MONTHS as f32
    };
    Raster { grid, data: (0..grid.len()).into_par_iter().map(year).collect() }
}

/// The mean of the twelve months of every cell.
fn yearly_mean(map: &MonthlyMap) -> Raster<f32> {
    match map {
        MonthlyMap::Shifted { base, offset } => {
            let mean = offset.iter().sum::<f32>() / MONTHS as f32;
            Raster { grid: base.grid, data: base.data.par_iter().map(|v| v + mean).collect() }
        }
        MonthlyMap::Maps(maps) => {
            let mean = |cell| maps.iter().map(|m| m.data[cell]).sum::<f32>() / MONTHS as f32;
            Raster { grid: maps[0].grid, data: (0..maps[0].data.len()).into_par_iter().map(mean).collect() }
        }
    }
}
