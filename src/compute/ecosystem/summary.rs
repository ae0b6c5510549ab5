//! Stage 9: what the experts read first (L 7.2): how many of each live where, whether the
//! proportions asked for were reached, and what is left of what grew.

use super::fauna;
use super::fauna::Population;
use super::fauna::Stock;
use super::flora;
use super::flora::Flora;
use super::regions::Regions;
use super::species::AnimalSpecies;
use super::species::Food;
use super::trails::Trails;

/// Square metres in a square kilometre.
const M2_PER_KM2: f64 = 1e6;

/// The shares of a species among those it competes with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Proportion {
    /// The share asked for, 0..=1; the shares of a level sum to 1. `None` without targets.
    pub asked: Option<f64>,
    /// The share reached, 0..=1; 0 when nothing of the level lives.
    pub reached: f64,
}

/// What grew of a food and what became of it, kg a year.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Balance {
    /// **Yearly growth** (L 3): dry matter of a plant that some animal eats, mass of the young of
    /// an animal.
    pub growth_kg: f64,
    /// What animals eat of it.
    pub eaten_kg: f64,
    /// **Surplus**: growth − eaten.
    pub surplus_kg: f64,
}

impl Balance {
    fn of(stock: &Stock) -> Self {
        let (growth_kg, eaten_kg) = (stock.growth_kg.iter().sum(), stock.eaten_kg.iter().sum());
        Self { growth_kg, eaten_kg, surplus_kg: growth_kg - eaten_kg }
    }
}

/// A plant species in the whole terrain.
#[derive(Debug, Clone, PartialEq)]
pub struct PlantSummary {
    /// Index of the species.
    pub species: usize,
    /// Area covered, m².
    pub cover_m2: f64,
    /// Cells where it grows.
    pub cells: u64,
    /// Shares of the covered area of all plants.
    pub proportion: Proportion,
    /// `None` for a plant that was not told to the animals.
    pub balance: Option<Balance>,
    /// Why it grows nowhere.
    pub why_empty: Option<flora::Absence>,
}

/// An animal species in the whole terrain.
#[derive(Debug, Clone, PartialEq)]
pub struct AnimalSummary {
    /// Index of the species.
    pub species: usize,
    /// Its level in the food chain.
    pub level: usize,
    /// Individuals.
    pub individuals: u64,
    /// Herds.
    pub herds: usize,
    /// Confinement regions.
    pub regions: usize,
    /// Regions with at least one herd.
    pub regions_inhabited: usize,
    /// Area it can reach, km².
    pub accessible_km2: f64,
    /// **Individuals per km²** of the area it can reach; 0 where there is none.
    pub per_km2: f64,
    /// Mass of all individuals, kg.
    pub biomass_kg: f64,
    /// Shares of the individuals of its level.
    pub proportion: Proportion,
    /// Its young.
    pub balance: Option<Balance>,
    /// Why none lives here.
    pub why_absent: Option<fauna::Absence>,
}

/// A level of animals as a whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelSummary {
    /// 1 for herbivores, 2 for carnivores, …
    pub level: usize,
    /// Individuals of all species.
    pub individuals: u64,
    /// Mass of all individuals, kg.
    pub biomass_kg: f64,
    /// Biomass over that of the level below; `None` at level 1 and where that level is empty.
    pub to_level_below: Option<f64>,
    /// Half the sum of |reached − asked| over its species, 0..=1; `None` without targets.
    pub distance: Option<f64>,
}

/// The trails as a whole.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrailSummary {
    /// Number of lines.
    pub lines: usize,
    /// Length of all lines, m.
    pub length_m: f64,
    /// Traffic of the busiest stretch, kg a year.
    pub busiest_kg_per_year: f64,
    /// Area worn, m².
    pub worn_m2: f64,
    /// See [`Trails::kept_share`].
    pub kept_share: f64,
}

/// The plants, by species; without `population`, before animals have eaten.
pub fn plants(flora: &Flora, population: Option<&Population>) -> Vec<PlantSummary> {
    let covered: f64 = flora.totals.iter().map(|total| total.cover_m2).sum();
    let summary = |(species, total): (usize, &flora::Total)| PlantSummary {
        species,
        cover_m2: total.cover_m2,
        cells: total.cells,
        proportion: Proportion {
            asked: flora.reached.as_ref().map(|reached| reached.asked[species]),
            reached: share(total.cover_m2, covered),
        },
        balance: population.and_then(|p| p.stocks.of(Food::Plant(species))).map(Balance::of),
        why_empty: total.why_empty,
    };
    flora.totals.iter().enumerate().map(summary).collect()
}

