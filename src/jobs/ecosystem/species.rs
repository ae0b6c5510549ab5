//! From the species of a request to species the stages can compute with, each number with its
//! source: the request, the library, or an estimate that is flagged as one.

use std::collections::BTreeMap;

use biotope_api::ecosystem::AnimalInput;
use biotope_api::ecosystem::DietInput;
use biotope_api::ecosystem::FormInput;
use biotope_api::ecosystem::NeedInput;
use biotope_api::ecosystem::PlantInput;
use biotope_api::ecosystem::ViabilityInput;
use biotope_api::error::ErrorCode;

use crate::compute::ecosystem::allometry;
use crate::compute::ecosystem::food_chain;
use crate::compute::ecosystem::species::AnimalSpecies;
use crate::compute::ecosystem::species::DietItem;
use crate::compute::ecosystem::species::Food;
use crate::compute::ecosystem::species::Interval;
use crate::compute::ecosystem::species::Mobility;
use crate::compute::ecosystem::species::Need;
use crate::compute::ecosystem::species::PlantSpecies;
use crate::compute::ecosystem::species::Stratum;
use crate::jobs::Invalid;
use crate::jobs::ecosystem::library;
use crate::jobs::ecosystem::library::Habits;
use crate::jobs::ecosystem::library::Row;

const DAYS_PER_YEAR: f64 = 365.25;
/// What stands as the source of a number that the request gives without one.
const REQUEST: &str = "the request";

/// A number of a species and where it comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct Origin {
    /// The species' slug and the field: `quercus-ilex.growth_kg_per_m2`.
    pub subject: String,
    /// The value, as text.
    pub value: String,
    /// Where it comes from.
    pub source: String,
    /// Whether it is an estimate.
    pub estimated: bool,
}

/// The plants of a request.
#[derive(Debug, Clone, PartialEq)]
pub struct Plants {
    /// The species.
    pub species: Vec<PlantSpecies>,
    /// The biome of each.
    pub biomes: Vec<String>,
    /// Where each number comes from.
    pub origins: Vec<Origin>,
}

/// The animals of a request.
#[derive(Debug, Clone, PartialEq)]
pub struct Animals {
    /// The species, in the order of the request.
    pub species: Vec<AnimalSpecies>,
    /// The habits that the library knows, after a living relative.
    pub habits: Vec<Option<&'static Habits>>,
    /// The most individuals per km² that each bears beside its own kind; infinite for no bound.
    pub max_density_per_km2: Vec<f64>,
    /// Where each number comes from.
    pub origins: Vec<Origin>,
}

/// A name as it stands in output ids: lower case, everything else than letters and digits a dash.
pub fn slug(name: &str) -> String {
    let dashed: String = name.to_lowercase().chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
    dashed.split('-').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("-")
}

/// Collects the numbers of one species with their sources, and its faults.
struct Origins<'a> {
    slug: String,
    pointer: String,
    given: &'a BTreeMap<String, String>,
    origins: Vec<Origin>,
    faults: Invalid,
}

impl<'a> Origins<'a> {
    fn new(species: &str, pointer: String, given: &'a BTreeMap<String, String>) -> Self {
        Self { slug: slug(species), pointer, given, origins: Vec::new(), faults: Invalid::default() }
    }

    fn note(&mut self, field: &str, value: impl ToString, source: &str, estimated: bool) {
        let subject = format!("{}.{field}", self.slug);
        self.origins.push(Origin { subject, value: value.to_string(), source: source.to_owned(), estimated });
    }

    fn note_request(&mut self, field: &str, value: impl ToString) {
        let source = self.given.get(field).map_or(REQUEST, String::as_str).to_owned();
        self.note(field, value, &source, false);
    }

    /// The number of the request, else the one of the library, else a fault.
    fn number(&mut self, field: &str, given: Option<f64>, known: Option<(f64, &str)>) -> f64 {
        match (given, known) {
            (Some(value), _) => self.note_request(field, value),
            (None, Some((value, source))) => self.note(field, value, source, false),
            (None, None) => self.missing(field),
        }
        given.or(known.map(|k| k.0)).unwrap_or(f64::NAN)
    }

