//! A plain animal for tests.

use crate::compute::ecosystem::species::AnimalSpecies;
use crate::compute::ecosystem::species::Mobility;

/// An animal of 100 kg that walks 1.25 m/s, climbs 0.6, descends 0.8 and wades 0.5 m.
pub(crate) fn animal(name: &str, level: usize) -> AnimalSpecies {
    AnimalSpecies {
        name: name.into(),
        level,
        mass_kg: 100.0,
        group_min: 5,
        group_max: 12,
        diet: Vec::new(),
        food_kg_per_year: 1000.0,
        needs_water: false,
        growth_per_year: 0.3,
        offtake: 0.5,
        mobility: Mobility {
            speed_m_per_s: 1.25,
            max_slope_up: 0.6,
            max_slope_down: 0.8,
            ford_depth_m: 0.5,
            max_tree_cover: 1.0,
        },
        active_from_s: 6.0 * 3600.0,
        active_s: 18.0 * 3600.0,
        target: None,
    }
}
