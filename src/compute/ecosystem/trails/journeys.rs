//! Who walks between which nodes, and how much (L equation 3).

use super::spanner::carried;
use crate::compute::ecosystem::presence::Drinking;
use crate::compute::ecosystem::presence::onward;
use crate::compute::ecosystem::presence::presence;
use crate::compute::ecosystem::rag::Rag;
use crate::compute::ecosystem::rag::Territory;
use crate::compute::ecosystem::species::AnimalSpecies;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;

/// Days in a year.
const DAYS: f64 = 365.0;

/// What one species carries between two nodes of a territory in a year.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Journey {
    /// Index in [`Rag::territories`].
    pub(crate) territory: usize,
    /// Position in the territory's nodes; below `to`.
    pub(crate) from: usize,
    /// Position in the territory's nodes.
    pub(crate) to: usize,
    /// Mass that goes from `from` to `to`, kg a year.
    pub(crate) there: f64,
    /// Mass that goes back, kg a year.
    pub(crate) back: f64,
}

impl Journey {
    /// **w** (L equation 3): mass in both directions, kg a year.
    pub(crate) fn weight(&self) -> f64 {
        self.there + self.back
    }
}

/// The journeys that wear trails.
pub(crate) struct Journeys {
    /// From the heaviest down; ties by territory and nodes.
    pub(crate) list: Vec<Journey>,
    /// The share of the weight of all journeys that these have.
    pub(crate) kept_share: f64,
}

/// What the journeys are chosen by.
pub(crate) struct Choice {
    pub(crate) drinking: Drinking,
    pub(crate) stay_s: f64,
    pub(crate) detour: f64,
    pub(crate) most: usize,
}

/// L equation 3 for every pair of nodes of every territory where animals live, carried over the
/// edges of the territory's [`carried`] spanner; the heaviest `most` of these.
///
/// Equation 3 weighs an edge by m · ‖s‖ · (P(v)P(v'|v) + P(v')P(v|v')), the mass that takes it in
/// one move. Times the moves a year (days × active time over the mean stay and way) it is in kg a
/// year, as the text means it ("the total mass that travelled during a year"). The sum over
/// species is made on the ground, where the ways of all species meet.
pub(crate) fn journeys(rag: &Rag, animals: &[AnimalSpecies], choice: &Choice, run: &Run) -> Result<Journeys, Stopped> {
    let of_territory = |i: usize| {
        run.check()?;
        Ok(carried(&rag.territories[i], &weigh(rag, animals, i, choice), choice.detour))
    };
    let parts: Vec<Vec<Journey>> =
        (0..rag.territories.len()).into_par_iter().map(of_territory).collect::<Result<_, Stopped>>()?;
    let mut list = parts.concat();
    let place = |j: &Journey| (j.territory, j.from, j.to);
    list.sort_unstable_by(|a, b| b.weight().total_cmp(&a.weight()).then_with(|| place(a).cmp(&place(b))));
    let sum = |list: &[Journey]| list.iter().map(Journey::weight).sum::<f64>();
    let total = sum(&list);
    list.truncate(choice.most);
    let kept_share = if total > 0.0 { sum(&list) / total } else { 1.0 };
    Ok(Journeys { list, kept_share })
}

fn weigh(rag: &Rag, animals: &[AnimalSpecies], index: usize, choice: &Choice) -> Vec<Journey> {
    let territory = &rag.territories[index];
    let species = &animals[territory.species];
    let mass = species.mass_kg * territory.individuals() as f64;
    if mass <= 0.0 {
        return Vec::new();
    }
    let n = territory.nodes.len();
    let at = presence(rag, territory, species, &choice.drinking);
    let next: Vec<Vec<f64>> = (0..n).map(|v| onward(territory, &at, v)).collect();
    // Nobody stays at a way-point.
    let passing: f64 =
        territory.nodes.iter().zip(&at).filter(|(n, _)| rag.nodes[**n].draws > 0.0).map(|(_, p)| p).sum();
    let moved = mass * moves_a_year(territory, species, (&at, &next), choice.stay_s * (1.0 - passing));
    let pairs = (0..n).flat_map(|from| (from + 1..n).map(move |to| (from, to)));
    pairs
        .map(|(from, to)| Journey {
            territory: index,
            from,
            to,
            there: moved * at[from] * next[from][to],
            back: moved * at[to] * next[to][from],
        })
        .filter(|journey| journey.weight() > 0.0)
        .collect()
}

/// Moves between nodes in a year: the active time over the mean stay and way.
fn moves_a_year(territory: &Territory, species: &AnimalSpecies, (at, next): (&[f64], &[Vec<f64>]), stay_s: f64) -> f64 {
    let mut way_s = 0.0;
    for (from, row) in next.iter().enumerate() {
        for (to, p) in row.iter().enumerate().filter(|(_, p)| **p > 0.0) {
            way_s += at[from] * p * territory.time_s(from, to);
        }
    }
    DAYS * species.active_s / (stay_s + way_s)
}