    /// The number of the request, else an estimate.
    fn estimate(&mut self, field: &str, given: Option<f64>, or: impl FnOnce() -> allometry::Estimate) -> f64 {
        match given {
            Some(value) => {
                self.note_request(field, value);
                value
            }
            None => {
                let estimate = or();
                self.note(field, estimate.value, estimate.source, true);
                estimate.value
            }
        }
    }

    fn missing(&mut self, field: &str) {
        let expected = "a value, as the species is not one of the library";
        self.faults.push(format!("{}/{field}", self.pointer), ErrorCode::Missing, expected, "nothing");
    }

    fn positive(&mut self, field: &str, value: f64) {
        if value <= 0.0 {
            self.faults.push(format!("{}/{field}", self.pointer), ErrorCode::OutOfRange, "a number above 0", value);
        }
    }
}

/// Makes species of the plants of a request.
pub fn plants(inputs: &[PlantInput]) -> Result<Plants, Invalid> {
    let mut plants = Plants { species: Vec::new(), biomes: Vec::new(), origins: Vec::new() };
    let mut faults = Invalid::default();
    faults.extend(duplicates("/plants", inputs.iter().map(|p| p.species.as_str())));
    for (i, input) in inputs.iter().enumerate() {
        let pointer = format!("/plants/{i}");
        let known = library::plant(&input.species);
        if known.is_none() && is_only_a_name(input) {
            faults.extend(unknown(&pointer, &input.species, &library::plant_names()));
            continue;
        }
        let mut origins = Origins::new(&input.species, pointer, &input.sources);
        let (species, biome) = plant(input, known, &mut origins);
        faults.extend(origins.faults);
        plants.origins.extend(origins.origins);
        plants.species.push(species);
        plants.biomes.push(biome);
    }
    let proportions: Vec<Option<f64>> = inputs.iter().map(|p| p.proportion).collect();
    faults.extend(proportions_of("/plants", "the plants", &proportions));
    faults.into_result().map(|()| plants)
}

fn is_only_a_name(input: &PlantInput) -> bool {
    input.form.is_none() && input.illumination.is_none() && input.temperature.is_none() && input.moisture.is_none()
}

fn plant(input: &PlantInput, known: Option<&'static Row>, origins: &mut Origins) -> (PlantSpecies, String) {
    let stratum = form(input, known, origins);
    let growth = origins.estimate("growth_kg_per_m2", input.growth_kg_per_m2, || allometry::plant_growth(stratum));
    let offtake = origins.estimate("offtake", input.offtake, || allometry::plant_offtake(stratum));
    if let Some(celsius) = input.survival_min_c {
        origins.note_request("survival_min_c", celsius);
    }
    let species = PlantSpecies {
        name: input.species.clone(),
        stratum,
        illumination: need("illumination", input.illumination, known, origins),
        temperature: need("temperature", input.temperature, known, origins),
        moisture: need("moisture", input.moisture, known, origins),
        texture: need("texture", input.texture, known, origins),
        viability: viability(input.viability, known, origins),
        survival_min_c: input.survival_min_c,
        growth_kg_per_m2: growth,
        offtake,
        target: input.proportion,
    };
    if species.illumination.consumption <= 0.0 {
        let pointer = format!("{}/illumination/use", origins.pointer);
        origins.faults.push(
            pointer,
            ErrorCode::OutOfRange,
            "a light use above 0, for it says how much a unit covers",
            0,
        );
    }
    let biome = input.biome.clone().or_else(|| known.map(|row| row.text("biome").to_owned())).unwrap_or_default();
    (species, biome)
}

fn form(input: &PlantInput, known: Option<&'static Row>, origins: &mut Origins) -> Stratum {
    let listed = known.map(|row| row.text("form"));
    match (input.form, listed) {
        (Some(FormInput::Tree), _) | (None, Some("tree")) => Stratum::Tree,
        (Some(FormInput::Shrub), _) | (None, Some("shrub")) => Stratum::Shrub,
        (Some(FormInput::Herb), _) | (None, Some("herb")) => Stratum::Herb,
        _ => {
            origins.missing("form");
            Stratum::Herb
        }
    }
}

