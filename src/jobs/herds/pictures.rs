//! Pictures of herds.

use bytes::Bytes;

use crate::codec::colours::Rgb;
use crate::codec::draw::Canvas;
use crate::codec::draw::Ink;
use crate::codec::draw::Text;
use crate::codec::draw::View;
use crate::codec::picture::Image;
use crate::compute::geometry::Bounds;
use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Point;
use crate::jobs::Artefact;
use crate::jobs::Failure;
use crate::jobs::herds::ellipses::Row;

/// Longest side of the overlay, in pixels.
const OVERLAY_SIDE: usize = 2400;

/// Height of the line below a picture that says what its colours mean.
const KEY: usize = 30;

/// Outline of an animal, and of one that is suspect.
const SURE: Rgb = [0, 229, 255];
const SUSPECT: Rgb = [255, 60, 0];

/// Animals whose numbers are written: more would hide the picture.
const MOST_NUMBERS: usize = 400;

/// The photo with the outline of every animal, its heading and its number; those that may not be
/// one animal in another colour.
///
/// # Errors
/// When the picture cannot be encoded.
pub fn overlay(photo: &Image, rows: &[Row]) -> Result<Artefact, Failure> {
    let shrunk = photo.shrunk(OVERLAY_SIDE);
    let world = Bounds::new(Point::default(), Point::new(photo.width as f64, photo.height as f64));
    let scale = shrunk.width as f64 / photo.width as f64;
    let (width, height) = (shrunk.width, shrunk.height);
    let view = View::fit(world, Bounds::new(Point::default(), world.max * scale));
    let mut canvas = Canvas::new(width, height + KEY, [255; 3]);
    canvas.paste(&shrunk, 0, 0);
    for row in rows {
        outline(&mut canvas, &view.ellipse(&row.ellipse), if row.why.is_empty() { SURE } else { SUSPECT });
    }
    if rows.len() <= MOST_NUMBERS {
        rows.iter().for_each(|row| number(&mut canvas, &view.ellipse(&row.ellipse), row.id));
    }
    let suspects = rows.iter().filter(|row| !row.why.is_empty()).count();
    let entries = [(SURE, format!("animals: {}", rows.len() - suspects)), (SUSPECT, format!("suspect: {suspects}"))];
    key(&mut canvas, &entries);
    encoded(canvas)
}

fn outline(canvas: &mut Canvas, ellipse: &Ellipse, colour: Rgb) {
    let width = (ellipse.b * 0.18).clamp(1.2, 3.0);
    canvas.ellipse_outline(ellipse, width + 1.4, Ink::veil([0; 3], 0.45));
    canvas.ellipse_outline(ellipse, width, Ink::solid(colour));
    let tip = ellipse.centre + ellipse.heading() * ellipse.a;
    canvas.stroke(&[ellipse.centre + ellipse.heading() * (0.45 * ellipse.a), tip], width, Ink::solid(colour));
}

fn number(canvas: &mut Canvas, ellipse: &Ellipse, id: u64) {
    let style = Text { size: 6.0, ink: Ink::solid([0; 3]), halo: Some([255; 3]), ..Text::default() };
    let right = ellipse.centre + Point::new(0.7 * ellipse.b + 1.0, -0.7 * ellipse.b - 1.0);
    canvas.text(right, &id.to_string(), &style);
}

/// One line of colours and what they mean, at the lower rim.
pub fn key(canvas: &mut Canvas, entries: &[(Rgb, String)]) {
    let text = Text::default();
    let y = canvas.height() as f64 - KEY as f64 / 2.0;
    let mut x = 12.0;
    for (colour, label) in entries {
        if x + text.width(label) + 24.0 > canvas.width() as f64 {
            break;
        }
        canvas.disk(Point::new(x + 6.0, y), 6.0, Ink::solid(*colour));
        canvas.text(Point::new(x + 18.0, y + 4.0), label, &text);
        x += text.width(label) + 44.0;
    }
}

/// The canvas as a picture to hand back.
///
/// # Errors
/// When it cannot be encoded.
pub fn encoded(canvas: Canvas) -> Result<Artefact, Failure> {
    Ok(Artefact::Picture(Bytes::from(canvas.into_image().to_png().map_err(Failure::fault)?)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::picture::MAX_PIXELS;

    #[test]
    fn suspect_animals_are_outlined_in_a_colour_of_their_own() {
        let photo = Image { width: 200, height: 100, rgb: vec![[90, 110, 60]; 20_000] };
        let row = |id: u64, x: f64, why: &str| {
            let ellipse = Ellipse { centre: Point::new(x, 50.0), a: 30.0, b: 14.0, theta: 0.0 };
            Row { id, ellipse, why: why.to_owned() }
        };
        let Ok(Artefact::Picture(png)) = overlay(&photo, &[row(0, 50.0, ""), row(1, 150.0, "size")]) else {
            panic!("no picture")
        };
        let drawn = Image::read(&png, MAX_PIXELS).unwrap();
        assert_eq!((drawn.width, drawn.height), (200, 100 + KEY));
        let of = |colour: Rgb, columns: std::ops::Range<usize>| {
            let is = |(x, y): &(usize, usize)| drawn.rgb[y * drawn.width + x] == colour;
            (0..100).flat_map(|y| columns.clone().map(move |x| (x, y))).filter(is).count()
        };
        assert!(of(SURE, 0..100) > 100 && of(SUSPECT, 100..200) > 100);
        assert_eq!((of(SUSPECT, 0..100), of(SURE, 100..200)), (0, 0));
    }
}
