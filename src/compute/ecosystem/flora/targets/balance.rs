//! How near the covered areas are to the proportions asked for, and who should grow next.

/// The areas covered so far against the target shares.
pub(super) struct Balance {
    /// Target shares, summing to 1.
    shares: Vec<f64>,
    /// Area covered by each species, in cover units.
    pub area: Vec<u64>,
    shares_sq: f64,
}

/// A unit, or a batch of them, that one species might add.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Attempt {
    pub species: usize,
    /// Area it would add, in cover units.
    pub area: u64,
    /// Distance to the target it would lead to.
    pub distance: f64,
}

impl Balance {
    pub(super) fn new(shares: Vec<f64>) -> Self {
        let shares_sq = shares.iter().map(|t| t * t).sum();
        Self { area: vec![0; shares.len()], shares, shares_sq }
    }

    /// Euclidean distance between the shares of the area and the targets; infinite while nothing
    /// is covered.
    pub(super) fn distance(&self) -> f64 {
        let sums = self.sums();
        self.distance_of(sums.total, sums.area_sq, sums.product)
    }

    /// The attempt that leads nearest to the target; the first of equals.
    pub(super) fn nearest(&self, attempts: impl Iterator<Item = (usize, u64)>) -> Option<Attempt> {
        let sums = self.sums();
        let tried = attempts.map(|(species, area)| {
            let (a, u) = (self.area[species] as f64, area as f64);
            let area_sq = sums.area_sq + 2.0 * a * u + u * u;
            let product = sums.product + u * self.shares[species];
            Attempt { species, area, distance: self.distance_of(sums.total + u, area_sq, product) }
        });
        tried.reduce(|best, next| if next.distance < best.distance { next } else { best })
    }

    /// Area covered by all species.
    pub(super) fn total(&self) -> u64 {
        self.area.iter().sum()
    }

    /// The share of the covered area that each species has; all 0 while nothing is covered.
    pub(super) fn reached(&self) -> Vec<f64> {
        let total = self.total().max(1) as f64;
        self.area.iter().map(|a| *a as f64 / total).collect()
    }

    fn sums(&self) -> Sums {
        let start = Sums { total: 0.0, area_sq: 0.0, product: 0.0 };
        self.area.iter().zip(&self.shares).fold(start, |sums, (area, share)| {
            let a = *area as f64;
            Sums { total: sums.total + a, area_sq: sums.area_sq + a * a, product: sums.product + a * share }
        })
    }

    fn distance_of(&self, total: f64, area_sq: f64, product: f64) -> f64 {
        if total <= 0.0 {
            return f64::INFINITY;
        }
        (area_sq / (total * total) - 2.0 * product / total + self.shares_sq).max(0.0).sqrt()
    }
}

struct Sums {
    total: f64,
    area_sq: f64,
    product: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_is_that_of_the_two_lists_of_shares() {
        let mut balance = Balance::new(vec![0.5, 0.3, 0.2]);
        assert_eq!(balance.distance(), f64::INFINITY);
        balance.area = vec![10, 10, 20];
        let expected = ((0.25_f64).powi(2) + (0.05_f64).powi(2) + (0.3_f64).powi(2)).sqrt();
        assert!((balance.distance() - expected).abs() < 1e-12);
        balance.area = vec![50, 30, 20];
        assert!(balance.distance() < 1e-7);
    }

    #[test]
    fn the_nearest_attempt_is_what_trying_each_would_show() {
        let mut balance = Balance::new(vec![0.5, 0.3, 0.2]);
        balance.area = vec![5, 1, 2];
        let best = balance.nearest([(0, 3), (1, 3), (2, 3)].into_iter()).unwrap();
        let mut distances = Vec::new();
        for s in 0..3 {
            balance.area[s] += 3;
            distances.push(balance.distance());
            balance.area[s] -= 3;
        }
        assert_eq!(best.species, 1);
        assert!((best.distance - distances[1]).abs() < 1e-9 && distances[1] < distances[0].min(distances[2]));
    }

    #[test]
    fn equally_near_attempts_go_by_species_order() {
        let balance = Balance::new(vec![0.5, 0.5]);
        assert_eq!(balance.nearest([(0, 1), (1, 1)].into_iter()).unwrap().species, 0);
    }
}
