//! The stages of a solve, each memoised under the digest of what it depends on, so that an edit
//! runs only what it touches.

use std::cell::OnceCell;

use serde::Serialize;

use crate::compute::ecosystem::fauna;
use crate::compute::ecosystem::fauna::FaunaOptions;
use crate::compute::ecosystem::fauna::Habitable;
use crate::compute::ecosystem::fauna::Population;
use crate::compute::ecosystem::fitness;
use crate::compute::ecosystem::fitness::Fitness;
use crate::compute::ecosystem::fitness::FitnessOptions;
use crate::compute::ecosystem::fitness::MonthRule;
use crate::compute::ecosystem::flora;
use crate::compute::ecosystem::flora::Flora;
use crate::compute::ecosystem::flora::FloraError;
use crate::compute::ecosystem::flora::FloraOptions;
use crate::compute::ecosystem::flora::Painted;
use crate::compute::ecosystem::flora::Total;
use crate::compute::ecosystem::habitat::Habitat;
use crate::compute::ecosystem::planning;
use crate::compute::ecosystem::planning::Conflict;
use crate::compute::ecosystem::planning::Edit;
use crate::compute::ecosystem::planning::Pace;
use crate::compute::ecosystem::planning::Plannings;
use crate::compute::ecosystem::planning::Track;
use crate::compute::ecosystem::rag::NodeOptions;
use crate::compute::ecosystem::rag::PlantGrowth;
use crate::compute::ecosystem::regions::Ground;
use crate::compute::ecosystem::regions::RegionOptions;
use crate::compute::ecosystem::regions::Regions;
use crate::compute::ecosystem::resources::MONTHS;
use crate::compute::ecosystem::resources::ResourceError;
use crate::compute::ecosystem::resources::ResourceRules;
use crate::compute::ecosystem::resources::Resources;
use crate::compute::ecosystem::species::Interval;
use crate::compute::ecosystem::species::Stratum;
use crate::compute::ecosystem::terrain::Terrain;
use crate::compute::ecosystem::trails;
use crate::compute::ecosystem::trails::Trails;
use crate::compute::ecosystem::travel::Travel;
use crate::compute::ecosystem::travel::TravelOptions;
use crate::compute::ecosystem::water::Water;
use crate::compute::ecosystem::water::WaterRules;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
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
    pub grown: Grown,
    digest: Digest,
}

/// The plants once trails are worn.
pub struct Trodden {
    /// How much of each grows beside the trails.
    pub flora: Flora,
    /// What there was of each before.
    pub before: Vec<Total>,
    /// What painting did, by plant.
    pub painted: Vec<(usize, Painted)>,
}

/// Where each animal can go.
pub struct Country {
    /// The confinement regions.
    pub regions: Regions,
    /// Cover of all trees.
    pub tree_cover: Raster<f32>,
    digest: Digest,
}

/// The animals.
pub struct Wildlife {
    /// Who lives where, and on what; with travel times.
    pub population: Population,
    digest: Digest,
}

/// What the herds do all day, and where they are.
pub struct Days {
    /// The plannings.
    pub plannings: Plannings,
    /// The paths, herd by herd.
    pub tracks: Vec<Track>,
    /// What could not be edited as asked: the herd and a sentence.
    pub conflicts: Vec<(usize, String)>,
}

/// Travel times of each territory, in the order of the graph's territories.
pub struct Times(pub Vec<Vec<f32>>);

