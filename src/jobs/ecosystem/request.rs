//! From the inputs on the wire to a request that cannot be wrong: every fault is found here,
//! before anything is queued.

use biotope_api::ecosystem::ClimateInput;
use biotope_api::ecosystem::CompetitionInput;
use biotope_api::ecosystem::EcosystemInputs;
use biotope_api::ecosystem::NeedName;
use biotope_api::ecosystem::PassagesInput;
use biotope_api::ecosystem::PlaceInput;
use biotope_api::ecosystem::PlanningChange;
use biotope_api::ecosystem::PlanningEdit;
use biotope_api::ecosystem::ScalesPreset;
use biotope_api::ecosystem::WaypointInput;
use biotope_api::error::ErrorCode;
use biotope_api::reference::Reference;
use biotope_api::warning::Warning;

use crate::codec::map::Georeference;
use crate::compute::ecosystem::climate::Climate;
use crate::compute::ecosystem::climate::MonthClimate;
use crate::compute::ecosystem::fitness::Needs;
use crate::compute::ecosystem::planning::Edit;
use crate::compute::ecosystem::rag::WayPoint;
use crate::compute::ecosystem::regions::Passages;
use crate::compute::ecosystem::regions::Place;
use crate::compute::ecosystem::resources::GivenMaps;
use crate::compute::ecosystem::resources::MONTHS;
use crate::compute::ecosystem::resources::MonthlyMap;
use crate::compute::ecosystem::scales::Scales;
use crate::compute::geometry::Bounds;
use crate::compute::geometry::Point;
use crate::compute::raster::Grid;
use crate::compute::raster::Raster;
use crate::jobs::Digest;
use crate::jobs::Hasher;
use crate::jobs::Invalid;
use crate::jobs::Sources;
use crate::jobs::ecosystem::species;
use crate::jobs::ecosystem::species::Animals;
use crate::jobs::ecosystem::species::Plants;
use crate::jobs::rasters;
use crate::jobs::rasters::Meaning;

/// A request whose every value is usable.
pub struct Request {
    /// As it came, with defaults filled in.
    pub inputs: EcosystemInputs,
    /// Heights, metres; NaN where there is no data. Origin at (0, 0).
    pub height: Raster<f32>,
    /// Where the terrain lies.
    pub georeference: Georeference,
    /// The climate, with the latitude of the terrain.
    pub climate: Climate,
    /// Conversions to the scales.
    pub scales: Scales,
    /// Needs of plants that count.
    pub needs: Needs,
    /// The plants.
    pub plants: Plants,
    /// The animals.
    pub animals: Animals,
    /// Resource maps given instead of computed.
    pub given: GivenMaps,
    /// Depth of the water, given.
    pub water_depth: Option<Raster<f32>>,
    /// Where no plant may grow, 0..=1.
    pub exclusion: Option<Raster<f32>>,
    /// Painted cover, by plant.
    pub painted: Vec<(usize, Raster<f32>)>,
    /// Places that fords and way-points open, in the terrain's frame.
    pub passages: Passages,
    /// The way-points, which draw animals.
    pub way_points: Vec<WayPoint>,
    /// The biomes.
    pub biomes: Biomes,
    /// Edits of plannings: the herd and its edit.
    pub edits: Vec<(usize, Edit)>,
    /// Digests of what stands behind the references, for the stages.
    pub digests: Digests,
    /// What readers should know of the inputs.
    pub warnings: Vec<Warning>,
}

/// Digests of the bytes behind the references of a request.
pub struct Digests {
    /// Of the terrain.
    pub terrain: Digest,
    /// Of the water map.
    pub water: Digest,
    /// Of the other given maps.
    pub maps: Digest,
    /// Of the painted covers and the exclusion.
    pub painted: Digest,
}

