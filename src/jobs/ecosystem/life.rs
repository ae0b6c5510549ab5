//! The maps and tables of animals: regions, densities, surplus, the graph, herds.

use serde_json::Value;
use serde_json::json;

use crate::codec::colours::ColourMap;
use crate::codec::map::Legend;
use crate::codec::map::MapData;
use crate::codec::map::Spread;
use crate::compute::ecosystem::fauna;
use crate::compute::ecosystem::planning::Activity;
use crate::compute::ecosystem::planning::Herd;
use crate::compute::ecosystem::planning::Plannings;
use crate::compute::ecosystem::planning::Visit;
use crate::compute::ecosystem::rag::Node;
use crate::compute::ecosystem::rag::Rag;
use crate::compute::ecosystem::rag::Resource;
use crate::compute::ecosystem::rag::Territory;
use crate::compute::ecosystem::regions::Regions;
use crate::compute::ecosystem::species::Food;
use crate::compute::ecosystem::terrain::Terrain;
use crate::compute::ecosystem::trails;
use crate::compute::ecosystem::trails::Stretch;
use crate::compute::ecosystem::trails::Trail;
use crate::compute::ecosystem::trails::Trails;
use crate::compute::geometry::Point;
use crate::compute::raster::Raster;
use crate::jobs::Artefact;
use crate::jobs::Failure;
use crate::jobs::JobContext;
use crate::jobs::Table;
use crate::jobs::ecosystem::chain::Country;
use crate::jobs::ecosystem::chain::Days;
use crate::jobs::ecosystem::chain::Growth;
use crate::jobs::ecosystem::chain::Vegetation;
use crate::jobs::ecosystem::chain::Wildlife;
use crate::jobs::ecosystem::outputs::Maps;
use crate::jobs::ecosystem::report;
use crate::jobs::ecosystem::request::Request;
use crate::jobs::ecosystem::species::slug;

const M2_PER_KM2: f32 = 1e6;

impl Maps<'_, '_> {
    /// Confinement regions, densities and surplus of every animal; surplus of every plant.
    pub fn animals(
        &mut self,
        request: &Request,
        (plants, country): (&Vegetation, &Country),
        wildlife: &Wildlife,
    ) -> Result<(), Failure> {
        let (regions, population) = (&country.regions, &wildlife.population);
        let per_cell = 1.0 / request.grid().cell_area_m2() as f32;
        for (s, animal) in request.animals.species.iter().enumerate() {
            let slug = slug(&animal.name);
            let legend = Legend::labels(format!("Confinement regions of {}", animal.name));
            self.put(&format!("animals.regions.{slug}"), legend, || MapData::U16(labels(regions, s)))?;
            let legend = Legend::continuous(format!("Density of {}", animal.name), "individuals/km²", ColourMap::Brown);
            self.quantities(&format!("animals.density.{slug}"), legend, || {
                fauna::density_per_m2(population, regions, s).map(|d| d * M2_PER_KM2)
            })?;
            let legend = Legend::continuous(format!("Surplus of {}", animal.name), "kg/km² a year", ColourMap::Brown);
            self.quantities(&format!("animals.surplus.{slug}"), legend, || {
                fauna::surplus_of_animal(population, regions, s).map(|kg| kg * per_cell * M2_PER_KM2)
            })?;
        }
        let growth = Growth { request, plants };
        for (s, plant) in request.plants.species.iter().enumerate() {
            let legend = Legend::continuous(format!("Surplus of {}", plant.name), "kg/m² a year", ColourMap::Green);
            self.quantities(&format!("plants.surplus.{}", slug(&plant.name)), legend, || {
                fauna::surplus_of_plant(population, regions, &growth, s).map(|kg| kg * per_cell)
            })?;
        }
        Ok(())
    }
}

/// Region numbers from 1; 0 where the species cannot go. Past the last number of 16 bits they
/// begin again at 1.
fn labels(regions: &Regions, species: usize) -> Raster<u16> {
    let number = |region: usize| (region % usize::from(u16::MAX - 1)) as u16 + 1;
    let of_part: Vec<u16> =
        (0..regions.parts()).map(|part| regions.region_of_part(species, part).map_or(0, number)).collect();
    regions.part.map(|part| of_part.get(part as usize).copied().unwrap_or(0))
}

