//! The way each journey takes over the terrain.

use super::journeys::Journey;
use crate::compute::ecosystem::curve::Ground;
use crate::compute::ecosystem::paths::Path;
use crate::compute::ecosystem::paths::Paths;
use crate::compute::ecosystem::rag::Rag;
use crate::compute::ecosystem::ways::Way;
use crate::compute::geometry::Point;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// A way serves both directions when going back on it takes at most this much longer than the
/// quickest way back (ours); else the animals wear two.
const SAME_WAY: f64 = 1.1;

/// The cells animals of one species walk along.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Route {
    pub(crate) species: usize,
    pub(crate) cells: Vec<u32>,
    /// Mass that walks here, kg a year.
    pub(crate) kg: f64,
    /// Whether it is walked in both directions.
    pub(crate) both_ways: bool,
}

/// One direction of a journey.
#[derive(Clone, Copy)]
struct Leg {
    journey: usize,
    species: usize,
    from: usize,
    to: usize,
    kg: f64,
    /// Quickest time in the other direction, and what walks there.
    back: (f64, f64),
}

/// The routes of all journeys, heaviest first, and how many legs found no way.
pub(crate) fn routes(
    journeys: &[Journey],
    rag: &Rag,
    ground: &Ground,
    run: &Run,
) -> Result<(Vec<Route>, usize), Stopped> {
    let legs = journeys.iter().enumerate().map(|(i, journey)| leg(rag, i, journey));
    let there: Vec<Leg> = legs.filter(|leg| leg.from != leg.to).collect();
    let mut found = walk(&there, ground, run)?;
    let settled: BTreeSet<usize> = found.iter().filter(|(_, route)| route.both_ways).map(|(i, _)| *i).collect();
    let single: Vec<Leg> = there
        .iter()
        .filter(|leg| leg.back.1 > 0.0 && !settled.contains(&leg.journey))
        .map(|leg| Leg { from: leg.to, to: leg.from, kg: leg.back.1, back: (0.0, 0.0), ..*leg })
        .collect();
    found.extend(walk(&single, ground, run)?);
    let lost = there.len() + single.len() - found.len();
    found.sort_by(|a, b| b.1.kg.total_cmp(&a.1.kg).then(a.0.cmp(&b.0)).then_with(|| a.1.cells.cmp(&b.1.cells)));
    Ok((found.into_iter().map(|(_, route)| route).collect(), lost))
}

fn leg(rag: &Rag, journey: usize, j: &Journey) -> Leg {
    let territory = &rag.territories[j.territory];
    let cell = |position: usize| rag.nodes[territory.nodes[position]].cell;
    let back = (territory.time_s(j.to, j.from), j.back);
    Leg { journey, species: territory.species, from: cell(j.from), to: cell(j.to), kg: j.there, back }
}

/// The routes of the legs that have one, with their journeys; one search per species and source.
fn walk(legs: &[Leg], ground: &Ground, run: &Run) -> Result<Vec<(usize, Route)>, Stopped> {
    let mut order: Vec<Leg> = legs.to_vec();
    order.sort_by_key(|leg| (leg.species, leg.from, leg.journey));
    let sources: Vec<&[Leg]> = order.chunk_by(|a, b| (a.species, a.from) == (b.species, b.from)).collect();
    let search = |legs: &&[Leg]| {
        let targets: Vec<usize> = legs.iter().map(|leg| leg.to).collect();
        let ways = ground.ways.ways(legs[0].species, legs[0].from, &targets, run)?;
        let routes = legs.iter().zip(ways).filter_map(|(leg, way)| Some((leg.journey, route(leg, &way?, ground))));
        Ok(routes.collect())
    };
    let found: Vec<Vec<(usize, Route)>> = sources.par_iter().map(search).collect::<Result<_, Stopped>>()?;
    Ok(found.into_iter().flatten().collect())
}

fn route(leg: &Leg, way: &Way, ground: &Ground) -> Route {
    let cells = ground.straightened(leg.species, way);
    let reversed: Vec<u32> = cells.iter().rev().copied().collect();
    let both_ways = leg.back.1 > 0.0 && ground.seconds(leg.species, &reversed) <= SAME_WAY * leg.back.0;
    let kg = if both_ways { leg.kg + leg.back.1 } else { leg.kg };
    Route { species: leg.species, cells, kg, both_ways }
}

/// The routes as they are walked, in each of their directions.
pub(crate) fn paths(routes: &[Route], ground: &Ground, run: &Run) -> Result<Paths, Stopped> {
    let of_route = |route: &Route| {
        run.check()?;
        let species = route.species;
        let path = |cells: Vec<u32>, points: Vec<Point>| {
            let open = ground.seconds(species, &cells).is_finite();
            let seconds = ground.timed(species, &cells, points).seconds();
            open.then_some(Path { species, cells, seconds })
        };
        let points = ground.smoothed(species, &route.cells);
        let turned = || (route.cells.iter().rev().copied().collect(), points.iter().rev().copied().collect());
        let back = route.both_ways.then(turned).and_then(|(cells, points)| path(cells, points));
        Ok(path(route.cells.clone(), points).into_iter().chain(back).collect())
    };
    let found: Vec<Vec<Path>> = routes.par_iter().map(of_route).collect::<Result<_, Stopped>>()?;
    Ok(Paths::new(found.into_iter().flatten().collect()))
}
