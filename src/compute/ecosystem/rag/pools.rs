//! How many nodes each resource gets in each region, so that no territory has too many to plan.

use super::NodeOptions;
use super::Resource;
use super::atoms::Atoms;
use crate::compute::ecosystem::species::Food;
use std::collections::BTreeMap;

/// A **pool**: all of one resource that the same species reach, in the same of their regions.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Pool {
    /// What it offers.
    pub(crate) resource: Resource,
    /// The parts of the partition it lies in, ascending.
    pub(crate) parts: Vec<u32>,
    /// Indices of its nodes in the graph.
    pub(crate) nodes: std::ops::Range<usize>,
    /// Sum of the quantities of its nodes, kg a year.
    pub(crate) kg: f64,
    /// The territories (species, region) that use it, ascending.
    pub(crate) users: Vec<(usize, usize)>,
}

/// A group of a resource before its nodes are made.
#[derive(Debug, Clone)]
pub(super) struct Group {
    /// Index of the resource in the level's list.
    pub(super) resource: usize,
    /// Number of the group within the resource.
    pub(super) group: u32,
    /// Its atoms, ascending.
    pub(super) atoms: Vec<usize>,
    pub(super) cells: u64,
    pub(super) kg: f64,
    /// Nodes it is to have.
    pub(super) nodes: usize,
    /// The territories (species, region) that use it, ascending.
    pub(super) users: Vec<(usize, usize)>,
}

/// The groups of a resource that have any atoms, by number.
pub(super) fn groups_of(resource: usize, atoms: &Atoms, groups: usize) -> Vec<Group> {
    let empty = |group| Group { resource, group, atoms: Vec::new(), cells: 0, kg: 0.0, nodes: 0, users: Vec::new() };
    let mut all: Vec<Group> = (0..groups as u32).map(empty).collect();
    for (i, atom) in atoms.atoms.iter().enumerate() {
        let group = &mut all[atom.group as usize];
        group.atoms.push(i);
        group.cells += u64::from(atom.cells);
        group.kg += atom.kg;
    }
    all.retain(|group| group.cells > 0);
    all
}

/// Where a species lives, and the groups (by index) that it can use there.
pub(super) type Reach = BTreeMap<(usize, usize), Vec<usize>>;

/// Decides who uses which group, and the number of nodes of each, so that no territory has more
/// nodes than [`NodeOptions::max_nodes`].
///
/// 1. Where the regions of other species cut a territory into more groups than half of that, its
///    species leaves those alone that hold least, so that the rest can be split. Others may still
///    use them; what nobody uses gets no nodes.
/// 2. The groups get the more nodes the larger they are, at least one each.
pub(super) fn allot(groups: &mut [Group], kinds: &[Resource], reach: &Reach, options: &NodeOptions) {
    let kept: Reach = reach
        .iter()
        .map(|(home, list)| (*home, main_groups(groups, kinds, list, options.max_nodes.div_ceil(2))))
        .collect();
    for (home, list) in &kept {
        list.iter().for_each(|g| groups[*g].users.push(*home));
    }
    let cells: u64 = groups.iter().map(|g| g.cells).max().unwrap_or(0);
    let mut patch = cells as f64 / options.max_nodes.max(1) as f64;
    let splits = |group: &Group, patch: f64| match kinds[group.resource] {
        _ if group.users.is_empty() => 0,
        Resource::Food(Food::Animal(_)) | Resource::WayPoint(_) => 1,
        // A bank is a line: a patch of a side √patch holds about that many cells of it.
        Resource::Water => (group.cells as f64 / patch.sqrt().max(1.0)).round().max(1.0) as usize,
        Resource::Food(_) => (group.cells as f64 / patch.max(1.0)).round().max(1.0) as usize,
    };
    for _ in 0..200 {
        let total = |t: &Vec<usize>| t.iter().map(|g| splits(&groups[*g], patch)).sum::<usize>();
        if kept.values().all(|t| total(t) <= options.max_nodes) {
            break;
        }
        patch = 1.25 * patch.max(1.0);
    }
    groups.iter_mut().for_each(|group| group.nodes = splits(group, patch));
}

/// At most `most` groups of a territory (at least one), ascending: left out are first those that
/// hold the least share of their resource there (of food by kg, of water by length of bank). The
/// largest group of each resource stays to the last.
fn main_groups(groups: &[Group], kinds: &[Resource], territory: &[usize], most: usize) -> Vec<usize> {
    let amount = |g: usize| match kinds[groups[g].resource] {
        Resource::Water | Resource::WayPoint(_) => groups[g].cells as f64,
        Resource::Food(_) => groups[g].kg,
    };
    let mut sums = vec![(0.0, 0.0_f64); kinds.len()];
    for &g in territory {
        let (sum, largest) = &mut sums[groups[g].resource];
        *sum += amount(g);
        *largest = largest.max(amount(g));
    }
    let rank = |g: usize| {
        let (sum, largest) = sums[groups[g].resource];
        let share = if sum > 0.0 { amount(g) / sum } else { 0.0 };
        (amount(g) >= largest, share, g)
    };
    let mut order: Vec<(bool, f64, usize)> = territory.iter().map(|g| rank(*g)).collect();
    order.sort_by(|a, b| b.0.cmp(&a.0).then(b.1.total_cmp(&a.1)).then(a.2.cmp(&b.2)));
    let mut kept: Vec<usize> = order.into_iter().take(most.max(1)).map(|(_, _, g)| g).collect();
    kept.sort_unstable();
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    const KINDS: [Resource; 2] = [Resource::Water, Resource::Food(Food::Plant(0))];

    fn group(resource: usize, group: u32, cells: u64, kg: f64) -> Group {
        Group { resource, group, atoms: Vec::new(), cells, kg, nodes: 0, users: Vec::new() }
    }

    /// A hundred scraps of water, of which the seventh is a lake, and ten meadows.
    fn scraps() -> Vec<Group> {
        let water = (0..100).map(|i| group(0, i, 1 + u64::from(i == 7) * 500, f64::INFINITY));
        water.chain((0..10).map(|i| group(1, i, 50, 1.0 + 100.0 * f64::from(i)))).collect()
    }

    #[test]
    fn many_scraps_of_water_do_not_cost_a_territory_its_food() {
        let territory: Vec<usize> = (0..110).collect();
        let kept = main_groups(&scraps(), &KINDS, &territory, 12);
        assert_eq!(kept.len(), 12);
        assert!(kept.contains(&7) && kept.contains(&109) && kept.iter().filter(|g| **g >= 100).count() >= 8);
    }

    #[test]
    fn what_one_territory_leaves_alone_another_keeps() {
        let mut groups = scraps();
        let reach = Reach::from([((0, 0), (0..110).collect()), ((1, 4), vec![55, 100])]);
        allot(&mut groups, &KINDS, &reach, &NodeOptions { min_area_m2: 0.0, max_nodes: 24 });
        assert_eq!((groups[55].users.as_slice(), groups[55].nodes), (&[(1, 4)][..], 1));
        assert_eq!(groups[54].nodes, 0, "nobody uses it");
        let of_first = |g: &&Group| g.users.contains(&(0, 0));
        assert!(groups.iter().filter(of_first).map(|g| g.nodes).sum::<usize>() <= 24);
    }
}
