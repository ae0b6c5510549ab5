//! Optimal assignment: who goes where, at the least total cost.
//!
//! Places are assigned to places; the cost of a pair grows with the distance between them. Up to
//! [`EXACT_UP_TO`] pairs by shortest augmenting paths (`lsap`, exact, a cost matrix in memory);
//! above by the auction algorithm with ε-scaling (Bertsekas 1988), in which every bid finds the
//! two columns of most value in a tree over places and prices instead of looking at all.

mod price_tree;

use crate::compute::geometry::Bounds;
use crate::compute::geometry::Point;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use price_tree::Offer;
use price_tree::PriceTree;

/// The most pairs that are assigned by shortest augmenting paths.
pub const EXACT_UP_TO: usize = 1000;

/// An auction ends when its total is proven to be within this share of the least one, ...
const SHARE: f64 = 1e-5;

/// ... or within this share of the cost of the longest way there is: where the least total is
/// next to nothing, no share of it will be reached.
const SHARE_OF_LONGEST: f64 = 1e-8;

/// Each round of an auction bids this many times finer than the one before (Bertsekas advises 4
/// to 10).
const SCALING: f64 = 5.0;

/// Why there is no assignment.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum AssignmentError {
    /// A place or a cost is not a finite number.
    #[error("the cost of giving {column} to {row} is not a finite number")]
    BadCost {
        /// Who.
        row: usize,
        /// What.
        column: usize,
    },
    /// The work was stopped.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}

/// Who goes where.
#[derive(Debug, Clone, PartialEq)]
pub struct Assignment {
    /// For each row its column, each taken once.
    pub columns: Vec<usize>,
    /// The total cost is the least possible, or above it by at most this: 0 from the exact
    /// solver, from an auction the gap to the bound that its prices prove.
    pub gap: f64,
}

/// Assigns each place of `from` one of `to`, of equal number, so that the sum of `cost(squared
/// distance)` is least: exactly up to [`EXACT_UP_TO`] places, above as [`auction`] does. `cost`
/// must not fall with the distance.
///
/// # Errors
/// A place or cost that is not finite, or a stop.
pub fn assign(
    from: &[Point],
    to: &[Point],
    cost: impl Fn(f64) -> f64,
    run: &Run,
) -> Result<Assignment, AssignmentError> {
    if from.len() > EXACT_UP_TO {
        return auction(from, to, cost, run);
    }
    let columns = exact(from.len(), |row, column| cost(from[row].distance_sq(to[column])))?;
    Ok(Assignment { columns, gap: 0.0 })
}

/// The assignment of least cost, by shortest augmenting paths in O(n³).
///
/// # Errors
/// A cost that is not finite.
pub fn exact(n: usize, cost: impl Fn(usize, usize) -> f64) -> Result<Vec<usize>, AssignmentError> {
    let matrix: Vec<f64> = (0..n * n).map(|k| cost(k / n, k % n)).collect();
    if let Some(k) = matrix.iter().position(|c| !c.is_finite()) {
        return Err(AssignmentError::BadCost { row: k / n, column: k % n });
    }
    // All costs are finite and the matrix is square: neither of lsap's errors can occur.
    let columns = lsap::solve(n, n, &matrix, false).map(|(_, columns)| columns);
    Ok(columns.unwrap_or_else(|_| (0..n).collect()))
}

/// An assignment whose total exceeds the least by at most 10⁻⁵ of it (or 10⁻⁸ of the cost of the
/// longest way, where that is more), and by how much at most, as its prices prove.
///
/// Forward auction: a row without a column bids for the one of most value to it (least cost plus
/// price) and raises its price by its lead over the second best plus ε, until all have one; then
/// again with a finer ε, from the prices so far, for those who would rather have another. Every
/// bid raises a price by at least ε and prices are bounded by the range, so it ends.
///
/// # Errors
/// A place or cost that is not finite, or a stop.
pub fn auction(
    from: &[Point],
    to: &[Point],
    cost: impl Fn(f64) -> f64,
    run: &Run,
) -> Result<Assignment, AssignmentError> {
    let highest = highest_cost(from, to, &cost)?;
    if highest <= 0.0 {
        // All places are one, or ways cost nothing.
        return Ok(Assignment { columns: (0..from.len()).collect(), gap: 0.0 });
    }
    let enough = SHARE_OF_LONGEST * highest;
    let mut market = Market::new(from, to);
    let mut epsilon = highest / SCALING;
    loop {
        market.round(&cost, epsilon, run)?;
        let (total, gap) = market.total_and_gap(&cost);
        // After a round the gap is at most ε a row: the second test ends it whatever comes.
        if gap <= SHARE * (total - gap) || epsilon * from.len() as f64 <= enough {
            return Ok(Assignment { columns: market.goods.iter().map(|good| *good as usize).collect(), gap });
        }
        epsilon /= SCALING;
    }
}