fn need(field: &str, given: Option<NeedInput>, known: Option<&'static Row>, origins: &mut Origins) -> Need {
    let listed = |row: &Row| {
        let number = |part: &str| row.number(&format!("{field}_{part}")).unwrap_or(f64::NAN);
        NeedInput { min: number("min"), max: number("max"), consumption: number("use") }
    };
    let text = |n: &NeedInput| format!("{}-{}, use {}", n.min, n.max, n.consumption);
    let need = match (given, known) {
        (Some(need), _) => {
            origins.note_request(field, text(&need));
            need
        }
        (None, Some(row)) => {
            let need = listed(row);
            origins.note(field, text(&need), library::TABLE_A1, false);
            need
        }
        (None, None) => {
            origins.missing(field);
            NeedInput { min: 1.0, max: 9.0, consumption: 0.0 }
        }
    };
    check_range(field, &need, origins);
    Need { range: Interval::new(need.min, need.max), consumption: need.consumption }
}

/// Scales run from 1 to 9, moisture in water to 12; a little more is let pass.
const SCALE: std::ops::RangeInclusive<f64> = 0.0..=12.0;

fn check_range(field: &str, need: &NeedInput, origins: &mut Origins) {
    let pointer = format!("{}/{field}", origins.pointer);
    if need.min > need.max {
        origins.faults.push(
            pointer,
            ErrorCode::Inconsistent,
            "min not above max",
            format!("{} to {}", need.min, need.max),
        );
    } else if !SCALE.contains(&need.min) || !SCALE.contains(&need.max) {
        let found = format!("{} to {}", need.min, need.max);
        origins.faults.push(pointer, ErrorCode::OutOfRange, "a range on the scale 1 to 9", found);
    }
}

fn viability(given: Option<ViabilityInput>, known: Option<&'static Row>, origins: &mut Origins) -> [f64; 5] {
    const COLUMNS: [&str; 5] = ["limestone", "water", "marl", "fallen_rocks", "alluvium"];
    match (given, known) {
        (Some(v), _) => {
            let values = [v.limestone, v.water, v.marl, v.fallen_rocks, v.alluvium];
            origins.note_request("viability", format!("{values:?}"));
            values
        }
        (None, Some(row)) => {
            let values = COLUMNS.map(|c| row.number(&format!("viability_{c}")).unwrap_or(0.0));
            origins.note("viability", format!("{values:?}"), library::TABLE_A1, false);
            values
        }
        (None, None) => {
            origins.missing("viability");
            [0.0; 5]
        }
    }
}

/// Makes species of the animals of a request, which eat `plants` and each other.
pub fn animals(inputs: &[AnimalInput], plants: &Plants) -> Result<Animals, Invalid> {
    let mut animals =
        Animals { species: Vec::new(), habits: Vec::new(), max_density_per_km2: Vec::new(), origins: Vec::new() };
    let mut faults = Invalid::default();
    faults.extend(duplicates("/animals", inputs.iter().map(|a| a.species.as_str())));
    for (i, input) in inputs.iter().enumerate() {
        let pointer = format!("/animals/{i}");
        let known = library::animal(&input.species);
        if known.is_none() && input.mass_kg.is_none() && input.diet.is_none() {
            faults.extend(unknown(&pointer, &input.species, &library::animal_names()));
            continue;
        }
        let mut origins = Origins::new(&input.species, pointer, &input.sources);
        let diet = diet(input, inputs, plants, &mut origins);
        animals.species.push(animal(input, known, diet, &mut origins));
        animals.habits.push(library::habits(&input.species));
        animals.max_density_per_km2.push(max_density(input, &mut origins));
        faults.extend(origins.faults);
        animals.origins.extend(origins.origins);
    }
    faults.into_result()?;
    set_levels(&mut animals.species)?;
    let mut faults = Invalid::default();
    for level in 1..=animals.species.iter().map(|a| a.level).max().unwrap_or(0) {
        let of_level: Vec<usize> = (0..inputs.len()).filter(|i| animals.species[*i].level == level).collect();
        let proportions: Vec<Option<f64>> = of_level.iter().map(|i| inputs[*i].proportion).collect();
        faults.extend(proportions_of("/animals", &format!("the animals of food-chain level {level}"), &proportions));
    }
    faults.into_result().map(|()| animals)
}

