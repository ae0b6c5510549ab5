//! How many nodes each resource gets in each region, so that no territory has too many to plan.

use super::NodeOptions;
use super::Resource;
use super::atoms::Atoms;

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
}

/// The groups of a resource that have any atoms, by number.
pub(super) fn groups_of(resource: usize, atoms: &Atoms, groups: usize) -> Vec<Group> {
    let empty = |group| Group { resource, group, atoms: Vec::new(), cells: 0, kg: 0.0, nodes: 1 };
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

/// Decides the number of nodes of each group so that no territory (a list of indices of groups)
/// has more than [`NodeOptions::max_nodes`].
///
/// 1. Where the regions of other species cut a territory into more groups than half of that, the
///    groups that hold least are left out (0 nodes), so that the rest can be split.
/// 2. The others get the more nodes the larger they are, at least one each.
pub(super) fn allot(groups: &mut [Group], kinds: &[Resource], territories: &[Vec<usize>], options: &NodeOptions) {
    for territory in territories {
        drop_excess(groups, kinds, territory, options.max_nodes.div_ceil(2));
    }
    let cells: u64 = groups.iter().map(|g| g.cells).max().unwrap_or(0);
    let mut patch = cells as f64 / options.max_nodes.max(1) as f64;
    let splits = |group: &Group, patch: f64| match kinds[group.resource] {
        _ if group.nodes == 0 => 0,
        Resource::Food(crate::compute::ecosystem::species::Food::Animal(_)) => 1,
        // A bank is a line: a patch of a side √patch holds about that many cells of it.
        Resource::Water => (group.cells as f64 / patch.sqrt().max(1.0)).round().max(1.0) as usize,
        Resource::Food(_) => (group.cells as f64 / patch.max(1.0)).round().max(1.0) as usize,
    };
    for _ in 0..200 {
        let total = |t: &Vec<usize>| t.iter().map(|g| splits(&groups[*g], patch)).sum::<usize>();
        if territories.iter().all(|t| total(t) <= options.max_nodes) {
            break;
        }
        patch = 1.25 * patch.max(1.0);
    }
    groups.iter_mut().for_each(|group| group.nodes = splits(group, patch));
}

/// Leaves out groups of a territory until it has few enough nodes: first those that hold the
/// least share of their resource there (of food by kg, of water by length of bank), so that where
/// other species' regions cut a territory into many groups, the small ones go. The largest group of
/// each resource stays to the last.
fn drop_excess(groups: &mut [Group], kinds: &[Resource], territory: &[usize], max_nodes: usize) {
    let mut left: usize = territory.iter().map(|g| groups[*g].nodes).sum();
    if left <= max_nodes {
        return;
    }
    let amount = |g: usize| match kinds[groups[g].resource] {
        Resource::Water => groups[g].cells as f64,
        Resource::Food(_) => groups[g].kg,
    };
    let mut sums = vec![(0.0, 0.0_f64); kinds.len()];
    for &g in territory {
        let (sum, most) = &mut sums[groups[g].resource];
        *sum += amount(g);
        *most = most.max(amount(g));
    }
    let rank = |g: usize| {
        let (sum, most) = sums[groups[g].resource];
        let share = if sum > 0.0 { amount(g) / sum } else { 0.0 };
        (amount(g) >= most, share, g)
    };
    let mut order: Vec<(bool, f64, usize)> = territory.iter().map(|g| rank(*g)).collect();
    order.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    for (_, _, g) in order {
        if left <= max_nodes.max(1) {
            break;
        }
        left -= std::mem::take(&mut groups[g].nodes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::ecosystem::species::Food;

    #[test]
    fn many_scraps_of_water_do_not_cost_a_territory_its_food() {
        let kinds = [Resource::Water, Resource::Food(Food::Plant(0))];
        let group = |resource, group: u32, cells, kg| Group { resource, group, atoms: Vec::new(), cells, kg, nodes: 1 };
        let mut groups: Vec<Group> =
            (0..100).map(|i| group(0, i, 1 + u64::from(i == 7) * 500, f64::INFINITY)).collect();
        groups.extend((0..10).map(|i| group(1, i, 50, 1.0 + 100.0 * f64::from(i))));
        let territory: Vec<usize> = (0..groups.len()).collect();
        drop_excess(&mut groups, &kinds, &territory, 12);
        let kept = |resource: usize| groups.iter().filter(|g| g.resource == resource && g.nodes > 0).count();
        assert_eq!(kept(0) + kept(1), 12);
        assert!(groups[7].nodes > 0 && groups[109].nodes > 0 && kept(1) >= 8, "{} {}", kept(0), kept(1));
    }
}