/// The cost of the longest way in the bounds of all places.
fn highest_cost(from: &[Point], to: &[Point], cost: &impl Fn(f64) -> f64) -> Result<f64, AssignmentError> {
    let broken = |places: &[Point]| places.iter().position(|p| !p.is_finite());
    let (row, column) = (broken(from), broken(to));
    if row.is_some() || column.is_some() {
        return Err(AssignmentError::BadCost { row: row.unwrap_or(0), column: column.unwrap_or(0) });
    }
    let bounds = Bounds::of(from.iter().chain(to).copied());
    let highest = bounds.map_or(0.0, |b| cost(b.min.distance_sq(b.max)));
    if highest.is_finite() { Ok(highest) } else { Err(AssignmentError::BadCost { row: 0, column: 0 }) }
}

const NOBODY: u32 = u32::MAX;

/// Bids between two looks at the stop flag.
const LOOK_EVERY: u32 = 1024;

/// Rows and columns on the way to an assignment.
struct Market<'a> {
    rows: &'a [Point],
    tree: PriceTree,
    /// The row that has each column.
    owners: Vec<u32>,
    /// The column that each row has.
    goods: Vec<u32>,
}

impl<'a> Market<'a> {
    fn new(rows: &'a [Point], columns: &[Point]) -> Self {
        let nobody = vec![NOBODY; rows.len()];
        Self { rows, tree: PriceTree::new(columns), owners: nobody.clone(), goods: nobody }
    }

    /// One auction from the prices so far. Who is still content within ε keeps what it has.
    fn round(&mut self, cost: &impl Fn(f64) -> f64, epsilon: f64, run: &Run) -> Result<(), AssignmentError> {
        let mut bidders: Vec<u32> =
            (0..self.rows.len() as u32).rev().filter(|row| !self.is_content(*row, cost, epsilon)).collect();
        for row in &bidders {
            let good = std::mem::replace(&mut self.goods[*row as usize], NOBODY);
            if good != NOBODY {
                self.owners[good as usize] = NOBODY;
            }
        }
        let mut bids = 0u32;
        while let Some(bidder) = bidders.pop() {
            bids = bids.wrapping_add(1);
            if bids.is_multiple_of(LOOK_EVERY) {
                run.check()?;
            }
            let Offer { best, least, second } = self.tree.best_two(self.rows[bidder as usize], cost);
            let lead = if second.is_finite() { second - least } else { 0.0 };
            self.tree.raise(best, lead + epsilon);
            self.goods[bidder as usize] = best as u32;
            let outbid = std::mem::replace(&mut self.owners[best], bidder);
            if outbid != NOBODY {
                self.goods[outbid as usize] = NOBODY;
                bidders.push(outbid);
            }
        }
        Ok(())
    }

    fn value(&self, row: u32, cost: &impl Fn(f64) -> f64) -> f64 {
        let good = self.goods[row as usize] as usize;
        cost(self.rows[row as usize].distance_sq(self.tree.place(good))) + self.tree.price(good)
    }

    fn is_content(&self, row: u32, cost: &impl Fn(f64) -> f64, epsilon: f64) -> bool {
        let has_one = self.goods[row as usize] != NOBODY;
        has_one && self.value(row, cost) <= self.tree.best_two(self.rows[row as usize], cost).least + epsilon
    }

