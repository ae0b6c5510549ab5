//! Herds made for tests and benchmarks.

use biotope::compute::geometry::Ellipse;
use biotope::compute::geometry::Point;
use biotope::compute::random::Purpose;
use biotope::compute::random::Stream;

/// Semi-axes of an animal in metres.
pub const BODY: (f64, f64) = (1.2, 0.5);

/// A herd as on a photo: an oval with a dense head and a loose tail, animals apart from each
/// other, headings that fan out.
pub fn exemplar(count: usize, seed: u64) -> Vec<Ellipse> {
    let mut random = Stream::new(seed, Purpose::new("test.exemplar"), count as u64);
    let extent = 9.0 * (count as f64).sqrt();
    let mut herd: Vec<Ellipse> = Vec::new();
    let mut gap = 1.0;
    while herd.len() < count {
        let p = Point::new(random.range(-1.0, 1.0), random.range(-0.6, 0.6));
        let inside = p.x * p.x + (p.y / 0.6).powi(2) < 1.0;
        let dense = random.unit() < 0.35 + 0.65 * (0.5 + 0.5 * p.x);
        let e = Ellipse {
            centre: Point::new(400.0, 300.0) + p * extent,
            a: random.range(7.0, 9.0),
            b: random.range(3.0, 3.6),
            theta: 0.5 * p.y + 0.3 * p.x + random.range(-0.1, 0.1),
        };
        let free = |gap: f64| herd.iter().all(|o| o.scale_to(e.centre) > 1.9 * gap && e.scale_to(o.centre) > 1.9 * gap);
        if inside && dense && free(gap) {
            herd.push(e);
        } else {
            gap *= 0.99997;
        }
    }
    herd
}

/// A herd of `count` around `centre`, `spacing` metres apart, all heading about `theta`.
pub fn herd(count: usize, centre: Point, (spacing, theta): (f64, f64), seed: u64) -> Vec<Ellipse> {
    let mut random = Stream::new(seed, Purpose::new("test.herd"), 0);
    let columns = (count as f64).sqrt().ceil() as usize;
    let mut herd: Vec<Ellipse> = (0..count)
        .map(|i| {
            let cell = Point::new((i % columns) as f64, (i / columns) as f64) * spacing;
            let jitter = Point::new(random.range(-0.2, 0.2), random.range(-0.2, 0.2)) * spacing;
            Ellipse { centre: cell + jitter, a: BODY.0, b: BODY.1, theta: theta + random.range(-0.3, 0.3) }
        })
        .collect();
    let mean = herd.iter().fold(Point::default(), |s, e| s + e.centre) * (1.0 / count as f64);
    herd.iter_mut().for_each(|e| e.centre = centre + (e.centre - mean).rotated(theta));
    herd
}
