use crate::codec::colours::Rgb;
use crate::codec::picture::Image;
use crate::compute::geometry::Bounds;
use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Point;

/// What shapes are filled with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ink {
    /// The colour.
    pub colour: Rgb,
    /// 0 invisible to 1 opaque.
    pub alpha: f64,
}

impl Ink {
    /// Opaque.
    pub const fn solid(colour: Rgb) -> Self {
        Self { colour, alpha: 1.0 }
    }

    /// See-through.
    pub const fn veil(colour: Rgb, alpha: f64) -> Self {
        Self { colour, alpha }
    }
}

/// A picture to draw on.
#[derive(Debug, Clone, PartialEq)]
pub struct Canvas {
    image: Image,
}

/// How much of each pixel of a part of the canvas a shape covers.
struct Mask {
    left: usize,
    top: usize,
    width: usize,
    cover: Vec<f32>,
}

impl Canvas {
    /// A canvas of one colour.
    pub fn new(width: usize, height: usize, background: Rgb) -> Self {
        Self { image: Image { width, height, rgb: vec![background; width * height] } }
    }

    /// A canvas that begins as a picture.
    pub const fn over(image: Image) -> Self {
        Self { image }
    }

    /// The picture.
    pub fn into_image(self) -> Image {
        self.image
    }

    /// The picture so far.
    pub const fn image(&self) -> &Image {
        &self.image
    }

    /// Width in pixels.
    pub const fn width(&self) -> usize {
        self.image.width
    }

    /// Height in pixels.
    pub const fn height(&self) -> usize {
        self.image.height
    }

    /// Copies `image` with its upper left corner at pixel (`left`, `top`); what does not fit is
    /// cut off.
    pub fn paste(&mut self, image: &Image, left: usize, top: usize) {
        let width = image.width.min(self.width().saturating_sub(left));
        let rows = image.height.min(self.height().saturating_sub(top));
        for row in 0..rows {
            let at = (top + row) * self.width() + left;
            let from = row * image.width;
            self.image.rgb[at..at + width].copy_from_slice(&image.rgb[from..from + width]);
        }
    }

    /// A filled disk.
    pub fn disk(&mut self, centre: Point, radius: f64, ink: Ink) {
        self.cover(box_around(centre, radius), ink, |p| radius - p.distance(centre) + 0.5);
    }

    /// The outline of a disk.
    pub fn circle(&mut self, centre: Point, radius: f64, width: f64, ink: Ink) {
        let reach = box_around(centre, radius + width);
        self.cover(reach, ink, |p| width / 2.0 - (p.distance(centre) - radius).abs() + 0.5);
    }

    /// A filled ellipse, in pixels ([`super::View::ellipse`] makes one of the world's).
    pub fn ellipse(&mut self, ellipse: &Ellipse, ink: Ink) {
        self.cover(box_around(ellipse.centre, ellipse.a), ink, |p| 0.5 - rim_distance(ellipse, p));
    }

    /// The outline of an ellipse.
    pub fn ellipse_outline(&mut self, ellipse: &Ellipse, width: f64, ink: Ink) {
        let reach = box_around(ellipse.centre, ellipse.a + width);
        self.cover(reach, ink, |p| width / 2.0 - rim_distance(ellipse, p).abs() + 0.5);
    }

    /// An axis-parallel filled rectangle.
    pub fn rectangle(&mut self, bounds: Bounds, ink: Ink) {
        let overlap = |lo: f64, hi: f64, at: f64| ((at + 0.5).min(hi) - (at - 0.5).max(lo)).max(0.0);
        self.cover(bounds, ink, |p| {
            overlap(bounds.min.x, bounds.max.x, p.x) * overlap(bounds.min.y, bounds.max.y, p.y)
        });
    }

    /// A line through `points` with round ends and joints, evenly inked where it crosses itself.
    pub fn stroke(&mut self, points: &[Point], width: f64, ink: Ink) {
        self.strokes(&[points.to_vec()], width, ink);
    }

    /// Several lines inked as one.
    pub fn strokes(&mut self, lines: &[Vec<Point>], width: f64, ink: Ink) {
        let Some(bounds) = Bounds::of(lines.iter().flatten().copied().filter(|p| p.is_finite())) else {
            return;
        };
        let Some(mut mask) = self.mask(bounds.grown(width / 2.0 + 1.0)) else {
            return;
        };
        for line in lines {
            let last = line.len().saturating_sub(1);
            for i in 0..last.max(usize::from(!line.is_empty())) {
                mask.segment(line[i], line[(i + 1).min(last)], width / 2.0);
            }
        }
        self.ink(&mask, ink);
    }

