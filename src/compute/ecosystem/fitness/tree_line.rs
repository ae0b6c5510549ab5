//! The **tree line**: where summers are too cool for trees, whatever the mean over the year says.
//!
//! Trees end where the warmest month's mean falls below 10 °C (W. Köppen's border of the tundra
//! climate, kept by M. C. Peel et al. 2007). It lies higher on sunny slopes. For those we take the
//! radiation term of MT-CLIM (S. W. Running, R. R. Nemani, R. D. Hungerford 1987), which warms a
//! slope by 1 °C · (R - 1/R), R its light relative to that of open ground. Reading R over the year
//! and open ground as the middle cell (median) of the terrain is ours: between slopes of 20° to
//! the south and to the north it moves the tree line by about 100 m, as is seen in mountains.

use crate::compute::ecosystem::fitness::temperature::mean_c;
use crate::compute::ecosystem::resources::MONTHS;
use crate::compute::ecosystem::resources::Resources;
use crate::compute::ecosystem::species::Stratum;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;

/// Mean of the warmest month below which trees end, °C.
pub const TREE_LINE_C: f64 = 10.0;

/// How much cooler it may be for shrubs, °C (ours): the belt of dwarf pines above the forest is one
/// to two hundred metres high.
pub const SCRUB_BELT_C: f64 = 1.0;

/// Warming at R - 1/R = 1, °C.
const SLOPE_WARMTH_C: f32 = 1.0;

/// Bounds of R, so that a dark gorge or a broken map stays a place on Earth (ours).
const RATIOS: (f32, f32) = (0.25, 4.0);

/// The tallest stratum that each cell is warm enough for; empty when there is no line.
pub(super) struct TreeLine(Vec<Stratum>);

impl TreeLine {
    /// No line: everything grows anywhere.
    pub(super) fn none() -> Self {
        Self(Vec::new())
    }

    /// The line where the warmest month's mean is `line_c`.
    pub(super) fn new(resources: &Resources, line_c: f64, run: &Run) -> Result<Self, Stopped> {
        let light = yearly_light(resources);
        run.check()?;
        let open = median(&light);
        run.check()?;
        let tallest = |(cell, light): (usize, &f32)| {
            let warmest = (0..MONTHS).map(|m| mean_c(resources, m, cell)).fold(f32::NEG_INFINITY, f32::max);
            let ratio = (light / open).clamp(RATIOS.0, RATIOS.1);
            let gain = if ratio.is_nan() { 0.0 } else { SLOPE_WARMTH_C * (ratio - 1.0 / ratio) };
            match f64::from(warmest + gain) {
                warmth if warmth >= line_c => Stratum::Tree,
                warmth if warmth >= line_c - SCRUB_BELT_C => Stratum::Shrub,
                _ => Stratum::Herb,
            }
        };
        Ok(Self(light.par_iter().enumerate().map(tallest).collect()))
    }

    /// Whether plants of a stratum can live in a cell.
    pub(super) fn is_below(&self, cell: usize, stratum: Stratum) -> bool {
        self.0.get(cell).is_none_or(|tallest| *tallest <= stratum)
    }
}

fn yearly_light(resources: &Resources) -> Vec<f32> {
    let sum = |cell| (0..MONTHS).map(|m| resources.sunlight.value(m, cell)).sum::<f32>();
    (0..resources.soil.data.len()).into_par_iter().map(sum).collect()
}

/// The middle one of the values that are numbers; NaN without any.
fn median(values: &[f32]) -> f32 {
    let mut known: Vec<f32> = values.iter().copied().filter(|v| !v.is_nan()).collect();
    if known.is_empty() {
        return f32::NAN;
    }
    let middle = known.len() / 2;
    *known.select_nth_unstable_by(middle, f32::total_cmp).1
}
