/// Buckets ahead of the present one that are kept apart; what lies farther waits in one heap.
const BUCKETS: usize = 1024;

/// A **bucket queue** (R. Dial, "Shortest-path forest with topological ordering", 1969): a
/// priority queue for searches whose keys never fall below the one taken last, and whose largest
/// key is not known beforehand.
///
/// Items leave in the order of their bucket `⌊key / width⌋`; within a bucket the last one in is
/// the first one out. Push and pop cost O(1) as long as keys span a few thousand widths.
#[derive(Debug, Clone)]
pub struct DialQueue {
    per_width: f64,
    first: u64,
    present: usize,
    near: Vec<Vec<(f32, u32)>>,
    far: Vec<(f32, u32)>,
}

impl DialQueue {
    /// An empty queue with buckets of `width`, which must be positive and finite (otherwise 1).
    pub fn new(width: f32) -> Self {
        let width = if width.is_finite() && width > 0.0 { width } else { 1.0 };
        let near = vec![Vec::new(); BUCKETS];
        Self { per_width: 1.0 / f64::from(width), first: 0, present: 0, near, far: Vec::new() }
    }

    /// Adds `item` at `key`, a finite number ≥ 0; a key below the present bucket joins it.
    pub fn push(&mut self, key: f32, item: u32) {
        let bucket = self.bucket(key).max(self.first + self.present as u64);
        match self.near.get_mut((bucket - self.first).min(BUCKETS as u64) as usize) {
            Some(slot) => slot.push((key, item)),
            None => self.far.push((key, item)),
        }
    }

    /// Takes an item of the lowest bucket, with its key.
    pub fn pop(&mut self) -> Option<(f32, u32)> {
        loop {
            while let Some(slot) = self.near.get_mut(self.present) {
                if let Some(item) = slot.pop() {
                    return Some(item);
                }
                self.present += 1;
            }
            if self.far.is_empty() {
                return None;
            }
            self.move_on();
        }
    }

    fn bucket(&self, key: f32) -> u64 {
        (f64::from(key) * self.per_width) as u64
    }

    /// Starts the near buckets anew at the lowest of what is far.
    fn move_on(&mut self) {
        let far = std::mem::take(&mut self.far);
        self.first = far.iter().map(|(key, _)| self.bucket(*key)).min().unwrap_or(self.first);
        self.present = 0;
        for (key, item) in far {
            self.push(key, item);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::random::Purpose;
    use crate::compute::random::Stream;

    #[test]
    fn items_leave_in_the_order_of_their_buckets_however_far_apart() {
        let mut stream = Stream::new(1, Purpose::new("test.queue"), 0);
        let mut queue = DialQueue::new(0.5);
        let keys: Vec<f32> = (0..5000).map(|i| (stream.unit() * if i % 7 == 0 { 1e6 } else { 100.0 }) as f32).collect();
        keys.iter().enumerate().for_each(|(i, key)| queue.push(*key, i as u32));
        let out: Vec<f32> = std::iter::from_fn(|| queue.pop()).map(|(key, _)| key).collect();
        assert_eq!(out.len(), keys.len());
        assert!(out.windows(2).all(|w| (w[0] / 0.5).floor() <= (w[1] / 0.5).floor()));
    }

    #[test]
    fn an_emptied_queue_can_be_filled_again() {
        let mut queue = DialQueue::new(1.0);
        queue.push(5.0, 1);
        assert_eq!(queue.pop(), Some((5.0, 1)));
        assert_eq!(queue.pop(), None);
        queue.push(6.0, 2);
        assert_eq!((queue.pop(), queue.pop()), (Some((6.0, 2)), None));
    }
}
