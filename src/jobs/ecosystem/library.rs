//! The species known by name: T tables A.1 (plants) and A.2 (animals), with diets after the
//! feeding types of their living relatives.

use std::sync::LazyLock;

use crate::compute::ecosystem::allometry::Agility;
use crate::compute::ecosystem::allometry::Ground;

/// The source of T table A.1.
pub const TABLE_A1: &str = "Ecormier-Nocca 2020 (thesis), table A.1";
/// The source of T table A.2.
pub const TABLE_A2: &str = "Ecormier-Nocca 2020 (thesis), table A.2";

/// The source of the relatives' densities.
pub const DENSITIES: &str = "population density in PanTHERIA (Jones et al. 2009, Ecology 90:2648)";
/// An animal of the library is not settled denser than this many times its living relative (ours:
/// what keeps real animals below what their food bears is not modelled).
pub const DENSEST: f64 = 10.0;

const PLANTS_CSV: &str = include_str!("../../../api/examples/data/tautavel_plants.csv");
const ANIMALS_CSV: &str = include_str!("../../../api/examples/data/tautavel_animals.csv");

/// A row of a table: its cells by column name.
#[derive(Debug, Clone)]
pub struct Row(Vec<(&'static str, &'static str)>);

impl Row {
    /// The text of a column; empty when there is none.
    pub fn text(&self, column: &str) -> &'static str {
        self.0.iter().find(|(name, _)| *name == column).map_or("", |(_, value)| *value)
    }

    /// The number of a column.
    pub fn number(&self, column: &str) -> Option<f64> {
        self.text(column).parse().ok()
    }
}

fn rows(csv: &'static str) -> Vec<Row> {
    let mut lines = csv.lines().filter(|line| !line.starts_with('#') && !line.is_empty());
    let header: Vec<&str> = lines.next().unwrap_or("").split(',').collect();
    lines.map(|line| Row(header.iter().copied().zip(line.split(',')).collect())).collect()
}

static PLANTS: LazyLock<Vec<Row>> = LazyLock::new(|| rows(PLANTS_CSV));
static ANIMALS: LazyLock<Vec<Row>> = LazyLock::new(|| rows(ANIMALS_CSV));

/// The plant with this name.
pub fn plant(name: &str) -> Option<&'static Row> {
    PLANTS.iter().find(|row| row.text("species") == name)
}

/// The animal with this name.
pub fn animal(name: &str) -> Option<&'static Row> {
    ANIMALS.iter().find(|row| row.text("species") == name)
}

/// The names of all plants of the library, for error messages.
pub fn plant_names() -> Vec<&'static str> {
    PLANTS.iter().map(|row| row.text("species")).collect()
}

/// The names of all animals of the library, for error messages.
pub fn animal_names() -> Vec<&'static str> {
    ANIMALS.iter().map(|row| row.text("species")).collect()
}

/// What a species of table A.2 is taken to eat, and how it lives, after a living relative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Habits {
    /// Name in table A.2.
    pub species: &'static str,
    /// The living relative whose habits are taken.
    pub relative: &'static str,
    /// Individuals of the relative per km² ([`DENSITIES`]).
    pub density_per_km2: Option<f64>,
    /// (food, preference): a growth form or a species.
    pub diet: &'static [(&'static str, f64)],
    /// Where the diet comes from.
    pub diet_source: &'static str,
    /// How well it climbs (ours, after the relative).
    pub agility: Agility,
    /// What ground it keeps to (ours, after the relative).
    pub ground: Ground,
}

const FEEDING_TYPES: &str =
    "feeding type of the living relative after Hofmann 1989, Oecologia 78:443-457; preferences estimated";
const PREY_SIZE: &str =
    "prey size classes of the living relative after Carbone et al. 1999, Nature 402:286-288; preferences estimated";
