//! **Slabs**: the same run of cells out of several maps, so that work over many maps at once
//! can be shared out among threads without a copy.

use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering;

/// Cells in a slab (ours): small enough for the working set of eighteen species to stay in the
/// second-level cache, large enough that sharing out costs nothing.
pub(super) const SLAB: usize = 4096;

/// One slab: which cells, and that part of every map.
pub(super) struct Slab<'a, T> {
    /// The cells, row-major.
    pub cells: Range<usize>,
    /// One slice a map, each as long as `cells`.
    pub maps: Vec<&'a mut [T]>,
}

/// Cuts equally long `maps` at the same places.
pub(super) fn cut<'a, T>(maps: impl IntoIterator<Item = &'a mut [T]>, len: usize) -> Vec<Slab<'a, T>> {
    let mut slabs: Vec<Slab<T>> =
        (0..len).step_by(SLAB).map(|a| Slab { cells: a..(a + SLAB).min(len), maps: Vec::new() }).collect();
    for map in maps {
        slabs.iter_mut().zip(map.chunks_mut(SLAB)).for_each(|(slab, part)| slab.maps.push(part));
    }
    slabs
}

/// Does `work` on every slab on all threads, reports progress, and gives the answers in order.
pub(super) fn each<S: Send, R: Send>(
    run: &Run,
    stage: &'static str,
    slabs: Vec<S>,
    work: impl Fn(S) -> R + Sync,
) -> Result<Vec<R>, Stopped> {
    let (done, total) = (AtomicU64::new(0), slabs.len() as u64);
    slabs
        .into_par_iter()
        .map(|slab| {
            run.check()?;
            let answer = work(slab);
            let now = done.fetch_add(1, Ordering::Relaxed) + 1;
            if now.is_multiple_of(32) || now == total {
                run.progress(stage, now, total)?;
            }
            Ok(answer)
        })
        .collect()
}
