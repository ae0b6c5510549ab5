use super::ExtractionError;
use super::ellipses::Shape;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use std::collections::BTreeMap;

/// Steps of the flooding in a pixel of depth.
const LEVELS_PER_PIXEL: f32 = 8.0;

/// How touching animals are parted.
#[derive(Debug, Clone, PartialEq)]
pub struct WatershedOptions {
    /// Two basins stay one while the pass between them is at least this share of the lower of
    /// their depths. Default: 0.92 (ours, chosen on drawn herds).
    pub merge_depth: f64,
    /// Two neighbouring basins become one again when their union fills at least this share of
    /// its ellipse of equal second moments, as one animal does; two ellipses that touch fill at
    /// most 0.894. Default: 0.95 (ours, chosen on drawn herds).
    pub merge_fill: f64,
}

impl Default for WatershedOptions {
    fn default() -> Self {
        Self { merge_depth: 0.92, merge_fill: 0.95 }
    }
}

/// The regions of a mask: at best one per animal.
pub(super) struct Regions {
    /// Region of each pixel plus one, 0 on the ground.
    pub labels: Vec<u32>,
    /// Shape of each region, in the order of its first pixel.
    pub shapes: Vec<Shape>,
}

/// Parts the animal pixels into the catchment basins of the distance to the ground.
///
/// Flooding from the deepest pixel outwards by immersion (Vincent and Soille 1991): the pixels
/// come out of a bucket per level, each joins the deepest basin next to it or founds one. Where
/// two basins meet, the height of the pass decides whether they are one (the dynamics of
/// Grimaud 1992, relative to the depth); then the shape of unions decides.
pub(super) fn regions(
    distance: &Raster<f32>,
    options: &WatershedOptions,
    run: &Run,
) -> Result<Regions, ExtractionError> {
    let mut flood = Flood::new(distance, options.merge_depth);
    for (step, pixel) in by_falling_depth(distance).into_iter().enumerate() {
        if step % (1 << 16) == 0 {
            run.check()?;
        }
        flood.immerse(pixel as usize);
    }
    run.check()?;
    flood.unite_by_shape(options.merge_fill);
    Ok(flood.finish())
}

fn level(depth: f32) -> usize {
    (depth * LEVELS_PER_PIXEL).min(65_535.0) as usize
}

/// The animal pixels, deepest level first, in raster order within a level.
fn by_falling_depth(distance: &Raster<f32>) -> Vec<u32> {
    let mut starts = vec![0usize; 65_537];
    let animal = || distance.data.iter().enumerate().filter(|(_, d)| **d > 0.0);
    animal().for_each(|(_, d)| starts[65_535 - level(*d) + 1] += 1);
    for i in 1..starts.len() {
        starts[i] += starts[i - 1];
    }
    let mut order = vec![0u32; starts[65_536]];
    for (pixel, depth) in animal() {
        let slot = &mut starts[65_535 - level(*depth)];
        order[*slot] = pixel as u32;
        *slot += 1;
    }
    order
}

struct Flood<'a> {
    distance: &'a Raster<f32>,
    merge_depth: f64,
    labels: Vec<u32>,
    parent: Vec<u32>,
    peak: Vec<f32>,
    /// Passes between basins that stayed apart, in the order they were met.
    passes: Vec<(u32, u32)>,
}

impl<'a> Flood<'a> {
    fn new(distance: &'a Raster<f32>, merge_depth: f64) -> Self {
        let labels = vec![0; distance.data.len()];
        Self { distance, merge_depth, labels, parent: Vec::new(), peak: Vec::new(), passes: Vec::new() }
    }

    fn root(&mut self, mut basin: u32) -> u32 {
        while self.parent[basin as usize] != basin {
            let up = self.parent[self.parent[basin as usize] as usize];
            self.parent[basin as usize] = up;
            basin = up;
        }
        basin
    }

    fn immerse(&mut self, pixel: usize) {
        let (mut found, mut count) = ([0u32; 8], 0);
        let mut deepest = (f32::NEG_INFINITY, 0u32);
        let grid = self.distance.grid;
        for (neighbour, _) in grid.neighbours(pixel) {
            let label = self.labels[neighbour];
            if label == 0 {
                continue;
            }
            let basin = self.root(label - 1);
            let depth = self.distance.data[neighbour];
            if depth > deepest.0 {
                deepest = (depth, basin);
            }
            if !found[..count].contains(&basin) {
                found[count] = basin;
                count += 1;
            }
        }
        if count == 0 {
            let basin = self.parent.len() as u32;
            self.parent.push(basin);
            self.peak.push(self.distance.data[pixel]);
            self.labels[pixel] = basin + 1;
            return;
        }
        self.labels[pixel] = deepest.1 + 1;
        for i in 1..count {
            self.meet(found[0], found[i], self.distance.data[pixel]);
        }
    }

