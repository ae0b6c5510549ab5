//! The **resource maps** that plants compete for, as the climate stage hands them on.

use crate::compute::ecosystem::climate::Climate;
use crate::compute::ecosystem::climate::MoistureRules;
use crate::compute::ecosystem::climate::SunlightRules;
use crate::compute::ecosystem::climate::moisture;
use crate::compute::ecosystem::climate::sunlight;
use crate::compute::ecosystem::climate::temperature;
use crate::compute::ecosystem::scales::Scales;
use crate::compute::ecosystem::soil;
use crate::compute::ecosystem::soil::SoilRules;
use crate::compute::ecosystem::terrain::Terrain;
use crate::compute::ecosystem::water::Water;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;

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

/// Maps that the caller gives instead of having them computed, in the units of [`Resources`].
/// They must lie on the terrain's grid and are taken as they are.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GivenMaps {
    /// Mean of the daily minima of a month, °C.
    pub temperature_min_c: Option<MonthlyMap>,
    /// Mean of the daily maxima of a month, °C.
    pub temperature_max_c: Option<MonthlyMap>,
    /// Light fraction.
    pub sunlight: Option<MonthlyMap>,
    /// Soil moisture on the scale 1–9.
    pub moisture: Option<MonthlyMap>,
    /// Soil texture on the scale 1–9.
    pub texture: Option<Raster<f32>>,
    /// Soil type codes.
    pub soil: Option<Raster<u8>>,
}

/// How the maps that are not given are computed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ResourceRules {
    /// Conversions to the scales 1–9.
    pub scales: Scales,
    /// Sunlight.
    pub sunlight: SunlightRules,
    /// Moisture.
    pub moisture: MoistureRules,
    /// Soil.
    pub soil: SoilRules,
}

/// Why the resource maps could not be made.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ResourceError {
    /// A given map does not have the terrain's columns and rows.
    #[error("the map {map} has {found} cells where the terrain has {expected}")]
    Size {
        /// Field of [`GivenMaps`].
        map: &'static str,
        /// Cells of the terrain.
        expected: usize,
        /// Cells of the map (of its first month of another size).
        found: usize,
    },
    /// A given monthly map does not have twelve months.
    #[error("the map {map} has {found} months, not twelve")]
    Months {
        /// Field of [`GivenMaps`].
        map: &'static str,
        /// Months of the map.
        found: usize,
    },
    /// The work was told to stop.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

impl Resources {
    /// The resource maps of a terrain with its water under a climate: the given ones as they are,
    /// the rest computed by `rules`. The soil is an estimate of ours unless it is given.
    pub fn assemble(
        (terrain, water): (&Terrain, &Water),
        climate: &Climate,
        (given, rules): (GivenMaps, &ResourceRules),
        run: &Run,
    ) -> Result<Self, ResourceError> {
        given.check(terrain.grid().len())?;
        let (temperature_min_c, temperature_max_c) = match (given.temperature_min_c, given.temperature_max_c) {
            (Some(min), Some(max)) => (min, max),
            (min, max) => {
                let ours = temperature(&terrain.height, climate);
                (min.unwrap_or(ours.min_c), max.unwrap_or(ours.max_c))
            }
        };
        let soil = match given.soil {
            Some(map) => map,
            None => soil::soil(terrain, water, &rules.soil, run)?,
        };
        Ok(Self {
            temperature_min_c,
            temperature_max_c,
            sunlight: match given.sunlight {
                Some(map) => map,
                None => sunlight(terrain, climate, rules.sunlight, run)?,
            },
            moisture: match given.moisture {
                Some(map) => map,
                None => moisture(terrain, water, climate, (rules.moisture, rules.scales.moisture), run)?,
            },
            texture: given.texture.unwrap_or_else(|| soil::texture(terrain, &soil, &rules.soil)),
            soil,
        })
    }
}

impl GivenMaps {
    /// Fails unless every map has `cells` cells and every monthly map twelve months.
    fn check(&self, cells: usize) -> Result<(), ResourceError> {
        let size =
            |map, found| if found == cells { Ok(()) } else { Err(ResourceError::Size { map, expected: cells, found }) };
        let monthly = [
            ("temperature_min_c", &self.temperature_min_c),
            ("temperature_max_c", &self.temperature_max_c),
            ("sunlight", &self.sunlight),
            ("moisture", &self.moisture),
        ];
        for (name, map) in monthly {
            match map {
                Some(MonthlyMap::Shifted { base, .. }) => size(name, base.data.len())?,
                Some(MonthlyMap::Maps(maps)) if maps.len() != MONTHS => {
                    return Err(ResourceError::Months { map: name, found: maps.len() });
                }
                Some(MonthlyMap::Maps(maps)) => maps.iter().try_for_each(|m| size(name, m.data.len()))?,
                None => {}
            }
        }
        self.texture.iter().try_for_each(|m| size("texture", m.data.len()))?;
        self.soil.iter().try_for_each(|m| size("soil", m.data.len()))
    }
}