/// What grows, after the competition and the edits.
pub struct Grown {
    /// The plants.
    pub flora: Flora,
    /// What painting did, by plant.
    pub painted: Vec<(usize, Painted)>,
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
        let key = Stage { name: "climate", version: 3, inputs };
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
        let growth_key = Stage { name: "plants.competition", version: 2, inputs };
        let (species, resources) = (&request.plants.species, &climate.resources);
        let fitness = stage(context, fitness_key, || {
            let options = FitnessOptions {
                months: months(request),
                needs: request.needs,
                scales: request.scales,
                ..FitnessOptions::default()
            };
            Ok(fitness::fitness(&context.run, species, resources, &options)?)
        })?;
        let grown = stage(context, growth_key, || {
            let options = flora_options(context, request);
            let flora = flora::compete(&context.run, species, resources, &fitness, &options).map_err(flora_failure)?;
            paint(context, request, (resources, &fitness), flora)
        })?;
        Ok(Vegetation { fitness, grown, digest: growth_key.digest() })
    }

    /// Stage 4: where each animal can go.
    pub fn regions(
        context: &JobContext<'_>,
        request: &Request,
        (land, plants): (&Land, &Vegetation),
    ) -> Result<Country, Failure> {
        let tree_cover = plants.grown.flora.stratum_map(&request.plants.species, Stratum::Tree);
        let inputs = digest(&[&land.digest, &plants.digest], &(&request.inputs.animals, &request.inputs.passages))?;
        let key = Stage { name: "animals.regions", version: 1, inputs };
        let regions = stage(context, key, || {
            let ground = ground(land, &tree_cover);
            let min_area_m2 = least_area_m2(request);
            let options = RegionOptions { min_area_m2, ..RegionOptions::default() };
            Ok(Regions::new(&ground, &request.passages, &request.animals.species, &options, &context.run)?)
        })?;
        Ok(Country { regions, tree_cover, digest: key.digest() })
    }

    /// Stages 5 and 6: the Resource Access Graph, and the animals that compete on it.
    pub fn animals(
        context: &JobContext<'_>,
        request: &Request,
        (land, plants, roads): (&Land, &Vegetation, &Roads<'_>),
    ) -> Result<Wildlife, Failure> {
        let (animals, country) = (&request.animals.species, roads.country);
        let parameters = (&request.inputs.animals, &request.inputs.competition, &request.inputs.climate, context.seed);
        let inputs = digest(&[&country.digest], &parameters)?;
        let key = Stage { name: "animals.competition", version: 4, inputs };
        let population = stage(context, key, || {
            let growth = Growth { request, plants };
            let habitable = Habitable {
                regions: &country.regions,
                water_depth: &land.water.depth_m,
                plants: &request.plants.species,
                growth: &growth,
                animals,
                way_points: &request.way_points,
            };
            Ok(fauna::populate(&habitable, &fauna_options(context, request), &context.run)?)
        })?;
        let key = Stage { name: "animals.travel", version: 2, inputs: digest(&[&key.digest()], &())? };
        let times = stage(context, key, || {
            let mut rag = population.rag.clone();
            roads.travel(&context.run)?.fill_times(&mut rag, &context.run)?;
            Ok(Times(rag.territories.into_iter().map(|t| t.times_s).collect()))
        })?;
        let mut population = population;
        for (territory, times_s) in population.rag.territories.iter_mut().zip(times.0) {
            territory.times_s = times_s;
        }
        Ok(Wildlife { population, digest: key.digest() })
    }

    /// Stage 7: the trails they wear.
    pub fn trails(
        context: &JobContext<'_>,
        request: &Request,
        roads: &Roads<'_>,
        wildlife: &Wildlife,
    ) -> Result<Trails, Failure> {
        stage(context, Self::trails_stage(context, request, wildlife)?, || {
            let habitat = habitat(request, wildlife, roads.travel(&context.run)?);
            Ok(trails::trails(&habitat, &trails_options(context, request), &context.run)?)
        })
    }

    fn trails_stage(context: &JobContext<'_>, request: &Request, wildlife: &Wildlife) -> Result<Stage, Failure> {
        let parameters = (&request.inputs.trails, context.seed);
        Ok(Stage { name: "trails", version: 4, inputs: digest(&[&wildlife.digest], &parameters)? })
    }

    /// What grows beside the trails: the plants under them are removed (L 6.1), in the maps of
    /// the plants themselves, which nothing needs as they were. Not stored: one pass.
    pub fn beside_trails(
        context: &JobContext<'_>,
        request: &Request,
        (climate, plants): (&ClimateMaps, Vegetation),
        trails: &Trails,
    ) -> Result<Trodden, Failure> {
        let Vegetation { fitness, grown: Grown { flora, painted }, .. } = plants;
        let (ground, options) = ((&climate.resources, &fitness), flora_options(context, request));
        let (before, worn) = (flora.totals.clone(), (flora, &trails.worn));
        let flora = flora::clear(&context.run, &request.plants.species, ground, worn, &options);
        Ok(Trodden { flora: flora.map_err(flora_failure)?, before, painted })
    }

    /// Stage 8: what each herd does all day, on the trails where these lead.
    pub fn plannings(
        context: &JobContext<'_>,
        request: &Request,
        (land, roads): (&Land, &Roads<'_>),
        (wildlife, trails): (&Wildlife, &Trails),
    ) -> Result<Days, Failure> {
        let parameters = (&request.inputs.planning, context.seed);
        let trodden = Self::trails_stage(context, request, wildlife)?.digest();
        let key = Stage { name: "planning", version: 6, inputs: digest(&[&trodden], &parameters)? };
        stage(context, key, || {
            let habitat =
                Habitat { paths: Some(&trails.paths), ..habitat(request, wildlife, roads.travel(&context.run)?) };
            let options = planning_options(context, request);
            let mut plannings = planning::plannings(&habitat, &options, &context.run)?;
            let conflicts = edit(context, request, &habitat, (&mut plannings, &options))?;
            let all: Vec<usize> = (0..plannings.herds.len()).collect();
            let pace = Pace { step_s: request.inputs.planning.path_step_s, height: Some(&land.terrain.height) };
            let tracks = planning::tracks(&habitat, &plannings, &all, pace, &context.run)?;
            Ok(Days { plannings, tracks, conflicts })
        })
    }
}

/// How the animals travel: prepared when a stage first asks, and shared by the stages.
pub struct Roads<'a> {
    request: &'a Request,
    land: &'a Land,
    /// Where each animal can go.
    pub country: &'a Country,
    travel: OnceCell<Travel<'a>>,
}

