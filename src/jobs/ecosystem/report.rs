//! What is told beside the maps: where numbers come from, reasons, warnings, the summary.

use biotope_api::warning::Warning;
use biotope_api::warning::WarningCode;
use serde_json::Value;
use serde_json::json;

use crate::compute::ecosystem::flora::Absence;
use crate::compute::ecosystem::flora::Flora;
use crate::jobs::Artefact;
use crate::jobs::Failure;
use crate::jobs::JobContext;
use crate::jobs::Table;
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

/// The plants' part of the summary, with a warning for each that grows nowhere.
pub fn plants(context: &mut JobContext<'_>, request: &Request, flora: &Flora) -> Vec<Value> {
    let all: f64 = flora.totals.iter().map(|t| t.cover_m2).sum();
    let row = |(s, total): (usize, &crate::compute::ecosystem::flora::Total)| {
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
            "cells": total.cells,
            "proportion_asked": flora.reached.as_ref().map(|r| r.asked[s]),
            "proportion_reached": if all > 0.0 { total.cover_m2 / all } else { 0.0 },
            "why_empty": why,
        })
    };
    flora.totals.iter().enumerate().map(row).collect()
}
