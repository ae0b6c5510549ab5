//! Ranges of single monthly values: turned back into the unit of the map once, and each
//! different one counted once however many species share it.

use crate::compute::ecosystem::resources::MONTHS;
use crate::compute::ecosystem::resources::MonthlyMap;
use crate::compute::ecosystem::scales::ENDS;
use crate::compute::ecosystem::scales::Scale;
use crate::compute::ecosystem::species::Interval;
use std::ops::Range;

/// The physical light fraction from which light is at least `value` on the scale. Light is cut at
/// the ends of the scale, so 1 is reached in darkness.
pub(in crate::compute::ecosystem) fn least_light(illumination: &Scale, value: f64) -> f32 {
    if value <= ENDS.min { 0.0 } else { illumination.inverse(value) as f32 }
}

/// A closed interval in the unit of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Window {
    low: f32,
    high: f32,
}

impl Window {
    /// The physical light fractions that lie in `range` on the scale. Ground lit more than fully
    /// counts as fully lit, so a range up to 9 has no upper end.
    pub(super) fn light(range: Interval, illumination: &Scale) -> Self {
        let high = if range.max >= ENDS.max { f32::INFINITY } else { illumination.inverse(range.max) as f32 };
        Self { low: least_light(illumination, range.min), high }
    }

    /// A range that is already in the unit of the map.
    pub(super) fn plain(range: Interval) -> Self {
        Self { low: range.min as f32, high: range.max as f32 }
    }

    /// Whether `value` lies in the interval; a value that is not a number does not.
    pub(super) fn holds(self, value: f32) -> bool {
        value >= self.low && value <= self.high
    }
}

/// The different ones among many, and which of them each was.
pub(super) struct Distinct<T> {
    /// Each once, in order of first appearance.
    pub items: Vec<T>,
    /// For each of the many, its place in `items`.
    pub of: Vec<usize>,
}

impl<T: PartialEq> Distinct<T> {
    pub(super) fn new(many: impl IntoIterator<Item = T>) -> Self {
        let mut distinct = Self { items: Vec::new(), of: Vec::new() };
        for item in many {
            let place = distinct.items.iter().position(|i| *i == item).unwrap_or(distinct.items.len());
            distinct.of.push(place);
            if place == distinct.items.len() {
                distinct.items.push(item);
            }
        }
        distinct
    }
}

/// In how many months of the year the value of each of `cells` lies in each of `windows`:
/// one row a window, one count a cell.
pub(super) fn months_inside(map: &MonthlyMap, windows: &[Window], cells: Range<usize>) -> Vec<Vec<u8>> {
    let mut inside = vec![vec![0; cells.len()]; windows.len()];
    let mut values = vec![0.0_f32; cells.len()];
    for month in 0..MONTHS {
        month_values(map, month, cells.clone(), &mut values);
        for (window, counts) in windows.iter().zip(&mut inside) {
            counts.iter_mut().zip(&values).for_each(|(n, v)| *n += u8::from(window.holds(*v)));
        }
    }
    inside
}

fn month_values(map: &MonthlyMap, month: usize, cells: Range<usize>, values: &mut [f32]) {
    match map {
        MonthlyMap::Shifted { base, offset } => {
            values.iter_mut().zip(&base.data[cells]).for_each(|(v, b)| *v = b + offset[month]);
        }
        MonthlyMap::Maps(maps) => values.copy_from_slice(&maps[month].data[cells]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::ecosystem::scales::Scales;
    use crate::compute::raster::Grid;
    use crate::compute::raster::Raster;

    #[test]
    fn a_window_of_light_holds_what_the_scale_puts_in_the_range() {
        let scale = Scales::authors().illumination;
        for range in [Interval::new(7.0, 9.0), Interval::new(5.0, 6.0), Interval::new(1.0, 3.0)] {
            let window = Window::light(range, &scale);
            for i in 0..2000 {
                let value = (i as f32 + 0.5) / 2000.0;
                let inside = range.contains(scale.clamped(f64::from(value)));
                assert_eq!(window.holds(value), inside, "{range:?} {value}");
            }
            assert!(!window.holds(f32::NAN));
        }
    }

    #[test]
    fn months_are_counted_alike_in_both_kinds_of_map() {
        let base = Raster { grid: Grid::new(3, 1, 1.0), data: vec![0.0, 2.0, f32::NAN] };
        let offset = std::array::from_fn(|m| m as f32);
        let shifted = MonthlyMap::Shifted { base, offset };
        let maps = MonthlyMap::Maps((0..MONTHS).map(|m| shifted.month(m)).collect());
        let windows = [Window::plain(Interval::new(3.0, 5.0)), Window::plain(Interval::new(11.0, 30.0))];
        for map in [shifted, maps] {
            assert_eq!(months_inside(&map, &windows, 0..3), vec![vec![3, 3, 0], vec![1, 3, 0]]);
            assert_eq!(months_inside(&map, &windows, 1..2), vec![vec![3], vec![3]]);
        }
    }
}
