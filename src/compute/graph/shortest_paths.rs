//! **Shortest paths** from one place to all others over a directed graph that lists its edges
//! on demand (E. W. Dijkstra, 1959), with a bucket queue.

use super::dial_queue::DialQueue;
use crate::compute::run::Run;
use crate::compute::run::Stopped;

/// Nodes taken from the queue between two looks at the stop flag.
const LOOK: usize = 4096;

/// A directed graph with costs.
pub trait Network {
    /// Number of nodes, below 2³².
    fn len(&self) -> usize;

    /// Whether there are no nodes.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Calls `visit(mark, target, cost)` for each edge that leaves `node`; costs are positive
    /// (infinite ones are ignored), and `mark` tells [`Network::origin`] where the edge came from.
    fn edges(&self, node: usize, visit: impl FnMut(u16, usize, f32));

    /// Where the edge with this `mark` that arrives at `node` came from.
    fn origin(&self, node: usize, mark: u16) -> usize;

    /// About the cost of a cheap edge: the width of a bucket. Any positive value gives the same
    /// costs; much above the cheapest edge nodes are expanded more than once.
    fn cheap_edge(&self) -> f32;
}

/// What to search for.
#[derive(Debug, Clone, Copy)]
pub struct Quest<'a> {
    /// Where paths start, each with the cost it starts with.
    pub sources: &'a [(usize, f32)],
    /// The search may end once all of these have their final cost; empty: it goes on to the end.
    pub targets: &'a [usize],
}

/// The cheapest paths found.
#[derive(Debug, Clone)]
pub struct Reached {
    /// Cost per node; infinite where no path was found. With targets only theirs, and those of
    /// the nodes on the way to them, are final.
    pub cost: Vec<f32>,
    mark: Vec<u16>,
}

const START: u16 = u16::MAX;

impl Reached {
    /// The nodes of the cheapest path to `node`, source first; empty where there is none.
    pub fn path(&self, network: &impl Network, node: usize) -> Vec<usize> {
        if !self.cost[node].is_finite() {
            return Vec::new();
        }
        let mut path = vec![node];
        let mut at = node;
        while self.mark[at] != START && path.len() <= self.cost.len() {
            at = network.origin(at, self.mark[at]);
            path.push(at);
        }
        path.reverse();
        path
    }
}

/// Cheapest costs from the sources of `quest` over `network`.
///
/// Exact up to the rounding of 32-bit sums. Sequential, so the same on any number of threads.
pub fn shortest_paths(network: &impl Network, quest: Quest<'_>, run: &Run) -> Result<Reached, Stopped> {
    let mut found = Reached { cost: vec![f32::INFINITY; network.len()], mark: vec![START; network.len()] };
    let width = network.cheap_edge();
    let mut queue = DialQueue::new(width);
    for &(node, cost) in quest.sources {
        if cost < found.cost[node] {
            found.cost[node] = cost;
            queue.push(cost, node as u32);
        }
    }
    let mut waiting = Waiting::new(network.len(), quest.targets);
    let mut taken = 0usize;
    while let Some((key, node)) = queue.pop() {
        let node = node as usize;
        if key > found.cost[node] {
            continue;
        }
        if waiting.all_reached_below(key - width, node, &found.cost) {
            break;
        }
        taken += 1;
        if taken.is_multiple_of(LOOK) {
            run.check()?;
        }
        network.edges(node, |mark, target, cost| {
            let reached = key + cost;
            if reached < found.cost[target] {
                found.cost[target] = reached;
                found.mark[target] = mark;
                queue.push(reached, target as u32);
            }
        });
    }
    Ok(found)
}

/// Targets that are not reached yet.
struct Waiting {
    is_target: Vec<bool>,
    targets: Vec<usize>,
    left: usize,
}

impl Waiting {
    fn new(nodes: usize, targets: &[usize]) -> Self {
        let mut is_target = vec![false; if targets.is_empty() { 0 } else { nodes }];
        targets.iter().for_each(|t| is_target[*t] = true);
        let mut targets = targets.to_vec();
        targets.sort_unstable();
        targets.dedup();
        Self { is_target, left: targets.len(), targets }
    }