const GRAZER: &[(&str, f64)] = &[("herb", 1.0), ("shrub", 0.1)];
const MIXED: &[(&str, f64)] = &[("herb", 1.0), ("shrub", 0.5), ("tree", 0.1)];
const LARGE_GAME: &[(&str, f64)] = &[
    ("Cervus elaphus", 1.0),
    ("Rangifer tarandus", 1.0),
    ("Dama roberti", 1.0),
    ("Ovis ammon", 0.8),
    ("Hemitragus bonali", 0.8),
    ("Equus mosbachensis", 0.4),
    ("Bison priscus", 0.3),
];
const SMALL_GAME: &[(&str, f64)] = &[
    ("Dama roberti", 1.0),
    ("Hemitragus bonali", 0.6),
    ("Ovis ammon", 0.4),
    ("Rangifer tarandus", 0.4),
    ("Cervus elaphus", 0.2),
];

/// The habits of the animals of table A.2. All diets are estimates of ours from the cited
/// feeding types; the request can replace them.
pub const HABITS: &[Habits] = &[
    habit("Bison priscus", ("Bison bison", Some(0.28)), (GRAZER, FEEDING_TYPES), (Agility::Walker, Ground::Open)),
    habit("Cervus elaphus", ("Cervus elaphus", Some(2.9)), (MIXED, FEEDING_TYPES), (Agility::Walker, Ground::Wooded)),
    habit("Dama roberti", ("Dama dama", Some(21.99)), (MIXED, FEEDING_TYPES), (Agility::Walker, Ground::Wooded)),
    habit(
        "Equus mosbachensis",
        ("Equus burchellii", Some(7.0)),
        (GRAZER, FEEDING_TYPES),
        (Agility::Walker, Ground::Open),
    ),
    habit(
        "Hemitragus bonali",
        ("Hemitragus jemlahicus", None),
        (MIXED, FEEDING_TYPES),
        (Agility::Climber, Ground::Wooded),
    ),
    habit("Ovis ammon", ("Ovis ammon", Some(0.02)), (GRAZER, FEEDING_TYPES), (Agility::Climber, Ground::Open)),
    habit(
        "Rangifer tarandus",
        ("Rangifer tarandus", Some(2.55)),
        (MIXED, FEEDING_TYPES),
        (Agility::Walker, Ground::Open),
    ),
    habit("Ursus arctos", ("Ursus arctos", Some(0.02)), (LARGE_GAME, PREY_SIZE), (Agility::Walker, Ground::Wooded)),
    habit("Ursus spelaeus", ("Ursus arctos", Some(0.02)), (LARGE_GAME, PREY_SIZE), (Agility::Walker, Ground::Wooded)),
    habit("Lynx spelaeus", ("Lynx lynx", Some(0.02)), (SMALL_GAME, PREY_SIZE), (Agility::Walker, Ground::Wooded)),
    habit(
        "Canis mosbachensis",
        ("Canis lupus", Some(0.01)),
        (LARGE_GAME, PREY_SIZE),
        (Agility::Walker, Ground::Wooded),
    ),
    habit("Vulpes vulpes", ("Vulpes vulpes", Some(1.1)), (SMALL_GAME, PREY_SIZE), (Agility::Walker, Ground::Wooded)),
];

const fn habit(
    species: &'static str,
    (relative, density_per_km2): (&'static str, Option<f64>),
    (diet, diet_source): (&'static [(&'static str, f64)], &'static str),
    (agility, ground): (Agility, Ground),
) -> Habits {
    Habits { species, relative, density_per_km2, diet, diet_source, agility, ground }
}

/// The habits of a species of table A.2.
pub fn habits(name: &str) -> Option<&'static Habits> {
    HABITS.iter().find(|h| h.species == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_tables_are_whole_and_every_animal_has_habits() {
        assert_eq!((plant_names().len(), animal_names().len()), (18, 12));
        for name in animal_names() {
            let habits = habits(name).expect(name);
            for (food, _) in habits.diet {
                assert!(["herb", "shrub", "tree"].contains(food) || animal(food).is_some(), "{food}");
            }
        }
        assert_eq!(plant("Quercus").and_then(|row| row.number("illumination_use")), Some(5.0));
        assert_eq!(animal("Lynx spelaeus").and_then(|row| row.number("mass_max_kg")), Some(15.0));
    }
}
