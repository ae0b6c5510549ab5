//! What is told beside the maps: where numbers come from, reasons, warnings, the summary.

use biotope_api::warning::Warning;
use biotope_api::warning::WarningCode;
use serde_json::Value;
use serde_json::json;

use crate::compute::ecosystem::allometry;
use crate::compute::ecosystem::biomes;
use crate::compute::ecosystem::fauna;
use crate::compute::ecosystem::fauna::Population;
use crate::compute::ecosystem::flora::Absence;
use crate::compute::ecosystem::flora::Flora;
use crate::compute::ecosystem::flora::Total;
use crate::compute::ecosystem::planning;
use crate::compute::ecosystem::planning::Activity;
use crate::compute::ecosystem::planning::Cause;
use crate::compute::ecosystem::planning::Plannings;
use crate::compute::ecosystem::planning::Reason;
use crate::compute::ecosystem::rag;
use crate::compute::ecosystem::regions::Regions;
use crate::compute::ecosystem::species::AnimalSpecies;
use crate::compute::ecosystem::species::Food;
use crate::jobs::Artefact;
use crate::jobs::Failure;
use crate::jobs::JobContext;
use crate::jobs::Table;
use crate::jobs::ecosystem::chain::Country;
use crate::jobs::ecosystem::chain::Days;
use crate::jobs::ecosystem::chain::Trodden;
use crate::jobs::ecosystem::chain::Wildlife;
use crate::jobs::ecosystem::library;
use crate::jobs::ecosystem::life;
use crate::jobs::ecosystem::request::Biomes;
use crate::jobs::ecosystem::request::Request;
use crate::jobs::ecosystem::species::slug;

/// Puts the table of sources, cites them in the manifest, and warns of estimates.
pub fn sources(context: &mut JobContext<'_>, request: &Request) -> Result<(), Failure> {
    for warning in &request.warnings {
        context.warn(warning.clone());
    }
    let origins: Vec<_> = request.plants.origins.iter().chain(&request.animals.origins).collect();
    for origin in &origins {
        let flag = if origin.estimated { " (estimate)" } else { "" };
        context.cite(format!("{} = {}", origin.subject, origin.value), format!("{}{flag}", origin.source));
    }
    climate_source(context, request);
    let estimates = origins.iter().filter(|origin| origin.estimated).count() as u64;
    if estimates > 0 {
        let message = "numbers of species that no table gives are estimates; the output `sources` names each";
        context.warn(Warning::new(WarningCode::Estimated, "", message).with_count(estimates));
    }
    let table = Table::new()
        .texts("subject", origins.iter().map(|o| o.subject.as_str()))
        .texts("value", origins.iter().map(|o| o.value.as_str()))
        .texts("source", origins.iter().map(|o| o.source.as_str()))
        .flags("estimated", origins.iter().map(|o| o.estimated));
    context.put("sources", Artefact::Table(table))
}

fn climate_source(context: &mut JobContext<'_>, request: &Request) {
    let climate = &request.inputs.climate;
    let source = if climate.source.is_empty() { "the request" } else { &climate.source };
    context.cite("climate", format!("{source}{}", if climate.estimated { " (estimate)" } else { "" }));
    if climate.estimated {
        let message = format!("the climate is an estimate: {source}");
        context.warn(Warning::new(WarningCode::Estimated, "/climate", message));
    }
    if request.given.soil.is_none() {
        let message = "no soil map was given: soil types are estimated from slope and water";
        context.warn(Warning::new(WarningCode::Estimated, "/maps/soil", message));
    }
}

/// Why a plant grows nowhere, as a sentence.
pub fn absence(reason: &Absence) -> String {
    match reason {
        Absence::NotAsked => "its proportion is 0".into(),
        Absence::Soil => "no cell has a soil type it can live on".into(),
        Absence::Texture => "no cell has a soil texture in its range".into(),
        Absence::Temperature => "no cell is in its temperature range in any month".into(),
        Absence::TreeLine => "summers are too cool for trees everywhere".into(),
        Absence::Winter => "every winter is colder than it survives".into(),
        Absence::Moisture => "no cell is in its moisture range in any month".into(),
        Absence::Illumination => "no cell has light in its range in any month".into(),
        Absence::NeverTogether(met) => format!(
            "each need is met somewhere but never all in one cell (cells that meet them: light {}, temperature {}, \
             moisture {}, texture {}, soil {})",
            met.illumination, met.temperature, met.moisture, met.texture, met.soil
        ),
        Absence::Outcompeted(c) => format!(
            "others keep it out where it could live (cells too dark {}, shaded {}, full {}, dry {})",
            c.dark, c.shaded, c.full, c.dry
        ),
        Absence::KeptOut => "its units would take the proportions further from those asked for".into(),
    }
}