impl Request {
    /// Parses the inputs and reads what they refer to.
    pub fn parse(inputs: EcosystemInputs, sources: &dyn Sources) -> Result<Self, Invalid> {
        let mut faults = Invalid::default();
        // 1. Species, which need no file.
        let plants = faults.keep(species::plants(&inputs.plants));
        let animals = plants.as_ref().and_then(|plants| faults.keep(species::animals(&inputs.animals, plants)));
        let biomes = plants.as_ref().and_then(|plants| faults.keep(biomes(&inputs, plants)));
        // 2. The terrain, on which everything else lies.
        let land = faults.keep(rasters::terrain(&inputs.terrain, sources));
        let climate = faults.keep(climate(&inputs.climate));
        // 3. What must fit the terrain.
        let Some(land) = land else { return Err(faults) };
        let latitude_deg = inputs.terrain.latitude_deg.or(land.latitude_deg);
        if latitude_deg.is_none() {
            let expected = "a latitude, as the terrain's file does not say where on Earth it lies";
            faults.push("/terrain/latitude_deg", ErrorCode::Missing, expected, "nothing");
        }
        let mut maps = Maps::new(land.height.grid, sources);
        let (water_depth, water) =
            maps.read(|m| m.one("/maps/water_depth_m", (inputs.maps.water_depth_m.as_ref(), Meaning::Depth)));
        let (given, given_digest) = maps.read(|m| m.given(&inputs));
        let (covers, painted) = maps
            .read(|m| (m.painted(&inputs), m.one("/maps/exclusion", (inputs.maps.exclusion.as_ref(), Meaning::Share))));
        faults.extend(maps.faults);
        let passages = faults.keep(passages(&inputs.passages, &land.height.grid));
        let way_points = animals.as_ref().zip(passages.as_ref()).and_then(|(animals, passages)| {
            faults.keep(way_points(&inputs.passages.waypoints, &passages.waypoints, animals))
        });
        let edits = faults.keep(edits(&inputs.planning.edits)).unwrap_or_default();
        // 4. All there, or all faults.
        let fitting = passages.zip(way_points);
        match (plants, animals, biomes, climate, latitude_deg, fitting, faults.errors.is_empty()) {
            (
                Some(plants),
                Some(animals),
                Some(biomes),
                Some(mut climate),
                Some(latitude_deg),
                Some((passages, way_points)),
                true,
            ) => {
                climate.latitude_deg = latitude_deg;
                Ok(Self {
                    scales: scales(&inputs.competition),
                    needs: needs(&inputs.competition),
                    height: land.height,
                    georeference: land.georeference,
                    climate,
                    plants,
                    animals,
                    given,
                    water_depth,
                    exclusion: covers.1,
                    painted: covers.0,
                    passages,
                    way_points,
                    edits,
                    biomes,
                    digests: Digests { terrain: land.digest, water, maps: given_digest, painted },
                    warnings: land.warnings,
                    inputs,
                })
            }
            _ => Err(faults),
        }
    }

    /// Where the cells lie.
    pub fn grid(&self) -> Grid {
        self.height.grid
    }

    /// What a way-point is called.
    pub fn way_point_name(&self, number: usize) -> String {
        let given = self.inputs.passages.waypoints.get(number).and_then(|input| input.name.clone());
        given.unwrap_or_else(|| format!("way-point {number}"))
    }

    /// Most memory the solve holds at one time, bytes: about 200 a cell for the maps of land,
    /// climate and animals, and five for each plant.
    pub fn memory_bytes(&self) -> u64 {
        let cells = self.grid().len() as u64;
        (64 << 20) + cells * (200 + 5 * self.plants.species.len() as u64)
    }
}

fn climate(input: &ClimateInput) -> Result<Climate, Invalid> {
    let months: Vec<MonthClimate> = input
        .months
        .iter()
        .map(|m| MonthClimate {
            temperature_mean_c: m.temperature_mean_c,
            temperature_half_range_c: m.temperature_half_range_c,
            precipitation_mm: m.precipitation_mm,
            sunshine_fraction: m.sunshine_fraction,
        })
        .collect();
    let found = months.len();
    let months: [MonthClimate; MONTHS] = months
        .try_into()
        .map_err(|_| Invalid::new("/climate/months", ErrorCode::WrongCount, "twelve months", found))?;
    Ok(Climate {
        months,
        reference_height_m: input.reference_height_m,
        lapse_c_per_m: input.lapse_c_per_100m / 100.0,
        latitude_deg: 0.0,
    })
}

