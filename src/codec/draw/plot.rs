use super::canvas::Canvas;
use super::canvas::Ink;
use super::font::Align;
use super::font::Text;
use super::ticks::Ticks;
use crate::codec::colours::Rgb;
use crate::compute::geometry::Bounds;
use crate::compute::geometry::Point;

const AXIS: Ink = Ink::solid([70; 3]);
const RULE: Ink = Ink::solid([228; 3]);

/// One curve of a plot, with the envelope around it.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Its name in the key; empty for none.
    pub label: String,
    /// Its colour.
    pub colour: Rgb,
    /// Its points, x ascending. Points that are not finite break the curve.
    pub points: Vec<(f64, f64)>,
    /// Lower and upper bound at each point, or nothing.
    pub band: Vec<(f64, f64)>,
}

/// Curves over one pair of axes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plot {
    /// Written above.
    pub title: String,
    /// Written below, with the unit.
    pub x_label: String,
    /// Written at the left, with the unit.
    pub y_label: String,
    /// Ends of the axes; `None`: whatever holds all curves and bands.
    pub x_range: Option<(f64, f64)>,
    /// The same for y.
    pub y_range: Option<(f64, f64)>,
    /// A thin level line, such as 1 for a pair correlation.
    pub reference: Option<f64>,
    /// The curves, the last on top.
    pub curves: Vec<Curve>,
}

/// From values to pixels within the frame.
struct Frame {
    pixels: Bounds,
    x: (f64, f64),
    y: (f64, f64),
}

impl Plot {
    /// Draws the plot, with its labels, into the rectangle `area` of the canvas.
    pub fn draw(&self, canvas: &mut Canvas, area: Bounds) {
        let frame = self.frame(area);
        self.grid(canvas, &frame);
        for curve in &self.curves {
            curve.band(canvas, &frame);
        }
        for curve in &self.curves {
            curve.line(canvas, &frame);
        }
        canvas.stroke(&frame.rim(), 1.0, AXIS);
        self.labels(canvas, &frame, area);
        self.key(canvas, &frame);
    }

    fn frame(&self, area: Bounds) -> Frame {
        let top = if self.title.is_empty() { 12.0 } else { 30.0 };
        let pixels = Bounds::new(
            Point::new((area.min.x + 62.0).round() + 0.5, (area.min.y + top).round() + 0.5),
            Point::new((area.max.x - 16.0).round() + 0.5, (area.max.y - 46.0).round() + 0.5),
        );
        let points = || self.curves.iter().flat_map(|c| c.points.iter());
        let bands = || self.curves.iter().flat_map(|c| c.band.iter().flat_map(|(lo, hi)| [*lo, *hi]));
        let x = self.x_range.unwrap_or_else(|| extent(points().map(|p| p.0), 0.0));
        let y =
            self.y_range.unwrap_or_else(|| extent(points().map(|p| p.1).chain(bands()).chain(self.reference), 0.05));
        Frame { pixels, x: opened(x), y: opened(y) }
    }

    fn grid(&self, canvas: &mut Canvas, frame: &Frame) {
        let style = Text { size: 8.0, ..Text::default() };
        let (left, bottom) = (frame.pixels.min.x, frame.pixels.max.y);
        let ticks = Ticks::linear(frame.x.0, frame.x.1, (frame.pixels.width() / 80.0).max(2.0) as usize);
        for value in &ticks.values {
            let x = frame.at(*value, frame.y.0).x.floor() + 0.5;
            canvas.stroke(&[Point::new(x, frame.pixels.min.y), Point::new(x, bottom)], 1.0, RULE);
            let text = Text { align: Align::Middle, ..style };
            canvas.text(Point::new(x, bottom + 16.0), &ticks.label(*value), &text);
        }
        let ticks = Ticks::linear(frame.y.0, frame.y.1, (frame.pixels.height() / 50.0).max(2.0) as usize);
        for value in &ticks.values {
            let y = frame.at(frame.x.0, *value).y.floor() + 0.5;
            canvas.stroke(&[Point::new(left, y), Point::new(frame.pixels.max.x, y)], 1.0, RULE);
            let text = Text { align: Align::End, ..style };
            canvas.text(Point::new(left - 6.0, y + 4.0), &ticks.label(*value), &text);
        }
        if let Some(value) = self.reference {
            let y = frame.at(frame.x.0, value).y;
            canvas.stroke(&[Point::new(left, y), Point::new(frame.pixels.max.x, y)], 1.0, Ink::solid([150; 3]));
        }
    }

    fn labels(&self, canvas: &mut Canvas, frame: &Frame, area: Bounds) {
        let middle = (frame.pixels.min + frame.pixels.max) * 0.5;
        let style = Text { align: Align::Middle, ..Text::default() };
        canvas.text(Point::new(middle.x, area.max.y - 10.0), &self.x_label, &style);
        let upwards = Text { angle: -std::f64::consts::FRAC_PI_2, ..style };
        canvas.text(Point::new(area.min.x + 15.5, middle.y), &self.y_label, &upwards);
        let title = style.fitted(&self.title, area.width());
        canvas.text(Point::new(middle.x, area.min.y + 18.0), &title, &Text { size: 10.0, bold: true, ..style });
    }

