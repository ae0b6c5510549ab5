//! What the animals of one level can still take, pool by pool and season by season.

use crate::compute::ecosystem::rag::pools::Pool;

/// What is left in the pools of a level. A year has as many equal **periods** as the food with
/// the most seasons asks for; what is not eaten in a period does not keep.
#[derive(Debug, Clone)]
pub(super) struct Larder {
    /// kg left per pool (first index) and period.
    left: Vec<Vec<f64>>,
    /// kg eaten per pool.
    pub(super) eaten: Vec<f64>,
    periods: usize,
}

/// A pool that a habitat draws from, and how much it is liked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Dish {
    pub(super) pool: usize,
    pub(super) preference: f64,
}

impl Larder {
    /// The larder of `pools`; `season` gives the share of each period in the pool's year, summing
    /// to 1, all of one length.
    pub(super) fn new(pools: &[Pool], season: impl Fn(&Pool) -> Vec<f64>) -> Self {
        let left = |pool: &Pool| season(pool).into_iter().map(|share| share * pool.kg).collect();
        let left: Vec<Vec<f64>> = pools.iter().map(left).collect();
        let periods = left.iter().map(Vec::len).max().unwrap_or(1);
        Self { left, eaten: vec![0.0; pools.len()], periods }
    }

    /// How well `need_kg` a year are met by the dishes (L 4.2): the part of the variation
    /// [0, q] of the food that lies above the need, 1 − need/q, in the **leanest** period, times
    /// how well the food is liked (mean preference of what is there over the highest of the
    /// diet). Positive only if the need can be taken in every period.
    pub(super) fn fitness(&self, dishes: &[Dish], need_kg: f64) -> f64 {
        let best = dishes.iter().map(|d| d.preference).fold(0.0, f64::max);
        let need = need_kg / self.periods as f64;
        let fit = |period: usize| {
            let (sum, liked) = dishes.iter().fold((0.0, 0.0), |(sum, liked), dish| {
                let kg = self.left[dish.pool][period];
                (sum + kg, liked + kg * dish.preference)
            });
            if sum > need { (1.0 - need / sum) * liked / (sum * best) } else { 0.0 }
        };
        (0..self.periods).map(fit).fold(1.0, f64::min)
    }

    /// The food of the leanest period, kg a year if all periods were like it.
    pub(super) fn leanest_kg(&self, dishes: &[Dish]) -> f64 {
        let sum = |period: usize| dishes.iter().map(|d| self.left[d.pool][period]).sum::<f64>();
        (0..self.periods).map(sum).fold(f64::INFINITY, f64::min) * self.periods as f64
    }

    /// Takes `need_kg` for a year from the dishes, which hold that much in every period: each
    /// gives by preference × what is left of it, none more than it has.
    pub(super) fn take(&mut self, dishes: &[Dish], need_kg: f64) {
        for period in 0..self.periods {
            self.take_in(dishes, period, need_kg / self.periods as f64);
        }
    }

    fn take_in(&mut self, dishes: &[Dish], period: usize, need: f64) {
        let mut open = dishes.to_vec();
        let mut need = need;
        while need > 0.0 && !open.is_empty() {
            let weight = |left: &[Vec<f64>], d: &Dish| d.preference * left[d.pool][period];
            let sum: f64 = open.iter().map(|d| weight(&self.left, d)).sum();
            if sum <= 0.0 {
                return;
            }
            let spent = |d: &Dish| need * d.preference >= sum;
            if !open.iter().any(spent) {
                for dish in &open {
                    let kg = need * weight(&self.left, dish) / sum;
                    self.give(dish.pool, period, kg);
                }
                return;
            }
            let (empty, rest): (Vec<Dish>, Vec<Dish>) = open.into_iter().partition(spent);
            for dish in empty {
                let kg = self.left[dish.pool][period].min(need);
                self.give(dish.pool, period, kg);
                need -= kg;
            }
            open = rest;
        }
    }

    fn give(&mut self, pool: usize, period: usize, kg: f64) {
        let kg = kg.min(self.left[pool][period]);
        self.left[pool][period] -= kg;
        self.eaten[pool] += kg;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::ecosystem::rag::Resource;
    use crate::compute::ecosystem::species::Food;

    fn larder(kg: &[f64], season: &[f64]) -> Larder {
        let pool = |kg: &f64| Pool {
            resource: Resource::Food(Food::Plant(0)),
            parts: vec![0],
            nodes: 0..0,
            kg: *kg,
            users: Vec::new(),
        };
        Larder::new(&kg.iter().map(pool).collect::<Vec<Pool>>(), |_| season.to_vec())
    }

    fn dishes(preferences: &[f64]) -> Vec<Dish> {
        preferences.iter().enumerate().map(|(pool, p)| Dish { pool, preference: *p }).collect()
    }

    #[test]
    fn what_is_taken_is_the_need_shared_by_preference_and_supply() {
        let mut larder = larder(&[100.0, 300.0], &[1.0]);
        larder.take(&dishes(&[2.0, 1.0]), 50.0);
        assert!((larder.eaten[0] - 20.0).abs() < 1e-9 && (larder.eaten[1] - 30.0).abs() < 1e-9);
    }

    #[test]
    fn a_favourite_is_eaten_up_and_the_rest_comes_from_what_is_there() {
        let mut larder = larder(&[10.0, 300.0], &[1.0]);
        larder.take(&dishes(&[100.0, 1.0]), 50.0);
        assert!((larder.eaten[0] - 10.0).abs() < 1e-9 && (larder.eaten[1] - 40.0).abs() < 1e-9);
        assert!(larder.left.iter().flatten().all(|kg| *kg >= 0.0));
    }

    #[test]
    fn the_leanest_season_bounds_what_fits() {
        let even = larder(&[120.0], &[0.25; 4]);
        let lean = larder(&[120.0], &[0.1, 0.3, 0.3, 0.3]);
        let dish = dishes(&[1.0]);
        assert!((even.fitness(&dish, 60.0) - 0.5).abs() < 1e-12);
        assert_eq!(lean.fitness(&dish, 60.0), 0.0);
        assert!((lean.leanest_kg(&dish) - 48.0).abs() < 1e-9);
        assert!((lean.fitness(&dish, 24.0) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn a_region_without_food_or_without_a_diet_fits_nobody() {
        assert_eq!(larder(&[0.0], &[1.0]).fitness(&dishes(&[1.0]), 5.0), 0.0);
        assert_eq!(larder(&[10.0], &[1.0]).fitness(&[], 5.0), 0.0);
    }
}