/// Area and densest places of each biome.
pub fn biomes(context: &mut JobContext<'_>, request: &Request, flora: &Flora) -> Result<(), Failure> {
    if !context.wants("biomes") {
        return Ok(());
    }
    let Biomes { names, of } = &request.biomes;
    let cell_m2 = request.grid().cell_area_m2();
    let dominant = biomes::dominant(flora, of);
    let biome = |(i, name): (usize, &String)| {
        let density = biomes::density(flora, of, i);
        let cover_m2: f64 = density.data.iter().filter(|v| !v.is_nan()).map(|v| f64::from(*v) * cell_m2).sum();
        let dominates = dominant.data.iter().filter(|v| usize::from(**v) == i).count() as f64 * cell_m2;
        let members: Vec<&str> =
            of.iter().zip(&request.plants.species).filter(|(b, _)| **b == i).map(|(_, s)| s.name.as_str()).collect();
        json!({"biome": name, "species": members, "cover_m2": cover_m2, "dominates_m2": dominates})
    };
    let all: Vec<Value> = names.iter().enumerate().map(biome).collect();
    context.put("biomes", Artefact::Json(json!({ "biomes": all })))
}

/// The summary of the whole, and its warnings.
pub fn summary(
    context: &mut JobContext<'_>,
    request: &Request,
    left: &Trodden,
    (country, wildlife, days): (&Country, &Wildlife, &Days),
) -> Result<(), Failure> {
    painted(context, request, left);
    let plants = plants(context, request, left, &wildlife.population);
    let animals = animals(context, request, &country.regions, &wildlife.population);
    let biomass = biomass(context, request, &wildlife.population);
    way_points(context, request, &country.regions);
    plannings(context, days);
    let area_km2 =
        request.height.data.iter().filter(|h| !h.is_nan()).count() as f64 * request.grid().cell_area_m2() * 1e-6;
    let summary = json!({
        "area_km2": area_km2,
        "plants": plants,
        "animals": animals,
        "biomass": biomass,
        "herds": days.plannings.herds.len(),
    });
    context.put("summary", Artefact::Json(summary))
}

fn painted(context: &mut JobContext<'_>, request: &Request, left: &Trodden) {
    for (s, painted) in &left.painted {
        let Some(short) = &painted.shortfall else { continue };
        let place = request.grid().centre(short.worst_cell);
        let message = format!(
            "{} was painted beyond the resources: {:.0} m2 in {} cells do not grow, most at x {:.0}, y {:.0} ({:.0} % of the cell)",
            request.plants.species[*s].name,
            short.area_m2,
            short.cells,
            place.x,
            place.y,
            100.0 * short.worst
        );
        let pointer = format!("/plants/{s}/painted_cover");
        context.warn(Warning::new(WarningCode::PaintedBeyondResources, pointer, message).with_count(short.cells));
    }
}

/// The plants' part of the summary, with a warning for each that grows nowhere.
fn plants(
    context: &mut JobContext<'_>,
    request: &Request,
    Trodden { flora, before, .. }: &Trodden,
    population: &Population,
) -> Vec<Value> {
    let all: f64 = before.iter().map(|t| t.cover_m2).sum();
    let row = |(s, total): (usize, &Total)| {
        let plant = &request.plants.species[s];
        let why = total.why_empty.as_ref().map(absence);
        if let Some(why) = &why {
            let message = format!("{} grows nowhere: {why}", plant.name);
            context.warn(Warning::new(WarningCode::NotPlaced, format!("/plants/{s}"), message));
        }
        json!({
            "species": plant.name,
            "slug": slug(&plant.name),
            "cover_m2": total.cover_m2,
            "cover_beside_trails_m2": flora.totals[s].cover_m2,
            "cells": total.cells,
            "proportion_asked": flora.reached.as_ref().map(|r| r.asked[s]),
            "proportion_reached": if all > 0.0 { total.cover_m2 / all } else { 0.0 },
            "growth_kg_per_year": stock(population, Food::Plant(s)).0,
            "eaten_kg_per_year": stock(population, Food::Plant(s)).1,
            "surplus_kg_per_year": stock(population, Food::Plant(s)).0 - stock(population, Food::Plant(s)).1,
            "why_empty": why,
        })
    };
    before.iter().enumerate().map(row).collect()
}

/// What grew of a food where animals go, and what was eaten of it, kg a year.
fn stock(population: &Population, food: Food) -> (f64, f64) {
    population.stocks.of(food).map_or((0.0, 0.0), |s| (s.growth_kg.iter().sum(), s.eaten_kg.iter().sum()))
}

