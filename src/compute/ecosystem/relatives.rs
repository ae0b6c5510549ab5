//! **Living relatives** of the sample's animals and how densely they live: what a solved fauna is
//! held against.
//!
//! Densities are single figures of PanTHERIA (Jones et al. 2009, Ecology 90:2648,
//! `PopulationDensity_n/km2`). Where a relative has none, the nearest species that has one stands
//! for it: the plains zebra for the horse. Animals without any known relative are estimated after
//! Damuth (1981, Nature 290:699–700).

use crate::compute::ecosystem::allometry::Estimate;
use crate::compute::ecosystem::fauna::Population;
use crate::compute::ecosystem::regions::Regions;
use crate::compute::ecosystem::species::AnimalSpecies;
use crate::compute::ecosystem::species::Food;

/// How many times as densely as its relative an animal may live before it is implausible.
pub const MOST_TIMES: f64 = 10.0;

/// Biomass of predators over that of their prey: 10 t of prey bear about 90 kg of a carnivore
/// species (Carbone and Gittleman 2002, Science 295:2273–2276), here for all together, with a
/// margin of three either way.
pub const PREDATORS_PER_PREY: (f64, f64) = (0.003, 0.03);

/// A living species that stands for another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relative {
    /// Its name.
    pub name: &'static str,
    /// Individuals per km².
    pub density_per_km2: f64,
}

const fn relative(name: &'static str, density_per_km2: f64) -> Relative {
    Relative { name, density_per_km2 }
}

/// The living relative of a species, by its name; the species itself if it is alive.
pub fn relative_of(species: &str) -> Option<Relative> {
    Some(match species {
        "Bison priscus" | "Bison bison" => relative("Bison bison", 0.28),
        "Bison bonasus" => relative("Bison bonasus", 0.88),
        "Cervus elaphus" => relative("Cervus elaphus", 2.9),
        "Dama roberti" | "Dama dama" => relative("Dama dama", 21.99),
        "Equus mosbachensis" | "Equus caballus" | "Equus burchellii" => relative("Equus burchellii", 7.0),
        "Ovis ammon" => relative("Ovis ammon", 0.02),
        "Ovis canadensis" => relative("Ovis canadensis", 1.48),
        "Rangifer tarandus" => relative("Rangifer tarandus", 2.55),
        "Capreolus capreolus" => relative("Capreolus capreolus", 7.61),
        "Alces alces" => relative("Alces alces", 0.4),
        "Sus scrofa" => relative("Sus scrofa", 3.54),
        "Canis mosbachensis" | "Canis lupus" => relative("Canis lupus", 0.01),
        "Ursus spelaeus" | "Ursus arctos" => relative("Ursus arctos", 0.02),
        "Lynx spelaeus" | "Lynx lynx" => relative("Lynx lynx", 0.02),
        "Vulpes vulpes" => relative("Vulpes vulpes", 1.1),
        _ => return None,
    })
}

/// Individuals per km² by mass: 10^4.23·M^−0.75 for primary consumers, M in g; a hundredth of
/// that for predators (ours: within a factor of ten for wolf, bear and fox).
pub fn density_per_km2(mass_kg: f64, eats_animals: bool) -> Estimate {
    let herbivore = libm::pow(10.0, 4.23) * libm::pow(1000.0 * mass_kg.max(1e-6), -0.75);
    if eats_animals {
        Estimate { value: herbivore / 100.0, source: "a hundredth (ours) of 10^4.23 M^-0.75, M in g (Damuth 1981)" }
    } else {
        Estimate { value: herbivore, source: "10^4.23 M^-0.75 individuals per km2, M in g (Damuth 1981)" }
    }
}

/// The density a species is held against, per km², and where it comes from.
pub fn reference_density(animal: &AnimalSpecies) -> Estimate {
    match relative_of(&animal.name) {
        Some(relative) => Estimate { value: relative.density_per_km2, source: "PanTHERIA (Jones et al. 2009)" },
        None => density_per_km2(animal.mass_kg, eats_animals(animal)),
    }
}