fn scales(input: &CompetitionInput) -> Scales {
    match input.scales {
        ScalesPreset::Authors => Scales::authors(),
        ScalesPreset::Julve => Scales::julve(),
    }
}

fn needs(input: &CompetitionInput) -> Needs {
    let counts = |need| !input.ignore.contains(&need);
    Needs {
        illumination: counts(NeedName::Illumination),
        temperature: counts(NeedName::Temperature),
        moisture: counts(NeedName::Moisture),
        texture: counts(NeedName::Soil),
        soil: counts(NeedName::Soil),
    }
}

/// Biomes by name, and which each plant belongs to.
#[derive(Debug, Clone, PartialEq)]
pub struct Biomes {
    /// Their names, in order.
    pub names: Vec<String>,
    /// The biome of each plant; the number of names for none.
    pub of: Vec<usize>,
}

/// The biomes of the request, or those that the plants name.
fn biomes(inputs: &EcosystemInputs, plants: &Plants) -> Result<Biomes, Invalid> {
    if inputs.biomes.is_empty() {
        let mut names: Vec<String> = plants.biomes.iter().filter(|name| !name.is_empty()).cloned().collect();
        names.sort();
        names.dedup();
        let place = |biome: &String| names.iter().position(|name| name == biome).unwrap_or(names.len());
        return Ok(Biomes { of: plants.biomes.iter().map(place).collect(), names });
    }
    let names: Vec<String> = inputs.biomes.keys().cloned().collect();
    let (mut of, mut faults) = (vec![names.len(); plants.species.len()], Invalid::default());
    for (biome, (name, members)) in inputs.biomes.iter().enumerate() {
        for (k, member) in members.iter().enumerate() {
            let pointer = format!("/biomes/{}/{k}", name.replace('~', "~0").replace('/', "~1"));
            match plants.species.iter().position(|s| s.name == *member) {
                Some(i) if of[i] == names.len() => of[i] = biome,
                Some(_) => faults.push(pointer, ErrorCode::DuplicateSpecies, "a plant in one biome only", member),
                None => faults.push(pointer, ErrorCode::UnknownSpecies, "a plant of the request", member),
            }
        }
    }
    faults.into_result().map(|()| Biomes { names, of })
}

fn passages(input: &PassagesInput, grid: &Grid) -> Result<Passages, Invalid> {
    let mut faults = Invalid::default();
    let mut places = |pointer: &str, inputs: Vec<PlaceInput>| {
        let place = |(i, p): (usize, &PlaceInput)| faults.keep(place(&format!("{pointer}/{i}"), p, grid));
        inputs.iter().enumerate().filter_map(place).collect()
    };
    let around = |p: &WaypointInput| PlaceInput { x: p.x, y: p.y, radius_m: p.radius_m };
    let passages = Passages {
        fords: places("/passages/fords", input.fords.clone()),
        waypoints: places("/passages/waypoints", input.waypoints.iter().map(around).collect()),
    };
    faults.into_result().map(|()| passages)
}

/// Way-points that draw animals, at most: each is a search for every region that it lies in.
const MOST_WAY_POINTS: usize = 100;

/// The way-points of the inputs at `places`, one for each.
fn way_points(inputs: &[WaypointInput], places: &[Place], animals: &Animals) -> Result<Vec<WayPoint>, Invalid> {
    let mut faults = Invalid::default();
    let drawing = inputs.iter().filter(|p| p.share > 0.0).count();
    if drawing > MOST_WAY_POINTS {
        let expected = format!("at most {MOST_WAY_POINTS} way-points with a share above 0");
        faults.push("/passages/waypoints", ErrorCode::WrongCount, expected, drawing);
    }
    let mut way_points = Vec::with_capacity(inputs.len());
    for (i, (input, place)) in inputs.iter().zip(places).enumerate() {
        let mut species = Vec::with_capacity(input.species.len());
        for (k, name) in input.species.iter().enumerate() {
            match animals.species.iter().position(|animal| animal.name.eq_ignore_ascii_case(name)) {
                Some(s) => species.push(s),
                None => {
                    let pointer = format!("/passages/waypoints/{i}/species/{k}");
                    faults.push(pointer, ErrorCode::UnknownSpecies, "an animal of the request", name);
                }
            }
        }
        species.sort_unstable();
        species.dedup();
        way_points.push(WayPoint { place: *place, share: input.share, species });
    }
    faults.into_result().map(|()| way_points)
}