/// Why an animal lives nowhere, as a sentence.
fn nobody(absence: &fauna::Absence) -> String {
    match absence {
        fauna::Absence::NotWanted => "its proportion is 0".into(),
        fauna::Absence::NoRegion => "no part of the terrain that is large enough is open to it".into(),
        fauna::Absence::NoWater => "none of its regions holds water it can reach".into(),
        fauna::Absence::NoRoom => "a group needs more room than any of its regions has".into(),
        fauna::Absence::NoFood { needed_kg, found_kg } => format!(
            "a group needs {needed_kg:.0} kg of food a year and its best region offers {found_kg:.0} in the leanest season"
        ),
        fauna::Absence::Displaced => "others took its food, or the proportions left it out".into(),
    }
}

/// The animals' part of the summary, with warnings.
fn animals(context: &mut JobContext<'_>, request: &Request, regions: &Regions, population: &Population) -> Vec<Value> {
    let of_level = |level: usize| -> u64 {
        let species = request.animals.species.iter().enumerate().filter(|(_, a)| a.level == level);
        species.map(|(s, _)| population.total(s)).sum()
    };
    let asked = |animal: &AnimalSpecies| -> Option<f64> {
        let level = request.animals.species.iter().filter(|a| a.level == animal.level);
        Some(animal.target? / level.filter_map(|a| a.target).sum::<f64>())
    };
    let mut rows = Vec::new();
    for (s, animal) in request.animals.species.iter().enumerate() {
        let individuals = population.total(s);
        let area_km2 = (0..regions.count(s)).fold(0.0, |km2, r| km2 + 1e-6 * regions.area_m2(s, r));
        let territories = population.rag.territories.iter().filter(|t| t.species == s && t.individuals() > 0);
        let inhabited_km2 = territories.clone().fold(0.0, |km2, t| km2 + 1e-6 * regions.area_m2(s, t.region));
        let density = if area_km2 > 0.0 { individuals as f64 / area_km2 } else { 0.0 };
        let why = population.absent[s].as_ref().map(nobody);
        if let Some(why) = &why {
            let message = format!("{} lives nowhere: {why}", animal.name);
            context.warn(Warning::new(WarningCode::NotPlaced, format!("/animals/{s}"), message));
        }
        warn_of_density(context, request, s, density);
        let level = of_level(animal.level);
        let (births, eaten) = stock(population, Food::Animal(s));
        rows.push(json!({
            "species": animal.name,
            "slug": slug(&animal.name),
            "level": animal.level,
            "individuals": individuals,
            "herds": territories.map(|t| t.herds.len()).sum::<usize>(),
            "accessible_km2": area_km2,
            "inhabited_km2": inhabited_km2,
            "individuals_per_km2": density,
            "proportion_asked": asked(animal),
            "proportion_reached": if level > 0 { individuals as f64 / level as f64 } else { 0.0 },
            "young_kg_per_year": births,
            "eaten_kg_per_year": eaten,
            "surplus_kg_per_year": births - eaten,
            "why_empty": why,
        }));
    }
    rows
}

/// Warns of a species that lives more densely than ten times its living relative, or, where none
/// is known, than ten times what its mass lets expect.
fn warn_of_density(context: &mut JobContext<'_>, request: &Request, s: usize, density: f64) {
    let animal = &request.animals.species[s];
    let known = request.animals.habits[s].and_then(|h| Some((h.density_per_km2?, h.relative, library::DENSITIES)));
    let (usual, of, source) = known.unwrap_or_else(|| {
        let eats_animals = animal.diet.iter().any(|item| matches!(item.food, Food::Animal(_)));
        let estimate = allometry::density_per_km2(animal.mass_kg, eats_animals);
        (estimate.value, "mammals of its mass", estimate.source)
    });
    if density > library::DENSEST * usual {
        let name = &animal.name;
        let message =
            format!("{name} lives at {density:.2} per km2, more than ten times the {usual:.2} of {of} ({source})");
        context.warn(Warning::new(WarningCode::DensityOutOfRange, format!("/animals/{s}"), message));
    }
}

/// Carnivores weigh 0.3 to 3 % of their prey: bounds of the range found in large mammals by
/// Carbone and Gittleman 2002 (Science 295:2273), about 1 %.
const BIOMASS_RANGE: std::ops::RangeInclusive<f64> = 0.003..=0.03;

