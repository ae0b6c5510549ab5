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
/// has more than [`NodeOptions::max_nodes`]: the more area, the more nodes; at least one each.
/// Where that is still too many, the groups that offer least are dropped (0 nodes), water last.
pub(super) fn allot(groups: &mut [Group], kinds: &[Resource], territories: &[Vec<usize>], options: &NodeOptions) {
    let cells: u64 = groups.iter().map(|g| g.cells).max().unwrap_or(0);
    let mut patch = cells as f64 / options.max_nodes.max(1) as f64;
    let splits = |group: &Group, patch: f64| match kinds[group.resource] {
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
    for territory in territories {
        drop_excess(groups, kinds, territory, options.max_nodes);
    }
}

fn drop_excess(groups: &mut [Group], kinds: &[Resource], territory: &[usize], max_nodes: usize) {
    let count: usize = territory.iter().map(|g| groups[*g].nodes).sum();
    if count <= max_nodes {
        return;
    }
    let mut order = territory.to_vec();
    let is_water = |g: usize| kinds[groups[g].resource] == Resource::Water;
    order.sort_by(|a, b| is_water(*a).cmp(&is_water(*b)).then(groups[*a].kg.total_cmp(&groups[*b].kg)).then(a.cmp(b)));
    let mut left = count;
    for g in order {
        if left <= max_nodes.max(1) {
            break;
        }
        left -= std::mem::take(&mut groups[g].nodes);
    }
}