/// What is hard to believe about a fauna.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Implausible {
    /// A species lives more densely over its accessible area than [`MOST_TIMES`] its reference.
    Density {
        /// Index of the species.
        species: usize,
        /// Individuals per km² of all its regions.
        found_per_km2: f64,
        /// The most that is plausible.
        most_per_km2: f64,
    },
    /// The biomass of those that eat animals over that of those that are eaten lies outside
    /// [`PREDATORS_PER_PREY`].
    PredatorBiomass {
        /// The ratio.
        found: f64,
    },
}

/// Individuals per km² of the area a species can reach; 0 where it can go nowhere.
pub fn density_over_accessible(population: &Population, regions: &Regions, species: usize) -> f64 {
    let area_m2: f64 = (0..regions.count(species)).map(|region| regions.area_m2(species, region)).sum();
    if area_m2 > 0.0 { population.total(species) as f64 / (area_m2 * 1e-6) } else { 0.0 }
}

/// Biomass of the animals that eat animals over that of those that are eaten; `None` where one of
/// the two does not live.
pub fn predators_per_prey(population: &Population, animals: &[AnimalSpecies]) -> Option<f64> {
    let eaten = |s: usize| animals.iter().any(|a| a.diet.iter().any(|d| d.food == Food::Animal(s)));
    let mass = |who: &dyn Fn(usize) -> bool| -> f64 {
        let species = (0..animals.len()).filter(|s| who(*s));
        species.map(|s| population.total(s) as f64 * animals[s].mass_kg).sum()
    };
    let (predators, prey) = (mass(&|s| eats_animals(&animals[s])), mass(&eaten));
    (predators > 0.0 && prey > 0.0).then(|| predators / prey)
}

/// Everything implausible about a fauna, in the order of the species.
pub fn implausible(population: &Population, regions: &Regions, animals: &[AnimalSpecies]) -> Vec<Implausible> {
    let dense = |species: usize| {
        let found_per_km2 = density_over_accessible(population, regions, species);
        let most_per_km2 = MOST_TIMES * reference_density(&animals[species]).value;
        (found_per_km2 > most_per_km2).then_some(Implausible::Density { species, found_per_km2, most_per_km2 })
    };
    let (low, high) = PREDATORS_PER_PREY;
    let ratio = predators_per_prey(population, animals).filter(|found| !(low..=high).contains(found));
    let biomass = ratio.map(|found| Implausible::PredatorBiomass { found });
    (0..animals.len()).filter_map(dense).chain(biomass).collect()
}

fn eats_animals(animal: &AnimalSpecies) -> bool {
    animal.diet.iter().any(|item| matches!(item.food, Food::Animal(_)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn estimates_by_mass_lie_within_a_factor_of_ten_of_the_relatives() {
        let known = [("Bison bison", 600.0, false), ("Cervus elaphus", 165.0, false), ("Dama dama", 55.0, false)];
        let hunters = [("Canis lupus", 32.0, true), ("Ursus arctos", 196.0, true), ("Vulpes vulpes", 5.0, true)];
        for (name, mass, hunts) in known.into_iter().chain(hunters) {
            let ratio = density_per_km2(mass, hunts).value / relative_of(name).unwrap().density_per_km2;
            assert!((0.1..10.0).contains(&ratio), "{name} {ratio}");
        }
    }

    #[test]
    fn every_animal_of_the_sample_but_the_tahr_has_a_relative() {
        let sample = [
            "Bison priscus",
            "Cervus elaphus",
            "Dama roberti",
            "Equus mosbachensis",
            "Ovis ammon",
            "Rangifer tarandus",
            "Ursus arctos",
            "Ursus spelaeus",
            "Lynx spelaeus",
            "Canis mosbachensis",
            "Vulpes vulpes",
        ];
        assert!(sample.iter().all(|name| relative_of(name).is_some()));
        assert_eq!(relative_of("Hemitragus bonali"), None);
    }
}
