//! The places and the memory that running jobs take.

use crate::jobs::Settings;
use crate::jobs::queue::Lane;

/// The places and the memory that running jobs take.
#[derive(Debug, Clone, Copy, Default)]
pub struct Places {
    quick: usize,
    heavy: usize,
    memory_bytes: u64,
}

impl Places {
    /// The memory a further job of a lane may take, in bytes; `None` when there is no place.
    pub fn free(&self, lane: Lane, settings: &Settings) -> Option<u64> {
        let (taken, all) = match lane {
            Lane::Quick => (self.quick, settings.quick_jobs),
            Lane::Heavy => (self.heavy, settings.heavy_jobs),
        };
        (taken < all).then(|| settings.memory_bytes.saturating_sub(self.memory_bytes))
    }

    /// A job takes a place and memory.
    pub fn take(&mut self, lane: Lane, memory_bytes: u64) {
        *self.of(lane) += 1;
        self.memory_bytes += memory_bytes;
    }

    /// A job gives its place and memory back.
    pub fn give_back(&mut self, lane: Lane, memory_bytes: u64) {
        *self.of(lane) -= 1;
        self.memory_bytes -= memory_bytes;
    }

    const fn of(&mut self, lane: Lane) -> &mut usize {
        match lane {
            Lane::Quick => &mut self.quick,
            Lane::Heavy => &mut self.heavy,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heavy_jobs_leave_the_quick_lane_free_but_not_its_memory() {
        let settings = Settings { heavy_jobs: 1, quick_jobs: 1, memory_bytes: 100, ..Settings::default() };
        let mut places = Places::default();
        assert_eq!(places.free(Lane::Heavy, &settings), Some(100));
        places.take(Lane::Heavy, 70);
        assert_eq!(places.free(Lane::Heavy, &settings), None);
        assert_eq!(places.free(Lane::Quick, &settings), Some(30));
        places.give_back(Lane::Heavy, 70);
        assert_eq!(places.free(Lane::Heavy, &settings), Some(100));
    }
}
