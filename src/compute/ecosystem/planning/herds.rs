//! The herds of a habitat, and which of them can get in each other's way.

use super::occupancy::Rooms;
use crate::compute::ecosystem::rag::Rag;
use crate::compute::ecosystem::rag::Resource;
use crate::compute::ecosystem::rag::Territory;
use crate::compute::ecosystem::species::AnimalSpecies;
use crate::compute::ecosystem::species::Food;

/// A herd: a group that lives in one territory and walks together; it may be a single animal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Herd {
    /// Index of the species.
    pub species: usize,
    /// Index in [`Rag::territories`].
    pub territory: usize,
    /// The species' own confinement region.
    pub region: usize,
    /// Its number among the herds of its territory.
    pub number: usize,
    /// Individuals.
    pub size: u32,
}

impl Herd {
    /// A number that does not depend on other species, regions or herds: what its random numbers
    /// are drawn by.
    pub(crate) fn key(&self) -> u64 {
        ((self.species as u64) << 44) ^ ((self.region as u64) << 22) ^ self.number as u64
    }
}

/// All herds that live somewhere: by territory, then number. The index in this list is the herd's
/// id.
pub fn herds(rag: &Rag) -> Vec<Herd> {
    let of_territory = |(territory, t): (usize, &Territory)| {
        let herd =
            |(number, &size): (usize, &u32)| Herd { species: t.species, territory, region: t.region, number, size };
        let settled = t.herds.iter().enumerate().filter(|herd| *herd.1 > 0 && !t.nodes.is_empty());
        settled.map(herd).collect::<Vec<Herd>>()
    };
    rag.territories.iter().enumerate().flat_map(of_territory).collect()
}

/// The herds of one level in groups that share no room, each with the rooms its territories hold;
/// groups by their first herd, herds ascending.
pub(crate) fn independent(
    herds: &[Herd],
    rag: &Rag,
    rooms: &Rooms,
    of_level: impl Fn(&Herd) -> bool,
) -> Vec<(Vec<usize>, Vec<usize>)> {
    let mut root: Vec<usize> = (0..rooms.capacity.len()).collect();
    let chosen: Vec<usize> = (0..herds.len()).filter(|&h| of_level(&herds[h])).collect();
    let limited = |room: &usize| rooms.capacity[*room] < u32::MAX;
    let rooms_of = |h: usize| {
        let nodes = rag.territories[herds[h].territory].nodes.iter();
        nodes.map(|&n| rooms.of_node[n]).filter(limited)
    };
    for &h in &chosen {
        let first = rooms_of(h).next().map(|room| find(&mut root, room));
        for room in rooms_of(h) {
            let other = find(&mut root, room);
            if let Some(first) = first {
                root[other] = first;
            }
        }
    }
    let mut groups: Vec<(usize, Vec<usize>, Vec<usize>)> = Vec::new();
    for h in chosen {
        let Some(group) = rooms_of(h).next().map(|room| find(&mut root, room)) else { continue };
        match groups.iter_mut().find(|g| g.0 == group) {
            Some(g) => {
                g.1.push(h);
                g.2.extend(rooms_of(h));
            }
            None => groups.push((group, vec![h], rooms_of(h).collect())),
        }
    }
    groups
        .into_iter()
        .map(|(_, herds, mut rooms)| {
            rooms.sort_unstable();
            rooms.dedup();
            (herds, rooms)
        })
        .collect()
}

fn find(root: &mut [usize], mut room: usize) -> usize {
    while root[room] != room {
        root[room] = root[root[room]];
        room = root[room];
    }
    room
}

/// The herds that make up the prey at a node: those of the species it names that live on the
/// nodes it was made from.
pub(crate) fn prey_at(node: usize, herds: &[Herd], rag: &Rag) -> Vec<usize> {
    let Resource::Food(Food::Animal(species)) = rag.nodes[node].resource else { return Vec::new() };
    let mut below = rag.nodes[node].below.clone();
    below.sort_unstable();
    let holds = |t: &Territory| t.species == species && t.nodes.iter().any(|n| below.binary_search(n).is_ok());
    let territories: Vec<bool> = rag.territories.iter().map(holds).collect();
    (0..herds.len()).filter(|&h| territories[herds[h].territory]).collect()
}

/// The levels of the food chain at which herds live, ascending.
pub(crate) fn levels(herds: &[Herd], animals: &[AnimalSpecies]) -> Vec<usize> {
    let mut levels: Vec<usize> = herds.iter().map(|herd| animals[herd.species].level).collect();
    levels.sort_unstable();
    levels.dedup();
    levels
}
