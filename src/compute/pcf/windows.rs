//! Coarse counts: how evenly the elements of a class fill windows a few spacings wide.
//!
//! Curves and triplets see the surroundings of elements; where there are none they see nothing,
//! and patterns with the same curves can differ in how much ground they leave thin. The mean
//! square root of the counts in wide windows tells: their mean and mean square are given by the
//! density and the curve, so a smaller root mean says that the same clumps stand on barer ground.
//! Windows are cones, 1 in their middle and 0 at their rim.

use crate::compute::geometry::Bounds;
use crate::compute::geometry::Point;
use crate::compute::geometry::Region;
use crate::compute::pcf::Body;
use crate::compute::pcf::BorderWeight;
use crate::compute::pcf::Frame;
use crate::compute::pcf::WEIGHT_CAP;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::ops::Range;

/// Radii of the windows in r_max (ours).
const RADII: [f64; 3] = [1.5, 2.5, 4.0];

/// Windows to a radius: their middles lie this much closer.
const PER_RADIUS: f64 = 3.0;

/// Elements of a class per square of its r_max, whatever their number (T eq. 3.1).
pub(super) const DENSITY: f64 = 1.154_700_538_379_251_5;

/// Steps of the integral over a window.
const QUADRATURE: usize = 16;

/// A window less of which than this lies in the domain is left out (ours: halves of windows along
/// the border vary most, and an exemplar whose gaps happen to lie there would ask for as many
/// within).
const LEAST_INSIDE: f64 = 0.6;

/// Where fewer windows than this share of those in the domain count, they do not tell how the
/// pattern fills them (ours: small classes have few wide windows, in domains with holes none).
const LEAST_WHOLE: f64 = 0.5;

/// The windows over a domain, or over one block of it.
#[derive(Debug, Clone)]
pub(super) struct Windows {
    unit: f64,
    grids: Vec<Grid>,
}

/// The windows of one radius.
#[derive(Debug, Clone)]
struct Grid {
    /// In r_max.
    radius: f64,
    lattice: Lattice,
    /// What each window holds, over what it would in a uniform pattern.
    counts: Vec<f64>,
    /// The roots of the counts.
    roots: Vec<f64>,
    /// What one element in its middle adds to each; 0 for windows that are left out.
    shares: Vec<f64>,
    /// Windows with their middle in the domain.
    inside: usize,
    /// Those that count.
    whole: usize,
    /// Σ of the roots.
    sum: f64,
}

impl Windows {
    /// Empty windows with their middles in `bounds` and in `domain`; an r_max is `unit` metres.
    pub(super) fn over(domain: &Region, bounds: Bounds, unit: f64) -> Self {
        Self { unit, grids: RADII.iter().map(|radius| Grid::over(domain, bounds, (*radius, unit))).collect() }
    }

    /// No windows at all: nothing is counted.
    pub(super) fn none() -> Self {
        Self { unit: 1.0, grids: Vec::new() }
    }

    /// Adds an element `times` at `p`.
    pub(super) fn add(&mut self, p: Point, times: f64) {
        for grid in &mut self.grids {
            let (mut growth, reach) = (0.0, grid.radius * self.unit);
            let Grid { lattice, counts, roots, shares, .. } = grid;
            lattice.for_each_near(p, reach, |column, row, cone| {
                let window = row * lattice.columns + column;
                let more = (counts[window] + times * cone * shares[window]).max(0.0);
                let root = more.sqrt();
                growth += root - roots[window];
                (counts[window], roots[window]) = (more, root);
            });
            grid.sum += growth;
        }
    }

    /// What the mean roots of other patterns of this kind are to be, by radius; `None` where too
    /// few windows count to tell.
    pub(super) fn goals(&self) -> Vec<Option<f64>> {
        let tells = |grid: &Grid| grid.whole as f64 > LEAST_WHOLE * grid.inside as f64;
        self.grids.iter().zip(self.mean_roots()).map(|(grid, root)| tells(grid).then_some(root)).collect()
    }

    /// The mean root of the counts, by radius.
    fn mean_roots(&self) -> impl Iterator<Item = f64> {
        self.grids.iter().map(|grid| grid.mean(0.0))
    }

    /// The element at `p`, which they count, taken out.
    pub(super) fn take_out(&self, p: Point) -> TakenOut {
        TakenOut { changed: self.grids.iter().map(|grid| grid.without(p, self.unit)).collect() }
    }