fn animal(
    input: &AnimalInput,
    known: Option<&'static Row>,
    diet: Vec<DietItem>,
    origins: &mut Origins,
) -> AnimalSpecies {
    let listed = |column: &str| known.and_then(|row| row.number(column)).map(|v| (v, library::TABLE_A2));
    let middle = listed("mass_min_kg").zip(listed("mass_max_kg")).map(|(a, b)| (0.5 * (a.0 + b.0), library::TABLE_A2));
    let mass_kg = origins.number("mass_kg", input.mass_kg, middle);
    origins.positive("mass_kg", mass_kg);
    let group_min = origins.number("group_size_min", input.group_size_min.map(f64::from), listed("group_size_min"));
    let group_max = origins.number("group_size_max", input.group_size_max.map(f64::from), listed("group_size_max"));
    if group_min > group_max {
        let pointer = format!("{}/group_size_min", origins.pointer);
        let expected = format!("at most group_size_max, which is {group_max}");
        origins.faults.push(pointer, ErrorCode::Inconsistent, expected, group_min);
    }
    let eats_animals = diet.iter().any(|item| matches!(item.food, Food::Animal(_)));
    let intake = origins
        .estimate("food_kg_per_day", input.food_kg_per_day, || allometry::food_kg_per_day(mass_kg, eats_animals));
    origins.positive("food_kg_per_day", intake);
    AnimalSpecies {
        name: input.species.clone(),
        level: 0,
        mass_kg,
        group_min: group_min as u32,
        group_max: group_max as u32,
        diet,
        food_kg_per_year: intake * DAYS_PER_YEAR,
        needs_water: input.needs_water.unwrap_or(true),
        growth_per_year: origins
            .estimate("growth_per_year", input.growth_per_year, || allometry::growth_per_year(mass_kg)),
        offtake: origins.estimate("offtake", input.offtake, allometry::birth_offtake),
        mobility: mobility(input, mass_kg, origins),
        active_from_s: 3600.0 * origins.estimate("active_from_h", input.active_from_h, allometry::active_from_h),
        active_s: 3600.0 * origins.estimate("active_h", input.active_h, allometry::active_h),
        target: input.proportion,
    }
}

fn max_density(input: &AnimalInput, origins: &mut Origins) -> f64 {
    let known = library::habits(&input.species).and_then(|h| Some((h.relative, h.density_per_km2?)));
    match (input.max_density_per_km2, known) {
        (Some(most), _) => {
            origins.note_request("max_density_per_km2", most);
            most
        }
        (None, Some((relative, density))) => {
            let most = library::DENSEST * density;
            let source = format!("ten times that of {relative}, {density} per km2, {}", library::DENSITIES);
            origins.note("max_density_per_km2", most, &source, true);
            most
        }
        (None, None) => f64::INFINITY,
    }
}

fn mobility(input: &AnimalInput, mass_kg: f64, origins: &mut Origins) -> Mobility {
    let habits = library::habits(&input.species);
    let agility = habits.map_or(allometry::Agility::Walker, |h| h.agility);
    let ground = habits.map_or(allometry::Ground::Wooded, |h| h.ground);
    let radians = |degrees: f64| degrees.to_radians().tan();
    let mobility = Mobility {
        speed_m_per_s: origins.estimate("speed_m_per_s", input.speed_m_per_s, || allometry::speed_m_per_s(mass_kg)),
        max_slope_up: radians(
            origins.estimate("max_slope_up_deg", input.max_slope_up_deg, || allometry::max_slope_up_deg(agility)),
        ),
        max_slope_down: radians(
            origins.estimate("max_slope_down_deg", input.max_slope_down_deg, || allometry::max_slope_down_deg(agility)),
        ),
        ford_depth_m: origins.estimate("ford_depth_m", input.ford_depth_m, || allometry::ford_depth_m(mass_kg)),
        max_tree_cover: origins.estimate("max_tree_cover", input.max_tree_cover, || allometry::max_tree_cover(ground)),
    };
    origins.positive("speed_m_per_s", mobility.speed_m_per_s);
    mobility
}

