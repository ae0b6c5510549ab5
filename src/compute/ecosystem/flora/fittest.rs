//! Competition without targets: in every cell the species that fit best take what there is
//! (L Algorithm 2, T Algorithm 4).
//!
//! A cell is a confinement region of its own for plants, so cells are independent.

use crate::compute::ecosystem::fitness::Fitness;
use crate::compute::ecosystem::flora::rule::FULL_COVER;
use crate::compute::ecosystem::flora::rule::Rule;
use crate::compute::ecosystem::flora::sites::Sites;
use crate::compute::ecosystem::flora::stand::Stand;
use crate::compute::ecosystem::slabs;
use crate::compute::ecosystem::slabs::Slab;
use crate::compute::ecosystem::species::Stratum;
use crate::compute::random::Purpose;
use crate::compute::random::Stream;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;

const TIE: Purpose = Purpose::new("plants.tie");

/// Least cover drawn for at a time (ours): a 64th of a cell, so that a species of tiny units
/// costs no more than one of ordinary ones. Every unit of T table A.1 is larger.
const BUNCH: u16 = FULL_COVER / 64;

/// The cover of every species where nothing but fitness decides.
pub(super) fn compete(
    run: &Run,
    rules: &[Rule],
    sites: &Sites,
    fitness: &Fitness,
    seed: u64,
) -> Result<Vec<Raster<u16>>, Stopped> {
    let grid = sites.light.grid;
    let mut covers = vec![Raster::filled(grid, 0_u16); rules.len()];
    let slabs = slabs::cut(covers.iter_mut().map(|map| map.data.as_mut_slice()), grid.len());
    slabs::each(run, "plants.competition", slabs, |slab| fill(slab, rules, sites, fitness, seed))?;
    Ok(covers)
}

fn fill(mut slab: Slab<u16>, rules: &[Rule], sites: &Sites, fitness: &Fitness, seed: u64) {
    let mut cover = vec![0_u16; rules.len()];
    let mut ranked = Vec::with_capacity(rules.len());
    for (i, cell) in slab.cells.enumerate() {
        rank(fitness, cell, &mut ranked);
        if ranked.is_empty() {
            continue;
        }
        cover.fill(0);
        let ties = Stream::new(seed, TIE, cell as u64);
        Contest { stand: Stand::new(rules, sites.at(cell), &mut cover), rules, ties }.settle(&ranked);
        slab.maps.iter_mut().zip(&cover).filter(|(_, c)| **c > 0).for_each(|(map, c)| map[i] = *c);
    }
}

/// The species that can live in a cell as (fitness level, species), the fittest first.
fn rank(fitness: &Fitness, cell: usize, ranked: &mut Vec<(u8, usize)>) {
    ranked.clear();
    let levels = fitness.levels.iter().map(|map| map.data[cell]);
    ranked.extend(levels.enumerate().filter(|(_, level)| *level > 0).map(|(species, level)| (level, species)));
    ranked.sort_unstable_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
}

/// The competition for one cell.
struct Contest<'a> {
    stand: Stand<'a>,
    rules: &'a [Rule],
    ties: Stream,
}

impl Contest<'_> {
    /// Plants units of the fittest species that still fits, until none does. When lower plants
    /// give way the fittest are asked again, for room and moisture came free. This ends: trees
    /// never give way, between two trees shrubs never do, and between two shrubs herbs never do.
    fn settle(&mut self, ranked: &[(u8, usize)]) {
        let mut first = 0;
        while first < ranked.len() {
            let equal = ranked[first..].iter().take_while(|r| r.0 == ranked[first].0).count();
            let gave_way = match equal {
                1 => self.fill_with(ranked[first].1),
                _ => self.fill_drawn(ranked[first..first + equal].iter().map(|r| r.1).collect()),
            };
            first = if gave_way { 0 } else { first + equal };
        }
    }

    /// Plants one species until it no longer fits or others gave way to it.
    fn fill_with(&mut self, species: usize) -> bool {
        let about = if self.rules[species].stratum == Stratum::Herb { FULL_COVER } else { 0 };
        loop {
            match self.stand.units(species, about) {
                0 => return false,
                cover if self.stand.plant(species, cover) => return true,
                _ => {}
            }
        }
    }

    /// Plants species of equal fitness, each unit's drawn by hash, until none fits or others
    /// gave way.
    fn fill_drawn(&mut self, mut equal: Vec<usize>) -> bool {
        while !equal.is_empty() {
            let drawn = self.ties.below(equal.len());
            match self.stand.units(equal[drawn], BUNCH) {
                0 => _ = equal.swap_remove(drawn),
                cover if self.stand.plant(equal[drawn], cover) => return true,
                _ => {}
            }
        }
        false
    }
}