    /// Notes that `node` was taken; whether every target has a cost of at most `key`.
    fn all_reached_below(&mut self, key: f32, node: usize, cost: &[f32]) -> bool {
        if self.targets.is_empty() {
            return false;
        }
        if self.is_target[node] {
            self.is_target[node] = false;
            self.left -= 1;
        }
        self.left == 0 && self.targets.iter().all(|t| cost[*t] <= key)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::random::Purpose;
    use crate::compute::random::Stream;

    /// A complete directed graph; the mark of an edge is its origin.
    struct Table(Vec<Vec<f32>>);

    impl Network for Table {
        fn len(&self) -> usize {
            self.0.len()
        }
        fn edges(&self, node: usize, mut visit: impl FnMut(u16, usize, f32)) {
            self.0[node].iter().enumerate().for_each(|(to, cost)| visit(node as u16, to, *cost));
        }
        fn origin(&self, _: usize, mark: u16) -> usize {
            usize::from(mark)
        }
        fn cheap_edge(&self) -> f32 {
            0.3
        }
    }

    fn random_table(n: usize, seed: u64) -> Table {
        let mut stream = Stream::new(seed, Purpose::new("test.paths"), 0);
        let mut cost = || {
            let u = stream.unit();
            if u < 0.8 { f32::INFINITY } else { (0.01 + 20.0 * u * stream.unit()) as f32 }
        };
        Table((0..n).map(|_| (0..n).map(|_| cost()).collect()).collect())
    }

    /// Bellman and Ford: the plainest exact method.
    fn plain(table: &Table, source: usize) -> Vec<f32> {
        let n = table.len();
        let mut cost = vec![f32::INFINITY; n];
        cost[source] = 0.0;
        for _ in 0..n {
            for a in 0..n {
                for b in 0..n {
                    cost[b] = cost[b].min(cost[a] + table.0[a][b]);
                }
            }
        }
        cost
    }

    #[test]
    fn costs_equal_those_of_the_plainest_method_with_and_without_targets() {
        for seed in 0..20 {
            let table = random_table(40, seed);
            let exact = plain(&table, 3);
            let all = Quest { sources: &[(3, 0.0)], targets: &[] };
            assert_eq!(shortest_paths(&table, all, &Run::silent()).unwrap().cost, exact);
            let two = Quest { sources: &[(3, 0.0)], targets: &[7, 20] };
            let found = shortest_paths(&table, two, &Run::silent()).unwrap();
            assert_eq!((found.cost[7], found.cost[20]), (exact[7], exact[20]));
        }
    }

    #[test]
    fn a_path_adds_up_to_its_cost() {
        let table = random_table(40, 99);
        let found = shortest_paths(&table, Quest { sources: &[(0, 0.0)], targets: &[] }, &Run::silent()).unwrap();
        for node in 0..40 {
            let path = found.path(&table, node);
            let sum = path.windows(2).fold(0.0f32, |sum, w| sum + table.0[w[0]][w[1]]);
            assert_eq!(path.is_empty(), !found.cost[node].is_finite());
            assert!(path.is_empty() || (path[0] == 0 && sum == found.cost[node]));
        }
    }

    #[test]
    fn a_stopped_search_ends() {
        let flag = crate::compute::run::StopFlag::default();
        flag.stop();
        struct Line;
        impl Network for Line {
            fn len(&self) -> usize {
                100_000
            }
            fn edges(&self, node: usize, mut visit: impl FnMut(u16, usize, f32)) {
                if node + 1 < self.len() {
                    visit(0, node + 1, 1.0);
                }
            }
            fn origin(&self, node: usize, _: u16) -> usize {
                node - 1
            }
            fn cheap_edge(&self) -> f32 {
                1.0
            }
        }
        let quest = Quest { sources: &[(0, 0.0)], targets: &[] };
        assert!(shortest_paths(&Line, quest, &Run::stoppable(flag)).is_err());
    }
}
