//! The nodes of one level of the graph (L 5.2): the banks where its species drink, and what they
//! eat, each cut at the borders of the regions of those who use it.

use super::Area;
use super::Node;
use super::NodeOptions;
use super::Resource;
use super::atoms::Atoms;
use super::field::Field;
use super::patches::patches_of;
use super::pools::Group;
use super::pools::Pool;
use super::pools::Reach;
use super::pools::allot;
use super::pools::groups_of;
use crate::compute::ecosystem::regions::NOWHERE;
use crate::compute::ecosystem::regions::Regions;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// A resource of the level, where it is, and which species use it.
pub(crate) struct Offer<'a> {
    pub(crate) resource: Resource,
    pub(crate) users: Vec<usize>,
    pub(crate) field: Field<'a>,
}

/// The nodes of a level and the pools they belong to, both in the order of the offers.
pub(crate) struct LevelNodes {
    pub(crate) nodes: Vec<Node>,
    pub(crate) pools: Vec<Pool>,
}

/// Groups the parts by the regions that `users` find them in and by `kind`; parts that none of
/// them reaches, or of no kind, are [`NOWHERE`]. Groups are numbered by their first part.
pub(crate) fn group_parts(regions: &Regions, users: &[usize], kind: impl Fn(usize) -> Option<u32>) -> Vec<u32> {
    let mut numbers: BTreeMap<(u32, Vec<Option<usize>>), u32> = BTreeMap::new();
    let group = |part: usize| {
        let reached: Vec<Option<usize>> = users.iter().map(|s| regions.region_of_part(*s, part)).collect();
        let (Some(kind), true) = (kind(part), reached.iter().any(Option::is_some)) else { return NOWHERE };
        let next = numbers.len() as u32;
        *numbers.entry((kind, reached)).or_insert(next)
    };
    (0..regions.parts()).map(group).collect()
}

