//! The path of a herd in time (L 6.2: ways "are reused, assembled and refined using spline
//! curves").

use super::DAY_S;
use super::Planning;
use super::Plannings;
use super::Visit;
use crate::compute::ecosystem::curve::Ground;
use crate::compute::ecosystem::curve::relax;
use crate::compute::ecosystem::habitat::Habitat;
use crate::compute::ecosystem::ways::Way;
use crate::compute::geometry::Point;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;

/// Rounds of averaging that smooth a way (see `curve::relax`).
const ROUNDS: usize = 10;

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

/// A way from one cell to another, with the time at each point.
struct Leg {
    points: Vec<Point>,
    /// Seconds since departure, ascending.
    at: Vec<f64>,
}

/// What a leg is known by: species, from, to.
type Trip = (usize, usize, usize);

/// The paths of the herds in `chosen` (indices in [`Plannings::herds`]), in that order, over one
/// active day and the rest after it. Between stays a herd follows the quickest way, made straight
/// where that is as quick and smooth where the ground is open; it is never on a closed cell and
/// moves at the speed the ground allows. Reports as `planning.tracks`.
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

/// The legs of sorted trips; one search per species and source.
fn legs(habitat: &Habitat, trips: &[Trip], run: &Run) -> Result<Vec<Option<Leg>>, Stopped> {
    let ground = Ground { grid: habitat.grid, ways: habitat.ways };
    let sources: Vec<&[Trip]> = trips.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).collect();
    let walked = |way: &Way| way.cells.len() > 1;
    let search = |trips: &&[Trip]| {
        let (species, from, _) = trips[0];
        let targets: Vec<usize> = trips.iter().map(|trip| trip.2).collect();
        let ways = habitat.ways.ways(species, from, &targets, run)?;
        Ok(ways
            .into_iter()
            .map(|way| way.filter(walked).map(|way| leg(species, &way, &ground)))
            .collect::<Vec<Option<Leg>>>())
    };
    let found: Vec<Vec<Option<Leg>>> = sources.par_iter().map(search).collect::<Result<_, Stopped>>()?;
    Ok(found.into_iter().flatten().collect())
}

/// A way made straight and smooth. Each piece keeps the slowness of the step it came from, and all
/// are scaled so that the leg takes as long as the way.
fn leg(species: usize, way: &Way, ground: &Ground) -> Leg {
    let cells = ground.straightened(species, way);
    let steps = ground.clock(species, &cells);
    let centres: Vec<Point> = cells.iter().map(|&cell| ground.grid.centre(cell as usize)).collect();
    let mut points = centres.clone();
    let last = points.len() - 1;
    relax(&mut points, ROUNDS, |i| i == 0 || i == last, |_, p, q| ground.clear(species, p, q));
    // Where the clock misses what the search knows (a ford), speed is even.
    let known = steps[last].is_finite();
    let mut at = vec![0.0];
    for i in 0..last {
        let (length, before) = (points[i].distance(points[i + 1]), centres[i].distance(centres[i + 1]));
        let slowness = if known { (steps[i + 1] - steps[i]) / before } else { 1.0 };
        at.push(at[i] + slowness * length);
    }
    let scale = if at[last] > 0.0 { way.seconds / at[last] } else { 0.0 };
    at.iter_mut().for_each(|seconds| *seconds *= scale);
    Leg { points, at }
}

fn track<'l>(
    herd: usize,
    plannings: &Plannings,
    pace: Pace,
    (habitat, leg): (&Habitat, &dyn Fn(Trip) -> Option<&'l Leg>),
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
            leg.place(now - here.leave_s, next.arrive_s - here.leave_s)
        })
    };
    let steps = if visits.is_empty() { 0 } else { (DAY_S / step_s) as usize + 1 };
    let places: Vec<Point> = (0..steps).map(place).collect();
    let height = |map: &Raster<f32>| places.iter().map(|&p| map.sample(p).map_or(f32::NAN, |z| z as f32)).collect();
    let heights_m = pace.height.map_or(Vec::new(), height);
    Track { herd, from_s, step_s, places, heights_m }
}

impl Leg {
    /// The place `after` seconds when there are `most` seconds for the whole leg: quicker when
    /// the way takes longer than planned, at the end when it takes less.
    fn place(&self, after: f64, most: f64) -> Point {
        let last = self.at.len() - 1;
        let hurry = if most > 0.0 { (self.at[last] / most).max(1.0) } else { 1.0 };
        let clock = after * hurry;
        let next = self.at.partition_point(|seconds| *seconds <= clock);
        if next == 0 || next > last {
            return self.points[next.min(last)];
        }
        let (from, to) = (self.at[next - 1], self.at[next]);
        self.points[next - 1].lerp(self.points[next], (clock - from) / (to - from))
    }
}
