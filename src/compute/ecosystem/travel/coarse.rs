//! The graph of rooms: a search over it costs a small fraction of one over cells.

use super::rooms::Room;
use super::rooms::Rooms;
use super::steps::Steps;
use crate::compute::graph::shortest_paths::Network;
use crate::compute::raster::Tiling;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;

/// A way from a room to one near by.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Link {
    to: u32,
    /// Which of the links of `to` comes back.
    back: u16,
    seconds: f32,
}

/// The rooms of one species and the links between them.
///
/// Rooms that share a walkable border are linked; so are rooms of tiles that touch by a corner if
/// a third lies between them, and rooms a knight's move apart if both ways between lead through
/// rooms that fill most of their tile. A link costs the distance of the centres times the mean
/// slowness of the rooms passed, in its direction.
pub(super) struct Coarse {
    pub(super) rooms: Rooms,
    width: usize,
    cell_m: f32,
    first: Vec<u32>,
    links: Vec<Link>,
    cheap: f32,
}

/// Links a room may have; more are left out (a tile of side 32 touches at most 64 by its sides).
const MOST_LINKS: usize = 4096;

impl Coarse {
    pub(super) fn new(steps: &Steps<'_>, tiling: Tiling, run: &Run) -> Result<Self, Stopped> {
        let rooms = Rooms::new(steps, tiling, run)?;
        let sides = neighbours_by_side(steps, &rooms);
        run.check()?;
        let corners = neighbours_by_corner(&rooms, &sides);
        run.check()?;
        let mut coarse = Self {
            width: steps.grid().width,
            cell_m: steps.grid().cell_m as f32,
            first: Vec::new(),
            links: Vec::new(),
            cheap: 1.0,
            rooms,
        };
        let lists: Vec<Vec<Link>> =
            (0..sides.len()).into_par_iter().map(|room| coarse.links_of(room, &sides, &corners)).collect();
        coarse.store(lists);
        Ok(coarse)
    }

    fn store(&mut self, lists: Vec<Vec<Link>>) {
        let mut sum = 0;
        self.first = std::iter::once(0)
            .chain(lists.iter().map(|list| {
                sum += list.len() as u32;
                sum
            }))
            .collect();
        self.links = lists.concat();
        let back = |from: usize, to: u32| {
            let list = &self.links[self.first[to as usize] as usize..self.first[to as usize + 1] as usize];
            list.binary_search_by_key(&(from as u32), |link| link.to).map_or(0, |i| i as u16)
        };
        let backs: Vec<u16> = (0..self.rooms.rooms.len())
            .flat_map(|from| self.list(from).iter().map(move |link| (from, link.to)))
            .map(|(from, to)| back(from, to))
            .collect();
        self.links.iter_mut().zip(backs).for_each(|(link, back)| link.back = back);
        let mean = self.links.iter().map(|link| f64::from(link.seconds)).sum::<f64>() / self.links.len().max(1) as f64;
        self.cheap = (0.25 * mean) as f32;
    }

    fn list(&self, room: usize) -> &[Link] {
        &self.links[self.first[room] as usize..self.first[room + 1] as usize]
    }

    /// The links of a room, by target.
    fn links_of(&self, room: usize, sides: &[Vec<u32>], corners: &[Vec<u32>]) -> Vec<Link> {
        let link = |to: &u32, passed: &[usize]| Link {
            to: *to,
            back: 0,
            seconds: self.seconds_between(self.rooms.rooms[room].centre, self.rooms.rooms[*to as usize].centre, passed),
        };
        let near = sides[room].iter().chain(&corners[room]);
        let mut links: Vec<Link> = near.map(|to| link(to, &[room, *to as usize])).collect();
        for (to, passed) in self.knights(room, sides, corners) {
            links.push(link(&to, &[room, passed.0, passed.1, to as usize]));
        }
        links.sort_by(|a, b| a.to.cmp(&b.to).then(a.seconds.total_cmp(&b.seconds)));
        links.dedup_by_key(|link| link.to);
        links.truncate(MOST_LINKS);
        links
    }

    /// Rooms a knight's move away, with the two rooms passed.
    fn knights(&self, room: usize, sides: &[Vec<u32>], corners: &[Vec<u32>]) -> Vec<(u32, (usize, usize))> {
        let mut found = Vec::new();
        for side in sides[room].iter().map(|s| *s as usize).filter(|s| self.is_wide(*s)) {
            for to in &corners[side] {
                let corner = sides[*to as usize]
                    .iter()
                    .map(|c| *c as usize)
                    .find(|c| self.is_wide(*c) && corners[room].binary_search(&(*c as u32)).is_ok());
                let (dx, dy) = self.apart(room, *to as usize);
                if let Some(corner) = corner.filter(|_| dx.abs() + dy.abs() == 3) {
                    found.push((*to, (side, corner)));
                }
            }
        }
        found
    }

    /// Whether a room fills most of its tile.
    fn is_wide(&self, room: usize) -> bool {
        let side = self.rooms.tiling.side() as u32;
        self.rooms.rooms[room].cells * 4 >= side * side * 3
    }

    fn apart(&self, a: usize, b: usize) -> (isize, isize) {
        apart(&self.rooms, a, b)
    }