/// The Resource Access Graph: nodes, spatial edges, hierarchical edges.
pub fn graph(context: &mut JobContext<'_>, request: &Request, rag: &Rag) -> Result<(), Failure> {
    let nodes = &rag.nodes;
    let table = Table::new()
        .integers("id", "", (0..nodes.len()).map(|i| i as i64))
        .integers("level", "", nodes.iter().map(|n| n.level as i64))
        .texts("kind", nodes.iter().map(kind))
        .texts("resource", nodes.iter().map(|n| resource(request, n)))
        .numbers("x", "m", nodes.iter().map(|n| n.place.x))
        .numbers("y", "m", nodes.iter().map(|n| n.place.y))
        .numbers("area_m2", "m²", nodes.iter().map(|n| n.area_m2))
        .numbers("quantity", "kg a year", nodes.iter().map(|n| n.quantity_kg))
        .numbers("draws", "share of moves", nodes.iter().map(|n| n.draws));
    let edges: Vec<(usize, usize, usize, f64)> = rag.territories.iter().flat_map(spatial_edges).collect();
    let spatial = Table::new()
        .texts("species", edges.iter().map(|e| request.animals.species[e.0].name.as_str()))
        .integers("from", "", edges.iter().map(|e| e.1 as i64))
        .integers("to", "", edges.iter().map(|e| e.2 as i64))
        .numbers("seconds", "s", edges.iter().map(|e| e.3));
    let links: Vec<(usize, usize)> =
        nodes.iter().enumerate().flat_map(|(i, n)| n.below.iter().map(move |b| (i, *b))).collect();
    let hierarchical = Table::new().integers("from", "", links.iter().map(|l| l.0 as i64)).integers(
        "below",
        "",
        links.iter().map(|l| l.1 as i64),
    );
    let tables = [("nodes", table), ("edges", spatial), ("hierarchy", hierarchical)];
    context.put("rag", Artefact::Tables(tables.map(|(name, table)| (name.to_owned(), table)).into()))
}

fn kind(node: &Node) -> &'static str {
    match node.resource {
        Resource::Water => "water",
        Resource::Food(Food::Plant(_)) => "plant",
        Resource::Food(Food::Animal(_)) => "animal",
        Resource::WayPoint(_) => "waypoint",
    }
}

fn resource(request: &Request, node: &Node) -> String {
    match node.resource {
        Resource::Water => "water".to_owned(),
        Resource::Food(Food::Plant(i)) => request.plants.species[i].name.clone(),
        Resource::Food(Food::Animal(i)) => request.animals.species[i].name.clone(),
        Resource::WayPoint(i) => request.way_point_name(i),
    }
}

/// (species, from, to, seconds) of every way there is, without the nodes' ways to themselves.
fn spatial_edges(territory: &Territory) -> impl Iterator<Item = (usize, usize, usize, f64)> + '_ {
    let n = territory.nodes.len();
    let edge = move |(i, j): (usize, usize)| {
        let seconds = territory.time_s(i, j);
        (i != j && seconds.is_finite()).then(|| (territory.species, territory.nodes[i], territory.nodes[j], seconds))
    };
    (0..n).flat_map(move |i| (0..n).map(move |j| (i, j))).filter_map(edge)
}

/// Every herd with its region and size.
pub fn herds(context: &mut JobContext<'_>, request: &Request, herds: &[Herd]) -> Result<(), Failure> {
    let table = Table::new()
        .integers("herd", "", (0..herds.len()).map(|i| i as i64))
        .texts("species", herds.iter().map(|h| name(request, h)))
        .integers("region", "", herds.iter().map(|h| h.region as i64 + 1))
        .integers("size", "individuals", herds.iter().map(|h| i64::from(h.size)));
    context.put("herds", Artefact::Table(table))
}

fn name<'r>(request: &'r Request, herd: &Herd) -> &'r str {
    &request.animals.species[herd.species].name
}

/// The trails as maps and as lines.
impl Maps<'_, '_> {
    /// Usage and carved terrain.
    pub fn trails(&mut self, terrain: &Terrain, trails: &Trails) -> Result<(), Failure> {
        let usage = Legend::continuous("Use of trails", "kg m a year per m²", ColourMap::Brown);
        self.quantities("trails.usage", usage.with_spread(Spread::Logarithmic), || trails.usage.clone())?;
        let carved = Legend::continuous("Height with trails", "m", ColourMap::Terrain);
        self.quantities("terrain.carved", carved, || trails::carved(&terrain.height, trails))
    }
}

