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
use crate::compute::ecosystem::slabs;
use crate::compute::ecosystem::species::Interval;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;

/// Mean temperature from which plants grow, °C.
const GROWTH_C: f32 = 5.0;

/// Temperatures at which plants grow, °C.
const GROWS: Interval = Interval::new(GROWTH_C as f64, f64::MAX);

/// What the resources offer a cell before anything grows there: its **capacity** for light and
/// moisture, and the part of it kept bare.
pub(super) struct Offer<'a> {
    resources: &'a Resources,
    needs: Needs,
    illumination: Scale,
    bare: Option<&'a Raster<f32>>,
}

impl<'a> Offer<'a> {
    pub(super) fn new(
        resources: &'a Resources,
        (needs, illumination): (Needs, Scale),
        bare: Option<&'a Raster<f32>>,
    ) -> Self {
        Self { resources, needs, illumination, bare }
    }

    pub(super) fn at(&self, cell: usize) -> Site<'_> {
        let (light, usable) = self.light(cell);
        Site {
            light,
            light_drawn: self.needs.illumination.then_some((usable, &self.illumination)),
            moisture: self.moisture(cell),
            room: room(self.bare, cell),
        }
    }

    /// The mean light of the growing season, and the mean over the year of the light that falls
    /// while it is warm enough to grow; all light where temperature does not count. NaN where light
    /// has no data, the first also where temperature has none.
    fn light(&self, cell: usize) -> (f32, f32) {
        let resources = self.resources;
        let (mut sum, mut months, mut warmest) = (0.0, 0.0, (f32::NEG_INFINITY, f32::NAN));
        let mut year = 0.0;
        for month in 0..MONTHS {
            let (mean_c, light) = (mean_c(resources, month, cell), resources.sunlight.value(month, cell));
            if mean_c >= GROWTH_C {
                (sum, months) = (sum + light, months + 1.0);
            }
            if mean_c > warmest.0 {
                warmest = (mean_c, light);
            }
            year += self.warm(month, cell) * light;
        }
        (if months > 0.0 { sum / months } else { warmest.1 }, year / MONTHS as f32)
    }

    /// The part of a month's temperatures at which plants grow.
    fn warm(&self, month: usize, cell: usize) -> f32 {
        if !self.needs.temperature {
            return 1.0;
        }
        let (coldest, warmest) = (&self.resources.temperature_min_c, &self.resources.temperature_max_c);
        let (low, high) = (coldest.value(month, cell), warmest.value(month, cell));
        share_in_range(GROWS, f64::from(low), f64::from(high)) as f32
    }

    /// The mean moisture of the year.
    fn moisture(&self, cell: usize) -> f32 {
        match &self.resources.moisture {
            MonthlyMap::Shifted { base, offset } => base.data[cell] + offset.iter().sum::<f32>() / MONTHS as f32,
            MonthlyMap::Maps(maps) => maps.iter().map(|m| m.data[cell]).sum::<f32>() / MONTHS as f32,
        }
    }
}

/// What each cell offers, worked out once for all of them.
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
    pub(super) fn new(run: &Run, offer: &Offer<'a>) -> Result<Self, Stopped> {
        let grid = offer.resources.soil.grid;
        let [mut light, mut usable, mut moisture] = [0, 1, 2].map(|_| Raster::filled(grid, 0.0_f32));
        let maps = [&mut light, &mut usable, &mut moisture].map(|map| map.data.as_mut_slice());
        slabs::cut(maps, grid.len()).into_par_iter().try_for_each(|slab| {
            run.check()?;
            let Ok([light, usable, moisture]) = <[&mut [f32]; 3]>::try_from(slab.maps) else { return Ok(()) };
            for (i, cell) in slab.cells.enumerate() {
                (light[i], usable[i]) = offer.light(cell);
                moisture[i] = offer.moisture(cell);
            }
            Ok(())
        })?;
        let light_drawn = offer.needs.illumination.then_some((usable, offer.illumination));
        Ok(Self { light, light_drawn, moisture, bare: offer.bare })
    }

    pub(super) fn at(&self, cell: usize) -> Site<'_> {
        Site {
            light: self.light.data[cell],
            light_drawn: self.light_drawn.as_ref().map(|(light, scale)| (light.data[cell], scale)),
            moisture: self.moisture.data[cell],
            room: room(self.bare, cell),
        }
    }
}

/// Cover that each stratum of a cell has room for.
fn room(bare: Option<&Raster<f32>>, cell: usize) -> u16 {
    let bare = bare.map_or(0.0, |map| map.data[cell]);
    if bare.is_nan() { FULL_COVER } else { FULL_COVER - rule::cover(bare) }
}
