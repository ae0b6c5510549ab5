//! Letters as strokes of a pen, drawn for this project: no font file, any size, any angle.
//!
//! The glyphs stand in [`super::glyphs`]; here they are placed and drawn.

use super::canvas::Canvas;
use super::canvas::Ink;
use super::glyphs;
use crate::codec::colours::Rgb;
use crate::compute::geometry::Point;

/// Grid units from the baseline to the top of a capital.
const CAPITAL: f64 = 6.0;
/// Grid units between letters.
const GAP: f64 = 1.9;
const BASELINE: f64 = 2.0;

/// On which side of its place a text lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// It begins there.
    Start,
    /// Its middle is there.
    Middle,
    /// It ends there.
    End,
}

/// How a text looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Text {
    /// Height of a capital in pixels.
    pub size: f64,
    /// Colour.
    pub ink: Ink,
    /// Which point of the baseline is placed.
    pub align: Align,
    /// Direction of the baseline, radians **clockwise** on the picture; −π/2 reads upwards.
    pub angle: f64,
    /// Twice as thick.
    pub bold: bool,
    /// Colour of a rim around the letters, to read them on a picture.
    pub halo: Option<Rgb>,
}

impl Default for Text {
    fn default() -> Self {
        Self { size: 9.0, ink: Ink::solid([30; 3]), align: Align::Start, angle: 0.0, bold: false, halo: None }
    }
}

impl Text {
    /// Width of `text` in pixels.
    pub fn width(&self, text: &str) -> f64 {
        let units: f64 = text.chars().map(|c| advance(glyph(c).0)).sum();
        (units - GAP).max(0.0) * self.size / CAPITAL
    }

    /// `text`, cut with an ellipsis to fit into `width` pixels.
    pub fn fitted(&self, text: &str, width: f64) -> String {
        if self.width(text) <= width {
            return text.to_owned();
        }
        let mut short: String = text.to_owned();
        while !short.is_empty() && self.width(&format!("{short}…")) > width {
            short.pop();
        }
        short + "…"
    }
}

impl Canvas {
    /// Writes one line of text with its baseline at `at`. A character that is not known is drawn
    /// as a box.
    pub fn text(&mut self, at: Point, text: &str, style: &Text) {
        let unit = style.size / CAPITAL;
        let shift = match style.align {
            Align::Start => 0.0,
            Align::Middle => 0.5,
            Align::End => 1.0,
        };
        let place = Place { at: snapped(at, style.angle), unit, angle: style.angle };
        let mut x = -shift * style.width(text) / unit;
        if style.angle == 0.0 {
            x = (x * unit).round() / unit;
        }
        let mut lines = Vec::new();
        for c in text.chars() {
            let (strokes, accent) = glyph(c);
            let rise = if c.is_uppercase() { 2.0 } else { 0.0 };
            lines.extend(strokes.split(' ').map(|s| place.stroke(s, x, 0.0)));
            lines.extend(accent.split(' ').filter(|s| !s.is_empty()).map(|s| place.stroke(s, x, rise)));
            x += advance(strokes);
        }
        lines.retain(|l| !l.is_empty());
        let weight = (style.size * if style.bold { 0.2 } else { 0.125 }).max(1.15);
        if let Some(halo) = style.halo {
            self.strokes(&lines, weight + 3.0, Ink::veil(halo, 0.85));
        }
        self.strokes(&lines, weight, style.ink);
    }
}

/// Centres of pixels, so that stems of level text are sharp.
fn snapped(at: Point, angle: f64) -> Point {
    if angle == 0.0 { Point::new(at.x.floor() + 0.5, at.y.floor() + 0.5) } else { at }
}

/// Where the grid of the glyphs lies on the picture.
struct Place {
    at: Point,
    unit: f64,
    angle: f64,
}

impl Place {
    fn stroke(&self, stroke: &str, x: f64, rise: f64) -> Vec<Point> {
        let mut bytes = stroke.bytes();
        let kind = bytes.next();
        let digits: Vec<f64> = bytes.map(|b| f64::from(b) - f64::from(b'0')).collect();
        let points: Vec<Point> = digits.chunks_exact(2).map(|d| Point::new(d[0], d[1])).collect();
        let line = match kind {
            Some(b'~') => rounded(&points),
            Some(b'o') => rounded_ring(&points),
            _ => points,
        };
        line.iter().map(|p| self.pixel(Point::new(p.x + x, p.y + rise - BASELINE))).collect()
    }

    fn pixel(&self, p: Point) -> Point {
        self.at + (Point::new(p.x, -p.y) * self.unit).rotated(self.angle)
    }
}

/// Rounds every inner corner by a parabola between the middles of its sides.
fn rounded(points: &[Point]) -> Vec<Point> {
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return Vec::new();
    };
    let corners = points.windows(3).flat_map(|w| corner(w[0].lerp(w[1], 0.5), w[1], w[1].lerp(w[2], 0.5)));
    std::iter::once(*first).chain(corners).chain([*last]).collect()
}

fn rounded_ring(points: &[Point]) -> Vec<Point> {
    let n = points.len();
    let at = |i: usize| points[i % n];
    (0..=n).flat_map(|i| corner(at(i).lerp(at(i + 1), 0.5), at(i + 1), at(i + 1).lerp(at(i + 2), 0.5))).collect()
}

fn corner(a: Point, control: Point, b: Point) -> impl Iterator<Item = Point> {
    const STEPS: usize = 6;
    (0..=STEPS).map(move |i| {
        let t = i as f64 / STEPS as f64;
        a.lerp(control, t).lerp(control.lerp(b, t), t)
    })
}

/// Width of a glyph with the gap after it, in grid units.
fn advance(strokes: &str) -> f64 {
    if strokes.is_empty() {
        return 3.5;
    }
    let widest = strokes.split(' ').flat_map(|s| s.bytes().skip(1).step_by(2)).max();
    f64::from(widest.unwrap_or(b'0')) - f64::from(b'0') + GAP
}

/// The strokes of a character, and those of its accent.
fn glyph(c: char) -> (&'static str, &'static str) {
    match glyphs::accented(c) {
        Some((base, accent)) => (glyphs::plain(base), accent),
        None => (glyphs::plain(c), ""),
    }
}