    /// The names of the curves in the upper right corner.
    fn key(&self, canvas: &mut Canvas, frame: &Frame) {
        let style = Text { size: 8.0, align: Align::End, halo: Some([255; 3]), ..Text::default() };
        let named = self.curves.iter().filter(|c| !c.label.is_empty());
        for (i, curve) in named.enumerate() {
            let y = frame.pixels.min.y + 18.0 + 17.0 * i as f64;
            let x = frame.pixels.max.x - 10.0;
            let swatch = [Point::new(x - 22.0, y - 4.0), Point::new(x, y - 4.0)];
            canvas.stroke(&swatch, 2.5, Ink::solid(curve.colour));
            canvas.text(Point::new(x - 30.0, y), &curve.label, &style);
        }
    }
}

impl Curve {
    fn band(&self, canvas: &mut Canvas, frame: &Frame) {
        let bounded: Vec<_> = self
            .points
            .iter()
            .zip(&self.band)
            .filter(|(p, b)| p.0.is_finite() && b.0.is_finite() && b.1.is_finite())
            .collect();
        let lower = bounded.iter().map(|(p, b)| frame.inside(p.0, b.0));
        let upper = bounded.iter().rev().map(|(p, b)| frame.inside(p.0, b.1));
        canvas.polygon(&[lower.chain(upper).collect()], Ink::veil(self.colour, 0.22));
    }

    fn line(&self, canvas: &mut Canvas, frame: &Frame) {
        let ink = Ink::solid(self.colour);
        for run in self.points.split(|p| !(p.0.is_finite() && p.1.is_finite())) {
            let line: Vec<Point> = run.iter().map(|p| frame.inside(p.0, p.1)).collect();
            canvas.stroke(&line, 1.8, ink);
        }
    }
}

impl Frame {
    fn at(&self, x: f64, y: f64) -> Point {
        let (u, v) = ((x - self.x.0) / (self.x.1 - self.x.0), (y - self.y.0) / (self.y.1 - self.y.0));
        Point::new(self.pixels.min.x + u * self.pixels.width(), self.pixels.max.y - v * self.pixels.height())
    }

    /// Clamped to the frame, so that a curve that leaves it runs along its edge.
    fn inside(&self, x: f64, y: f64) -> Point {
        self.at(x.clamp(self.x.0, self.x.1), y.clamp(self.y.0, self.y.1))
    }

    fn rim(&self) -> [Point; 5] {
        let (lo, hi) = (self.pixels.min, self.pixels.max);
        [lo, Point::new(hi.x, lo.y), hi, Point::new(lo.x, hi.y), lo]
    }
}

/// The least range of the finite values, widened by a share of itself.
fn extent(values: impl Iterator<Item = f64>, margin: f64) -> (f64, f64) {
    let (lo, hi) =
        values.filter(|v| v.is_finite()).fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(v), hi.max(v)));
    if lo > hi {
        return (0.0, 1.0);
    }
    let room = (hi - lo) * margin;
    (lo - room, hi + room)
}

/// A range with some extent.
fn opened((lo, hi): (f64, f64)) -> (f64, f64) {
    if hi - lo > 0.0 { (lo, hi) } else { (lo - 0.5, lo + 0.5) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area() -> Bounds {
        Bounds::new(Point::new(0.0, 0.0), Point::new(420.0, 300.0))
    }

    fn plot(curves: Vec<Curve>) -> Plot {
        Plot { title: "a ~ b".into(), x_label: "r (m)".into(), y_label: "g(r)".into(), curves, ..Plot::default() }
    }

    fn curve(points: Vec<(f64, f64)>, band: Vec<(f64, f64)>) -> Curve {
        Curve { label: "c".into(), colour: [200, 0, 0], points, band }
    }

    #[test]
    fn a_curve_is_drawn_where_its_values_are() {
        let mut canvas = Canvas::new(420, 300, [255; 3]);
        let p = plot(vec![curve(vec![(0.0, 0.0), (1.0, 1.0)], Vec::new())]);
        let p = Plot { x_range: Some((0.0, 1.0)), y_range: Some((0.0, 1.0)), ..p };
        p.draw(&mut canvas, area());
        let at = p.frame(area()).at(0.5, 0.5);
        let image = canvas.into_image();
        assert_eq!(image.rgb[at.y as usize * 420 + at.x as usize], [200, 0, 0]);
    }

    #[test]
    fn empty_constant_and_broken_curves_are_drawn_without_fuss() {
        let mut canvas = Canvas::new(420, 300, [255; 3]);
        plot(Vec::new()).draw(&mut canvas, area());
        plot(vec![curve(vec![(1.0, 2.0)], Vec::new())]).draw(&mut canvas, area());
        let broken = vec![(0.0, 1.0), (1.0, f64::NAN), (2.0, f64::INFINITY), (3.0, 1.0)];
        plot(vec![curve(broken, vec![(0.0, f64::NAN); 4])]).draw(&mut canvas, area());
        plot(Vec::new()).draw(&mut canvas, Bounds::new(Point::new(0.0, 0.0), Point::new(1.0, 1.0)));
    }
}
