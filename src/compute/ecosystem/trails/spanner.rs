//! Which nodes animals walk between without a third: a **spanner** of each territory.

use super::journeys::Journey;
use crate::compute::ecosystem::rag::Territory;

/// The same traffic over fewer edges: a greedy spanner (Althöfer, Das, Dobkin, Joseph and Soares
/// 1993) of the nodes that `journeys` of one territory join. From the shortest on, two nodes get
/// an edge when every way over the edges so far takes more than `detour` times the direct one;
/// then each journey goes over the edges that are quickest in all, and adds its mass to them.
///
/// L 6.1 leaves it to the travel times whether a herd takes "this direct path or … prefers
/// traveling through other resource nodes": this is that choice. Edges are few (a small multiple
/// of the nodes) and short, so their courses can be searched for finely, and what goes to the
/// same far place shares its way there.
pub(crate) fn carried(territory: &Territory, journeys: &[Journey], detour: f64) -> Vec<Journey> {
    let (index, nodes) = match journeys.first() {
        Some(journey) => (journey.territory, ends(journeys)),
        None => return Vec::new(),
    };
    let place = |node: usize| nodes.partition_point(|n| *n < node);
    let cost = |j: &Journey| 0.5 * (territory.time_s(j.from, j.to) + territory.time_s(j.to, j.from));
    let mut pairs: Vec<(f64, usize, usize)> = journeys.iter().map(|j| (cost(j), place(j.from), place(j.to))).collect();
    pairs.retain(|pair| pair.0.is_finite());
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut web = Web::new(nodes.len());
    for (cost, a, b) in pairs {
        if web.cost[a * web.n + b] > detour.max(1.0) * cost {
            web.join(a, b, cost);
        }
    }
    let parents: Vec<Vec<usize>> = (0..nodes.len()).map(|root| web.parents(root)).collect();
    let mut loads = vec![(0.0, 0.0); web.edges.len()];
    for journey in journeys {
        let (root, mut at) = (place(journey.from), place(journey.to));
        while at != root && parents[root][at] != NONE {
            let before = parents[root][at];
            if let Some(edge) = web.edge(before, at) {
                let load = &mut loads[edge];
                let (there, back) = if before < at { (&mut load.0, &mut load.1) } else { (&mut load.1, &mut load.0) };
                *there += journey.there;
                *back += journey.back;
            }
            at = before;
        }
    }
    let edges = web.edges.iter().zip(loads).map(|(&(a, b, _), (there, back))| Journey {
        territory: index,
        from: nodes[a],
        to: nodes[b],
        there,
        back,
    });
    edges.filter(|journey| journey.weight() > 0.0).collect()
}

/// No parent: the root, or a node that is not joined to it.
const NONE: usize = usize::MAX;

/// The nodes that journeys join, ascending.
fn ends(journeys: &[Journey]) -> Vec<usize> {
    let mut ends: Vec<usize> = journeys.iter().flat_map(|j| [j.from, j.to]).collect();
    ends.sort_unstable();
    ends.dedup();
    ends
}

/// The edges so far, and the cheapest cost over them between any two nodes.
struct Web {
    n: usize,
    /// (smaller node, larger node, cost).
    edges: Vec<(usize, usize, f64)>,
    /// The edge between two nodes, or [`NONE`].
    between: Vec<usize>,
    cost: Vec<f64>,
}

impl Web {
    fn new(n: usize) -> Self {
        let mut cost = vec![f64::INFINITY; n * n];
        (0..n).for_each(|i| cost[i * n + i] = 0.0);
        Self { n, edges: Vec::new(), between: vec![NONE; n * n], cost }
    }

    /// Adds an edge, and what it shortens.
    fn join(&mut self, a: usize, b: usize, cost: f64) {
        let n = self.n;
        (self.between[a * n + b], self.between[b * n + a]) = (self.edges.len(), self.edges.len());
        self.edges.push((a.min(b), a.max(b), cost));
        let (from_a, from_b) = (self.cost[a * n..(a + 1) * n].to_vec(), self.cost[b * n..(b + 1) * n].to_vec());
        for i in 0..n {
            let (over_a, over_b) = (from_a[i] + cost, from_b[i] + cost);
            let row = &mut self.cost[i * n..(i + 1) * n];
            for (j, least) in row.iter_mut().enumerate() {
                *least = least.min(over_a + from_b[j]).min(over_b + from_a[j]);
            }
        }
    }

    fn edge(&self, a: usize, b: usize) -> Option<usize> {
        Some(self.between[a * self.n + b]).filter(|edge| *edge != NONE)
    }