    /// What the assignment costs, and how much of it may be too much: duality proves that no
    /// total is below Σ least − Σ price.
    fn total_and_gap(&self, cost: &impl Fn(f64) -> f64) -> (f64, f64) {
        (0..self.rows.len() as u32).fold((0.0, 0.0), |(total, gap), row| {
            let value = self.value(row, cost);
            let regret = value - self.tree.best_two(self.rows[row as usize], cost).least;
            (total + value - self.tree.price(self.goods[row as usize] as usize), gap + regret.max(0.0))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::geometry::Point;
    use crate::compute::random::Purpose;
    use crate::compute::random::Stream;

    const TEST: Purpose = Purpose::new("test.assignment");

    fn cloud(n: usize, seed: u64) -> Vec<Point> {
        let mut random = Stream::new(seed, TEST, n as u64);
        (0..n).map(|_| Point::new(random.unit(), random.unit())).collect()
    }

    fn total(columns: &[usize], cost: impl Fn(usize, usize) -> f64) -> f64 {
        columns.iter().enumerate().map(|(row, column)| cost(row, *column)).sum()
    }

    fn is_a_permutation(columns: &[usize]) -> bool {
        let mut sorted = columns.to_vec();
        sorted.sort_unstable();
        sorted.into_iter().eq(0..columns.len())
    }

    /// Every permutation of up to seven rows.
    fn least_of_all(n: usize, cost: &dyn Fn(usize, usize) -> f64) -> f64 {
        fn go(row: usize, n: usize, taken: usize, cost: &dyn Fn(usize, usize) -> f64) -> f64 {
            if row == n {
                return 0.0;
            }
            (0..n)
                .filter(|c| taken & (1 << c) == 0)
                .map(|c| cost(row, c) + go(row + 1, n, taken | (1 << c), cost))
                .fold(f64::INFINITY, f64::min)
        }
        go(0, n, 0, cost)
    }

    #[test]
    fn small_assignments_cost_as_little_as_the_best_of_all_permutations() {
        for seed in 0..30 {
            let mut random = Stream::new(seed, TEST, 0);
            let n = 1 + random.below(7);
            let costs: Vec<f64> = (0..n * n).map(|_| random.range(-3.0, 9.0)).collect();
            let cost = |r: usize, c: usize| costs[r * n + c];
            assert!((total(&exact(n, cost).unwrap(), cost) - least_of_all(n, &cost)).abs() < 1e-9);
        }
    }

    #[test]
    fn an_auction_costs_what_an_exact_solver_finds_and_its_gap_is_a_bound() {
        for (n, seed, power) in [(1, 7, 1), (3, 0, 1), (17, 1, 2), (60, 2, 1), (120, 3, 4), (200, 4, 2), (700, 6, 1)] {
            let (from, to) = (cloud(n, seed), cloud(n, seed + 100));
            let way = |d: f64| d.powf(0.5 * f64::from(power));
            let cost = |r: usize, c: usize| way(from[r].distance_sq(to[c]));
            let (best, bid) = (exact(n, cost).unwrap(), auction(&from, &to, way, &Run::silent()).unwrap());
            assert!(is_a_permutation(&bid.columns) && is_a_permutation(&best));
            let (least, found) = (total(&best, cost), total(&bid.columns, cost));
            assert!(found >= least - 1e-9 && found - least <= bid.gap + 1e-9, "{n}: {found} {least} {}", bid.gap);
            assert!(bid.gap <= (SHARE * least).max(SHARE_OF_LONGEST * way(2.0)), "{n}: {}", bid.gap);
        }
    }

    #[test]
    fn a_large_herd_that_moves_together_costs_no_more_than_in_its_order() {
        let from = cloud(4000, 9);
        let to: Vec<Point> = from.iter().map(|p| *p * 0.9 + Point::new(0.3, 0.1)).collect();
        let found = assign(&from, &to, |d| d, &Run::silent()).unwrap();
        // A map that is the slope of a convex function is the cheapest for squared ways (Brenier 1991).
        let cost = |r: usize, c: usize| from[r].distance_sq(to[c]);
        let in_order: f64 = (0..4000).map(|i| cost(i, i)).sum();
        let excess = total(&found.columns, cost) - in_order;
        assert!(excess > -1e-9 && excess <= found.gap && found.gap <= SHARE * in_order, "{excess} {}", found.gap);
    }

    #[test]
    fn equal_costs_and_equal_places_do_not_hang_an_auction() {
        let here = vec![Point::new(3.0, 4.0); 300];
        let flat = auction(&here, &here, f64::sqrt, &Run::silent()).unwrap();
        assert!(is_a_permutation(&flat.columns) && flat.gap == 0.0);
        let clumped: Vec<Point> = (0..300u32).map(|i| Point::new(f64::from(i % 3), 0.0)).collect();
        let other: Vec<Point> = (0..300u32).map(|i| Point::new(f64::from(i / 100), 0.0)).collect();
        let found = auction(&clumped, &other, f64::sqrt, &Run::silent()).unwrap();
        assert!(is_a_permutation(&found.columns));
        assert_eq!(total(&found.columns, |r, c| clumped[r].distance(other[c])), 0.0);
        assert_eq!(auction(&[], &[], f64::sqrt, &Run::silent()).unwrap().columns, Vec::<usize>::new());
    }

    #[test]
    fn costs_that_are_no_numbers_are_refused() {
        let cost = |r: usize, c: usize| if (r, c) == (1, 2) { f64::NAN } else { 1.0 };
        assert_eq!(exact(4, cost).unwrap_err(), AssignmentError::BadCost { row: 1, column: 2 });
        let (mut broken, whole) = (cloud(4, 1), cloud(4, 2));
        broken[2].y = f64::NAN;
        let refused = auction(&whole, &broken, f64::sqrt, &Run::silent()).unwrap_err();
        assert_eq!(refused, AssignmentError::BadCost { row: 0, column: 2 });
    }
}