/// The trails as lines: a list of trails, each with its stretches.
pub fn trail_lines(context: &mut JobContext<'_>, request: &Request, trails: &Trails) -> Result<(), Failure> {
    let stretch = |trail: &Trail, s: &Stretch| {
        let points: Vec<[f64; 2]> = trail.points[s.points.clone()].iter().map(|p| [p.x, p.y]).collect();
        let species: Vec<Value> = s
            .species
            .iter()
            .map(|(i, share)| json!({"species": request.animals.species[*i].name, "share": share}))
            .collect();
        json!({
            "points": points,
            "weight_kg_per_year": s.kg_per_year,
            "width_m": s.width_m,
            "depth_m": s.depth_m,
            "species": species,
        })
    };
    let lines: Vec<Value> = trails
        .lines
        .iter()
        .map(|trail| {
            let stretches: Vec<Value> = trail.stretches.iter().map(|s| stretch(trail, s)).collect();
            json!({"length_m": trail.length_m(), "weight_kg_per_year": trail.kg_per_year(), "stretches": stretches})
        })
        .collect();
    context.put("trails.lines", Artefact::Json(json!({"kept_share": trails.kept_share, "trails": lines})))
}

/// What every herd does all day, and where it is. What a herd needs every day and misses stands,
/// with the cause, in the row of its last visit.
pub fn plannings(
    context: &mut JobContext<'_>,
    request: &Request,
    wildlife: &Wildlife,
    days: &Days,
) -> Result<(), Failure> {
    let Plannings { herds, days: plans, .. } = &days.plannings;
    let rows: Vec<(usize, usize, &Visit)> = plans
        .iter()
        .enumerate()
        .flat_map(|(h, day)| day.visits.iter().enumerate().map(move |(order, visit)| (h, order, visit)))
        .collect();
    let missed: Vec<String> = (0..herds.len()).map(|herd| report::missed(&days.plannings, herd)).collect();
    let places: Vec<Point> = rows.iter().map(|(_, _, v)| request.grid().centre(v.cell)).collect();
    let table = Table::new()
        .integers("herd", "", rows.iter().map(|r| r.0 as i64))
        .texts("species", rows.iter().map(|r| name(request, &herds[r.0])))
        .integers("order", "", rows.iter().map(|r| r.1 as i64))
        .integers("node", "", rows.iter().map(|r| r.2.node as i64))
        .numbers("arrive_s", "s", rows.iter().map(|r| r.2.arrive_s))
        .numbers("leave_s", "s", rows.iter().map(|r| r.2.leave_s))
        .numbers("x", "m", places.iter().map(|p| p.x))
        .numbers("y", "m", places.iter().map(|p| p.y))
        .texts("activity", rows.iter().map(|r| activity(r.2.activity)))
        .texts("resource", rows.iter().map(|r| resource(request, &wildlife.population.rag.nodes[r.2.node])))
        .integers("prey", "", rows.iter().map(|r| r.2.prey.map_or(-1, |p| p as i64)))
        .texts(
            "missed",
            rows.iter().map(|r| if r.1 + 1 == plans[r.0].visits.len() { missed[r.0].as_str() } else { "" }),
        );
    context.put("plannings", Artefact::Table(table))?;
    paths(context, request, days)
}

/// What is done, in a word.
pub const fn activity(activity: Activity) -> &'static str {
    match activity {
        Activity::Drink => "drink",
        Activity::Feed => "feed",
        Activity::Hunt => "hunt",
        Activity::Rest => "rest",
        Activity::Wait => "wait",
        Activity::Pass => "pass",
    }
}

fn paths(context: &mut JobContext<'_>, request: &Request, days: &Days) -> Result<(), Failure> {
    let rows = || days.tracks.iter().flat_map(|track| (0..track.places.len()).map(move |i| (track, i)));
    let herds = &days.plannings.herds;
    let table = Table::new()
        .integers("herd", "", rows().map(|(t, _)| t.herd as i64))
        .texts("species", rows().map(|(t, _)| name(request, &herds[t.herd])))
        .numbers("t", "s", rows().map(|(t, i)| t.from_s + t.step_s * i as f64))
        .numbers("x", "m", rows().map(|(t, i)| t.places[i].x))
        .numbers("y", "m", rows().map(|(t, i)| t.places[i].y))
        .numbers("z", "m", rows().map(|(t, i)| t.heights_m.get(i).map_or(f64::NAN, |z| f64::from(*z))));
    context.put("paths", Artefact::Table(table))
}
