//! The path of a herd in time (L 6.2: ways "are reused, assembled and refined using spline
//! curves").

use super::DAY_S;
use super::Planning;
use super::Plannings;
use super::Visit;
use crate::compute::ecosystem::curve::Ground;
use crate::compute::ecosystem::curve::Walk;
use crate::compute::ecosystem::habitat::Habitat;
use crate::compute::ecosystem::ways::Way;
use crate::compute::geometry::Point;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;

/// At which moments a path is wanted, and over which ground.
#[derive(Debug, Clone, Copy)]
pub struct Pace<'a> {
    /// Seconds between two positions, at least 1. A day gives 86 400 / step + 1 of them.
    pub step_s: f64,
    /// Height map, for the third coordinate.
    pub height: Option<&'a Raster<f32>>,
}

/// Where a herd is through its day.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// Index in [`Plannings::herds`].
    pub herd: usize,
    /// Time of the first position, seconds of the solar day.
    pub from_s: f64,
    /// Seconds between two positions.
    pub step_s: f64,
    /// The positions, metres.
    pub places: Vec<Point>,
    /// The height at each, metres; empty when no height map was given, NaN where it has none.
    pub heights_m: Vec<f32>,
}

/// What a leg is known by: species, from, to.
type Trip = (usize, usize, usize);

/// The paths of the herds in `chosen` (indices in [`Plannings::herds`]), in that order, over one
/// active day and the rest after it. Between stays a herd follows the trails where these lead
/// ([`Habitat::paths`]), else the quickest way, made straight where that is as quick; smooth where
/// the ground is open. It is never on a closed cell and moves at the speed the ground allows. Reports as `planning.tracks`.
///
/// # Errors
/// [`Stopped`] when the run was asked to stop.
pub fn tracks(
    habitat: &Habitat,
    plannings: &Plannings,
    chosen: &[usize],
    pace: Pace,
    run: &Run,
) -> Result<Vec<Track>, Stopped> {
    let chosen: Vec<usize> = chosen.iter().copied().filter(|&h| h < plannings.herds.len()).collect();
    let trips_of = |&h: &usize| trips(plannings.herds[h].species, &plannings.days[h]);
    let mut trips: Vec<Trip> = chosen.iter().flat_map(trips_of).collect();
    trips.sort_unstable();
    trips.dedup();
    let legs = legs(habitat, &trips, run)?;
    let track = |&herd: &usize| {
        run.check()?;
        let leg = |trip: Trip| trips.binary_search(&trip).ok().and_then(|i| legs[i].as_ref());
        Ok(track(herd, plannings, pace, (habitat, &leg)))
    };
    chosen.par_iter().map(track).collect()
}

fn trips(species: usize, day: &Planning) -> Vec<Trip> {
    let trip = |w: &[Visit]| (w[0].cell != w[1].cell).then_some((species, w[0].cell, w[1].cell));
    day.visits.windows(2).filter_map(trip).collect()
}

/// The legs of sorted trips: over the trails where these lead, else the quickest way; one search
/// per species and source.
fn legs(habitat: &Habitat, trips: &[Trip], run: &Run) -> Result<Vec<Option<Walk>>, Stopped> {
    let ground = Ground { grid: habitat.grid, ways: habitat.ways };
    let sources: Vec<&[Trip]> = trips.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).collect();
    let search = |trips: &&[Trip]| {
        run.check()?;
        let (species, from, _) = trips[0];
        let trodden = |trip: &Trip| {
            let way = habitat.paths?.way(species, from, trip.2)?;
            Some(ground.walk(species, &way.cells))
        };
        let mut legs: Vec<Option<Walk>> = trips.iter().map(trodden).collect();
        let left: Vec<usize> = (0..trips.len()).filter(|&i| legs[i].is_none()).collect();
        if !left.is_empty() {
            let targets: Vec<usize> = left.iter().map(|&i| trips[i].2).collect();
            let ways = habitat.ways.ways(species, from, &targets, run)?;
            left.into_iter().zip(ways).for_each(|(i, way)| legs[i] = way.map(|way| leg(species, &way, &ground)));
        }
        Ok(legs)
    };
    let found: Vec<Vec<Option<Walk>>> = sources.par_iter().map(search).collect::<Result<_, Stopped>>()?;
    Ok(found.into_iter().flatten().collect())
}

/// A way made straight and smooth, scaled to take as long as the way does.
fn leg(species: usize, way: &Way, ground: &Ground) -> Walk {
    let mut walk = ground.walk(species, &ground.straightened(species, way));
    let scale = if walk.seconds() > 0.0 { way.seconds / walk.seconds() } else { 0.0 };
    walk.at.iter_mut().for_each(|seconds| *seconds *= scale);
    walk
}

fn track<'l>(
    herd: usize,
    plannings: &Plannings,
    pace: Pace,
    (habitat, leg): (&Habitat, &dyn Fn(Trip) -> Option<&'l Walk>),
) -> Track {
    let visits = &plannings.days[herd].visits;
    let species = plannings.herds[herd].species;
    let step_s = pace.step_s.clamp(1.0, DAY_S);
    let from_s = visits.first().map_or(0.0, |visit| visit.arrive_s);
    let place = |k: usize| {
        let now = from_s + k as f64 * step_s;
        let last = visits.partition_point(|visit| visit.arrive_s <= now).clamp(1, visits.len()) - 1;
        let here = &visits[last];
        let next = visits.get(last + 1).filter(|next| now > here.leave_s && next.cell != here.cell);
        let on_leg = next.and_then(|next| leg((species, here.cell, next.cell)).map(|leg| (leg, next)));
        on_leg.map_or(habitat.grid.centre(here.cell), |(leg, next)| {
            on_the_way(leg, now - here.leave_s, next.arrive_s - here.leave_s)
        })
    };
    let steps = if visits.is_empty() { 0 } else { (DAY_S / step_s) as usize + 1 };
    let places: Vec<Point> = (0..steps).map(place).collect();
    let height = |map: &Raster<f32>| places.iter().map(|&p| map.sample(p).map_or(f32::NAN, |z| z as f32)).collect();
    let heights_m = pace.height.map_or(Vec::new(), height);
    Track { herd, from_s, step_s, places, heights_m }
}

/// The place on a walk `after` seconds when there are `most` seconds for all of it: quicker when
/// it takes longer than planned, at the end when it takes less.
fn on_the_way(walk: &Walk, after: f64, most: f64) -> Point {
    let (last, points) = (walk.points.len() - 1, &walk.points);
    let hurry = if most > 0.0 { (walk.seconds() / most).max(1.0) } else { 1.0 };
    let clock = after * hurry;
    let next = walk.at.partition_point(|seconds| *seconds <= clock);
    if next == 0 || next > last {
        return points[next.min(last)];
    }
    let (from, to) = (walk.at[next - 1], walk.at[next]);
    points[next - 1].lerp(points[next], (clock - from) / (to - from))
}
