//! A plant species in whole numbers, so that what is taken can be given back exactly.

use crate::compute::ecosystem::fitness::Needs;
use crate::compute::ecosystem::fitness::window;
use crate::compute::ecosystem::flora::FloraError;
use crate::compute::ecosystem::scales::Scales;
use crate::compute::ecosystem::species::PlantSpecies;
use crate::compute::ecosystem::species::Stratum;

/// The cover that stands for a whole cell. Covers are whole numbers of 1/45 000 of a cell: ninths
/// and fiftieths, hence the units of T table A.1, are exact.
pub const FULL_COVER: u16 = 45_000;

/// The light use that covers a whole cell with one unit: the top of the scale (ours).
pub(super) const WHOLE_CELL_USE: f64 = 9.0;

/// Parts of a scale unit in which moisture is counted per unit of cover (ours).
const MOISTURE_PARTS: f64 = 1000.0;

/// Whole-number moisture in one scale unit over a whole cell.
const MOISTURE_UNIT: f64 = MOISTURE_PARTS * FULL_COVER as f64;

/// How one species takes part in the competition.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rule {
    pub stratum: Stratum,
    /// Cover of a population unit, 1..=[`FULL_COVER`].
    pub unit: u16,
    /// Moisture drawn per unit of cover.
    pub use_per_cover: u64,
    /// Physical light fraction below which a unit dies.
    pub least_light: f32,
}

impl Rule {
    /// The rule of `species`; an error when it uses no light, so that its units cover nothing.
    pub(super) fn new(species: &PlantSpecies, needs: Needs, scales: &Scales) -> Result<Self, FloraError> {
        let use_ = species.illumination.consumption;
        if !(use_.is_finite() && use_ > 0.0) {
            return Err(FloraError::NoLightUse { species: species.name.clone(), found: use_ });
        }
        let unit = (use_ / WHOLE_CELL_USE * f64::from(FULL_COVER)).round().clamp(1.0, f64::from(FULL_COVER));
        let draws = if needs.moisture { species.moisture.consumption.max(0.0) } else { 0.0 };
        let least_light = if needs.illumination {
            window::least_light(&scales.illumination, species.illumination.range.min)
        } else {
            0.0
        };
        Ok(Self {
            stratum: species.stratum,
            unit: unit as u16,
            use_per_cover: (draws * MOISTURE_PARTS).round() as u64,
            least_light,
        })
    }
}

/// Whole-number moisture of a capacity in scale units; no data counts as none.
pub(super) fn moisture_parts(scale_units: f32) -> u64 {
    (f64::from(scale_units).max(0.0) * MOISTURE_UNIT) as u64
}

/// Scale units of whole-number moisture.
pub(super) fn moisture_scale_units(parts: u64) -> f32 {
    (parts as f64 / MOISTURE_UNIT) as f32
}

/// A cover as a share of the cell, 0..=1.
pub(super) fn share(cover: u16) -> f32 {
    f32::from(cover) / f32::from(FULL_COVER)
}

/// The cover nearest to a share of the cell.
pub(super) fn cover(share: f32) -> u16 {
    (f64::from(share.clamp(0.0, 1.0) * f32::from(FULL_COVER)) + 0.5) as u16
}