fn place(pointer: &str, input: &PlaceInput, grid: &Grid) -> Result<Place, Invalid> {
    let bounds = grid.bounds();
    let centre = Point::new(input.x, input.y);
    let radius_m = input.radius_m.unwrap_or(1.5 * grid.cell_m);
    if !bounds.contains(centre) {
        let Bounds { min, max } = bounds;
        let expected = format!("a place on the terrain: x {} to {}, y {} to {}", min.x, max.x, min.y, max.y);
        return Err(Invalid::new(pointer, ErrorCode::OutOfRange, expected, format!("({}, {})", input.x, input.y)));
    }
    if radius_m <= 0.0 {
        return Err(Invalid::new(format!("{pointer}/radius_m"), ErrorCode::OutOfRange, "a radius above 0", radius_m));
    }
    Ok(Place { centre, radius_m })
}

fn edits(inputs: &[PlanningEdit]) -> Result<Vec<(usize, Edit)>, Invalid> {
    const STAY_S: f64 = 3600.0;
    let mut faults = Invalid::default();
    let mut edits = Vec::new();
    for (i, input) in inputs.iter().enumerate() {
        let order = input.order as usize;
        let mut missing = |field: &str| {
            faults.push(
                format!("/planning/edits/{i}/{field}"),
                ErrorCode::Missing,
                "a value, for this change",
                "nothing",
            );
        };
        let edit = match (input.change, input.node, input.arrive_s, input.leave_s) {
            (PlanningChange::Drop, ..) => Edit::Drop { order },
            (PlanningChange::Add, Some(node), ..) => {
                Edit::Add { order, node: node as usize, stay_s: input.stay_s.unwrap_or(STAY_S) }
            }
            (PlanningChange::Add, None, ..) => {
                missing("node");
                continue;
            }
            (PlanningChange::Pin, _, Some(arrive_s), Some(leave_s)) => {
                if arrive_s >= leave_s {
                    let pointer = format!("/planning/edits/{i}/leave_s");
                    faults.push(pointer, ErrorCode::Inconsistent, format!("a time after {arrive_s}"), leave_s);
                }
                Edit::Pin { order, arrive_s, leave_s }
            }
            (PlanningChange::Pin, _, arrive_s, _) => {
                missing(if arrive_s.is_none() { "arrive_s" } else { "leave_s" });
                continue;
            }
        };
        edits.push((input.herd as usize, edit));
    }
    faults.into_result().map(|()| edits)
}

/// Temperatures of Earth's air, with room to spare; those in kelvin lie outside.
const CELSIUS: Meaning = Meaning::Quantity(-100.0, 100.0);

/// Moisture and texture: scale 1 to 9, with the moisture of open water (12) and of nothing (0).
const SCALE: Meaning = Meaning::Quantity(0.0, 12.0);

/// Reads maps that must fit the terrain, collecting faults and digests.
struct Maps<'a> {
    grid: Grid,
    sources: &'a dyn Sources,
    hasher: Hasher,
    faults: Invalid,
}

impl<'a> Maps<'a> {
    fn new(grid: Grid, sources: &'a dyn Sources) -> Self {
        Self { grid, sources, hasher: Hasher::new(), faults: Invalid::default() }
    }

    /// What `read` gives, and the digest of all that it read.
    fn read<T>(&mut self, read: impl FnOnce(&mut Self) -> T) -> (T, Digest) {
        let value = read(self);
        (value, std::mem::replace(&mut self.hasher, Hasher::new()).finish())
    }