/// Biomass by level, with a warning where carnivores are out of proportion with their prey.
fn biomass(context: &mut JobContext<'_>, request: &Request, population: &Population) -> Value {
    let animals = &request.animals.species;
    let kg = |s: usize| population.total(s) as f64 * animals[s].mass_kg;
    let is_carnivore = |a: &AnimalSpecies| a.diet.iter().any(|d| matches!(d.food, Food::Animal(_)));
    let is_prey =
        |s: usize| animals.iter().any(|a| a.diet.iter().any(|d| d.food == Food::Animal(s) && d.preference > 0.0));
    let sum = |chosen: &dyn Fn(usize) -> bool| -> f64 { (0..animals.len()).filter(|s| chosen(*s)).map(kg).sum() };
    let carnivores = sum(&|s| is_carnivore(&animals[s]));
    let prey = sum(&|s| is_prey(s) && !is_carnivore(&animals[s]));
    let ratio = if prey > 0.0 { carnivores / prey } else { 0.0 };
    if carnivores > 0.0 && !BIOMASS_RANGE.contains(&ratio) {
        let message = format!("carnivores weigh {:.2} % of their prey", 100.0 * ratio);
        context.warn(Warning::new(WarningCode::BiomassOutOfRange, "/animals", message));
    }
    json!({"carnivores_kg": carnivores, "prey_kg": prey, "carnivores_per_prey": ratio})
}

fn plannings(context: &mut JobContext<'_>, days: &Days) {
    for (herd, sentence) in &days.conflicts {
        let message = format!("herd {herd}: {sentence}");
        context.warn(Warning::new(WarningCode::PlanningConflict, "/planning/edits", message));
    }
    let count = |of: &dyn Fn(&Reason) -> bool| days.plannings.warnings.iter().filter(|w| of(&w.reason)).count() as u64;
    let kinds: [(&str, u64); 3] = [
        ("waited because no node had room", count(&|r| matches!(r, Reason::Crowded(_)))),
        ("found no node with room to rest", count(&|r| matches!(r, Reason::NoRoomToRest))),
        ("met no prey for a time", count(&|r| matches!(r, Reason::PreyOutOfReach(_)))),
    ];
    let kinds = kinds.map(|(what, herds)| (format!("herds {what}"), herds));
    let mut missed: Vec<(Activity, Cause, usize)> = Vec::new();
    for warning in &days.plannings.warnings {
        let Reason::Missed(activity, cause) = warning.reason else { continue };
        missed.push((activity, cause, warning.herd));
    }
    missed.sort_unstable();
    missed.dedup();
    let missed = missed.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).map(|herds| {
        let often = if herds[0].0 == Activity::Drink { "as often as they should" } else { "at all" };
        (format!("herds could not {} {often}: {}", life::activity(herds[0].0), because(herds[0].1)), herds.len() as u64)
    });
    for (message, herds) in kinds.into_iter().chain(missed).filter(|(_, herds)| *herds > 0) {
        context.warn(Warning::new(WarningCode::HerdWaits, "/planning", message).with_count(herds));
    }
}

/// What a herd needs every day and misses, and why; empty when it has all.
pub fn missed(plannings: &Plannings, herd: usize) -> String {
    let of_herd = plannings.warnings.iter().filter(|warning| warning.herd == herd);
    let sentence = |warning: &planning::Warning| match warning.reason {
        Reason::Missed(activity, cause) => Some(format!("{}: {}", life::activity(activity), because(cause))),
        _ => None,
    };
    of_herd.filter_map(sentence).collect::<Vec<String>>().join("; ")
}

const fn because(cause: Cause) -> &'static str {
    match cause {
        Cause::NoWay => "no way leads there and back",
        Cause::TooFar => "too far for the active day",
        Cause::TooSmall => "no place within reach holds the whole herd",
        Cause::NoRoom => "no room at any time of the day",
        Cause::NoTime => "room at some time of the day, but not when they came by",
        Cause::NoPrey => "no prey met",
    }
}

/// Warns of each way-point that an animal it is to draw cannot reach. Of those that are to draw all,
/// it is enough that one animal reaches them.
fn way_points(context: &mut JobContext<'_>, request: &Request, regions: &Regions) {
    for (i, way_point) in request.way_points.iter().enumerate() {
        let drawn: Vec<usize> = (0..request.animals.species.len()).filter(|s| way_point.draws(*s)).collect();
        let lost: Vec<&str> = drawn
            .iter()
            .filter(|s| rag::reached(regions, **s, way_point).is_none())
            .map(|s| request.animals.species[*s].name.as_str())
            .collect();
        let all = way_point.species.is_empty();
        if !lost.is_empty() && (!all || lost.len() == drawn.len()) {
            let message = format!("{} lies in no confinement region of {}", request.way_point_name(i), lost.join(", "));
            let pointer = format!("/passages/waypoints/{i}");
            let count = lost.len() as u64;
            context.warn(Warning::new(WarningCode::WaypointNotReached, pointer, message).with_count(count));
        }
    }
}
