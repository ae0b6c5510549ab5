//! The Tautavel sample as the science tests see it: the plants of T table A.1 and the two
//! climates, read from the files of the example requests.

use biotope::compute::ecosystem::climate::Climate;
use biotope::compute::ecosystem::climate::MonthClimate;
use biotope::compute::ecosystem::species::Interval;
use biotope::compute::ecosystem::species::Need;
use biotope::compute::ecosystem::species::PlantSpecies;
use biotope::compute::ecosystem::species::Stratum;

const PLANTS: &str = include_str!("../../api/examples/data/tautavel_plants.csv");
const CLIMATES: &str = include_str!("../../api/examples/data/tautavel_climate.csv");

/// The rows of a table without its comments and heading, cut at commas.
fn rows(table: &str) -> impl Iterator<Item = Vec<&str>> {
    table.lines().filter(|line| !line.starts_with('#')).skip(1).map(|line| line.split(',').collect())
}

/// The eighteen plants. Growth is not in the table: grass, shrub and forest of a temperate
/// country, to the nearest tenth of a kilogram.
pub fn plants() -> Vec<PlantSpecies> {
    let number = |row: &[&str], i: usize| row[i].parse::<f64>().unwrap();
    let need = |row: &[&str], i: usize| Need {
        range: Interval::new(number(row, i), number(row, i + 1)),
        consumption: number(row, i + 2),
    };
    let plant = |row: Vec<&str>| {
        let (stratum, growth) = match row[18] {
            "tree" => (Stratum::Tree, 1.0),
            "shrub" => (Stratum::Shrub, 0.6),
            _ => (Stratum::Herb, 0.5),
        };
        PlantSpecies {
            name: row[0].to_owned(),
            stratum,
            illumination: need(&row, 1),
            temperature: need(&row, 4),
            moisture: need(&row, 7),
            texture: need(&row, 10),
            viability: std::array::from_fn(|soil| number(&row, 13 + soil)),
            survival_min_c: None,
            growth_kg_per_m2: growth,
            offtake: if stratum == Stratum::Herb { 0.3 } else { 0.1 },
            target: None,
        }
    };
    rows(PLANTS).map(plant).collect()
}

/// The biome of each plant, and the biomes' names in alphabetical order.
pub fn biomes() -> (Vec<usize>, Vec<&'static str>) {
    let of: Vec<&str> = rows(PLANTS).map(|row| row[19]).collect();
    let mut names = of.clone();
    names.sort_unstable();
    names.dedup();
    (of.iter().map(|biome| names.iter().position(|n| n == biome).unwrap()).collect(), names)
}

/// The climate `mild` or `ice_age`.
pub fn climate(name: &str) -> Climate {
    let months: Vec<MonthClimate> = rows(CLIMATES)
        .filter(|row| row[0] == name)
        .map(|row| row[2..].iter().map(|v| v.parse::<f64>().unwrap()).collect::<Vec<_>>())
        .map(|v| MonthClimate {
            temperature_mean_c: v[0],
            temperature_half_range_c: v[1],
            precipitation_mm: v[2],
            sunshine_fraction: v[3],
        })
        .collect();
    Climate {
        months: months.try_into().unwrap(),
        reference_height_m: 100.0,
        lapse_c_per_m: Climate::LAPSE_C_PER_M,
        latitude_deg: 42.85,
    }
}
