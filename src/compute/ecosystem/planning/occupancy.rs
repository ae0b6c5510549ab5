//! Who is where when, and whether there is room: **node capacity** (L 6.2).

use super::DAY_S;
use crate::compute::ecosystem::rag::Rag;
use std::collections::BTreeMap;
use std::ops::Range;

/// The rooms of the habitat: nodes that offer the same resource at the same cell are one room,
/// so that levels of the food chain share it; it holds what the smallest of them holds.
pub(crate) struct Rooms {
    /// The room of each node.
    pub(crate) of_node: Vec<usize>,
    /// Individuals that each room holds.
    pub(crate) capacity: Vec<u32>,
}

impl Rooms {
    /// Rooms for one individual per `m2_each` square metres, and at least one.
    pub(crate) fn new(rag: &Rag, m2_each: f64) -> Self {
        let mut known = BTreeMap::new();
        let mut rooms = Self { of_node: Vec::with_capacity(rag.nodes.len()), capacity: Vec::new() };
        for node in &rag.nodes {
            let next = rooms.capacity.len();
            let room = *known.entry((node.resource, node.cell)).or_insert(next);
            let holds = (node.area_m2 / m2_each).max(1.0) as u32;
            if room == next {
                rooms.capacity.push(holds);
            } else {
                rooms.capacity[room] = rooms.capacity[room].min(holds);
            }
            rooms.of_node.push(room);
        }
        rooms
    }
}

/// Stays in rooms, on a day that comes again and again: intervals are taken modulo a day.
#[derive(Debug, Clone, Default)]
pub(crate) struct Occupancy {
    /// Per room: (from, to, individuals) with 0 ≤ from < to ≤ a day.
    stays: BTreeMap<usize, Vec<(f64, f64, u32)>>,
}

impl Occupancy {
    /// Takes `individuals` places in a room during `when` (seconds, at most a day long).
    pub(crate) fn take(&mut self, room: usize, when: Range<f64>, individuals: u32) {
        let pieces = pieces(when).into_iter().flatten();
        self.stays.entry(room).or_default().extend(pieces.map(|(from, to)| (from, to, individuals)));
    }

    /// The most individuals in a room at any moment of `when`.
    pub(crate) fn peak(&self, room: usize, when: Range<f64>) -> u32 {
        let Some(stays) = self.stays.get(&room) else { return 0 };
        let at = |moment: f64| -> u32 {
            stays.iter().filter(|s| (s.0..s.1).contains(&moment)).fold(0, |sum, stay| sum.saturating_add(stay.2))
        };
        let of_piece = |(from, to): (f64, f64)| {
            let starts = stays.iter().map(|stay| stay.0).filter(|start| (from..to).contains(start));
            starts.chain([from]).map(at).max().unwrap_or(0)
        };
        pieces(when).into_iter().flatten().map(of_piece).max().unwrap_or(0)
    }

    /// What is known of some rooms only.
    pub(crate) fn of_rooms(&self, rooms: &[usize]) -> Self {
        let stays = rooms.iter().filter_map(|room| Some((*room, self.stays.get(room)?.clone()))).collect();
        Self { stays }
    }

    /// Replaces what is known of the rooms that `other` knows.
    pub(crate) fn update(&mut self, other: Self) {
        self.stays.extend(other.stays);
    }
}

/// An interval modulo a day, as one or two intervals within it; none when it is empty.
fn pieces(when: Range<f64>) -> [Option<(f64, f64)>; 2] {
    let length = (when.end - when.start).min(DAY_S);
    if length.is_nan() || length <= 0.0 {
        return [None, None];
    }
    let from = when.start.rem_euclid(DAY_S);
    let to = from + length;
    if to <= DAY_S { [Some((from, to)), None] } else { [Some((from, DAY_S)), Some((0.0, to - DAY_S))] }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HOUR: f64 = 3600.0;

    #[test]
    fn places_are_taken_during_the_stay_only() {
        let mut rooms = Occupancy::default();
        rooms.take(3, 8.0 * HOUR..10.0 * HOUR, 20);
        rooms.take(3, 9.0 * HOUR..12.0 * HOUR, 5);
        assert_eq!(rooms.peak(3, 0.0..8.0 * HOUR), 0);
        assert_eq!(rooms.peak(3, 8.5 * HOUR..8.6 * HOUR), 20);
        assert_eq!(rooms.peak(3, 7.0 * HOUR..20.0 * HOUR), 25);
        assert_eq!(rooms.peak(3, 10.0 * HOUR..20.0 * HOUR), 5);
        assert_eq!(rooms.peak(4, 0.0..24.0 * HOUR), 0);
    }

    #[test]
    fn a_stay_past_midnight_is_there_the_next_morning() {
        let mut rooms = Occupancy::default();
        rooms.take(0, 22.0 * HOUR..29.0 * HOUR, 7);
        assert_eq!(rooms.peak(0, HOUR..2.0 * HOUR), 7);
        assert_eq!(rooms.peak(0, 25.0 * HOUR..26.0 * HOUR), 7);
        assert_eq!(rooms.peak(0, 5.0 * HOUR..22.0 * HOUR), 0);
        assert_eq!(rooms.peak(0, 5.0 * HOUR..5.0 * HOUR), 0);
    }
}