    /// The mean root of the counts, by radius, without the element `gone` and, if given, with
    /// another at `p`.
    pub(super) fn mean_roots_without(&self, gone: &TakenOut, p: Option<Point>) -> impl Iterator<Item = f64> {
        self.grids.iter().zip(&gone.changed).map(move |(grid, changed)| {
            let more = p.map_or(0.0, |p| grid.growth((p, self.unit), changed));
            grid.mean(changed.growth + more)
        })
    }
}

/// An element taken out of windows that count it.
#[derive(Debug, Clone, Default)]
pub(super) struct TakenOut {
    /// By radius.
    changed: Vec<Changed>,
}

/// The windows of one radius around an element that are changed without it.
#[derive(Debug, Clone, Default)]
struct Changed {
    columns: Range<usize>,
    rows: Range<usize>,
    /// Row by row, their counts and the roots of these.
    windows: Vec<(f64, f64)>,
    /// By how much the sum of all roots is more.
    growth: f64,
}

impl Changed {
    /// The count and root of a window, if it is one of them.
    fn get(&self, column: usize, row: usize) -> Option<(f64, f64)> {
        let is_here = self.columns.contains(&column) && self.rows.contains(&row);
        is_here.then(|| self.windows[(row - self.rows.start) * self.columns.len() + column - self.columns.start])
    }
}

/// Where the middles of windows are.
#[derive(Debug, Clone, Copy)]
struct Lattice {
    origin: Point,
    /// In metres.
    step: f64,
    columns: usize,
    rows: usize,
}

impl Lattice {
    fn over(bounds: Bounds, step: f64) -> Self {
        let size = |extent: f64| (extent / step) as usize + 1;
        let (columns, rows) = (size(bounds.width()), size(bounds.height()));
        let spare =
            Point::new(bounds.width(), bounds.height()) - Point::new((columns - 1) as f64, (rows - 1) as f64) * step;
        Self { origin: bounds.min + spare * 0.5, step, columns, rows }
    }

    fn middle(&self, window: usize) -> Point {
        self.origin + Point::new((window % self.columns) as f64, (window / self.columns) as f64) * self.step
    }

    /// The columns and rows of the windows up to `reach` metres from `p` along each axis.
    fn around(&self, p: Point, reach: f64) -> (Range<usize>, Range<usize>) {
        let span = |v: f64, count: usize| {
            let at = |v: f64| ((v / self.step + 1.0).max(0.0) as usize).min(count);
            at(v - reach)..at(v + reach)
        };
        (span(p.x - self.origin.x, self.columns), span(p.y - self.origin.y, self.rows))
    }

    /// Calls `visit` with the column and row of the windows that hold `p`, which reach `reach` metres
    /// far, and how high their cones are there; also with some beyond, by 0.
    fn for_each_near(&self, p: Point, reach: f64, mut visit: impl FnMut(usize, usize, f64)) {
        let (columns, rows) = self.around(p, reach);
        let (offset, per_reach) = (p - self.origin, 1.0 / reach);
        for row in rows {
            let y = row as f64 * self.step - offset.y;
            for column in columns.clone() {
                let x = column as f64 * self.step - offset.x;
                visit(column, row, (1.0 - (x * x + y * y).sqrt() * per_reach).max(0.0));
            }
        }
    }
}

impl Grid {
    fn over(domain: &Region, bounds: Bounds, (radius, unit): (f64, f64)) -> Self {
        let lattice = Lattice::over(bounds, radius * unit / PER_RADIUS);
        let share = |window: usize| {
            let p = lattice.middle(window);
            if !domain.contains(p) {
                return None;
            }
            let body = Body { centre: p, radius: 0.0, frame: Frame::of_unit(unit) };
            let inside = {
                let border = BorderWeight::new(domain, &body, radius, WEIGHT_CAP);
                volume(radius, |d| border.at(d))
            };
            if inside < LEAST_INSIDE * TAU * radius * radius / 6.0 { Some(0.0) } else { Some(1.0 / (DENSITY * inside)) }
        };
        let found: Vec<Option<f64>> = (0..lattice.columns * lattice.rows).into_par_iter().map(share).collect();
        let inside = found.iter().flatten().count();
        let shares: Vec<f64> = found.into_iter().map(|share| share.unwrap_or(0.0)).collect();
        let whole = shares.iter().filter(|share| **share > 0.0).count();
        let empty = vec![0.0; shares.len()];
        Self { radius, lattice, counts: empty.clone(), roots: empty, shares, inside, whole, sum: 0.0 }
    }

    /// The mean root of the counts when the sum is more by `change`.
    fn mean(&self, change: f64) -> f64 {
        (self.sum + change) / self.whole.max(1) as f64
    }

