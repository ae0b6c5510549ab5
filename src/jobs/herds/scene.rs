//! Pictures of the ground with what stands and walks on it.

use crate::codec::colours::ColourMap;
use crate::codec::colours::Rgb;
use crate::codec::draw::Align;
use crate::codec::draw::Canvas;
use crate::codec::draw::Ink;
use crate::codec::draw::Text;
use crate::codec::draw::Ticks;
use crate::codec::draw::View;
use crate::codec::map::Georeference;
use crate::codec::map::Legend;
use crate::codec::map::Map;
use crate::codec::map::MapData;
use crate::codec::map::PictureOptions;
use crate::codec::picture::Image;
use crate::compute::geometry::Bounds;
use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Point;
use crate::compute::herds::Obstacles;
use crate::compute::raster::Grid;
use crate::compute::raster::Raster;

const PLAIN: Rgb = [244, 243, 236];
const OBSTACLE: Ink = Ink::veil([70, 74, 84], 0.75);
const BAR: Ink = Ink::solid([30; 3]);

/// How much white lies over the colours of the ground, so that animals stand out.
const FADED: f64 = 0.45;

/// An animal is drawn at least this long, in pixels.
const LEAST_LENGTH: f64 = 5.0;

/// A part of the ground as a picture.
pub struct Scene {
    /// Where the picture lies.
    pub view: View,
    /// The picture so far.
    pub canvas: Canvas,
}

impl Scene {
    /// The ground within `world` and a margin, its longer side `side` pixels, with room for a
    /// line of text of `below` pixels.
    pub fn new(world: Bounds, side: f64, below: usize) -> Self {
        let margin = 0.08 * world.width().max(world.height()).max(1.0);
        let mut world = world.grown(margin);
        // No picture is flatter than three to one.
        let least = world.width().max(world.height()) / 3.0;
        let lack = Point::new((least - world.width()).max(0.0), (least - world.height()).max(0.0)) * 0.5;
        world = Bounds::new(world.min - lack, world.max + lack);
        let scale = side / world.width().max(world.height());
        let size = ((world.width() * scale).ceil(), (world.height() * scale).ceil());
        let view = View::fit(world, Bounds::new(Point::default(), Point::new(size.0, size.1)));
        let canvas = Canvas::new(size.0 as usize, size.1 as usize + below, [255; 3]);
        let mut scene = Self { view, canvas };
        let ground = Bounds::new(Point::default(), Point::new(size.0, size.1));
        scene.canvas.rectangle(ground, Ink::solid(PLAIN));
        scene
    }

    /// Lays the terrain under everything, tinted by height and shaded.
    pub fn terrain(&mut self, heights: &Raster<f32>, below: usize) {
        let (width, height) = (self.canvas.width(), self.canvas.height() - below);
        let cell_m = 1.0 / self.view.scale;
        let corner = self.view.world(Point::new(0.0, height as f64));
        let grid = Grid { width, height, cell_m, origin: corner };
        let sampled = |i: usize| heights.sample(grid.centre(i)).map_or(f32::NAN, |z| z as f32);
        let relief = Raster { grid, data: (0..grid.len()).map(sampled).collect() };
        let map = Map {
            data: MapData::F32(relief.clone()),
            legend: Legend::continuous("Height", "m", ColourMap::Terrain),
            georeference: Georeference::default(),
        };
        let options = PictureOptions { max_side: width.max(height), relief: Some(&relief), legend: false };
        let mut image = map.picture(&options);
        let fade = |c: u8| (f64::from(c) * (1.0 - FADED) + 255.0 * FADED) as u8;
        image.rgb.iter_mut().for_each(|pixel| *pixel = pixel.map(fade));
        self.canvas.paste(&image, 0, 0);
    }

    /// Lays the values of a map over the ground, the more opaque the greater they are.
    pub fn veil(&mut self, map: &Raster<f32>, colour: Rgb, most: f64) {
        let greatest = map.data.iter().copied().filter(|v| v.is_finite()).fold(0.0, f32::max);
        let half = map.grid.cell_m / 2.0;
        for (cell, value) in map.data.iter().enumerate().filter(|(_, v)| **v > 0.0) {
            let centre = map.grid.centre(cell);
            let (low, high) =
                (self.view.at(centre - Point::new(half, -half)), self.view.at(centre + Point::new(half, -half)));
            let share = f64::from(value / greatest);
            self.canvas.rectangle(Bounds::new(low, high), Ink::veil(colour, most * share));
        }
    }

    /// Draws the obstacles.
    pub fn obstacles(&mut self, obstacles: &Obstacles) {
        for area in &obstacles.areas {
            for polygon in area.polygons() {
                let rings: Vec<Vec<Point>> = polygon.rings().map(|ring| self.view.all(ring)).collect();
                self.canvas.polygon(&rings, OBSTACLE);
            }
        }
        for (centre, radius) in &obstacles.disks {
            self.canvas.disk(self.view.at(*centre), radius * self.view.scale, OBSTACLE);
        }
        if let Some(mask) = &obstacles.mask {
            let colour = OBSTACLE.colour;
            let closed =
                Raster { grid: mask.grid, data: mask.data.iter().map(|c| f32::from(u8::from(*c != 0))).collect() };
            self.veil(&closed, colour, OBSTACLE.alpha);
        }
    }

    /// An animal, its head lighter.
    pub fn animal(&mut self, ellipse: &Ellipse, colour: Rgb) {
        let shown = self.shown(ellipse);
        self.canvas.ellipse(&shown, Ink::solid(colour));
        let head = shown.centre + shown.heading() * (0.62 * shown.a);
        self.canvas.disk(head, (0.45 * shown.b).max(0.8), Ink::solid(colour.map(|c| c.saturating_add(120))));
    }

    /// The ellipse in pixels, large enough to be seen.
    fn shown(&self, ellipse: &Ellipse) -> Ellipse {
        let shown = self.view.ellipse(ellipse);
        let factor = (LEAST_LENGTH / (2.0 * shown.a)).max(1.0);
        Ellipse { a: shown.a * factor, b: shown.b * factor, ..shown }
    }

    /// A bar that says how long a length on the ground is.
    pub fn scale_bar(&mut self, below: usize) {
        let quarter = 0.25 * self.canvas.width() as f64 / self.view.scale;
        let ticks = Ticks::linear(0.0, quarter, 2);
        let Some(length) = ticks.values.iter().copied().filter(|v| *v > 0.0).reduce(f64::max) else { return };
        let y = (self.canvas.height() - below) as f64 - 14.0;
        let right = self.canvas.width() as f64 - 14.0;
        let left = right - length * self.view.scale;
        self.canvas.stroke(&[Point::new(left, y), Point::new(right, y)], 3.0, BAR);
        let style = Text { align: Align::End, halo: Some([255; 3]), ..Text::default() };
        self.canvas.text(Point::new(right, y - 7.0), &format!("{} m", ticks.label(length)), &style);
    }

    /// Words at the upper left.
    pub fn title(&mut self, text: &str) {
        let style = Text { size: 10.0, halo: Some([255; 3]), bold: true, ..Text::default() };
        self.canvas.text(Point::new(12.0, 24.0), text, &style);
    }

    /// The picture.
    pub fn into_image(self) -> Image {
        self.canvas.into_image()
    }
}
