use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A cell waiting in a bucket, in the chain that starts at the bucket's head.
#[derive(Debug, Clone, Copy)]
struct Entry {
    key: f32,
    cell: u32,
    next: u32,
}

/// The end of a chain.
const NONE: u32 = u32::MAX;

/// A priority queue of cells by ascending key, for searches whose keys never fall: no key
/// pushed may lie below the last one popped (one that does counts as equal to it).
///
/// Keys are spread over buckets of equal width (Dial's algorithm); only the bucket in work is
/// kept sorted, as a small heap, so a push or pop takes constant time for keys that spread
/// evenly and never more than the logarithm of the waiting cells. The order is exact, equal keys
/// come in the order of their cells, and memory grows with the waiting cells only.
#[derive(Debug)]
pub struct BucketQueue {
    heads: Vec<u32>,
    entries: Vec<Entry>,
    free: u32,
    heap: BinaryHeap<Reverse<(u32, u32)>>,
    current: usize,
    low: f32,
    per_key: f32,
}

impl BucketQueue {
    /// An empty queue for finite keys, best between `low` and `high` (others are taken as well,
    /// only slower).
    pub fn new(low: f32, high: f32, buckets: usize) -> Self {
        let buckets = buckets.max(1);
        let width = (high - low) / buckets as f32;
        let per_key = if width > 0.0 && width.is_finite() { 1.0 / width } else { 0.0 };
        Self {
            heads: vec![NONE; buckets],
            entries: Vec::new(),
            free: NONE,
            heap: BinaryHeap::new(),
            current: 0,
            low,
            per_key,
        }
    }

    /// Adds `cell` with `key`, which is not NaN.
    pub fn push(&mut self, key: f32, cell: usize) {
        let bucket = (((key - self.low) * self.per_key) as usize).min(self.heads.len() - 1);
        if bucket <= self.current {
            self.heap.push(Reverse((ordered(key), cell as u32)));
        } else {
            let entry = Entry { key, cell: cell as u32, next: self.heads[bucket] };
            self.heads[bucket] = self.store(entry);
        }
    }

    /// Takes the cell with the least key.
    pub fn pop(&mut self) -> Option<(f32, usize)> {
        while self.heap.is_empty() {
            self.current = self.heads[self.current..].iter().position(|h| *h != NONE)? + self.current;
            self.open();
        }
        self.heap.pop().map(|Reverse((key, cell))| (unordered(key), cell as usize))
    }

    /// Takes the cell with the least key if that is `key`, the last one popped.
    pub fn pop_equal(&mut self, key: f32) -> Option<usize> {
        // Equal keys share a bucket, and the bucket in work is in the heap.
        let equal = self.heap.peek().is_some_and(|Reverse((least, _))| *least == ordered(key));
        if equal { self.heap.pop().map(|Reverse((_, cell))| cell as usize) } else { None }
    }

    /// Moves the chain of the current bucket to the heap.
    fn open(&mut self) {
        let mut at = std::mem::replace(&mut self.heads[self.current], NONE);
        while at != NONE {
            let entry = self.entries[at as usize];
            self.heap.push(Reverse((ordered(entry.key), entry.cell)));
            self.entries[at as usize].next = self.free;
            self.free = at;
            at = entry.next;
        }
    }

    fn store(&mut self, entry: Entry) -> u32 {
        if self.free == NONE {
            self.entries.push(entry);
            return (self.entries.len() - 1) as u32;
        }
        let at = self.free;
        self.free = self.entries[at as usize].next;
        self.entries[at as usize] = entry;
        at
    }
}

/// The bits of `key` as an integer of the same order.
fn ordered(key: f32) -> u32 {
    let bits = key.to_bits();
    if bits >> 31 == 0 { bits | 0x8000_0000 } else { !bits }
}

/// Undoes [`ordered`].
fn unordered(bits: u32) -> f32 {
    f32::from_bits(if bits >> 31 == 1 { bits & 0x7fff_ffff } else { !bits })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_come_in_ascending_order_whatever_the_buckets() {
        for buckets in [1, 7, 1000] {
            let mut queue = BucketQueue::new(-10.0, 10.0, buckets);
            let keys: Vec<f32> = (0..500).map(|i: i32| ((i * 7919) % 503) as f32 * 0.06 - 15.0).collect();
            keys.iter().enumerate().for_each(|(cell, key)| queue.push(*key, cell));
            let mut expected: Vec<(f32, usize)> = keys.iter().copied().zip(0..).collect();
            expected.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let popped: Vec<(f32, usize)> = std::iter::from_fn(|| queue.pop()).collect();
            assert_eq!(popped, expected);
        }
    }

    #[test]
    fn pushes_between_pops_keep_the_order() {
        let mut queue = BucketQueue::new(0.0, 5.0, 64);
        queue.push(0.0, 0);
        let (mut last, mut n) = (0.0, 0u32);
        while let Some((key, cell)) = queue.pop() {
            assert!(key >= last);
            last = key;
            n += 1;
            if n < 400 {
                queue.push(key + ((cell * 37) % 11) as f32 * 0.01, cell + 1);
                queue.push(key + ((cell * 53) % 17) as f32 * 0.1, cell + 2);
            }
        }
        assert!(n > 400);
    }

    #[test]
    fn only_cells_of_the_last_key_pop_as_equal() {
        let mut queue = BucketQueue::new(0.0, 9.0, 4);
        [(2.0, 7), (2.0, 5), (2.5, 1)].into_iter().for_each(|(key, cell)| queue.push(key, cell));
        assert_eq!(queue.pop(), Some((2.0, 5)));
        assert_eq!([queue.pop_equal(2.0), queue.pop_equal(2.0)], [Some(7), None]);
    }

    #[test]
    fn keys_that_are_all_equal_come_by_cell() {
        let mut queue = BucketQueue::new(3.0, 3.0, 16);
        for cell in [5, 1, 3] {
            queue.push(3.0, cell);
        }
        assert_eq!([(); 3].map(|()| queue.pop()), [Some((3.0, 1)), Some((3.0, 3)), Some((3.0, 5))]);
        assert_eq!(queue.pop(), None);
    }
}
