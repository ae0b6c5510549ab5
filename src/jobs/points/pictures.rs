//! Pictures: a pattern as disks coloured by class, and curves with their envelopes.

use bytes::Bytes;

use crate::codec::colours::Rgb;
use crate::codec::colours::category;
use crate::codec::draw::Canvas;
use crate::codec::draw::Curve as Line;
use crate::codec::draw::Ink;
use crate::codec::draw::Plot;
use crate::codec::draw::Text;
use crate::codec::draw::View;
use crate::compute::geometry::Bounds;
use crate::compute::geometry::Point;
use crate::compute::geometry::Region;
use crate::compute::pcf::Analysis;
use crate::compute::pcf::Curve;
use crate::compute::pcf::Element;
use crate::jobs::Artefact;
use crate::jobs::Failure;

const WHITE: Rgb = [255, 255, 255];
const GROUND: Ink = Ink::solid([246, 246, 242]);
const BORDER: Ink = Ink::solid([120, 120, 120]);

/// Longer side of the picture of a pattern, in pixels.
const SIDE: f64 = 1200.0;

/// Space for the key below it.
const KEY: f64 = 40.0;

/// A point is drawn at least this large, in pixels.
const LEAST_RADIUS: f64 = 2.0;

/// The most of its longer side that is shown around a domain, for disks that reach past it.
const MOST_OVERHANG: f64 = 0.2;

/// The most curves that are drawn; the document has all.
const MOST_CURVES: usize = 36;

/// A pattern in its domain. `groups` are names by the number that `group` gives an element.
///
/// # Errors
/// When the picture cannot be encoded.
pub fn pattern(
    elements: &[Element],
    domain: &Region,
    (groups, group): (&[String], impl Fn(usize) -> usize),
) -> Result<Artefact, Failure> {
    let world = domain.bounds().grown(overhang(elements, domain.bounds()));
    let scale = SIDE / world.width().max(world.height());
    let size = ((world.width() * scale).max(80.0) + 40.0, (world.height() * scale).max(80.0) + 40.0 + KEY);
    let mut canvas = Canvas::new(size.0 as usize, size.1 as usize, WHITE);
    let pixels = Bounds::new(Point::new(20.0, 20.0), Point::new(size.0 - 20.0, size.1 - 20.0 - KEY));
    let view = View::fit(world, pixels);
    for polygon in domain.polygons() {
        let rings: Vec<Vec<Point>> = polygon.rings().map(|r| view.all(r)).collect();
        canvas.polygon(&rings, GROUND);
        for mut ring in rings {
            ring.extend(ring.first().copied());
            canvas.stroke(&ring, 1.0, BORDER);
        }
    }
    // The largest first, so that nested disks stay visible.
    let mut order: Vec<usize> = (0..elements.len()).collect();
    order.sort_by(|a, b| elements[*b].radius.total_cmp(&elements[*a].radius).then(a.cmp(b)));
    for i in order {
        let (centre, radius) = (view.at(elements[i].centre), (elements[i].radius * view.scale).max(LEAST_RADIUS));
        canvas.disk(centre, radius, Ink::veil(category(group(i)), 0.55));
        canvas.circle(centre, radius, 1.0, Ink::solid(darker(category(group(i)))));
    }
    key(&mut canvas, groups, size.1);
    encoded(canvas)
}

/// How far disks reach past the `bounds` of their domain, as far as the picture shows it.
fn overhang(elements: &[Element], bounds: Bounds) -> f64 {
    let past = |e: &Element| {
        let inside = (e.centre - bounds.min, bounds.max - e.centre);
        e.radius - inside.0.x.min(inside.0.y).min(inside.1.x).min(inside.1.y)
    };
    let most = MOST_OVERHANG * bounds.width().max(bounds.height());
    elements.iter().map(past).fold(0.0, f64::max).min(most)
}

fn key(canvas: &mut Canvas, groups: &[String], height: f64) {
    let mut x = 24.0;
    for (k, name) in groups.iter().enumerate() {
        let text = Text::default();
        if x + text.width(name) + 20.0 > canvas.width() as f64 {
            break;
        }
        canvas.disk(Point::new(x, height - 24.0), 6.0, Ink::solid(category(k)));
        canvas.text(Point::new(x + 12.0, height - 20.0), name, &text);
        x += text.width(name) + 36.0;
    }
}

fn darker(colour: Rgb) -> Rgb {
    colour.map(|c| (f64::from(c) * 0.55) as u8)
}

/// The exemplar's curves with their envelopes, and, where there are `others`, the curves of what
/// was laid out.
///
/// # Errors
/// When the picture cannot be encoded.
pub fn curves(analysis: &Analysis, others: &[&Curve], name: impl Fn(usize) -> String) -> Result<Artefact, Failure> {
    let shown = analysis.curves.len().clamp(1, MOST_CURVES);
    let columns = (shown as f64).sqrt().ceil() as usize;
    let (width, height) = (440.0, 300.0);
    let rows = shown.div_ceil(columns);
    let mut canvas = Canvas::new(columns * width as usize, rows * height as usize, WHITE);
    for (k, curve) in analysis.curves.iter().take(MOST_CURVES).enumerate() {
        let corner = Point::new((k % columns) as f64 * width, (k / columns) as f64 * height);
        let other = others.iter().find(|o| (o.child, o.parent) == (curve.child, curve.parent)).copied();
        let area = Bounds::new(corner, corner + Point::new(width, height));
        plot(curve, other, &name).draw(&mut canvas, area);
    }
    encoded(canvas)
}

fn plot(curve: &Curve, other: Option<&Curve>, name: impl Fn(usize) -> String) -> Plot {
    let line = |label: &str, curve: &Curve, colour: Rgb, has_band: bool| Line {
        label: label.to_owned(),
        colour,
        points: curve.axis.places().into_iter().zip(curve.mean.iter().copied()).collect(),
        band: if has_band { curve.lower.iter().copied().zip(curve.upper.iter().copied()).collect() } else { vec![] },
    };
    let title = if curve.child == curve.parent {
        name(curve.child)
    } else {
        format!("{} looking at {}", name(curve.child), name(curve.parent))
    };
    let mut curves = vec![line("exemplar", curve, category(0), true)];
    curves.extend(other.map(|o| line("result", o, category(1), false)));
    Plot {
        title,
        x_label: "r (r_max)".to_owned(),
        y_label: "correlation".to_owned(),
        x_range: None,
        y_range: Some((0.0, top(curve, other))),
        reference: Some(1.0),
        curves,
    }
}

/// Where the plot ends: three times the highest mean, or the envelope if that is lower.
fn top(curve: &Curve, other: Option<&Curve>) -> f64 {
    let highest = |values: &[f64]| values.iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
    let mean = highest(&curve.mean).max(other.map_or(0.0, |o| highest(&o.mean)));
    highest(&curve.upper).min(3.0 * mean).max(mean * 1.1).max(1.5)
}

fn encoded(canvas: Canvas) -> Result<Artefact, Failure> {
    Ok(Artefact::Picture(Bytes::from(canvas.into_image().to_png().map_err(Failure::fault)?)))
}