/// Makes the nodes of `level` from its `offers`; `first` is the number of the first of them in the
/// graph.
///
/// Every cell of a pool belongs to exactly one of its nodes, so that what the nodes offer adds up
/// to the pool. Pools of food smaller than [`NodeOptions::min_area_m2`], and the least ones of
/// territories with too many, are left out: nobody eats there and it stays surplus.
pub(crate) fn level_nodes(
    offers: &[Offer<'_>],
    regions: &Regions,
    (level, first): (usize, usize),
    options: &NodeOptions,
    run: &Run,
) -> Result<LevelNodes, Stopped> {
    let atoms: Vec<Atoms> =
        offers.par_iter().map(|offer| Atoms::gather(&offer.field, regions, run)).collect::<Result<_, _>>()?;
    let groups = plan(offers, &atoms, regions, options);
    let min_cells = min_cells(regions, options);
    let of_offer = |o: usize| groups.iter().filter(move |g| g.resource == o);
    let made: Vec<Made<'_>> = (0..offers.len())
        .into_par_iter()
        .map(|o| make(&offers[o], &atoms[o], of_offer(o), (regions, min_cells), run))
        .collect::<Result<_, _>>()?;
    Ok(assemble(offers, made, regions, (level, first)))
}

fn min_cells(regions: &Regions, options: &NodeOptions) -> u32 {
    (options.min_area_m2 / regions.grid().cell_area_m2()).ceil().clamp(1.0, 1e9) as u32
}

/// The groups that get nodes, by offer, then number.
fn plan(offers: &[Offer<'_>], atoms: &[Atoms], regions: &Regions, options: &NodeOptions) -> Vec<Group> {
    let kinds: Vec<Resource> = offers.iter().map(|offer| offer.resource).collect();
    let count =
        |offer: &Offer<'_>| offer.field.group.iter().filter(|g| **g != NOWHERE).max().map_or(0, |g| *g as usize + 1);
    let least = u64::from(min_cells(regions, options));
    let mut groups: Vec<Group> = (0..offers.len())
        .flat_map(|o| groups_of(o, &atoms[o], count(&offers[o])))
        .filter(|g| kinds[g.resource] == Resource::Water || g.cells >= least)
        .collect();
    let reach = reach(offers, &groups, regions);
    allot(&mut groups, &kinds, &reach, options);
    groups.retain(|group| group.nodes > 0);
    groups
}

/// For each species and region, the groups it can use.
fn reach(offers: &[Offer<'_>], groups: &[Group], regions: &Regions) -> Reach {
    let mut lists = Reach::new();
    for (g, group) in groups.iter().enumerate() {
        let offer = &offers[group.resource];
        let Some(part) = offer.field.group.iter().position(|n| *n == group.group) else { continue };
        for species in &offer.users {
            if let Some(region) = regions.region_of_part(*species, part) {
                lists.entry((*species, region)).or_default().push(g);
            }
        }
    }
    lists
}

/// The nodes of one offer, group by group.
struct Made<'a> {
    pieces: Vec<Piece>,
    /// Each group, and how many of the pieces are its.
    groups: Vec<(&'a Group, usize)>,
}

/// A node in the making.
#[derive(Debug, Clone, Default)]
struct Piece {
    area: Area,
    cells: u64,
    kg: f64,
    columns: f64,
    rows: f64,
    /// Squared distance from the centroid of the nearest cell, and that cell.
    nearest: Option<(f64, usize)>,
}

fn make<'g>(
    offer: &Offer<'_>,
    atoms: &Atoms,
    groups: impl Iterator<Item = &'g Group>,
    (regions, min_cells): (&Regions, u32),
    run: &Run,
) -> Result<Made<'g>, Stopped> {
    let mut made = Made { pieces: Vec::new(), groups: Vec::new() };
    let mut piece_of_atom = vec![NOWHERE; atoms.atoms.len()];
    for group in groups {
        let first = made.pieces.len();
        let patches = patches_of(atoms, &group.atoms, group.nodes, min_cells);
        let count = patches.iter().max().map_or(0, |n| n + 1);
        made.pieces.resize(first + count, Piece::default());
        for (atom, patch) in group.atoms.iter().zip(patches) {
            piece_of_atom[*atom] = (first + patch) as u32;
            let (piece, atom) = (&mut made.pieces[first + patch], &atoms.atoms[*atom]);
            piece.cells += u64::from(atom.cells);
            piece.kg += atom.kg;
            piece.columns += atom.columns;
            piece.rows += atom.rows;
        }
        made.groups.push((group, count));
    }
    outline(offer, atoms, &piece_of_atom, (regions, &mut made.pieces), run)?;
    Ok(made)
}

/// Writes the cells of every piece, and finds the one nearest its centroid.
fn outline(
    offer: &Offer<'_>,
    atoms: &Atoms,
    piece_of_atom: &[u32],
    (regions, pieces): (&Regions, &mut [Piece]),
    run: &Run,
) -> Result<(), Stopped> {
    let grid = regions.grid();
    let shift = atoms.tiles.shift;
    let mut buffer = vec![0.0; grid.width];
    for row in 0..grid.height {
        run.check()?;
        let mut last = (usize::MAX, NOWHERE, NOWHERE);
        offer.field.visit_row(regions, row, &mut buffer, |column, _, group, _| {
            let tile = (row >> shift) * atoms.tiles.columns + (column >> shift);
            if (last.0, last.1) != (tile, group) {
                last = (tile, group, atoms.find(tile, group).map_or(NOWHERE, |atom| piece_of_atom[atom]));
            }
            if last.2 != NOWHERE {
                pieces[last.2 as usize].add(grid.index(column, row), (column as f64, row as f64));
            }
        });
    }
    Ok(())
}

impl Piece {
    fn add(&mut self, cell: usize, (column, row): (f64, f64)) {
        self.area.push(cell);
        let n = self.cells as f64;
        let distance = (self.columns / n - column).powi(2) + (self.rows / n - row).powi(2);
        if self.nearest.is_none_or(|(least, _)| distance < least) {
            self.nearest = Some((distance, cell));
        }
    }
}

fn assemble(
    offers: &[Offer<'_>],
    made: Vec<Made<'_>>,
    regions: &Regions,
    (level, first): (usize, usize),
) -> LevelNodes {
    let grid = regions.grid();
    let mut out = LevelNodes { nodes: Vec::new(), pools: Vec::new() };
    for (offer, made) in offers.iter().zip(made) {
        let mut pieces = made.pieces.into_iter();
        for (group, count) in made.groups {
            let start = first + out.nodes.len();
            let of_group = |(part, g): (usize, &u32)| (*g == group.group).then_some(part as u32);
            let parts = offer.field.group.iter().enumerate().filter_map(of_group).collect();
            let mut kg = 0.0;
            for piece in pieces.by_ref().take(count) {
                let cell = piece.nearest.map_or(0, |(_, cell)| cell);
                let quantity_kg = if offer.resource == Resource::Water { f64::INFINITY } else { piece.kg };
                kg += quantity_kg;
                out.nodes.push(Node {
                    level,
                    resource: offer.resource,
                    area: piece.area,
                    cell,
                    place: grid.centre(cell),
                    area_m2: piece.cells as f64 * grid.cell_area_m2(),
                    quantity_kg,
                    draws: 0.0,
                    below: Vec::new(),
                });
            }
            let (nodes, users) = (start..first + out.nodes.len(), group.users.clone());
            out.pools.push(Pool { resource: offer.resource, parts, nodes, kg, users });
        }
    }
    out
}
