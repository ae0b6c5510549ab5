//! Who is where when, and whether there is room: **node capacity** (L 6.2).

use super::DAY_S;
use crate::compute::ecosystem::rag::Node;
use crate::compute::ecosystem::rag::Rag;
use crate::compute::ecosystem::rag::Resource;
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
    /// The rooms of a graph on cells of `cell_m`, where an individual takes `m2_each`.
    pub(crate) fn new(rag: &Rag, cell_m: f64, m2_each: f64) -> Self {
        let mut known = BTreeMap::new();
        let mut rooms = Self { of_node: Vec::with_capacity(rag.nodes.len()), capacity: Vec::new() };
        for node in &rag.nodes {
            let next = rooms.capacity.len();
            let room = *known.entry((node.resource, node.cell)).or_insert(next);
            let holds = capacity(node, cell_m, m2_each);
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

/// **Node capacity**: individuals that a node holds at a time, at least one. A bank is as long as
/// its cells, and as wide as one of them or as an individual, whichever is more, so that it does
/// not hold fewer on finer cells. Any number pass a way-point.
pub fn capacity(node: &Node, cell_m: f64, m2_each: f64) -> u32 {
    let wider = match node.resource {
        Resource::Water => (m2_each.sqrt() / cell_m).max(1.0),
        Resource::Food(_) => 1.0,
        Resource::WayPoint(_) => return u32::MAX,
    };
    (node.area_m2 * wider / m2_each).max(1.0) as u32
}

/// Who is in the rooms, on a day that comes again and again: intervals are taken modulo a day.
#[derive(Debug, Clone, Default)]
pub(crate) struct Occupancy {
    rooms: BTreeMap<usize, Room>,
}

/// The individuals in one room through the day.
#[derive(Debug, Clone)]
struct Room {
    /// From when on how many are there: ascending from 0, up to the next entry or the day's end.
    levels: Vec<(f64, u32)>,
    /// The most at any moment.
    most: u32,
}

impl Occupancy {
    /// Takes `individuals` places in a room during `when` (seconds, at most a day long).
    pub(crate) fn take(&mut self, room: usize, when: Range<f64>, individuals: u32) {
        let room = self.rooms.entry(room).or_insert(Room { levels: vec![(0.0, 0)], most: 0 });
        pieces(when).into_iter().flatten().for_each(|piece| room.add(piece, individuals));
    }

    /// The most individuals in a room at any moment of `when`.
    pub(crate) fn peak(&self, room: usize, when: Range<f64>) -> u32 {
        let Some(room) = self.rooms.get(&room) else { return 0 };
        pieces(when).into_iter().flatten().map(|piece| room.peak(piece)).max().unwrap_or(0)
    }

    /// The first moment within `when` from which at most `others` individuals are in a room for
    /// `length` seconds on end, still within it.
    pub(crate) fn first_gap(&self, room: usize, when: Range<f64>, (length, others): (f64, u32)) -> Option<f64> {
        let Some(room) = self.rooms.get(&room) else {
            return (when.end - when.start >= length).then_some(when.start);
        };
        let (mut clock, mut since) = (when.start, None);
        for (from, to) in pieces(when).into_iter().flatten() {
            let first = room.levels.partition_point(|(start, _)| *start <= from).saturating_sub(1);
            for (i, (start, level)) in room.levels.iter().enumerate().skip(first).take_while(|(_, l)| l.0 < to) {
                let end = room.levels.get(i + 1).map_or(DAY_S, |next| next.0);
                let (begins, ends) = (clock + start.max(from) - from, clock + end.min(to) - from);
                since = (*level <= others).then(|| since.unwrap_or(begins));
                if let Some(since) = since.filter(|since| ends - since >= length) {
                    return Some(since);
                }
            }
            clock += to - from;
        }
        None
    }

    /// The most individuals in a room at any moment of the day.
    pub(crate) fn most(&self, room: usize) -> u32 {
        self.rooms.get(&room).map_or(0, |room| room.most)
    }

    /// What is known of some rooms only.
    pub(crate) fn of_rooms(&self, rooms: &[usize]) -> Self {
        Self { rooms: rooms.iter().filter_map(|room| Some((*room, self.rooms.get(room)?.clone()))).collect() }
    }

    /// Replaces what is known of the rooms that `other` knows.
    pub(crate) fn update(&mut self, other: Self) {
        self.rooms.extend(other.rooms);
    }
}

impl Room {
    fn add(&mut self, (from, to): (f64, f64), individuals: u32) {
        let first = self.cut(from);
        let end = if to < DAY_S { self.cut(to) } else { self.levels.len() };
        for (_, level) in &mut self.levels[first..end] {
            *level = level.saturating_add(individuals);
            self.most = self.most.max(*level);
        }
    }

    /// The entry that begins at a moment, made when there is none.
    fn cut(&mut self, moment: f64) -> usize {
        let next = self.levels.partition_point(|(start, _)| *start < moment);
        if self.levels.get(next).is_none_or(|(start, _)| *start > moment) {
            let before = self.levels[..next].last().map_or(0, |(_, level)| *level);
            self.levels.insert(next, (moment, before));
        }
        next
    }

    fn peak(&self, (from, to): (f64, f64)) -> u32 {
        let first = self.levels.partition_point(|(start, _)| *start <= from).saturating_sub(1);
        let during = self.levels[first..].iter().take_while(|(start, _)| *start < to);
        during.map(|(_, level)| *level).max().unwrap_or(0)
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
    fn the_peak_is_the_most_that_any_moment_has() {
        let mut rooms = Occupancy::default();
        let stay = |k: u32| {
            let from = f64::from(k * 7919 % 1440) * 60.0;
            (from..from + 60.0 * f64::from(10 + k * 31 % 300), 1 + k % 5)
        };
        (0..60).map(stay).for_each(|(when, individuals)| rooms.take(0, when, individuals));
        let there = |moment: f64| {
            let is_there = |when: &Range<f64>| when.contains(&moment) || when.contains(&(moment + DAY_S));
            (0..60).map(stay).filter(|(when, _)| is_there(when)).map(|(_, n)| n).sum::<u32>()
        };
        let minutes = |range: Range<u32>| range.map(|m| there(f64::from(m) * 60.0)).max().unwrap();
        for from in (0..1300).step_by(37) {
            let when = f64::from(from) * 60.0..f64::from(from + 100) * 60.0;
            assert_eq!(rooms.peak(0, when), minutes(from..from + 100));
        }
        assert_eq!(rooms.most(0), minutes(0..1440));
    }

    #[test]
    fn a_gap_is_as_long_as_there_is_room_on_end_past_midnight_too() {
        let mut rooms = Occupancy::default();
        rooms.take(0, 6.0 * HOUR..10.0 * HOUR, 20);
        rooms.take(0, 12.0 * HOUR..22.0 * HOUR, 20);
        let gap = |from: f64, to: f64, hours: f64| {
            rooms.first_gap(0, from * HOUR..to * HOUR, (hours * HOUR, 5)).map(|start| start / HOUR)
        };
        assert_eq!([gap(6.0, 14.0, 2.0), gap(6.0, 14.0, 2.1), gap(6.0, 11.0, 1.5)], [Some(10.0), None, None]);
        assert_eq!([gap(12.0, 30.0, 7.9), gap(12.0, 30.0, 8.1), gap(11.0, 30.0, 1.0)], [Some(22.0), None, Some(11.0)]);
        assert_eq!(gap(26.0, 37.0, 1.5), Some(26.0));
        assert_eq!(gap(30.0, 37.0, 2.0), Some(34.0));
        assert_eq!(rooms.first_gap(0, 0.0..DAY_S, (DAY_S, 20)), Some(0.0));
        assert_eq!(rooms.first_gap(0, 0.0..DAY_S, (DAY_S, 19)), None);
        assert_eq!(rooms.first_gap(7, HOUR..2.0 * HOUR, (HOUR, 0)), Some(HOUR));
        assert_eq!(rooms.first_gap(7, 0.0..HOUR, (2.0 * HOUR, 0)), None);
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
