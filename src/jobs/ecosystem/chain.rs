//! The stages of a solve, each memoised under the digest of what it depends on, so that an edit
//! runs only what it touches.

use serde::Serialize;

use crate::compute::ecosystem::fitness;
use crate::compute::ecosystem::fitness::Fitness;
use crate::compute::ecosystem::fitness::FitnessOptions;
use crate::compute::ecosystem::fitness::MonthRule;
use crate::compute::ecosystem::flora;
use crate::compute::ecosystem::flora::Flora;
use crate::compute::ecosystem::flora::FloraError;
use crate::compute::ecosystem::flora::FloraOptions;
use crate::compute::ecosystem::resources::ResourceError;
use crate::compute::ecosystem::resources::ResourceRules;
use crate::compute::ecosystem::resources::Resources;
use crate::compute::ecosystem::terrain::Terrain;
use crate::compute::ecosystem::water::Water;
use crate::compute::ecosystem::water::WaterRules;
use crate::jobs::Digest;
use crate::jobs::Failure;
use crate::jobs::Hasher;
use crate::jobs::JobContext;
use crate::jobs::Stage;
use crate::jobs::ecosystem::request::Request;
use crate::jobs::ecosystem::stored::stage;
use biotope_api::ecosystem::MonthsRule;

/// The terrain with its water.
pub struct Land {
    /// Height, slope and aspect.
    pub terrain: Terrain,
    /// Lakes, rivers and streams.
    pub water: Water,
    digest: Digest,
}

/// The resource maps.
pub struct ClimateMaps {
    /// The maps.
    pub resources: Resources,
    digest: Digest,
}

/// The plants.
pub struct Vegetation {
    /// How well each plant does where.
    pub fitness: Fitness,
    /// How much of each grows where.
    pub flora: Flora,
    digest: Digest,
}

/// The stages, in order; each takes what the ones before it made.
pub struct Chain;

impl Chain {
    /// Stage 1: slope and aspect (not stored: quicker computed than read), water.
    pub fn land(context: &JobContext<'_>, request: &Request) -> Result<Land, Failure> {
        let terrain = Terrain::new(request.height.clone(), &context.run)?;
        let digests = &request.digests;
        let key = Stage { name: "water", version: 1, inputs: digest(&[&digests.terrain, &digests.water], &())? };
        let water = stage(context, key, || {
            Ok(match &request.water_depth {
                Some(depth) => Water::given(&terrain.height, depth, &context.run)?,
                None => Water::derived(&terrain.height, &WaterRules::default(), &context.run)?,
            })
        })?;
        Ok(Land { terrain, water, digest: key.digest() })
    }

    /// Stage 2: the resource maps.
    pub fn climate(context: &JobContext<'_>, request: &Request, land: &Land) -> Result<ClimateMaps, Failure> {
        let inputs = &request.inputs;
        let parameters = (&inputs.climate, inputs.competition.scales, request.climate.latitude_deg);
        let inputs = digest(&[&land.digest, &request.digests.maps], &parameters)?;
        let key = Stage { name: "climate", version: 1, inputs };
        let resources = stage(context, key, || {
            let rules = ResourceRules { scales: request.scales, ..ResourceRules::default() };
            let ground = (&land.terrain, &land.water);
            Resources::assemble(ground, &request.climate, (request.given.clone(), &rules), &context.run)
                .map_err(resource_failure)
        })?;
        Ok(ClimateMaps { resources, digest: key.digest() })
    }

    /// Stage 3: the plants compete.
    pub fn plants(context: &JobContext<'_>, request: &Request, climate: &ClimateMaps) -> Result<Vegetation, Failure> {
        let inputs = &request.inputs;
        let parameters = (&inputs.plants, &inputs.competition, context.seed);
        let inputs = digest(&[&climate.digest, &request.digests.painted], &parameters)?;
        let fitness_key = Stage { name: "plants.fitness", version: 1, inputs };
        let flora_key = Stage { name: "plants.competition", version: 1, inputs };
        let (temperature, light) = (request.scales.temperature, request.scales.illumination);
        let (temperature_scale, illumination_scale) = (|c| temperature.at(c), |l| light.at(l));
        let species = &request.plants.species;
        let resources = &climate.resources;
        let fitness = stage(context, fitness_key, || {
            let options = FitnessOptions {
                months: months(request),
                needs: request.needs,
                temperature_scale: &temperature_scale,
                illumination_scale: &illumination_scale,
            };
            Ok(fitness::fitness(&context.run, species, resources, &options)?)
        })?;
        let flora = stage(context, flora_key, || {
            let options = FloraOptions {
                seed: context.seed,
                needs: request.needs,
                illumination_scale: &illumination_scale,
                bare: request.exclusion.as_ref(),
                proportion_tolerance: request.inputs.competition.proportion_tolerance,
                fill: request.inputs.competition.fill,
            };
            flora::compete(&context.run, species, resources, &fitness, &options).map_err(flora_failure)
        })?;
        Ok(Vegetation { fitness, flora, digest: flora_key.digest() })
    }
}

fn months(request: &Request) -> MonthRule {
    match request.inputs.competition.months {
        MonthsRule::Mean => MonthRule::Mean,
        MonthsRule::Minimum => MonthRule::Minimum,
    }
}

/// The digest of what a stage depends on: other digests, and parameters in their JSON form.
fn digest(inputs: &[&Digest], parameters: &impl Serialize) -> Result<Digest, Failure> {
    let json = serde_json::to_vec(parameters).map_err(Failure::fault)?;
    let hasher = Hasher::new().part("parameters", &json);
    Ok(inputs.iter().fold(hasher, |hasher, input| hasher.part("input", input.to_string().as_bytes())).finish())
}

fn resource_failure(error: ResourceError) -> Failure {
    match error {
        ResourceError::Stopped(stopped) => stopped.into(),
        other => Failure::fault(other),
    }
}

fn flora_failure(error: FloraError) -> Failure {
    match error {
        FloraError::Stopped(stopped) => stopped.into(),
        other => Failure::fault(other),
    }
}
