//! Initialisation: dart throwing with a growing tolerance, then a grid search (T Algorithm 1).

use super::filling::Filling;
use super::meter::Meter;
use super::partners::Partner;
use super::patch::Patch;
use super::strata::Strata;
use super::trial::BARRED;
use super::trial::Trial;
use crate::compute::geometry::Point;
use crate::compute::pcf::PcfError;
use crate::compute::pcf::SynthesisOptions;
use crate::compute::random::Purpose;
use crate::compute::random::Stream;
use crate::compute::run::Run;

const DARTS: Purpose = Purpose::new("distribution.darts");

/// Darts between two looks at the stop flag.
const LOOK_EVERY: usize = 64;

/// Draws that miss the room, for one dart, before it counts as failed.
const MISSES: usize = 32;

/// Places of one level of a painted density differ by at most this factor from the first.
const LEVEL_WIDTH: f64 = 1.3;

/// What a block was filled with.
#[derive(Debug, Clone, Default)]
pub(super) struct Filled {
    /// Places and radii in metres, in the order they were laid out.
    pub(super) elements: Vec<(Point, f64)>,
    /// Darts thrown.
    pub(super) darts: usize,
    /// Elements placed by the grid search.
    pub(super) by_grid: usize,
    /// Elements for which no free place was found.
    pub(super) missing: usize,
}

/// Fills the block of an empty `patch` with elements of `radii` (metres), the largest first;
/// `index` is the block's number.
pub(super) fn fill(
    patch: &Patch<'_>,
    (index, mut radii): (usize, Vec<f64>),
    (options, meter): (&SynthesisOptions, &Meter<'_>),
) -> Result<Filled, PcfError> {
    radii.sort_by(|a, b| b.total_cmp(a));
    let mut thrower = Thrower {
        patch,
        options,
        trial: Trial::new(patch),
        filling: Filling::empty(patch, radii.len()),
        random: Stream::new(options.seed, DARTS, (patch.scene.class as u64) << 32 | index as u64),
        filled: Filled::default(),
        searching: false,
        strata: Strata::of_block(patch),
    };
    for radius in radii {
        thrower.place(radius, meter.run)?;
        meter.advance(1)?;
    }
    Ok(thrower.filled)
}

struct Thrower<'a> {
    patch: &'a Patch<'a>,
    options: &'a SynthesisOptions,
    trial: Trial<'a>,
    filling: Filling,
    random: Stream,
    filled: Filled,
    searching: bool,
    strata: Strata,
}

/// Where the darts of one element may fall.
#[derive(Debug, Clone, Copy)]
struct Aim {
    stratum: usize,
    level: f64,
}

impl Thrower<'_> {
    /// Places one element of `radius` metres, if there is any place for it.
    fn place(&mut self, radius: f64, run: &Run) -> Result<(), PcfError> {
        let thrown = if self.searching { None } else { self.throw(radius, run)? };
        let found = match thrown {
            Some(p) => Some(p),
            None => {
                self.searching = true;
                self.search(radius, run)?
            }
        };
        match found {
            Some(p) => self.accept(p, radius),
            None => self.filled.missing += 1,
        }
        Ok(())
    }

    /// Throws darts until one is below the tolerance; `None` after `max_fails` in a row.
    fn throw(&mut self, radius: f64, run: &Run) -> Result<Option<Point>, PcfError> {
        let mut aim = None;
        for fails in 0..self.options.max_fails {
            if fails % LOOK_EVERY == 0 {
                run.check()?;
            }
            let tolerance = self.options.tolerance + self.options.tolerance_step * fails as f64;
            let Some((p, hit)) = (0..MISSES).find_map(|_| self.draw(aim)) else { continue };
            aim = aim.or(Some(hit));
            self.filled.darts += 1;
            if self.error(p, radius, tolerance) <= tolerance {
                return Ok(Some(p));
            }
        }
        Ok(None)
    }

    /// A place drawn by the density. The first dart of an element decides how far from the edges of
    /// the block its place is and, with a painted density, how dense; the others keep to that
    /// (`aim`). Where elements see few others, at edges, or lie thin, curves are rougher or smoother
    /// and darts fail more or less often, which must not change the density.
    fn draw(&mut self, aim: Option<Aim>) -> Option<(Point, Aim)> {
        let (patch, intensity) = (self.patch, self.patch.scene.intensity);
        let cell = match aim {
            Some(aim) => self.strata.draw_cell(aim.stratum, &mut self.random),
            None => patch.block.draw_cell(&mut self.random),
        };
        let p = patch.sampler.draw_in(patch.block.cells().get(cell)?, &mut self.random)?;
        let level = intensity.at(p);
        let is_level = |aim: Aim| (1.0 / LEVEL_WIDTH..=LEVEL_WIDTH).contains(&(level / aim.level));
        let keeps = intensity.is_flat() || aim.is_none_or(is_level);
        keeps.then_some((p, Aim { stratum: self.strata.of(cell), level }))
    }

    /// The best of one random place in every cell of the block (T 3.5.2), ties by a coin.
    fn search(&mut self, radius: f64, run: &Run) -> Result<Option<Point>, PcfError> {
        let (mut best, mut least, mut ties) = (None, BARRED, 1.0);
        for (k, cell) in self.patch.block.cells().iter().enumerate() {
            if k % LOOK_EVERY == 0 {
                run.check()?;
            }
            let Some(p) = self.patch.sampler.draw_in(cell, &mut self.random) else { continue };
            let error = self.error(p, radius, least);
            ties = if error == least { ties + 1.0 } else { 1.0 };
            if error < least || (error == least && error < BARRED && self.random.unit() * ties < 1.0) {
                (best, least) = (Some(p), error);
            }
        }
        self.filled.by_grid += usize::from(best.is_some());
        Ok(best)
    }

    fn error(&mut self, p: Point, radius: f64, bound: f64) -> f64 {
        self.trial.error((p, radius / self.patch.scene.unit), &self.filling, bound)
    }

    fn accept(&mut self, p: Point, radius: f64) {
        self.error(p, radius, f64::INFINITY);
        let weight = self.patch.scene.intensity.weight(p);
        let partner = Partner { place: p, radius: radius / self.patch.scene.unit, weight };
        self.trial.accept(partner, &mut self.filling);
        self.filled.elements.push((p, radius));
    }
}