    /// The area inside `rings` by the even-odd rule: a ring within another is a hole. Rings
    /// close by themselves.
    pub fn polygon(&mut self, rings: &[Vec<Point>], ink: Ink) {
        let Some(bounds) = Bounds::of(rings.iter().flatten().copied()).filter(|b| (b.min + b.max).is_finite()) else {
            return;
        };
        let Some(mut mask) = self.mask(bounds.grown(1.0)) else {
            return;
        };
        mask.fill(rings);
        self.ink(&mask, ink);
    }

    /// Inks every pixel of `bounds` by how much of it is covered.
    fn cover(&mut self, bounds: Bounds, ink: Ink, coverage: impl Fn(Point) -> f64) {
        let Some((columns, rows)) = self.pixels(bounds.grown(1.0)) else {
            return;
        };
        for y in rows {
            for x in columns.clone() {
                let cover = coverage(Point::new(x as f64 + 0.5, y as f64 + 0.5)).clamp(0.0, 1.0);
                blend(&mut self.image.rgb[y * self.image.width + x], ink, cover);
            }
        }
    }

    fn mask(&self, bounds: Bounds) -> Option<Mask> {
        let (columns, rows) = self.pixels(bounds)?;
        let cover = vec![0.0; columns.len() * rows.len()];
        Some(Mask { left: columns.start, top: rows.start, width: columns.len(), cover })
    }

    fn ink(&mut self, mask: &Mask, ink: Ink) {
        for (row, cover) in mask.cover.chunks_exact(mask.width).enumerate() {
            let at = (mask.top + row) * self.image.width + mask.left;
            for (pixel, cover) in self.image.rgb[at..].iter_mut().zip(cover) {
                blend(pixel, ink, f64::from(*cover));
            }
        }
    }

    /// The pixels that `bounds` touches, as ranges; `None` when there are none.
    fn pixels(&self, bounds: Bounds) -> Option<(std::ops::Range<usize>, std::ops::Range<usize>)> {
        let range = |lo: f64, hi: f64, size: usize| {
            let clip = |v: f64| v.clamp(0.0, size as f64) as usize;
            clip(lo.floor())..clip(hi.ceil())
        };
        let columns = range(bounds.min.x, bounds.max.x, self.width());
        let rows = range(bounds.min.y, bounds.max.y, self.height());
        (!columns.is_empty() && !rows.is_empty()).then_some((columns, rows))
    }
}

impl Mask {
    /// Covers what lies within `half` of the segment from `a` to `b`.
    fn segment(&mut self, a: Point, b: Point, half: f64) {
        if !(a.is_finite() && b.is_finite()) {
            return;
        }
        let height = self.cover.len() / self.width;
        let reach = half + 1.0;
        let clip = |v: f64, from: usize, size: usize| (v - from as f64).clamp(0.0, size as f64) as usize;
        let left = clip(a.x.min(b.x) - reach, self.left, self.width);
        let right = clip(a.x.max(b.x) + reach + 1.0, self.left, self.width);
        let top = clip(a.y.min(b.y) - reach, self.top, height);
        let bottom = clip(a.y.max(b.y) + reach + 1.0, self.top, height);
        let along = b - a;
        let scale = 1.0 / along.norm_sq().max(1e-12);
        for y in top..bottom {
            for x in left..right {
                let p = Point::new((self.left + x) as f64 + 0.5, (self.top + y) as f64 + 0.5);
                let t = ((p - a).dot(along) * scale).clamp(0.0, 1.0);
                let cover = (half - p.distance(a + along * t) + 0.5).clamp(0.0, (2.0 * half).min(1.0)) as f32;
                let cell = &mut self.cover[y * self.width + x];
                *cell = cell.max(cover);
            }
        }
    }

    /// Covers the inside of `rings`: four scan lines a pixel, exact along each.
    fn fill(&mut self, rings: &[Vec<Point>]) {
        const LINES: usize = 4;
        let rows = self.cover.len() / self.width;
        for line in 0..rows * LINES {
            let y = self.top as f64 + (line as f64 + 0.5) / LINES as f64;
            let mut crossings: Vec<f64> = rings.iter().flat_map(|ring| ring_crossings(ring, y)).collect();
            crossings.sort_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                self.span(line / LINES, pair[0], pair[1], 1.0 / LINES as f32);
            }
        }
    }

    fn span(&mut self, row: usize, from: f64, to: f64, weight: f32) {
        let from = (from - self.left as f64).clamp(0.0, self.width as f64);
        let to = (to - self.left as f64).clamp(0.0, self.width as f64);
        for x in from as usize..(to.ceil() as usize).min(self.width) {
            let part = (to.min(x as f64 + 1.0) - from.max(x as f64)).max(0.0) as f32;
            self.cover[row * self.width + x] += weight * part;
        }
    }
}

fn ring_crossings(ring: &[Point], y: f64) -> impl Iterator<Item = f64> + '_ {
    (0..ring.len()).filter_map(move |i| {
        let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
        ((a.y <= y) != (b.y <= y)).then(|| a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x))
    })
}

