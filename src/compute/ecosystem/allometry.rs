//! What is not in T appendix A, estimated from an animal's mass or a plant's growth form by
//! published relations. Every estimate carries its source and can be replaced in the request.

use crate::compute::ecosystem::species::Stratum;

/// A number that was estimated, and how.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The number, in the unit its maker names.
    pub value: f64,
    /// The relation and where it comes from.
    pub source: &'static str,
}

const fn estimate(value: f64, source: &'static str) -> Estimate {
    Estimate { value, source }
}

/// How well an animal climbs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Agility {
    /// Most hoofed animals and carnivores.
    #[default]
    Walker,
    /// Goats, sheep and chamois.
    Climber,
}

/// What ground an animal keeps to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ground {
    /// Open country: large grazers.
    Open,
    /// Woods as well as open country.
    #[default]
    Wooded,
}

/// Yearly growth of what a browser or grazer can reach, kg of dry matter per covered m².
///
/// Net primary production after Whittaker and Likens (1975): 0.6 (temperate grassland), 0.7
/// (shrubland), 1.2 (temperate deciduous forest) kg/m² a year. Half of a grassland's is below
/// ground (Sims and Singh 1978, J. Ecol. 66:573–597); of shrubs a half, of trees a tenth is
/// taken as leaves and twigs within reach (both ours).
pub const fn plant_growth(stratum: Stratum) -> Estimate {
    match stratum {
        Stratum::Herb => estimate(
            0.3,
            "half (above ground, Sims & Singh 1978) of 0.6 kg/m2 a year, temperate grassland (Whittaker & Likens 1975)",
        ),
        Stratum::Shrub => {
            estimate(0.35, "half (within reach, ours) of 0.7 kg/m2 a year, shrubland (Whittaker & Likens 1975)")
        }
        Stratum::Tree => estimate(
            0.12,
            "a tenth (within reach, ours) of 1.2 kg/m2 a year, temperate deciduous forest (Whittaker & Likens 1975)",
        ),
    }
}

/// The share of a plant's growth that animals may take without loss: 0.3 of herbs, 0.1 of browse
/// (ours, after the common "take half, leave half" rule of range management with half of the
/// take lost to trampling and insects; browse stands less).
pub const fn plant_offtake(stratum: Stratum) -> Estimate {
    match stratum {
        Stratum::Herb => estimate(0.3, "ours: share of herb growth that can be grazed without loss"),
        Stratum::Shrub | Stratum::Tree => estimate(0.1, "ours: share of browse that can be taken without loss"),
    }
}

/// The share of the births that predators may take: 0.5 (ours).
pub const fn birth_offtake() -> Estimate {
    estimate(0.5, "ours: half of the births, the other half replaces natural deaths")
}

/// Food needed, kg a day: dry matter for herbivores, prey mass for carnivores.
///
/// Herbivores 0.88·M^0.628 g a day of dry matter, M in g (Nagy 2001, Nutr. Abstr. Rev. B
/// 71:21R–31R). Carnivores 0.17·M^0.73 kg a day of prey, M in kg: the exponent of field metabolic
/// rates (Nagy et al. 1999, Annu. Rev. Nutr. 19:247–277), the factor such that a wolf of 32 kg
/// eats 2.1 kg a day (ours).
pub fn food_kg_per_day(mass_kg: f64, eats_animals: bool) -> Estimate {
    if eats_animals {
        estimate(
            0.17 * libm::pow(mass_kg, 0.73),
            "0.17 M^0.73 kg of prey a day, exponent of field metabolic rate (Nagy et al. 1999), factor ours",
        )
    } else {
        estimate(0.88e-3 * libm::pow(1000.0 * mass_kg, 0.628), "0.88 M^0.628 g of dry matter a day, M in g (Nagy 2001)")
    }
}

/// Births per individual and year: the intrinsic rate 1.5·M^−0.36, M in kg (Caughley and Krebs
/// 1983, Oecologia 59:7–17).
pub fn growth_per_year(mass_kg: f64) -> Estimate {
    estimate(
        1.5 * libm::pow(mass_kg, -0.36),
        "intrinsic rate of increase 1.5 M^-0.36 a year, M in kg (Caughley & Krebs 1983)",
    )
}

/// Individuals per km²: 10^4.23·M^−0.75 for primary consumers, M in g (Damuth 1981, Nature
/// 290:699–700); a hundredth of that for those that eat animals (ours: within a factor of ten of
/// the densities of wolf, brown bear and red fox in PanTHERIA, Jones et al. 2009).
pub fn density_per_km2(mass_kg: f64, eats_animals: bool) -> Estimate {
    let consumer = libm::pow(10.0, 4.23) * libm::pow(1000.0 * mass_kg, -0.75);
    if eats_animals {
        estimate(0.01 * consumer, "a hundredth (ours) of 10^4.23 M^-0.75 individuals per km2, M in g (Damuth 1981)")
    } else {
        estimate(consumer, "10^4.23 M^-0.75 individuals per km2, M in g (Damuth 1981)")
    }
}

