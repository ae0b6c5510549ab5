//! `ecosystem`: from a terrain, a climate and species to where everything lives, the trails
//! animals wear and what every herd does all day (L, T chapter 5).
//!
//! | file | holds |
//! |---|---|
//! | `request` | inputs on the wire → a request that cannot be wrong |
//! | `species`, `library` | the numbers of each species, and where they come from |
//! | `chain` | the stages, each memoised |
//! | `stored` | the stored form of what stages hand on |
//! | `outputs`, `life`, `report` | maps, tables and the summary |

mod chain;
mod library;
mod life;
mod outputs;
mod report;
mod request;
mod species;
mod stored;

use biotope_api::ecosystem::EcosystemInputs;
use serde_json::Value;

use crate::jobs::Description;
use crate::jobs::Estimate;
use crate::jobs::Failure;
use crate::jobs::Invalid;
use crate::jobs::Job;
use crate::jobs::JobContext;
use crate::jobs::Output;
use crate::jobs::Process;
use crate::jobs::Sources;
use crate::jobs::artefact::Kind;
use crate::jobs::ecosystem::chain::Chain;
use crate::jobs::ecosystem::chain::Roads;
use crate::jobs::ecosystem::outputs::Maps;
use crate::jobs::ecosystem::request::Request;
use crate::jobs::process::ASYNC;
use crate::jobs::process::inputs_schema;
use crate::jobs::schema::read;

/// The process.
pub struct Ecosystem;

impl Process for Ecosystem {
    fn description(&self) -> Description {
        Description {
            id: "ecosystem",
            title: "Ecosystem",
            text: "Solves an ecosystem on a terrain at its steady state: cover of every plant, herds of \
                   every animal, the trails they wear and what each herd does all day.",
            version: "1",
            keywords: &["ecosystem", "vegetation", "fauna", "trails"],
            control: ASYNC,
            inputs: inputs_schema::<EcosystemInputs>(),
            outputs: outputs(),
        }
    }

    fn parse(&self, inputs: Value, sources: &dyn Sources) -> Result<Box<dyn Job>, Invalid> {
        let inputs: EcosystemInputs = read(inputs)?;
        Ok(Box::new(EcosystemJob { request: Request::parse(inputs, sources)? }))
    }
}

fn outputs() -> Vec<Output> {
    let map = |id, title, text, unit| Output::new(id, title, text, Kind::Map).in_unit(unit);
    vec![
        map("terrain.height", "Height", "Height of the ground.", "m"),
        map("terrain.slope", "Slope", "Slope of the ground.", "rise over run"),
        map("terrain.water", "Water", "Depth of lakes, rivers and streams.", "m"),
        map("climate.temperature_min.<mm>", "Monthly minimum", "Mean of the daily minima of a month.", "°C")
            .on_request(),
        map("climate.temperature_max.<mm>", "Monthly maximum", "Mean of the daily maxima of a month.", "°C")
            .on_request(),
        map("climate.sunlight.<mm>", "Sunlight", "Light fraction of a month.", "light fraction").on_request(),
        map("climate.moisture.<mm>", "Moisture", "Soil moisture of a month.", "scale 1-9").on_request(),
        map("soil", "Soil", "Soil type.", ""),
        map(
            "plants.cover.<slug>",
            "Cover of a plant",
            "Share of each cell that the species covers.",
            "share of the cell",
        ),
        map("plants.surplus.<slug>", "Surplus of a plant", "Yearly growth that nothing eats.", "kg/m² a year"),
        map("plants.left.light", "Light left", "Light that reaches the ground, mean of the year.", "light fraction"),
        map(
            "plants.left.moisture",
            "Moisture left",
            "Moisture that plants do not draw, mean of the year.",
            "scale 1-9",
        ),
        map("plants.biome", "Biome", "The biome that covers most of each cell.", ""),
        map(
            "animals.regions.<slug>",
            "Confinement regions",
            "Numbers of the regions that the species cannot leave.",
            "",
        ),
        map("animals.density.<slug>", "Density of an animal", "Individuals per square kilometre.", "individuals/km²"),
        map("animals.surplus.<slug>", "Surplus of an animal", "Yearly births that nothing eats.", "kg/km² a year"),
        Output::new(
            "rag",
            "Resource Access Graph",
            "Nodes, and travel times between them for each species.",
            Kind::Tables,
        ),
        map("trails.usage", "Trails", "Mass of animals a year times metres walked, per area.", "kg m a year per m²"),
        Output::new("trails.lines", "Trails", "Trails as lines with their weight and width.", Kind::Json),
        map("terrain.carved", "Carved height", "Height of the ground with the trails worn into it.", "m"),
        Output::new("herds", "Herds", "Every herd with its region and size.", Kind::Table),
        Output::new("plannings", "Plannings", "What every herd does all day.", Kind::Table),
        Output::new("paths", "Paths", "Where every herd is, step by step.", Kind::Table),
        Output::new("biomes", "Biomes", "Area and densest places of each biome.", Kind::Json),
        Output::new("summary", "Summary", "Individuals, proportions, surplus and reasons, by species.", Kind::Json),
        Output::new("sources", "Sources", "Where every number of every species comes from.", Kind::Table),
    ]
}