fn box_around(centre: Point, reach: f64) -> Bounds {
    Bounds::new(centre, centre).grown(reach)
}

/// Distance to the rim, negative inside; to first order, which is exact on the rim.
fn rim_distance(ellipse: &Ellipse, p: Point) -> f64 {
    let q = (p - ellipse.centre).rotated(-ellipse.theta);
    let s = (q.x / ellipse.a).hypot(q.y / ellipse.b);
    let gradient = (q.x / ellipse.a.powi(2)).hypot(q.y / ellipse.b.powi(2));
    if gradient > 0.0 { (s - 1.0) * s / gradient } else { -ellipse.b }
}

fn blend(pixel: &mut Rgb, ink: Ink, cover: f64) {
    let alpha = cover.min(1.0) * ink.alpha;
    if alpha <= 0.0 {
        return;
    }
    for (under, over) in pixel.iter_mut().zip(ink.colour) {
        let mixed = f64::from(*under) + (f64::from(over) - f64::from(*under)) * alpha;
        *under = (mixed + 0.5) as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INK: Ink = Ink::solid([0, 0, 0]);

    /// Total ink on a white canvas, in pixels.
    fn area(draw: impl Fn(&mut Canvas)) -> f64 {
        let mut canvas = Canvas::new(100, 80, [255; 3]);
        draw(&mut canvas);
        canvas.image.rgb.iter().map(|p| 1.0 - f64::from(p[0]) / 255.0).sum()
    }

    fn square(lo: f64, hi: f64) -> Vec<Point> {
        vec![Point::new(lo, lo), Point::new(hi, lo), Point::new(hi, hi), Point::new(lo, hi)]
    }

    #[test]
    fn shapes_cover_the_area_they_have() {
        use std::f64::consts::PI;
        let c = Point::new(50.3, 40.6);
        let e = Ellipse { centre: c, a: 30.0, b: 12.0, theta: 0.6 };
        assert!((area(|k| k.disk(c, 20.0, INK)) / (PI * 400.0) - 1.0).abs() < 0.005);
        assert!((area(|k| k.circle(c, 20.0, 3.0, INK)) / (PI * 120.0) - 1.0).abs() < 0.01);
        assert!((area(|k| k.ellipse(&e, INK)) / e.area() - 1.0).abs() < 0.01);
        assert!(
            (area(|k| k.rectangle(Bounds::new(Point::new(10.25, 9.5), Point::new(20.5, 30.0)), INK)) - 10.25 * 20.5)
                .abs()
                < 0.3
        );
        let line = [Point::new(10.0, 10.0), Point::new(70.0, 55.0)];
        assert!((area(|k| k.stroke(&line, 4.0, INK)) / (75.0 * 4.0 + PI * 4.0) - 1.0).abs() < 0.02);
    }

    #[test]
    fn a_ring_within_a_ring_is_a_hole() {
        let rings = [square(10.3, 60.3), square(20.5, 40.5)];
        assert!((area(|k| k.polygon(&rings, INK)) - (2500.0 - 400.0)).abs() < 12.0);
    }

    #[test]
    fn a_veiled_line_is_even_where_it_meets_itself() {
        let mut canvas = Canvas::new(60, 60, [255; 3]);
        let bow = [Point::new(5.0, 5.0), Point::new(55.0, 55.0), Point::new(55.0, 5.0), Point::new(5.0, 55.0)];
        canvas.stroke(&bow, 5.0, Ink::veil([0, 0, 0], 0.5));
        assert_eq!(canvas.image.rgb.iter().map(|p| p[0]).min(), Some(128));
    }

    #[test]
    fn what_lies_outside_or_is_not_a_number_leaves_no_trace_and_no_panic() {
        let far = [Point::new(-1e9, 3.0), Point::new(f64::NAN, 1.0), Point::new(1e30, -1e30)];
        let ink = area(|k| {
            k.disk(Point::new(1e12, 0.0), 5.0, INK);
            k.disk(Point::new(f64::NAN, 0.0), 5.0, INK);
            k.polygon(&[vec![Point::new(f64::INFINITY, 0.0), Point::new(1.0, 1.0)]], INK);
            k.polygon(&[Vec::new()], INK);
            k.stroke(&[], 2.0, INK);
            k.stroke(&far[1..2], 2.0, INK);
        });
        assert_eq!(ink, 0.0);
        area(|k| k.stroke(&far, 2.0, INK));
    }

    #[test]
    fn pasting_cuts_off_what_does_not_fit() {
        let mut canvas = Canvas::new(4, 4, [255; 3]);
        canvas.paste(&Image { width: 3, height: 3, rgb: vec![[7; 3]; 9] }, 2, 3);
        assert_eq!(canvas.image.rgb.iter().filter(|p| p[0] == 7).count(), 2);
    }
}