impl<'a> Roads<'a> {
    /// Nothing is prepared yet.
    pub fn new(request: &'a Request, land: &'a Land, country: &'a Country) -> Self {
        Self { request, land, country, travel: OnceCell::new() }
    }

    fn travel(&self, run: &Run) -> Result<&Travel<'a>, Failure> {
        if let Some(travel) = self.travel.get() {
            return Ok(travel);
        }
        let ground = ground(self.land, &self.country.tree_cover);
        let (regions, animals) = (&self.country.regions, &self.request.animals.species);
        let options = TravelOptions::default();
        let travel = Travel::new((ground, &self.request.passages), regions, animals, &options, run)?;
        Ok(self.travel.get_or_init(|| travel))
    }
}

/// Applies the edits, herd by herd in the order in which they first come up.
fn edit(
    context: &JobContext<'_>,
    request: &Request,
    habitat: &Habitat<'_>,
    (plannings, options): (&mut Plannings, &planning::Options),
) -> Result<Vec<(usize, String)>, Failure> {
    let mut herds: Vec<usize> = request.edits.iter().map(|(herd, _)| *herd).collect();
    herds.sort_unstable();
    herds.dedup();
    let mut conflicts = Vec::new();
    for herd in herds {
        if herd >= plannings.herds.len() {
            conflicts.push((herd, format!("there are only {} herds", plannings.herds.len())));
            continue;
        }
        let edits: Vec<Edit> = request.edits.iter().filter(|(h, _)| *h == herd).map(|(_, edit)| *edit).collect();
        let edited = planning::edit(habitat, (plannings, options), (herd, &edits), &context.run)?;
        for (changed, day) in edited.days {
            plannings.days[changed] = day;
        }
        conflicts.extend(edited.conflicts.iter().map(|(herd, conflict)| (*herd, sentence(conflict))));
    }
    Ok(conflicts)
}

fn sentence(conflict: &Conflict) -> String {
    match conflict {
        Conflict::NoSuchVisit(order) => format!("there is no visit {order} that can be changed"),
        Conflict::NotReached(node) => format!("node {node} is not in its territory or cannot be reached"),
        Conflict::Late(node, seconds) => format!("it is {seconds:.0} s late at node {node}"),
        Conflict::NoTime(node) => format!("there was no time for node {node}"),
        Conflict::PreyGone(node) => format!("its prey is not met at node {node}"),
        Conflict::Crowded(node, many) => format!("node {node} holds {many} individuals too many"),
        Conflict::Missed(_) => "something it needs every day is no longer visited".to_owned(),
    }
}

/// The terrain with its animals in place.
fn habitat<'a>(request: &'a Request, wildlife: &'a Wildlife, travel: &'a Travel<'a>) -> Habitat<'a> {
    Habitat {
        grid: &request.height.grid,
        rag: &wildlife.population.rag,
        animals: &request.animals.species,
        ways: travel,
        paths: None,
    }
}

fn trails_options(context: &JobContext<'_>, request: &Request) -> trails::Options {
    let (input, wear) = (&request.inputs.trails, trails::Wear::default());
    let width_m = Interval::new(wear.width_m.min.min(input.width_m), input.width_m);
    trails::Options {
        seed: context.seed,
        wear: trails::Wear { width_m, depth_limit_m: input.depth_limit_m, ..wear },
        ..trails::Options::default()
    }
}