/// The animals, by species.
pub fn animals(animals: &[AnimalSpecies], population: &Population, regions: &Regions) -> Vec<AnimalSummary> {
    let summary = |(species, animal): (usize, &AnimalSpecies)| {
        let individuals = population.total(species);
        let homes = || population.rag.territories.iter().filter(|t| t.species == species && t.individuals() > 0);
        let of_level = || (0..animals.len()).filter(|&s| animals[s].level == animal.level);
        let area: f64 = (0..regions.count(species)).map(|region| regions.area_m2(species, region)).sum();
        let asked: f64 = of_level().filter_map(|s| animals[s].target).sum();
        let level: u64 = of_level().map(|s| population.total(s)).sum();
        AnimalSummary {
            species,
            level: animal.level,
            individuals,
            herds: homes().map(|t| t.herds.iter().filter(|n| **n > 0).count()).sum(),
            regions: regions.count(species),
            regions_inhabited: homes().count(),
            accessible_km2: area / M2_PER_KM2,
            per_km2: share(individuals as f64 * M2_PER_KM2, area),
            biomass_kg: individuals as f64 * animal.mass_kg,
            proportion: Proportion {
                asked: (asked > 0.0).then(|| animal.target.unwrap_or(0.0) / asked),
                reached: share(individuals as f64, level as f64),
            },
            balance: population.stocks.of(Food::Animal(species)).map(Balance::of),
            why_absent: population.absent[species],
        }
    };
    animals.iter().enumerate().map(summary).collect()
}

/// The levels of the food chain, from herbivores up.
pub fn levels(animals: &[AnimalSummary]) -> Vec<LevelSummary> {
    let mut numbers: Vec<usize> = animals.iter().map(|animal| animal.level).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let biomass = |level: usize| animals.iter().filter(|a| a.level == level).map(|a| a.biomass_kg).sum::<f64>();
    let summary = |&level: &usize| {
        let species: Vec<&AnimalSummary> = animals.iter().filter(|a| a.level == level).collect();
        let missed = |a: &&AnimalSummary| a.proportion.asked.map(|asked| 0.5 * (a.proportion.reached - asked).abs());
        let below = biomass(level.saturating_sub(1));
        LevelSummary {
            level,
            individuals: species.iter().map(|a| a.individuals).sum(),
            biomass_kg: biomass(level),
            to_level_below: (level > 1 && below > 0.0).then(|| biomass(level) / below),
            distance: species.iter().map(missed).sum(),
        }
    };
    numbers.iter().map(summary).collect()
}

/// The trails.
pub fn trails(trails: &Trails) -> TrailSummary {
    let worn: f64 = trails.worn.data.iter().map(|share| f64::from(*share)).sum();
    TrailSummary {
        lines: trails.lines.len(),
        length_m: trails.lines.iter().map(|line| line.length_m()).sum(),
        busiest_kg_per_year: trails.lines.iter().map(|line| line.kg_per_year()).fold(0.0, f64::max),
        worn_m2: worn * trails.worn.grid.cell_area_m2(),
        kept_share: trails.kept_share,
    }
}

fn share(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(level: usize, individuals: u64, biomass_kg: f64, (asked, reached): (Option<f64>, f64)) -> AnimalSummary {
        AnimalSummary {
            species: 0,
            level,
            individuals,
            herds: 1,
            regions: 1,
            regions_inhabited: 1,
            accessible_km2: 2.0,
            per_km2: individuals as f64 / 2.0,
            biomass_kg,
            proportion: Proportion { asked, reached },
            balance: None,
            why_absent: None,
        }
    }

    #[test]
    fn levels_are_compared_with_the_one_below_and_with_what_was_asked() {
        let levels = levels(&[
            of(1, 30, 3000.0, (Some(0.5), 0.6)),
            of(1, 20, 1000.0, (Some(0.5), 0.4)),
            of(2, 2, 80.0, (None, 1.0)),
        ]);
        assert_eq!((levels[0].individuals, levels[0].biomass_kg, levels[0].to_level_below), (50, 4000.0, None));
        assert!(levels[0].distance.is_some_and(|d| (d - 0.1).abs() < 1e-12));
        assert_eq!((levels[1].to_level_below, levels[1].distance), (Some(0.02), None));
    }
}