/// Walking speed on flat ground, m/s: 5 to 8 km/h, the range of the authors' sample; between
/// them by the logarithm of the mass from 10 kg to 1 t (ours).
pub fn speed_m_per_s(mass_kg: f64) -> Estimate {
    let kmh = 5.0 + 3.0 * (libm::log10(mass_kg / 10.0) / 2.0).clamp(0.0, 1.0);
    estimate(kmh / 3.6, "walking 5 to 8 km/h (sample of the authors of L), by mass within that range (ours)")
}

/// Shoulder height, m: 0.22·M^0.31 (ours; gives 1.8 m for 850 kg, 1.1 m for 160 kg, 0.4 m for
/// 8 kg, as in bison, red deer and fox).
pub fn shoulder_height_m(mass_kg: f64) -> f64 {
    0.22 * libm::pow(mass_kg, 0.31)
}

/// Deepest water waded through, m: half the shoulder height (ours).
pub fn ford_depth_m(mass_kg: f64) -> Estimate {
    estimate(0.5 * shoulder_height_m(mass_kg), "half the shoulder height, which is 0.22 M^0.31 m (ours)")
}

/// Steepest slope climbed, degrees: the authors' sample closes slopes of 0.5 (26.6°) to all;
/// climbers 45° (ours).
pub const fn max_slope_up_deg(agility: Agility) -> Estimate {
    match agility {
        Agility::Walker => estimate(26.6, "slope 0.5 (sample of the authors of L)"),
        Agility::Climber => estimate(45.0, "ours: goats and sheep climb what others cannot"),
    }
}

/// Steepest slope descended, degrees: five degrees more than climbed (ours; animals go down what
/// they would not climb, L 5.2).
pub const fn max_slope_down_deg(agility: Agility) -> Estimate {
    match agility {
        Agility::Walker => estimate(31.6, "ours: 5 degrees more than climbed"),
        Agility::Climber => estimate(50.0, "ours: 5 degrees more than climbed"),
    }
}

/// Tree cover above which an animal does not enter: 0.3 in the authors' sample for all, kept for
/// animals of open country; none for the others, which live in woods too (ours).
pub const fn max_tree_cover(ground: Ground) -> Estimate {
    match ground {
        Ground::Open => estimate(0.3, "tree cover 0.3 (sample of the authors of L)"),
        Ground::Wooded => estimate(1.0, "ours: woods do not stop animals that live in them"),
    }
}

/// Start of the active day, hours: 5 (ours, before sunrise).
pub const fn active_from_h() -> Estimate {
    estimate(5.0, "ours: before sunrise")
}

/// Length of the active day, hours: 18.
pub const fn active_h() -> Estimate {
    estimate(18.0, "18 active hours (sample of the authors of L)")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bison_a_deer_and_a_wolf_get_figures_of_the_right_size() {
        assert!((2.0..6.0).contains(&food_kg_per_day(850.0, false).value));
        assert!((1.0..3.0).contains(&food_kg_per_day(160.0, false).value));
        assert!((1.5..4.0).contains(&food_kg_per_day(45.0, true).value));
        assert!((0.1..0.2).contains(&growth_per_year(850.0).value));
        assert!((0.8..1.0).contains(&ford_depth_m(850.0).value));
        assert!((5.0 / 3.6..8.0 / 3.6).contains(&speed_m_per_s(160.0).value));
    }

    #[test]
    fn densities_by_mass_lie_within_a_factor_of_ten_of_those_observed() {
        // Bison, red and fallow deer, wolf, brown bear, red fox; PanTHERIA, per km².
        let grazers = [(625.0, 0.28), (241.0, 2.9), (57.0, 21.99)].map(|(mass, d)| (mass, d, false));
        let hunters = [(31.8, 0.01), (196.0, 0.02), (4.8, 1.1)].map(|(mass, d)| (mass, d, true));
        for (mass, observed, eats_animals) in grazers.into_iter().chain(hunters) {
            let ratio = density_per_km2(mass, eats_animals).value / observed;
            assert!((0.1..10.0).contains(&ratio), "{mass} kg: {ratio}");
        }
    }

    #[test]
    fn larger_animals_eat_more_and_breed_less() {
        for (small, large) in [(1.0, 10.0), (10.0, 100.0), (100.0, 1000.0)] {
            assert!(food_kg_per_day(small, false).value < food_kg_per_day(large, false).value);
            assert!(food_kg_per_day(small, true).value < food_kg_per_day(large, true).value);
            assert!(growth_per_year(small).value > growth_per_year(large).value);
        }
    }
}