    /// Seconds from one place (column, row) to another through these rooms: the distance times
    /// the mean slowness in that direction, interpolated between the two nearest of the eight.
    pub(super) fn seconds_between(&self, from: (f32, f32), to: (f32, f32), rooms: &[usize]) -> f32 {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let (long, short) = (dx.abs().max(dy.abs()), dx.abs().min(dy.abs()));
        let axis = match (dx.abs() >= dy.abs(), dx >= 0.0, dy >= 0.0) {
            (true, east, _) => usize::from(!east),
            (false, _, south) => 2 + usize::from(!south),
        };
        let corner = match (dx >= 0.0, dy >= 0.0) {
            (true, true) => 4,
            (false, false) => 5,
            (true, false) => 6,
            (false, true) => 7,
        };
        let mean =
            |which: usize| rooms.iter().map(|r| self.rooms.rooms[*r].slowness[which]).sum::<f32>() / rooms.len() as f32;
        let (straight, diagonal) = (long - short, std::f32::consts::SQRT_2 * short);
        let length = (dx * dx + dy * dy).sqrt();
        if length == 0.0 {
            return 0.0;
        }
        let slowness = (straight * mean(axis) + diagonal * mean(corner)) / (straight + diagonal);
        length * self.cell_m * slowness
    }

    /// The room of a cell.
    pub(super) fn room_of(&self, cell: usize) -> Option<usize> {
        self.rooms.of(cell % self.width, cell / self.width, self.width)
    }

    fn place(&self, cell: usize) -> (f32, f32) {
        ((cell % self.width) as f32, (cell / self.width) as f32)
    }

    /// Where a search from a cell starts: its room and those linked to it, with the seconds from
    /// the cell to their centres.
    pub(super) fn sources(&self, cell: usize) -> Vec<(usize, f32)> {
        let Some(room) = self.room_of(cell) else { return Vec::new() };
        let at = self.place(cell);
        self.with_linked(room)
            .map(|to| (to, self.seconds_between(at, self.rooms.rooms[to].centre, &[room, to])))
            .collect()
    }

    /// Seconds from the start of a search to a cell, by the cheapest of the rooms around it, and
    /// that room.
    pub(super) fn arrival(&self, cost: &[f32], cell: usize) -> Option<(usize, f32)> {
        let room = self.room_of(cell)?;
        let at = self.place(cell);
        self.with_linked(room)
            .map(|from| (from, cost[from] + self.seconds_between(self.rooms.rooms[from].centre, at, &[from, room])))
            .min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)))
            .filter(|(_, seconds)| seconds.is_finite())
    }

    fn with_linked(&self, room: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::once(room).chain(self.list(room).iter().map(|link| link.to as usize))
    }

    /// The tile of a room.
    pub(super) fn tile(&self, room: usize) -> usize {
        self.rooms.rooms[room].tile as usize
    }
}

impl Network for Coarse {
    fn len(&self) -> usize {
        self.rooms.rooms.len()
    }

    fn edges(&self, node: usize, mut visit: impl FnMut(u16, usize, f32)) {
        self.list(node).iter().for_each(|link| visit(link.back, link.to as usize, link.seconds));
    }

    fn origin(&self, node: usize, mark: u16) -> usize {
        self.list(node)[usize::from(mark)].to as usize
    }

    fn cheap_edge(&self) -> f32 {
        self.cheap
    }
}

/// Columns and rows of tiles from room `a` to room `b`.
fn apart(rooms: &Rooms, a: usize, b: usize) -> (isize, isize) {
    let columns = rooms.tiling.columns as isize;
    let tile = |room: usize| {
        let Room { tile, .. } = rooms.rooms[room];
        (tile as isize % columns, tile as isize / columns)
    };
    (tile(b).0 - tile(a).0, tile(b).1 - tile(a).1)
}

/// For each room, the rooms that share a border with it which is walked both ways.
fn neighbours_by_side(steps: &Steps<'_>, rooms: &Rooms) -> Vec<Vec<u32>> {
    let grid = steps.grid();
    let side = rooms.tiling.side();
    let mut lists = vec![Vec::new(); rooms.rooms.len()];
    let pair = |(x, y): (usize, usize), (dx, dy): (usize, usize)| {
        let a = rooms.of(x, y, grid.width)?;
        let b = rooms.of(x + dx, y + dy, grid.width)?;
        steps.both_ways(grid.index(x, y), grid.index(x + dx, y + dy)).then_some((a, b))
    };
    let down = (1..rooms.tiling.columns).flat_map(|c| (0..grid.height).map(move |y| ((c * side - 1, y), (1, 0))));
    let along = (1..rooms.tiling.rows).flat_map(|r| (0..grid.width).map(move |x| ((x, r * side - 1), (0, 1))));
    for (a, b) in down.chain(along).filter_map(|(cell, step)| pair(cell, step)) {
        lists[a].push(b as u32);
        lists[b].push(a as u32);
    }
    for list in &mut lists {
        list.sort_unstable();
        list.dedup();
    }
    lists
}

/// For each room, the rooms of the tiles beyond its corners that share a neighbour with it.
fn neighbours_by_corner(rooms: &Rooms, sides: &[Vec<u32>]) -> Vec<Vec<u32>> {
    let of_room = |room: usize| {
        let beyond = sides[room].iter().flat_map(|side| sides[*side as usize].iter().copied());
        let is_corner = |to: &u32| {
            let (dx, dy) = apart(rooms, room, *to as usize);
            dx.abs() == 1 && dy.abs() == 1
        };
        let mut list: Vec<u32> = beyond.filter(is_corner).collect();
        list.sort_unstable();
        list.dedup();
        list
    };
    (0..sides.len()).into_par_iter().map(of_room).collect()
}
