//! A small canvas: what every picture of the service is drawn with.
//!
//! Pixels are counted from the upper left corner, x to the right, y **down**; the centre of the
//! first pixel is (0.5, 0.5). [`View`] takes points of the world (y up) there. Edges are
//! antialiased by coverage. Everything is drawn in the order of the calls, so pictures are the
//! same on any number of threads.
//!
//! ```
//! use biotope::codec::draw::{Canvas, Ink, Text};
//! use biotope::compute::geometry::Point;
//! let mut canvas = Canvas::new(200, 100, [255, 255, 255]);
//! canvas.disk(Point::new(50.0, 50.0), 20.0, Ink::solid([0, 120, 80]));
//! canvas.stroke(&[Point::new(10.0, 90.0), Point::new(190.0, 10.0)], 1.5, Ink::veil([0, 0, 0], 0.5));
//! canvas.text(Point::new(80.0, 55.0), "460 disks", &Text::default());
//! let png = canvas.into_image().to_png()?;
//! # Ok::<(), png::EncodingError>(())
//! ```

mod canvas;
mod font;
mod glyphs;
mod plot;
mod ticks;
mod view;

pub use canvas::{Canvas, Ink};
pub use font::{Align, Text};
pub use plot::{Curve, Plot};
pub use ticks::Ticks;
pub use view::View;
