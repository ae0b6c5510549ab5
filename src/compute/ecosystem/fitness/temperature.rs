//! The share of a year's temperatures that suits each range, quick: over a terrain the monthly
//! temperatures depend on one number, so one table serves all cells.

use crate::compute::ecosystem::fitness::MonthRule;
use crate::compute::ecosystem::fitness::share_in_range;
use crate::compute::ecosystem::resources::MONTHS;
use crate::compute::ecosystem::resources::MonthlyMap;
use crate::compute::ecosystem::resources::Resources;
use crate::compute::ecosystem::scales::Scale;
use crate::compute::ecosystem::species::Interval;
use rayon::prelude::*;
use std::ops::Range;

/// Steps of the table in 1/°C (ours): temperatures are rounded to 1/128 °C, far finer than any
/// climate is known.
const STEPS_PER_DEGREE: f32 = 128.0;

/// Entries beyond which no table is made (ours): 8,000 °C, which only broken maps span.
const MOST_ENTRIES: usize = 1 << 20;

/// Mean temperature of a cell in a month, °C: the middle of the daily minimum and maximum.
pub(in crate::compute::ecosystem) fn mean_c(resources: &Resources, month: usize, cell: usize) -> f32 {
    0.5 * (resources.temperature_min_c.value(month, cell) + resources.temperature_max_c.value(month, cell))
}

/// How the shares are found.
pub(super) enum Temperatures<'a> {
    /// Both maps vary over the year alike everywhere: one table by the lower map's base.
    Table { base: &'a [f32], lowest: f32, shares: Vec<Vec<f32>> },
    /// Any maps: month by month in every cell.
    Direct { resources: &'a Resources, ranges: &'a [Interval], rule: MonthRule, scale: &'a Scale },
}

impl<'a> Temperatures<'a> {
    /// Chooses the table where the maps allow it.
    pub(super) fn new(resources: &'a Resources, ranges: &'a [Interval], rule: MonthRule, scale: &'a Scale) -> Self {
        let direct = Self::Direct { resources, ranges, rule, scale };
        let (MonthlyMap::Shifted { base, offset: cold }, MonthlyMap::Shifted { base: warm_base, offset: warm }) =
            (&resources.temperature_min_c, &resources.temperature_max_c)
        else {
            return direct;
        };
        let Some(apart) = constant_difference(&base.data, &warm_base.data) else { return direct };
        let Some((lowest, entries)) = extent(&base.data) else { return direct };
        let year = Year { cold, warm: &warm.map(|w| w + apart), scale };
        let shares = ranges.iter().map(|range| table(*range, rule, &year, (lowest, entries))).collect();
        Self::Table { base: &base.data, lowest, shares }
    }

    /// The shares of `cells`: one row a range.
    pub(super) fn shares(&self, cells: Range<usize>) -> Vec<Vec<f32>> {
        match self {
            Self::Table { base, lowest, shares } => {
                let entry = |t: f32| {
                    if t.is_nan() { usize::MAX } else { ((t - lowest) * STEPS_PER_DEGREE).round().max(0.0) as usize }
                };
                let entries: Vec<usize> = base[cells].iter().map(|t| entry(*t)).collect();
                let row = |table: &Vec<f32>| entries.iter().map(|e| table.get(*e).copied().unwrap_or(0.0)).collect();
                shares.iter().map(row).collect()
            }
            Self::Direct { resources, ranges, rule, scale } => {
                let mut rows = vec![Vec::with_capacity(cells.len()); ranges.len()];
                for cell in cells {
                    let year = scaled_year(resources, cell, scale);
                    for (range, row) in ranges.iter().zip(&mut rows) {
                        row.push(share_of_year(*range, *rule, &year));
                    }
                }
                rows
            }
        }
    }
}

/// The months of the place whose base temperature is 0 °C.
struct Year<'a> {
    cold: &'a [f32; MONTHS],
    warm: &'a [f32; MONTHS],
    scale: &'a Scale,
}

fn table(range: Interval, rule: MonthRule, year: &Year, (lowest, entries): (f32, usize)) -> Vec<f32> {
    let share = |entry: usize| {
        let base = lowest + entry as f32 / STEPS_PER_DEGREE;
        let month =
            |m: usize| (year.scale.at(f64::from(base + year.cold[m])), year.scale.at(f64::from(base + year.warm[m])));
        share_of_year(range, rule, &std::array::from_fn(month))
    };
    (0..entries).into_par_iter().map(share).collect()
}

fn scaled_year(resources: &Resources, cell: usize, scale: &Scale) -> [(f64, f64); MONTHS] {
    std::array::from_fn(|month| {
        let low = f64::from(resources.temperature_min_c.value(month, cell));
        let high = f64::from(resources.temperature_max_c.value(month, cell));
        (scale.at(low), scale.at(high))
    })
}

fn share_of_year(range: Interval, rule: MonthRule, year: &[(f64, f64); MONTHS]) -> f32 {
    rule.combine(&year.map(|(low, high)| share_in_range(range, low, high))) as f32
}

/// `b - a` where it is the same in every cell that has data, within a tenth of the table's step.
fn constant_difference(a: &[f32], b: &[f32]) -> Option<f32> {
    let apart = a.iter().zip(b).map(|(a, b)| b - a).find(|d| !d.is_nan()).unwrap_or(0.0);
    let same = |(a, b): (&f32, &f32)| a.is_nan() == b.is_nan() && !((b - a - apart).abs() > 0.1 / STEPS_PER_DEGREE);
    a.par_iter().zip(b).all(same).then_some(apart)
}

/// The lowest finite value and the number of entries up to the highest.
fn extent(values: &[f32]) -> Option<(f32, usize)> {
    let (low, high) = values
        .iter()
        .filter(|v| v.is_finite())
        .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
    let entries = ((high - low) * STEPS_PER_DEGREE).round().max(0.0) as usize + 1;
    (low.is_finite() && entries <= MOST_ENTRIES).then_some((low, entries))
}
