//! The cells a species can live in, the fittest first and equals in the order of their hash.

use crate::compute::ecosystem::fitness::PERFECT;
use crate::compute::random;
use crate::compute::random::Purpose;
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

const VISIT: Purpose = Purpose::new("plants.visit");

/// A cell's place in the queue of a species: the lack of fitness in the upper 8 bits, then 24
/// bits of hash(seed, species, cell), then the cell.
fn key(seed: u64, species: usize, cell: usize, level: u8) -> u64 {
    let hash = random::hash2(seed, VISIT, species as u64, cell as u64);
    u64::from(PERFECT - level) << 56 | (hash >> 40) << 32 | cell as u64
}

/// The cells one species still has to be tried in.
pub(super) struct Queue<'a> {
    levels: &'a [u8],
    seed: u64,
    species: usize,
    order: Vec<u32>,
    next: usize,
    /// Key of the last cell of `order` that was given up.
    passed: Option<u64>,
    /// Cells given up before, where room came free since.
    reopened: BinaryHeap<Reverse<u64>>,
}

impl<'a> Queue<'a> {
    pub(super) fn new(seed: u64, species: usize, levels: &'a [u8]) -> Self {
        let suited = levels.par_iter().enumerate().filter(|(_, level)| **level > 0);
        let mut keys: Vec<u64> = suited.map(|(cell, level)| key(seed, species, cell, *level)).collect();
        keys.par_sort_unstable();
        let order = keys.into_iter().map(|key| key as u32).collect();
        Self { levels, seed, species, order, next: 0, passed: None, reopened: BinaryHeap::new() }
    }

    /// A queue of nothing, for a species that is not wanted.
    pub(super) fn empty(seed: u64, species: usize) -> Self {
        Self { levels: &[], seed, species, order: Vec::new(), next: 0, passed: None, reopened: BinaryHeap::new() }
    }

    /// The best cell left, without giving it up.
    pub(super) fn best(&self) -> Option<usize> {
        let next = self.order.get(self.next).map(|cell| *cell as usize);
        match (self.reopened.peek(), next) {
            (Some(Reverse(again)), Some(next)) if *again > self.key(next) => Some(next),
            (Some(Reverse(again)), _) => Some((*again & u64::from(u32::MAX)) as usize),
            (None, next) => next,
        }
    }

    /// Gives up the best cell: nothing more of the species fits there.
    pub(super) fn give_up(&mut self) {
        let Some(best) = self.best() else { return };
        let key = self.key(best);
        if self.reopened.peek() == Some(&Reverse(key)) {
            self.reopened.pop();
        } else {
            self.passed = Some(key);
            self.next += 1;
        }
    }

    /// Room came free in `cell`: it is tried again if it was given up.
    pub(super) fn reopen(&mut self, cell: usize) {
        if self.levels.get(cell).is_some_and(|level| *level > 0) {
            let key = self.key(cell);
            if self.passed.is_some_and(|passed| key <= passed) {
                self.reopened.push(Reverse(key));
            }
        }
    }

    /// Whether there is no cell left to try.
    pub(super) fn is_empty(&self) -> bool {
        self.next == self.order.len() && self.reopened.is_empty()
    }

    /// Cells tried for the first time, and cells in all.
    pub(super) fn progress(&self) -> (u64, u64) {
        (self.next as u64, self.order.len() as u64)
    }

    fn key(&self, cell: usize) -> u64 {
        key(self.seed, self.species, cell, self.levels[cell])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drain(queue: &mut Queue) -> Vec<usize> {
        std::iter::from_fn(|| queue.best().inspect(|_| queue.give_up())).collect()
    }

    #[test]
    fn fitter_cells_come_first_and_cells_without_fitness_never() {
        let levels = [0, 9, 255, 9, 30, 0, 9];
        let cells = drain(&mut Queue::new(1, 0, &levels));
        let seen: Vec<u8> = cells.iter().map(|c| levels[*c]).collect();
        assert_eq!(seen, [255, 30, 9, 9, 9]);
    }

    #[test]
    fn equals_come_in_an_order_that_depends_on_seed_and_species() {
        let levels = [7; 40];
        let orders = [(1, 0), (1, 1), (2, 0)].map(|(seed, species)| drain(&mut Queue::new(seed, species, &levels)));
        assert!(orders[0] != orders[1] && orders[0] != orders[2]);
        assert_eq!(orders[0], drain(&mut Queue::new(1, 0, &levels)));
    }

    #[test]
    fn a_reopened_cell_is_tried_again_before_worse_ones_and_only_if_it_was_given_up() {
        let levels = [9, 200, 100, 50];
        let mut queue = Queue::new(0, 0, &levels);
        queue.reopen(1);
        queue.give_up();
        queue.give_up();
        queue.reopen(1);
        assert_eq!(drain(&mut queue), [1, 3, 0]);
        assert!(queue.is_empty());
        queue.reopen(2);
        assert!(!queue.is_empty());
        assert_eq!(queue.best(), Some(2));
    }
}
