//! Smooth lines through the cells of the trails.

use super::Stretch;
use super::Trail;
use super::network::Chain;
use super::network::Portion;
use super::wear::Wear;
use crate::compute::ecosystem::curve::Ground;
use crate::compute::ecosystem::curve::relax;
use crate::compute::ecosystem::curve::smoothing;
use crate::compute::ecosystem::curve::thinned;
use crate::compute::geometry::Point;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use std::collections::BTreeMap;

/// How far a line may be from the smoothed curve, in cells.
const TOLERANCE: f64 = 0.05;

/// What lines are drawn through.
pub(crate) struct Plot<'a> {
    pub(crate) portions: &'a [Portion],
    /// Cells that lines pass through exactly: where resources are.
    pub(crate) stops: &'a [u32],
    pub(crate) ground: &'a Ground<'a>,
    pub(crate) wear: &'a Wear,
}

/// One line per chain, on ground open to the species that walk it most. Chains are smoothed from
/// the heaviest down; where a later one meets an earlier one it ends on the earlier one's line.
pub(crate) fn lines(plot: &Plot, chains: &[Chain], run: &Run) -> Result<Vec<Trail>, Stopped> {
    let place = |&cell: &u32| (cell, plot.ground.grid.centre(cell as usize));
    let mut settled: BTreeMap<u32, Point> = plot.stops.iter().map(place).collect();
    let mut trails = Vec::with_capacity(chains.len());
    for chain in chains {
        run.check()?;
        trails.push(Course::of(plot.portions, chain).trail(plot, &mut settled));
    }
    Ok(trails)
}

/// A chain as one run of cells.
struct Course {
    cells: Vec<u32>,
    /// (first cell, last cell, portion), by position in `cells`.
    parts: Vec<(usize, usize, usize)>,
}

impl Course {
    fn of(portions: &[Portion], chain: &Chain) -> Self {
        let mut course = Self { cells: Vec::new(), parts: Vec::new() };
        for &(portion, reversed) in chain {
            course.cells.pop();
            let first = course.cells.len();
            let cells = portions[portion].cells.iter().copied();
            if reversed {
                course.cells.extend(cells.rev())
            } else {
                course.cells.extend(cells)
            }
            course.parts.push((first, course.cells.len() - 1, portion));
        }
        course
    }

    fn trail(&self, plot: &Plot, settled: &mut BTreeMap<u32, Point>) -> Trail {
        let Plot { portions, ground, wear, .. } = *plot;
        let joints = self.joints();
        let fixed: Vec<bool> = self.fixed(&joints, settled);
        let centre = |cell: &u32| settled.get(cell).copied().unwrap_or(ground.grid.centre(*cell as usize));
        let mut points: Vec<Point> = self.cells.iter().map(centre).collect();
        let walkers = self.walkers(portions);
        let clear = |i: usize, p: Point, q: Point| ground.clear(walkers[i], p, q);
        relax(&mut points, smoothing(ground.grid.cell_m), |i| fixed[i], clear);
        joints.iter().for_each(|&i| {
            settled.insert(self.cells[i], points[i]);
        });
        let joint = |i: usize| joints.binary_search(&i).is_ok();
        let kept = thinned(&points, TOLERANCE * ground.grid.cell_m, joint, clear);
        let stretch = |&(first, last, portion): &(usize, usize, usize)| {
            let at = |i: usize| kept.partition_point(|k| *k < i);
            Stretch::new(at(first)..=at(last), &portions[portion].loads, wear)
        };
        Trail { stretches: self.parts.iter().map(stretch).collect(), points: kept.iter().map(|&i| points[i]).collect() }
    }

    /// Where portions begin and end, ascending.
    fn joints(&self) -> Vec<usize> {
        let mut joints: Vec<usize> = self.parts.iter().flat_map(|part| [part.0, part.1]).collect();
        joints.dedup();
        joints
    }

    /// Points that stay: the ends, junctions that earlier lines have settled, and junctions this
    /// line passes twice.
    fn fixed(&self, joints: &[usize], settled: &BTreeMap<u32, Point>) -> Vec<bool> {
        let mut fixed = vec![false; self.cells.len()];
        let mut passed: Vec<u32> = joints.iter().map(|&i| self.cells[i]).collect();
        passed.sort_unstable();
        for &i in joints {
            let cell = self.cells[i];
            let times = passed.partition_point(|c| *c <= cell) - passed.partition_point(|c| *c < cell);
            fixed[i] = times > 1 || settled.contains_key(&cell);
        }
        (fixed[0], fixed[self.cells.len() - 1]) = (true, true);
        fixed
    }

    /// The species that carries most, per link.
    fn walkers(&self, portions: &[Portion]) -> Vec<usize> {
        let mut walkers = vec![0; self.cells.len()];
        for &(first, last, portion) in &self.parts {
            let most = portions[portion].loads.iter().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
            walkers[first..last].fill(most.map_or(0, |load| load.0));
        }
        walkers
    }
}