    /// The node before each on the cheapest way from `root` (E. W. Dijkstra, 1959; ties by index).
    fn parents(&self, root: usize) -> Vec<usize> {
        let mut best = vec![f64::INFINITY; self.n];
        let mut parents = vec![NONE; self.n];
        let mut open: Vec<usize> = (0..self.n).collect();
        best[root] = 0.0;
        while let Some(k) = (0..open.len()).min_by(|&i, &j| best[open[i]].total_cmp(&best[open[j]]).then(i.cmp(&j))) {
            let here = open.remove(k);
            for &next in &open {
                let Some(edge) = self.edge(here, next) else { continue };
                let reached = best[here] + self.edges[edge].2;
                if reached < best[next] {
                    (best[next], parents[next]) = (reached, here);
                }
            }
        }
        parents
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A territory of places on the plane, walked at 1 m/s, uphill (north) twice as slowly.
    fn territory(places: &[(f64, f64)]) -> Territory {
        let seconds = |a: &(f64, f64), b: &(f64, f64)| {
            let length = libm::hypot(a.0 - b.0, a.1 - b.1);
            (if b.1 > a.1 { 2.0 * length } else { length }) as f32
        };
        let times_s = places.iter().flat_map(|a| places.iter().map(move |b| seconds(a, b))).collect();
        Territory { species: 0, region: 0, nodes: (0..places.len()).collect(), times_s, herds: vec![1] }
    }

    fn all_pairs(n: usize) -> Vec<Journey> {
        let weight = |from: usize, to: usize| ((from * 7 + to * 3) % 5 + 1) as f64;
        let journey =
            |from, to| Journey { territory: 4, from, to, there: weight(from, to), back: 0.5 * weight(to, from) };
        (0..n).flat_map(|from| (from + 1..n).map(move |to| journey(from, to))).collect()
    }

    fn scattered(n: usize) -> Vec<(f64, f64)> {
        (0..n).map(|i| ((i * 7919 % 101) as f64, (i * 104_729 % 97) as f64)).collect()
    }

    #[test]
    fn nodes_in_a_row_are_joined_to_their_neighbours_only() {
        let row: Vec<(f64, f64)> = [3.0, 0.0, 2.0, 1.0].map(|x| (x, 0.0)).into();
        let edges = carried(&territory(&row), &all_pairs(4), 1.01);
        let mut joined: Vec<(usize, usize)> = edges.iter().map(|j| (j.from, j.to)).collect();
        joined.sort_unstable();
        assert_eq!(joined, [(0, 2), (1, 3), (2, 3)]);
        // The middle edge carries all that passes: 0 and 2 on one side, 1 and 3 on the other.
        let middle = edges.iter().find(|j| (j.from, j.to) == (2, 3)).unwrap();
        let passing: f64 = all_pairs(4).iter().filter(|j| (j.from % 2) != (j.to % 2)).map(Journey::weight).sum();
        assert!((middle.weight() - passing).abs() < 1e-9, "{} {passing}", middle.weight());
    }

    #[test]
    fn every_journey_has_a_way_within_the_detour_over_few_edges() {
        let (n, detour) = (50, 1.25);
        let land = territory(&scattered(n));
        let edges = carried(&land, &all_pairs(n), detour);
        assert!(edges.len() < 4 * n, "{}", edges.len());
        let cost = |a: usize, b: usize| 0.5 * (land.time_s(a, b) + land.time_s(b, a));
        let mut best: Vec<Vec<f64>> =
            (0..n).map(|i| (0..n).map(|j| if i == j { 0.0 } else { f64::INFINITY }).collect()).collect();
        edges.iter().for_each(|j| (best[j.from][j.to], best[j.to][j.from]) = (cost(j.from, j.to), cost(j.from, j.to)));
        for k in 0..n {
            for i in 0..n {
                for j in 0..n {
                    best[i][j] = best[i][j].min(best[i][k] + best[k][j]);
                }
            }
        }
        for (i, row) in best.iter().enumerate() {
            assert!(row.iter().enumerate().all(|(j, length)| *length <= detour * cost(i, j) + 1e-9));
        }
    }

    #[test]
    fn what_leaves_and_what_arrives_at_each_node_is_kept() {
        let n = 30;
        let (before, after) = (all_pairs(n), carried(&territory(&scattered(n)), &all_pairs(n), 1.3));
        let net = |journeys: &[Journey], node: usize| {
            let part = |j: &Journey| match node {
                _ if j.from == node => j.there - j.back,
                _ if j.to == node => j.back - j.there,
                _ => 0.0,
            };
            journeys.iter().map(part).sum::<f64>()
        };
        for node in 0..n {
            assert!((net(&before, node) - net(&after, node)).abs() < 1e-6);
        }
        assert!(after.iter().all(|j| j.territory == 4 && j.from < j.to));
    }

    #[test]
    fn no_journeys_and_nodes_out_of_reach_have_no_edges() {
        assert!(carried(&territory(&[(0.0, 0.0)]), &[], 1.2).is_empty());
        let mut apart = territory(&[(0.0, 0.0), (5.0, 0.0), (9.0, 0.0)]);
        for (i, j) in [(0, 2), (2, 0), (1, 2), (2, 1)] {
            apart.times_s[i * 3 + j] = f32::INFINITY;
        }
        let edges = carried(&apart, &all_pairs(3), 1.2);
        assert_eq!(edges.iter().map(|j| (j.from, j.to)).collect::<Vec<_>>(), [(0, 1)]);
    }
}
