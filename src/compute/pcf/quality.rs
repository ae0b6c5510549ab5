//! Whether a pattern looks like its exemplar, told by statistics the synthesis does not
//! optimise: the nearest-neighbour distribution G and the empty-space function F, within bands
//! by block bootstrap over tiles of the exemplar.

use crate::compute::geometry::CellGrid;
use crate::compute::geometry::Point;
use crate::compute::geometry::Region;
use crate::compute::pcf::Element;
use crate::compute::pcf::maximal_spacing;
use crate::compute::random::Purpose;
use crate::compute::random::Stream;

const BOOTSTRAP: Purpose = Purpose::new("distribution.bootstrap");

/// Tiles on a side of the exemplar.
const TILES: usize = 4;

/// Resamples of the tiles.
const RESAMPLES: usize = 999;

/// Distances at which the functions are compared.
const PLACES: usize = 60;

/// Test points on a side for the empty-space function.
const GRID: usize = 64;

/// Doublings of the search radius for a nearest neighbour.
const MOST_DOUBLINGS: usize = 40;

/// Distances to the nearest element, each seen from one place: the elements themselves (G) or a
/// grid of test points (F).
#[derive(Debug, Clone)]
pub struct NearestDistances {
    samples: Vec<Sample>,
}

#[derive(Debug, Clone, Copy)]
struct Sample {
    distance: f64,
    clearance: f64,
    tile: usize,
}

impl NearestDistances {
    /// From every element of a class to the nearest other: for G.
    pub fn between(elements: &[Element], domain: &Region) -> Self {
        let centres: Vec<Point> = elements.iter().map(|e| e.centre).collect();
        Self::from(&centres, (&centres, true), domain)
    }

    /// From a grid of places in the domain to the nearest element of a class: for F.
    pub fn to_places(elements: &[Element], domain: &Region) -> Self {
        let centres: Vec<Point> = elements.iter().map(|e| e.centre).collect();
        let bounds = domain.bounds();
        let place = |k: usize| {
            let (u, v) = ((k % GRID) as f64 + 0.5, (k / GRID) as f64 + 0.5);
            bounds.min + Point::new(u / GRID as f64 * bounds.width(), v / GRID as f64 * bounds.height())
        };
        let places: Vec<Point> = (0..GRID * GRID).map(place).filter(|p| domain.contains(*p)).collect();
        Self::from(&places, (&centres, false), domain)
    }

    fn from(places: &[Point], (centres, same): (&[Point], bool), domain: &Region) -> Self {
        let spacing = maximal_spacing(domain.area(), centres.len());
        let (grid, bounds) = (CellGrid::new(centres, spacing), domain.bounds());
        let farthest = bounds.width().hypot(bounds.height());
        let tile = |p: &Point| {
            let at = |v: f64, extent: f64| ((v / extent * TILES as f64) as usize).min(TILES - 1);
            at(p.y - bounds.min.y, bounds.height()) * TILES + at(p.x - bounds.min.x, bounds.width())
        };
        let sample = |(i, p): (usize, &Point)| Sample {
            distance: nearest(&grid, centres, (*p, same.then_some(i)), spacing),
            clearance: domain.clearance(*p, farthest),
            tile: tile(p),
        };
        Self { samples: places.iter().enumerate().map(sample).collect() }
    }

    /// The 99 % quantile of the distances.
    fn range(&self) -> f64 {
        let mut sorted: Vec<f64> = self.samples.iter().map(|s| s.distance).filter(|d| d.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        sorted.get((sorted.len() as f64 * 0.99) as usize).or(sorted.last()).copied().unwrap_or(0.0)
    }

    /// The share of distances up to `r`, among places at least `r` from the border (the
    /// reduced-sample estimate).
    pub fn share(&self, r: f64) -> Option<f64> {
        ratio(self.samples.iter().map(|s| s.counts(r)).fold((0, 0), |a, b| (a.0 + b.0, a.1 + b.1)))
    }

    /// Counts for [`NearestDistances::share`], one pair a tile.
    fn tiles(&self, r: f64) -> Vec<(usize, usize)> {
        let mut tiles = vec![(0, 0); TILES * TILES];
        for s in &self.samples {
            let (near, all) = s.counts(r);
            tiles[s.tile] = (tiles[s.tile].0 + near, tiles[s.tile].1 + all);
        }
        tiles
    }
}

impl Sample {
    fn counts(&self, r: f64) -> (usize, usize) {
        let seen = self.clearance >= r;
        (usize::from(seen && self.distance <= r), usize::from(seen))
    }
}

fn ratio((near, all): (usize, usize)) -> Option<f64> {
    (all > 0).then(|| near as f64 / all as f64)
}

fn nearest(grid: &CellGrid, centres: &[Point], (p, itself): (Point, Option<usize>), spacing: f64) -> f64 {
    let mut radius = spacing;
    for _ in 0..MOST_DOUBLINGS {
        let mut least = f64::INFINITY;
        grid.for_each_near(p, radius, |j| {
            if itself != Some(j) {
                least = least.min(centres[j].distance(p));
            }
        });
        if least <= radius {
            return least;
        }
        radius *= 2.0;
    }
    f64::INFINITY
}

/// Where a distribution function of another pattern of the same kind is to be expected:
/// pointwise 95 % by bootstrap over 4 × 4 tiles, widened by √2 because two patterns are
/// compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    /// Distances, from 0 to the exemplar's 99 % quantile.
    pub distances: Vec<f64>,
    /// Lower bounds.
    pub lower: Vec<f64>,
    /// Upper bounds.
    pub upper: Vec<f64>,
}