    fn meet(&mut self, a: u32, b: u32, pass: f32) {
        let (a, b) = (self.root(a), self.root(b));
        if a == b {
            return;
        }
        let lower = self.peak[a as usize].min(self.peak[b as usize]);
        // Two thirds of a pixel of relief are the raster's own.
        if f64::from(pass) >= self.merge_depth * f64::from(lower) || lower - pass < 0.67 {
            self.unite(a, b);
        } else if !self.passes.contains_recently(a, b) {
            self.passes.push((a, b));
        }
    }

    /// The deeper basin, or the elder of equals, gives its name.
    fn unite(&mut self, a: u32, b: u32) {
        let (pa, pb) = (self.peak[a as usize], self.peak[b as usize]);
        let (keep, give) = if pa > pb || (pa == pb && a < b) { (a, b) } else { (b, a) };
        self.parent[give as usize] = keep;
    }

    fn shapes(&mut self) -> BTreeMap<u32, Shape> {
        let mut shapes = vec![Shape::default(); self.parent.len()];
        for pixel in 0..self.labels.len() {
            if self.labels[pixel] > 0 {
                let basin = self.root(self.labels[pixel] - 1);
                shapes[basin as usize].add(self.distance.grid.cell(pixel));
            }
        }
        (0u32..).zip(shapes).filter(|(_, s)| s.area() > 0.0).collect()
    }

    /// Unites neighbours whose union looks like one ellipse, highest pass first.
    fn unite_by_shape(&mut self, merge_fill: f64) {
        let mut shapes = self.shapes();
        for (a, b) in std::mem::take(&mut self.passes) {
            let (a, b) = (self.root(a), self.root(b));
            let (Some(one), Some(two)) = (shapes.get(&a), shapes.get(&b)) else { continue };
            let union = one.united(two);
            if a != b && union.fill() >= merge_fill {
                self.unite(a, b);
                shapes.insert(self.root(a), union);
            }
        }
    }

    fn finish(mut self) -> Regions {
        let mut region_of = vec![0u32; self.parent.len()];
        let mut shapes: Vec<Shape> = Vec::new();
        let mut labels = std::mem::take(&mut self.labels);
        for (pixel, label) in labels.iter_mut().enumerate().filter(|(_, label)| **label > 0) {
            let basin = self.root(*label - 1) as usize;
            if region_of[basin] == 0 {
                shapes.push(Shape::default());
                region_of[basin] = shapes.len() as u32;
            }
            *label = region_of[basin];
            shapes[*label as usize - 1].add(self.distance.grid.cell(pixel));
        }
        Regions { labels, shapes }
    }
}

/// A pass is met at many pixels in a row: only its first is kept.
trait Recent {
    fn contains_recently(&self, a: u32, b: u32) -> bool;
}

impl Recent for Vec<(u32, u32)> {
    fn contains_recently(&self, a: u32, b: u32) -> bool {
        self.iter().rev().take(8).any(|pass| *pass == (a, b) || *pass == (b, a))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::geometry::Ellipse;
    use crate::compute::geometry::Point;
    use crate::compute::raster::Grid;
    use crate::compute::raster::distance_to_zero;

    fn drawn(ellipses: &[Ellipse]) -> Raster<u8> {
        let grid = Grid::new(120, 100, 1.0);
        let covered = |p: Point| ellipses.iter().any(|e| e.scale_to(p) <= 1.0);
        Raster { grid, data: (0..grid.len()).map(|i| u8::from(covered(grid.centre(i)))).collect() }
    }

    fn parted(ellipses: &[Ellipse]) -> Vec<Ellipse> {
        let mask = drawn(ellipses);
        let distance = distance_to_zero(&mask, &Run::silent()).unwrap();
        let regions = regions(&distance, &WatershedOptions::default(), &Run::silent()).unwrap();
        regions.shapes.iter().map(|s| s.ellipse(mask.grid)).collect()
    }

    fn ellipse(x: f64, y: f64, theta: f64) -> Ellipse {
        Ellipse { centre: Point::new(x, y), a: 20.0, b: 9.0, theta }
    }

    #[test]
    fn one_ellipse_is_one_region_whatever_its_angle() {
        for k in 0..24 {
            let one = ellipse(60.3, 50.8, f64::from(k) * 0.13);
            let found = parted(&[one]);
            assert_eq!(found.len(), 1, "angle {}", one.theta);
            assert!(found[0].centre.distance(one.centre) < 0.2, "{found:?}");
            assert!((found[0].a - one.a).abs() < 0.2 && (found[0].b - one.b).abs() < 0.2, "{:?}", found[0]);
            assert!(found[0].heading().cross(one.heading()).abs() < 0.02);
        }
    }

    #[test]
    fn two_ellipses_that_touch_are_parted() {
        for (other, name) in [
            (ellipse(92.0, 50.0, 0.1), "end to end"),
            (ellipse(82.0, 60.0, 1.3), "end to side"),
            (ellipse(64.0, 66.4, 0.0), "side by side"),
        ] {
            let one = ellipse(54.0, 50.0, 0.0);
            let found = parted(&[one, other]);
            assert_eq!(found.len(), 2, "{name}");
            for e in [one, other] {
                assert!(found.iter().any(|f| f.centre.distance(e.centre) < 2.0), "{name}: {found:?}");
            }
        }
    }
}