    /// The windows without the element at `p`.
    fn without(&self, p: Point, unit: f64) -> Changed {
        let reach = self.radius * unit;
        let (columns, rows) = self.lattice.around(p, reach);
        let (mut windows, mut growth) = (Vec::with_capacity(columns.len() * rows.len()), 0.0);
        self.lattice.for_each_near(p, reach, |column, row, cone| {
            let window = row * self.lattice.columns + column;
            let count = (self.counts[window] - cone * self.shares[window]).max(0.0);
            windows.push((count, count.sqrt()));
            growth += count.sqrt() - self.roots[window];
        });
        Changed { columns, rows, windows, growth }
    }

    /// By how much the sum of the roots is more with an element at `p`, given those windows that
    /// are `changed` meanwhile.
    fn growth(&self, (p, unit): (Point, f64), changed: &Changed) -> f64 {
        let mut growth = 0.0;
        self.lattice.for_each_near(p, self.radius * unit, |column, row, cone| {
            let window = row * self.lattice.columns + column;
            let (count, root) = changed.get(column, row).unwrap_or((self.counts[window], self.roots[window]));
            growth += (count + cone * self.shares[window]).sqrt() - root;
        });
        growth
    }
}

/// The volume of a cone of `radius` r_max inside the domain, given the border weight around its
/// middle at a distance in r_max.
fn volume(radius: f64, border: impl Fn(f64) -> f64) -> f64 {
    let step = radius / QUADRATURE as f64;
    let ring = |k: usize| {
        let r = (k as f64 + 0.5) * step;
        TAU * r * (1.0 - r / radius) / border(r) * step
    };
    (0..QUADRATURE).map(ring).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::random::Purpose;
    use crate::compute::random::Stream;

    fn square() -> Region {
        Region::rectangle(Bounds::new(Point::default(), Point::new(1.0, 1.0))).unwrap()
    }

    fn filled(places: &[Point]) -> Windows {
        let (domain, unit) = (square(), crate::compute::pcf::maximal_spacing(1.0, places.len()));
        let mut windows = Windows::over(&domain, domain.bounds(), unit);
        places.iter().for_each(|p| windows.add(*p, 1.0));
        windows
    }

    fn uniform(count: usize) -> Vec<Point> {
        let mut random = Stream::new(1, Purpose::new("test.windows"), 0);
        (0..count).map(|_| Point::new(random.unit(), random.unit())).collect()
    }

    #[test]
    fn a_lattice_fills_windows_evenly_and_clumps_do_not() {
        let lattice: Vec<Point> =
            (0..400).map(|k| Point::new(f64::from(k % 20) + 0.5, f64::from(k / 20) + 0.5) * 0.05).collect();
        assert!(filled(&lattice).mean_roots().all(|root: f64| (root - 1.0).abs() < 0.03));
        let clumps: Vec<Point> = lattice.iter().map(|p| Point::new(p.x * 0.2, p.y)).collect();
        assert!(filled(&clumps).mean_roots().all(|root| root < 0.7));
        let scattered: Vec<f64> = filled(&uniform(400)).mean_roots().collect();
        assert!(scattered[0] > 0.9 && scattered[2] > scattered[0] && scattered[2] < 1.0, "{scattered:?}");
    }

    #[test]
    fn windows_too_wide_for_the_domain_tell_nothing() {
        assert!(filled(&uniform(400)).goals().iter().all(Option::is_some));
        assert_eq!(filled(&uniform(10)).goals()[2], None);
    }

    #[test]
    fn an_element_elsewhere_counts_as_if_it_were_moved() {
        let places = uniform(100);
        let mut windows = filled(&places);
        let before: Vec<f64> = windows.mean_roots().collect();
        let gone = windows.take_out(places[3]);
        let near = places[3] + Point::new(0.02, -0.03);
        for p in [near, places[3], Point::new(0.03, 0.6)] {
            let foreseen: Vec<f64> = windows.mean_roots_without(&gone, Some(p)).collect();
            windows.add(places[3], -1.0);
            let without: Vec<f64> = windows.mean_roots().collect();
            windows.add(p, 1.0);
            let moved: Vec<f64> = windows.mean_roots().collect();
            assert!(foreseen.iter().zip(&moved).all(|(a, b)| (a - b).abs() < 1e-9), "{foreseen:?} {moved:?}");
            assert!(foreseen != without);
            windows.add(p, -1.0);
            windows.add(places[3], 1.0);
            assert!(windows.mean_roots_without(&gone, None).zip(&without).all(|(a, b)| (a - b).abs() < 1e-9));
            assert!(windows.mean_roots().zip(&before).all(|(a, b)| (a - b).abs() < 1e-9));
        }
    }
}