impl Band {
    /// The band around the exemplar's function.
    pub fn of(exemplar: &NearestDistances, seed: u64) -> Self {
        let range = exemplar.range();
        let distances: Vec<f64> = (1..=PLACES).map(|k| range * k as f64 / PLACES as f64).collect();
        let mut random = Stream::new(seed, BOOTSTRAP, 0);
        let draws: Vec<Vec<usize>> =
            (0..RESAMPLES).map(|_| (0..TILES * TILES).map(|_| random.below(TILES * TILES)).collect()).collect();
        let bounds: Vec<(f64, f64)> = distances.iter().map(|r| bounds(exemplar, *r, &draws)).collect();
        Self { distances, lower: bounds.iter().map(|b| b.0).collect(), upper: bounds.iter().map(|b| b.1).collect() }
    }

    /// The share of the range at which the function of `pattern` lies inside the band.
    pub fn share_inside(&self, pattern: &NearestDistances) -> f64 {
        let inside = |k: &usize| {
            let value = pattern.share(self.distances[*k]);
            value.is_none_or(|v| v >= self.lower[*k] - 1e-12 && v <= self.upper[*k] + 1e-12)
        };
        (0..self.distances.len()).filter(inside).count() as f64 / self.distances.len() as f64
    }
}

fn bounds(exemplar: &NearestDistances, r: f64, draws: &[Vec<usize>]) -> (f64, f64) {
    let Some(estimate) = exemplar.share(r) else { return (0.0, 1.0) };
    let tiles = exemplar.tiles(r);
    let resampled =
        |draw: &Vec<usize>| ratio(draw.iter().map(|t| tiles[*t]).fold((0, 0), |a, b| (a.0 + b.0, a.1 + b.1)));
    let mut values: Vec<f64> = draws.iter().filter_map(resampled).collect();
    values.sort_by(f64::total_cmp);
    let quantile = |q: f64| values[((values.len() - 1) as f64 * q).round() as usize];
    let widened = |bound: f64| estimate + (bound - estimate) * std::f64::consts::SQRT_2;
    (widened(quantile(0.025)), widened(quantile(0.975)))
}

/// Nested pairs and partly overlapping pairs among disks, per 100 disks.
pub fn overlaps_per_hundred(elements: &[Element]) -> (f64, f64) {
    let centres: Vec<Point> = elements.iter().map(|e| e.centre).collect();
    let largest = elements.iter().map(|e| e.radius).fold(0.0, f64::max);
    let grid = CellGrid::new(&centres, largest.max(1e-9));
    let (mut nested, mut partly) = (0, 0);
    for (i, e) in elements.iter().enumerate() {
        grid.for_each_near(e.centre, e.radius + largest, |j| {
            if j > i {
                let (d, o) = (centres[j].distance(e.centre), elements[j].radius);
                nested += usize::from(d <= (e.radius - o).abs());
                partly += usize::from(d > (e.radius - o).abs() && d < e.radius + o);
            }
        });
    }
    let per_hundred = |pairs: usize| pairs as f64 * 100.0 / elements.len().max(1) as f64;
    (per_hundred(nested), per_hundred(partly))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::geometry::Bounds;

    fn uniform(count: usize, seed: u64) -> Vec<Element> {
        let mut random = Stream::new(seed, Purpose::new("test.quality"), 0);
        let mut place = || Point::new(random.unit(), random.unit());
        (0..count).map(|_| Element { centre: place(), radius: 0.0, class: 0 }).collect()
    }

    fn square() -> Region {
        Region::rectangle(Bounds::new(Point::default(), Point::new(1.0, 1.0))).unwrap()
    }

    #[test]
    fn a_uniform_pattern_has_the_known_functions() {
        let (elements, domain) = (uniform(2000, 1), square());
        for distances in
            [NearestDistances::between(&elements, &domain), NearestDistances::to_places(&elements, &domain)]
        {
            for r in [0.005, 0.01, 0.02] {
                let known = 1.0 - (-2000.0 * std::f64::consts::PI * r * r).exp();
                assert!((distances.share(r).unwrap() - known).abs() < 0.04);
            }
        }
    }

    #[test]
    fn a_second_pattern_of_the_same_kind_is_inside_the_band_and_another_kind_is_not() {
        let domain = square();
        let band = Band::of(&NearestDistances::between(&uniform(400, 1), &domain), 0);
        let same: f64 = (2..12).map(|s| band.share_inside(&NearestDistances::between(&uniform(400, s), &domain))).sum();
        assert!(same / 10.0 > 0.85, "{same}");
        let lattice: Vec<Element> = (0..400)
            .map(|k| Element {
                centre: Point::new((f64::from(k % 20) + 0.5) / 20.0, (f64::from(k / 20) + 0.5) / 20.0),
                radius: 0.0,
                class: 0,
            })
            .collect();
        // Below its spacing a lattice has no neighbours at all, beyond it everyone has one: it
        // meets the band in the first few places and where all functions are 1.
        let lattice = NearestDistances::between(&lattice, &domain);
        let below = |k: &usize| (0.2 / 20.0..1.0 / 20.0).contains(&band.distances[*k]);
        assert!((0..PLACES).filter(below).all(|k| lattice.share(band.distances[k]) < Some(band.lower[k])));
        assert!(band.share_inside(&lattice) < 0.4);
    }

    #[test]
    fn nested_and_partly_overlapping_pairs_are_told_apart() {
        let disk = |x: f64, radius: f64| Element { centre: Point::new(x, 0.0), radius, class: 0 };
        assert_eq!(
            overlaps_per_hundred(&[disk(0.0, 2.0), disk(0.5, 1.0), disk(2.5, 1.0), disk(9.0, 1.0)]),
            (25.0, 25.0 + 0.0)
        );
    }
}