/// The diet given, each food of which must be there; else what is there of the library's.
fn diet(input: &AnimalInput, all: &[AnimalInput], plants: &Plants, origins: &mut Origins) -> Vec<DietItem> {
    let mut items = Vec::new();
    if let Some(given) = &input.diet {
        for (k, item) in given.iter().enumerate() {
            let found = foods(&item.food, item.preference, all, plants);
            if found.is_empty() {
                let pointer = format!("{}/diet/{k}/food", origins.pointer);
                let expected = "`tree`, `shrub` or `herb` with plants of that form, or a species of the request";
                origins.faults.push(pointer, ErrorCode::MissingPrey, expected, &item.food);
            }
            items.extend(found);
        }
        origins.note_request("diet", shown(given));
    } else if let Some(habits) = library::habits(&input.species) {
        items.extend(habits.diet.iter().flat_map(|(food, liking)| foods(food, *liking, all, plants)));
        origins.note("diet", format!("{:?}", habits.diet), habits.diet_source, true);
    }
    items.retain(|item| item.preference > 0.0);
    if items.is_empty() && origins.faults.errors.is_empty() {
        let expected = "something of its diet among the plants and animals of the request";
        origins.faults.push(format!("{}/diet", origins.pointer), ErrorCode::MissingPrey, expected, "nothing it eats");
    }
    items
}

fn shown(diet: &[DietInput]) -> String {
    diet.iter().map(|d| format!("{} {}", d.food, d.preference)).collect::<Vec<_>>().join(", ")
}

fn foods(food: &str, preference: f64, all: &[AnimalInput], plants: &Plants) -> Vec<DietItem> {
    let stratum = match food {
        "tree" => Some(Stratum::Tree),
        "shrub" => Some(Stratum::Shrub),
        "herb" => Some(Stratum::Herb),
        _ => None,
    };
    let plant = |(i, s): (usize, &PlantSpecies)| {
        let eaten = stratum.map_or(s.name == food, |stratum| s.stratum == stratum);
        eaten.then_some(DietItem { food: Food::Plant(i), preference })
    };
    let animal =
        |(i, a): (usize, &AnimalInput)| (a.species == food).then_some(DietItem { food: Food::Animal(i), preference });
    plants.species.iter().enumerate().filter_map(plant).chain(all.iter().enumerate().filter_map(animal)).collect()
}

/// Gives every animal its **food-chain level**: one more than the highest of its foods.
fn set_levels(species: &mut [AnimalSpecies]) -> Result<(), Invalid> {
    let levels = food_chain::levels(species.iter().map(|s| s.diet.as_slice())).map_err(|cycle| {
        let names: Vec<&str> = cycle.iter().map(|i| species[*i].name.as_str()).collect();
        let pointer = format!("/animals/{}/diet", cycle.first().copied().unwrap_or(0));
        Invalid::new(pointer, ErrorCode::FoodChainCycle, "a food chain without a cycle", names.join(" eats "))
    })?;
    species.iter_mut().zip(levels).for_each(|(s, level)| s.level = level);
    Ok(())
}

fn duplicates<'a>(pointer: &str, names: impl Iterator<Item = &'a str>) -> Invalid {
    let (mut seen, mut faults) = (BTreeMap::new(), Invalid::default());
    for (i, name) in names.enumerate() {
        if let Some(first) = seen.insert(slug(name), i) {
            let expected = format!("a name other than that of {pointer}/{first}");
            faults.push(format!("{pointer}/{i}/species"), ErrorCode::DuplicateSpecies, expected, name);
        }
        if slug(name).is_empty() {
            faults.push(format!("{pointer}/{i}/species"), ErrorCode::Malformed, "a name with letters or digits", name);
        }
    }
    faults
}

fn unknown(pointer: &str, name: &str, known: &[&str]) -> Invalid {
    let expected = format!("a species of the library ({}), or one with all its numbers", known.join(", "));
    Invalid::new(format!("{pointer}/species"), ErrorCode::UnknownSpecies, expected, name)
}

/// Proportions are given for all or for none, and are not all zero.
fn proportions_of(pointer: &str, whose: &str, proportions: &[Option<f64>]) -> Invalid {
    let given = proportions.iter().flatten().count();
    let sum: f64 = proportions.iter().flatten().sum();
    let mut faults = Invalid::default();
    if given > 0 && given < proportions.len() {
        let expected = format!("a proportion for all of {whose} or for none");
        faults.push(pointer, ErrorCode::Inconsistent, expected, format!("{given} of {}", proportions.len()));
    } else if given > 0 && sum <= 0.0 {
        faults.push(pointer, ErrorCode::ZeroProportions, format!("proportions of {whose} with a sum above 0"), sum);
    }
    faults
}
