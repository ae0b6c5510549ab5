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

/// Radii of the windows in r_max (ours).
const RADII: [f64; 3] = [1.5, 2.5, 4.0];

/// Windows to a radius: their middles lie this much closer.
const PER_RADIUS: f64 = 3.0;

/// Elements of a class per square of its r_max, whatever their number (T eq. 3.1).
const DENSITY: f64 = 1.154_700_538_379_251_5;

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
    origin: Point,
    /// In metres.
    step: f64,
    columns: usize,
    rows: usize,
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
            let mut growth = 0.0;
            let touched: Vec<(usize, f64)> = grid.touched(p, self.unit).collect();
            for (window, cone) in touched {
                let more = (grid.counts[window] + times * cone * grid.shares[window]).max(0.0);
                let root = more.sqrt();
                growth += root - grid.roots[window];
                (grid.counts[window], grid.roots[window]) = (more, root);
            }
            grid.sum += growth;
        }
    }

    /// What the mean roots of other patterns of this kind are to be, by radius; `None` where too
    /// few windows count to tell.
    pub(super) fn goals(&self) -> Vec<Option<f64>> {
        let tells = |grid: &Grid| grid.whole as f64 > LEAST_WHOLE * grid.inside as f64;
        self.grids.iter().zip(self.mean_roots(None)).map(|(grid, root)| tells(grid).then_some(root)).collect()
    }

    /// The mean root of the counts, by radius, with one more element at `p`.
    pub(super) fn mean_roots(&self, p: Option<Point>) -> Vec<f64> {
        let mean = |grid: &Grid| {
            let growth = p.map_or(0.0, |p| {
                let root = |(window, cone): (usize, f64)| {
                    (grid.counts[window] + cone * grid.shares[window]).sqrt() - grid.roots[window]
                };
                grid.touched(p, self.unit).map(root).sum()
            });
            (grid.sum + growth) / grid.whole.max(1) as f64
        };
        self.grids.iter().map(mean).collect()
    }
}

impl Grid {
    fn over(domain: &Region, bounds: Bounds, (radius, unit): (f64, f64)) -> Self {
        let step = radius * unit / PER_RADIUS;
        let size = |extent: f64| (extent / step) as usize + 1;
        let (columns, rows) = (size(bounds.width()), size(bounds.height()));
        let spare =
            Point::new(bounds.width(), bounds.height()) - Point::new((columns - 1) as f64, (rows - 1) as f64) * step;
        let origin = bounds.min + spare * 0.5;
        let share = |window: usize| {
            let p = origin + Point::new((window % columns) as f64, (window / columns) as f64) * step;
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
        let found: Vec<Option<f64>> = (0..columns * rows).into_par_iter().map(share).collect();
        let inside = found.iter().flatten().count();
        let shares: Vec<f64> = found.into_iter().map(|share| share.unwrap_or(0.0)).collect();
        let whole = shares.iter().filter(|share| **share > 0.0).count();
        let empty = vec![0.0; shares.len()];
        Self {
            radius,
            origin,
            step,
            columns,
            rows,
            counts: empty.clone(),
            roots: empty,
            shares,
            inside,
            whole,
            sum: 0.0,
        }
    }

    /// The windows that count and hold `p`, and how high their cones are there.
    fn touched(&self, p: Point, unit: f64) -> impl Iterator<Item = (usize, f64)> {
        let reach = self.radius * unit;
        let span = |v: f64, count: usize| {
            let at = |v: f64| ((v / self.step + 1.0).max(0.0) as usize).min(count);
            at(v - reach)..at(v + reach)
        };
        let (offset, near) = (p - self.origin, reach * reach * (1.0 + 1e-9));
        let (columns, rows) = (span(offset.x, self.columns), span(offset.y, self.rows));
        rows.flat_map(move |row| columns.clone().map(move |column| (column, row))).filter_map(move |(column, row)| {
            let middle = Point::new(column as f64, row as f64) * self.step;
            let (x, y) = (middle.x - offset.x, middle.y - offset.y);
            if x * x + y * y > near {
                return None;
            }
            let cone = 1.0 - middle.distance(offset) / reach;
            let window = row * self.columns + column;
            (cone > 0.0 && self.shares[window] > 0.0).then_some((window, cone))
        })
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
        assert!(filled(&lattice).mean_roots(None).iter().all(|root| (root - 1.0).abs() < 0.03));
        let clumps: Vec<Point> = lattice.iter().map(|p| Point::new(p.x * 0.2, p.y)).collect();
        assert!(filled(&clumps).mean_roots(None).iter().all(|root| *root < 0.7));
        let scattered = filled(&uniform(400)).mean_roots(None);
        assert!(scattered[0] > 0.9 && scattered[2] > scattered[0] && scattered[2] < 1.0, "{scattered:?}");
    }

    #[test]
    fn windows_too_wide_for_the_domain_tell_nothing() {
        assert!(filled(&uniform(400)).goals().iter().all(Option::is_some));
        assert_eq!(filled(&uniform(10)).goals()[2], None);
    }

    #[test]
    fn one_more_element_counts_as_if_it_were_added() {
        let places = uniform(100);
        let mut windows = filled(&places);
        let p = Point::new(0.03, 0.6);
        let foreseen = windows.mean_roots(Some(p));
        windows.add(p, 1.0);
        let added = windows.mean_roots(None);
        assert!(foreseen.iter().zip(&added).all(|(a, b)| (a - b).abs() < 1e-12));
        windows.add(p, -1.0);
        let before = filled(&places).mean_roots(None);
        assert!(windows.mean_roots(None).iter().zip(&before).all(|(a, b)| (a - b).abs() < 1e-9));
    }
}