fn planning_options(context: &JobContext<'_>, request: &Request) -> planning::Options {
    planning::Options { seed: context.seed, m2_each: request.inputs.planning.m2_each, ..planning::Options::default() }
}

/// What stops or slows animals.
pub fn ground<'a>(land: &'a Land, tree_cover: &'a Raster<f32>) -> Ground<'a> {
    let Terrain { height, slope, .. } = &land.terrain;
    Ground { height, slope, water_depth: &land.water.depth_m, tree_cover }
}

/// The yearly growth of the plants that stand.
pub struct Growth<'a> {
    /// Whose plants.
    pub request: &'a Request,
    /// The plants.
    pub plants: &'a Vegetation,
}

impl PlantGrowth for Growth<'_> {
    fn row(&self, plant: usize, row: usize, out: &mut [f32]) {
        let Vegetation { fitness, grown, .. } = self.plants;
        let first = row * self.request.grid().width;
        for (i, kg) in out.iter_mut().enumerate() {
            *kg = grown.flora.growth_kg(&self.request.plants.species[plant], fitness, (plant, first + i)) as f32;
        }
    }
}

/// Regions and resources of a smaller area are left alone, m².
fn least_area_m2(request: &Request) -> f64 {
    request.inputs.passages.min_region_m2.unwrap_or(RegionOptions::default().min_area_m2)
}

fn fauna_options(context: &JobContext<'_>, request: &Request) -> FaunaOptions {
    let competition = &request.inputs.competition;
    FaunaOptions {
        seed: context.seed,
        proportion_tolerance: competition.proportion_tolerance,
        fill: competition.fill,
        max_density_per_km2: (0..request.animals.species.len()).map(|s| max_density(request, s)).collect(),
        plant_seasons: vec![seasons(request); request.plants.species.len()],
        nodes: NodeOptions { min_area_m2: least_area_m2(request), ..NodeOptions::default() },
    }
}

/// The most individuals per km². The bound of the library gives way only on land so small that not
/// one group could live on the whole of it.
fn max_density(request: &Request, species: usize) -> f64 {
    let land = request.height.data.iter().filter(|height| !height.is_nan()).count();
    let land_km2 = 1e-6 * land as f64 * request.grid().cell_area_m2();
    let group = f64::from(request.animals.species[species].group_min);
    request.animals.max_density_per_km2[species].max(group / land_km2)
}

/// The share of each month in what can be eaten of a plant (ours): half of the year's growth
/// stands all year, as cured grass and twigs; the other half goes with the warmth above 5 °C, the
/// usual threshold of growth, at the terrain's mean height.
fn seasons(request: &Request) -> Vec<f64> {
    const GROWTH_THRESHOLD_C: f64 = 5.0;
    let heights = request.height.data.iter().filter(|h| h.is_finite());
    let (sum, count) = heights.fold((0.0, 0.0), |(s, n), h| (s + f64::from(*h), n + 1.0));
    let climate = &request.climate;
    let cooling = climate.lapse_c_per_m * (sum / f64::max(count, 1.0) - climate.reference_height_m);
    let warmth = climate.months.map(|m| (m.temperature_mean_c - cooling - GROWTH_THRESHOLD_C).max(0.0));
    let year: f64 = warmth.iter().sum();
    let even = 1.0 / MONTHS as f64;
    warmth.iter().map(|w| 0.5 * even + 0.5 * if year > 0.0 { w / year } else { even }).collect()
}

/// The rules of the plants' competition.
pub fn flora_options<'a>(context: &JobContext<'_>, request: &'a Request) -> FloraOptions<'a> {
    FloraOptions {
        seed: context.seed,
        needs: request.needs,
        scales: request.scales,
        bare: request.exclusion.as_ref(),
        proportion_tolerance: request.inputs.competition.proportion_tolerance,
        fill: request.inputs.competition.fill,
        ..FloraOptions::default()
    }
}

/// Applies the painted covers, in the order of the plants.
fn paint(
    context: &JobContext<'_>,
    request: &Request,
    ground: (&Resources, &Fitness),
    mut flora: Flora,
) -> Result<Grown, Failure> {
    let options = flora_options(context, request);
    let mut painted = Vec::new();
    for (s, wanted) in &request.painted {
        let (after, done) = flora::paint(&context.run, &request.plants.species, ground, (flora, *s, wanted), &options)
            .map_err(flora_failure)?;
        flora = after;
        painted.push((*s, done));
    }
    Ok(Grown { flora, painted })
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
