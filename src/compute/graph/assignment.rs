//! Optimal assignment: who goes where, at the least total cost.
//!
//! Up to [`EXACT_UP_TO`] pairs by shortest augmenting paths (`lsap`, exact, a cost matrix in
//! memory); above by the auction algorithm with ε-scaling (Bertsekas 1988), which keeps only
//! prices and asks for costs as it goes.

use crate::compute::run::Run;
use crate::compute::run::Stopped;

/// The most pairs that are assigned by shortest augmenting paths.
pub const EXACT_UP_TO: usize = 1000;

/// Prices rise by at least this share of the cost range in the last round of an auction, over
/// the number of pairs: the total is within this share of the range of the least one.
const LAST_EPSILON: f64 = 1e-4;

/// Each round of an auction bids this many times finer than the one before (Bertsekas advises 4
/// to 10).
const SCALING: f64 = 5.0;

/// Why there is no assignment.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum AssignmentError {
    /// A cost is not a finite number.
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

/// For each of `n` rows one of `n` columns, each taken once, so that the sum of `cost(row,
/// column)` is least: exactly up to [`EXACT_UP_TO`] rows, above within 10⁻⁴ of the range of costs.
///
/// # Errors
/// A cost that is not finite, or a stop.
pub fn assign(n: usize, cost: impl Fn(usize, usize) -> f64, run: &Run) -> Result<Vec<usize>, AssignmentError> {
    if n <= EXACT_UP_TO { exact(n, cost) } else { auction(n, cost, run) }
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

/// An assignment whose cost exceeds the least by at most 10⁻⁴ of the range of costs.
///
/// Forward auction: a row without a column bids for the one of most value to it (least cost plus
/// price) and raises its price by its lead over the second best plus ε, until all have one; then
/// again with a finer ε from the prices so far. Every bid raises a price by at least ε and prices
/// are bounded by the range, so it ends.
///
/// # Errors
/// A cost that is not finite, or a stop.
pub fn auction(n: usize, cost: impl Fn(usize, usize) -> f64, run: &Run) -> Result<Vec<usize>, AssignmentError> {
    let (low, high) = cost_range(n, &cost, run)?;
    let range = high - low;
    if n < 2 || range <= 0.0 {
        return Ok((0..n).collect());
    }
    // Above the least cost, so that a small ε never drowns in a large common part.
    let cost = |row: usize, column: usize| cost(row, column) - low;
    let last = LAST_EPSILON * range / n as f64;
    let mut prices = vec![0.0; n];
    let mut epsilon = (range / SCALING).max(last);
    loop {
        let owners = round(&cost, &mut prices, epsilon, run)?;
        if epsilon <= last {
            return Ok(invert(&owners));
        }
        epsilon = (epsilon / SCALING).max(last);
    }
}

fn cost_range(n: usize, cost: &impl Fn(usize, usize) -> f64, run: &Run) -> Result<(f64, f64), AssignmentError> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for row in 0..n {
        run.check()?;
        for column in 0..n {
            let c = cost(row, column);
            if !c.is_finite() {
                return Err(AssignmentError::BadCost { row, column });
            }
            low = low.min(c);
            high = high.max(c);
        }
    }
    Ok((low, high))
}

const NOBODY: u32 = u32::MAX;

/// One auction from the prices given; the owner of each column.
fn round(
    cost: &impl Fn(usize, usize) -> f64,
    prices: &mut [f64],
    epsilon: f64,
    run: &Run,
) -> Result<Vec<u32>, AssignmentError> {
    let n = prices.len();
    let mut owners = vec![NOBODY; n];
    let mut bidders: Vec<u32> = (0..n as u32).rev().collect();
    let mut bids = 0u32;
    while let Some(bidder) = bidders.pop() {
        bids = bids.wrapping_add(1);
        if bids.is_multiple_of(64) {
            run.check()?;
        }
        let (mut best, mut least, mut second) = (0, f64::INFINITY, f64::INFINITY);
        for (column, price) in prices.iter().enumerate() {
            let value = cost(bidder as usize, column) + price;
            if value < second {
                if value < least {
                    second = least;
                    least = value;
                    best = column;
                } else {
                    second = value;
                }
            }
        }
        let lead = if second.is_finite() { second - least } else { 0.0 };
        prices[best] += lead + epsilon;
        let outbid = std::mem::replace(&mut owners[best], bidder);
        if outbid != NOBODY {
            bidders.push(outbid);
        }
    }
    Ok(owners)
}

fn invert(owners: &[u32]) -> Vec<usize> {
    let mut columns = vec![0; owners.len()];
    owners.iter().enumerate().for_each(|(column, owner)| columns[*owner as usize] = column);
    columns
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
            let least = least_of_all(n, &cost);
            assert!((total(&exact(n, cost).unwrap(), cost) - least).abs() < 1e-9);
            let bid = total(&auction(n, cost, &Run::silent()).unwrap(), cost);
            assert!(bid - least < 1.2e-3 && bid >= least - 1e-9, "{bid} {least}");
        }
    }

    #[test]
    fn an_auction_costs_what_an_exact_solver_finds() {
        for (n, seed, power) in [(3, 0, 1), (17, 1, 2), (60, 2, 1), (120, 3, 4), (200, 4, 2), (200, 5, 1), (700, 6, 2)]
        {
            let (from, to) = (cloud(n, seed), cloud(n, seed + 100));
            let cost = |r: usize, c: usize| from[r].distance(to[c]).powi(power);
            let (best, bid) = (exact(n, cost).unwrap(), auction(n, cost, &Run::silent()).unwrap());
            assert!(is_a_permutation(&bid) && is_a_permutation(&best));
            let (least, found) = (total(&best, cost), total(&bid, cost));
            assert!(found >= least - 1e-9 && found - least <= 2e-4, "{n}: {found} {least}");
        }
    }

    #[test]
    fn equal_costs_and_equal_places_do_not_hang_an_auction() {
        let flat = auction(300, |_, _| 1.0, &Run::silent()).unwrap();
        assert!(is_a_permutation(&flat));
        let clumped = auction(300, |r, c| f64::from((r % 3 != c % 3) as u8), &Run::silent()).unwrap();
        assert!(is_a_permutation(&clumped));
        assert_eq!(total(&clumped, |r, c| f64::from((r % 3 != c % 3) as u8)), 0.0);
        assert_eq!(auction(0, |_, _| 0.0, &Run::silent()).unwrap(), Vec::<usize>::new());
    }

    #[test]
    fn costs_that_are_no_numbers_are_refused() {
        let cost = |r: usize, c: usize| if (r, c) == (1, 2) { f64::NAN } else { 1.0 };
        assert_eq!(exact(4, cost).unwrap_err(), AssignmentError::BadCost { row: 1, column: 2 });
        assert_eq!(auction(4, cost, &Run::silent()).unwrap_err(), AssignmentError::BadCost { row: 1, column: 2 });
    }
}