    fn one(&mut self, pointer: &str, what: (Option<&Reference>, Meaning)) -> Option<Raster<f32>> {
        let map = self.faults.keep(rasters::map(pointer, (what.0?, what.1), &self.grid, self.sources))?;
        let hasher = std::mem::replace(&mut self.hasher, Hasher::new());
        self.hasher = hasher.part(pointer, map.digest.to_string().as_bytes());
        Some(map.raster)
    }

    /// One map for the whole year, or twelve.
    fn monthly(&mut self, pointer: &str, (references, meaning): (&[Reference], Meaning)) -> Option<MonthlyMap> {
        match references {
            [] => None,
            [year] => {
                let base = self.one(&format!("{pointer}/0"), (Some(year), meaning))?;
                Some(MonthlyMap::Shifted { base, offset: [0.0; MONTHS] })
            }
            months if months.len() == MONTHS => {
                let maps: Vec<Raster<f32>> =
                    (0..MONTHS).filter_map(|m| self.one(&format!("{pointer}/{m}"), (months.get(m), meaning))).collect();
                (maps.len() == MONTHS).then_some(MonthlyMap::Maps(maps))
            }
            other => {
                self.faults.push(pointer, ErrorCode::WrongCount, "one map, or twelve", other.len());
                None
            }
        }
    }

    fn given(&mut self, inputs: &EcosystemInputs) -> GivenMaps {
        let maps = &inputs.maps;
        let temperature_min_c = self.monthly("/maps/temperature_min_c", (&maps.temperature_min_c, CELSIUS));
        let temperature_max_c = self.monthly("/maps/temperature_max_c", (&maps.temperature_max_c, CELSIUS));
        self.in_order(temperature_min_c.as_ref(), temperature_max_c.as_ref());
        GivenMaps {
            temperature_min_c,
            temperature_max_c,
            sunlight: self.monthly("/maps/sunlight", (&maps.sunlight, Meaning::Share)),
            moisture: self.monthly("/maps/moisture", (&maps.moisture, SCALE)),
            texture: self.one("/maps/texture", (maps.texture.as_ref(), SCALE)),
            soil: self.soil(maps.soil.as_ref()),
        }
    }

    /// No minimum may lie above the maximum of its month.
    fn in_order(&mut self, min: Option<&MonthlyMap>, max: Option<&MonthlyMap>) {
        let (Some(min), Some(max)) = (min, max) else { return };
        let places = (0..MONTHS).flat_map(|month| (0..self.grid.len()).map(move |cell| (month, cell)));
        let found = places.map(|(m, c)| (m, min.value(m, c), max.value(m, c))).find(|(_, low, high)| low > high);
        if let Some((month, low, high)) = found {
            let expected = format!("at most the month's maximum, {high} °C in month {}", month + 1);
            self.faults.push("/maps/temperature_min_c", ErrorCode::Inconsistent, expected, low);
        }
    }

    fn soil(&mut self, reference: Option<&Reference>) -> Option<Raster<u8>> {
        let map = self.one("/maps/soil", (reference, Meaning::Code))?;
        match map.data.iter().find(|v| !(v.is_nan() || [0.0, 1.0, 2.0, 3.0, 4.0].contains(*v))) {
            None => Some(map.map(|v| if v.is_nan() { u8::MAX } else { v as u8 })),
            Some(odd) => {
                self.faults.push("/maps/soil", ErrorCode::OutOfRange, "soil types 0 to 4 in every cell", odd);
                None
            }
        }
    }

    fn painted(&mut self, inputs: &EcosystemInputs) -> Vec<(usize, Raster<f32>)> {
        let cover = |(i, plant): (usize, &biotope_api::ecosystem::PlantInput)| {
            let map = (plant.painted_cover.as_ref(), Meaning::Share);
            self.one(&format!("/plants/{i}/painted_cover"), map).map(|map| (i, map))
        };
        inputs.plants.iter().enumerate().filter_map(cover).collect()
    }
}
