//! What the cells offer before anything grows there.

use crate::compute::ecosystem::flora::rule;
use crate::compute::ecosystem::flora::rule::FULL_COVER;
use crate::compute::ecosystem::flora::stand::Site;
use crate::compute::ecosystem::resources::MONTHS;
use crate::compute::ecosystem::resources::MonthlyMap;
use crate::compute::ecosystem::resources::Resources;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;

/// The **capacity** of every cell for light and moisture, and the part of it kept bare.
pub(super) struct Sites<'a> {
    /// Physical light fraction, mean of the year.
    pub light: Raster<f32>,
    /// Moisture on the scale, mean of the year.
    pub moisture: Raster<f32>,
    bare: Option<&'a Raster<f32>>,
}

impl<'a> Sites<'a> {
    pub(super) fn new(run: &Run, resources: &Resources, bare: Option<&'a Raster<f32>>) -> Result<Self, Stopped> {
        let light = yearly_mean(&resources.sunlight);
        run.check()?;
        let moisture = yearly_mean(&resources.moisture);
        run.check()?;
        Ok(Self { light, moisture, bare })
    }

    pub(super) fn at(&self, cell: usize) -> Site {
        Site { light: self.light.data[cell], moisture: self.moisture.data[cell], room: self.room(cell) }
    }

    fn room(&self, cell: usize) -> u16 {
        let bare = self.bare.map_or(0.0, |map| map.data[cell]);
        if bare.is_nan() { FULL_COVER } else { FULL_COVER - rule::cover(bare) }
    }
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