/// The job.
struct EcosystemJob {
    request: Request,
}

impl Job for EcosystemJob {
    fn estimate(&self) -> Estimate {
        Estimate { memory_bytes: self.request.memory_bytes() }
    }

    fn parameters(&self) -> Value {
        serde_json::to_value(&self.request.inputs).unwrap_or_default()
    }

    fn stages(&self) -> &'static [(&'static str, u32)] {
        &[
            ("terrain.slope", 2),
            ("water.flood", 6),
            ("climate.sunlight", 22),
            ("plants.fitness", 12),
            ("plants.competition", 14),
            ("plants.left", 3),
            ("plants.absent", 2),
            ("animals.regions", 4),
            ("animals.competition", 6),
            ("animals.rooms", 4),
            ("animals.travel", 10),
            ("trails.bundle", 6),
            ("plants.edit", 2),
            ("planning.herds", 4),
            ("planning.tracks", 4),
        ]
    }

    fn run(self: Box<Self>, context: &mut JobContext<'_>) -> Result<(), Failure> {
        let request = self.request;
        report::sources(context, &request)?;
        // 1. Terrain and water.
        let land = Chain::land(context, &request)?;
        maps(context, &request).land(&land.terrain, &land.water)?;
        // 2. Climate and soil.
        let climate = Chain::climate(context, &request, &land)?;
        maps(context, &request).climate(&climate.resources)?;
        // 3. Plants compete.
        let plants = Chain::plants(context, &request, &climate)?;
        // 4. Where each animal can go.
        let country = Chain::regions(context, &request, (&land, &plants))?;
        // 5. and 6. The Resource Access Graph; herbivores, then carnivores compete on it.
        let roads = Roads::new(&request, &land, &country);
        let wildlife = Chain::animals(context, &request, (&land, &plants, &roads))?;
        maps(context, &request).animals(&request, (&plants, &country), &wildlife)?;
        life::graph(context, &request, &wildlife.population.rag)?;
        // 7. The trails they wear, and the plants that are left beside them.
        let trails = Chain::trails(context, &request, &roads, &wildlife)?;
        maps(context, &request).trails(&land.terrain, &trails)?;
        life::trail_lines(context, &request, &trails)?;
        let left = Chain::beside_trails(context, &request, (&climate, plants), &trails)?;
        maps(context, &request).plants(&request, &left.flora)?;
        // 8. What each herd does all day.
        let days = Chain::plannings(context, &request, (&land, &roads), (&wildlife, &trails))?;
        life::herds(context, &request, &days.plannings.herds)?;
        life::plannings(context, &request, &wildlife, &days)?;
        // 9. What the experts look at.
        maps(context, &request).biomes(&request, &left.flora)?;
        report::biomes(context, &request, &left.flora)?;
        report::summary(context, &request, &left, (&country, &wildlife, &days))
    }
}

fn maps<'a, 'b>(context: &'a mut JobContext<'b>, request: &Request) -> Maps<'a, 'b> {
    Maps { context, georeference: request.georeference.clone() }
}
