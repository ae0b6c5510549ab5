//! The **resource maps** that plants compete for, as the climate stage hands them on.

use crate::compute::raster::Raster;

/// Months in the year; index 0 is January.
pub const MONTHS: usize = 12;

/// A quantity with a map for each month.
#[derive(Debug, Clone, PartialEq)]
pub enum MonthlyMap {
    /// `base[cell] + offset[month]`: what varies in the same way everywhere.
    Shifted {
        /// The part that varies in space.
        base: Raster<f32>,
        /// The part that varies in time.
        offset: [f32; MONTHS],
    },
    /// One map a month, all on the same grid.
    Maps(Vec<Raster<f32>>),
}

impl MonthlyMap {
    /// The value of `cell` in `month` (0..12).
    pub fn value(&self, month: usize, cell: usize) -> f32 {
        match self {
            Self::Shifted { base, offset } => base.data[cell] + offset[month],
            Self::Maps(maps) => maps[month].data[cell],
        }
    }

    /// The map of one month.
    pub fn month(&self, month: usize) -> Raster<f32> {
        match self {
            Self::Shifted { base, offset } => base.map(|v| v + offset[month]),
            Self::Maps(maps) => maps[month].clone(),
        }
    }
}

/// All that plants compete for. Every map is on the terrain's grid; NaN where there is no data.
#[derive(Debug, Clone, PartialEq)]
pub struct Resources {
    /// Mean of the daily minima of a month, °C.
    pub temperature_min_c: MonthlyMap,
    /// Mean of the daily maxima of a month, °C.
    pub temperature_max_c: MonthlyMap,
    /// **Illumination**: the physical light fraction that a canopy multiplies and that
    /// `scales` converts to 1–9.
    pub sunlight: MonthlyMap,
    /// Soil moisture on the scale 1–9, not clamped.
    pub moisture: MonthlyMap,
    /// Soil texture on the scale 1–9 (clay to bare slab).
    pub texture: Raster<f32>,
    /// Soil type: the code of a [`super::species::Soil`].
    pub soil: Raster<u8>,
}
