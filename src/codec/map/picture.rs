use super::Error;
use super::Legend;
use super::Map;
use super::MapData;
use super::Scale;
use super::Spread;
use crate::codec::colours::ColourMap;
use crate::codec::colours::Rgb;
use crate::codec::colours::category;
use crate::codec::draw::Align;
use crate::codec::draw::Canvas;
use crate::codec::draw::Ink;
use crate::codec::draw::Text;
use crate::codec::draw::Ticks;
use crate::codec::map::shade::Shade;
use crate::codec::picture::Image;
use crate::compute::geometry::Bounds;
use crate::compute::geometry::Point;
use crate::compute::raster::Raster;
use rayon::prelude::*;

/// Cells without data.
const NODATA: Rgb = [214, 214, 218];
const MARGIN: usize = 16;
const TITLE: usize = 34;
const BAR: f64 = 18.0;
/// Least height of the picture part, so that a legend fits beside a flat map.
const LEAST: usize = 220;

/// How a map is shown.
#[derive(Debug, Clone, Copy)]
pub struct PictureOptions<'a> {
    /// Longest side of the map itself, in pixels. Larger maps are averaged down (classes: the
    /// most frequent one), smaller ones are shown with whole multiples of pixels a cell.
    pub max_side: usize,
    /// Heights on the same grid, to shade the map by its relief.
    pub relief: Option<&'a Raster<f32>>,
    /// Whether the frame with title and legend is drawn, or the bare map.
    pub legend: bool,
}

impl Default for PictureOptions<'_> {
    fn default() -> Self {
        Self { max_side: 1024, relief: None, legend: true }
    }
}

impl Map {
    /// A ready-to-show PNG: the map with its title, unit and colour bar or names of classes.
    pub fn to_png(&self, options: &PictureOptions) -> Result<Vec<u8>, Error> {
        Ok(self.picture(options).to_png()?)
    }

    /// The same as pixels, to draw on.
    pub fn picture(&self, options: &PictureOptions) -> Image {
        let painter = Painter::new(self);
        let image = self.bare(&painter, options);
        if options.legend { painter.framed(self, &image) } else { image }
    }

    /// The map alone, one pixel (or more) a cell.
    fn bare(&self, painter: &Painter, options: &PictureOptions) -> Image {
        let zoom = Zoom::new(self, options.max_side);
        let relief =
            options.relief.filter(|r| r.grid.width == self.grid().width && r.grid.height == self.grid().height);
        let shade = relief.map(Shade::new);
        let rows: Vec<Vec<Rgb>> = (0..zoom.height)
            .into_par_iter()
            .map(|y| (0..zoom.width).map(|x| self.pixel(painter, shade.as_ref(), &zoom.block(x, y))).collect())
            .collect();
        zoom.enlarged(rows)
    }

    fn pixel(&self, painter: &Painter, shade: Option<&Shade>, block: &Block) -> Rgb {
        let value = match &painter.colours {
            Colours::Ramp { .. } => block.mean(&self.data),
            _ => block.mode(&self.data),
        };
        let colour = value.map_or(NODATA, |v| painter.colour(v));
        shade.map_or(colour, |s| s.over(colour, block.cells()))
    }
}

/// How many cells become a pixel, or pixels a cell.
struct Zoom {
    cells: (usize, usize),
    /// Cells a pixel, along a side.
    shrink: usize,
    /// Pixels a cell, along a side.
    grow: usize,
    width: usize,
    height: usize,
}

impl Zoom {
    fn new(map: &Map, max_side: usize) -> Self {
        let grid = map.grid();
        let (side, most) = (grid.width.max(grid.height), max_side.max(16));
        let shrink = side.div_ceil(most);
        let grow = (most / side).max(1);
        let cells = (grid.width, grid.height);
        Self { cells, shrink, grow, width: cells.0.div_ceil(shrink), height: cells.1.div_ceil(shrink) }
    }

    fn block(&self, x: usize, y: usize) -> Block {
        let range = |i: usize, n: usize| i * self.shrink..((i + 1) * self.shrink).min(n);
        Block { width: self.cells.0, columns: range(x, self.cells.0), rows: range(y, self.cells.1) }
    }

    fn enlarged(&self, rows: Vec<Vec<Rgb>>) -> Image {
        let wide =
            |row: Vec<Rgb>| -> Vec<Rgb> { row.into_iter().flat_map(|c| std::iter::repeat_n(c, self.grow)).collect() };
        let rgb = rows.into_iter().flat_map(|row| wide(row).repeat(self.grow)).collect();
        Image { width: self.width * self.grow, height: self.height * self.grow, rgb }
    }
}

/// The cells that share a pixel.
struct Block {
    width: usize,
    columns: std::ops::Range<usize>,
    rows: std::ops::Range<usize>,
}

impl Block {
    fn cells(&self) -> impl Iterator<Item = usize> + '_ {
        self.rows.clone().flat_map(move |row| self.columns.clone().map(move |column| row * self.width + column))
    }

    /// Mean of the cells with data (a box filter).
    fn mean(&self, data: &MapData) -> Option<f64> {
        let (sum, n) = self.cells().filter_map(|i| data.value(i)).fold((0.0, 0_usize), |(s, n), v| (s + v, n + 1));
        (n > 0).then(|| sum / n as f64)
    }

    /// The most frequent value; the smallest of those that tie.
    fn mode(&self, data: &MapData) -> Option<f64> {
        let mut values: Vec<f64> = self.cells().filter_map(|i| data.value(i)).collect();
        values.sort_by(f64::total_cmp);
        let runs = values.chunk_by(|a, b| a == b).map(|run| (run[0], run.len()));
        runs.fold(None, |best: Option<(f64, usize)>, run| best.filter(|b| b.1 >= run.1).or(Some(run))).map(|b| b.0)
    }
}

/// From values to colours, once the range is known.
struct Painter {
    colours: Colours,
}

enum Colours {
    Ramp { range: (f64, f64), map: ColourMap, spread: Spread },
    Named(Vec<(u32, String, Rgb)>),
    Numbered { count: usize },
}

impl Painter {
    fn new(map: &Map) -> Self {
        let extremes = || {
            let s = map.statistics();
            (s.min.unwrap_or(0.0), s.max.unwrap_or(1.0))
        };
        let colours = match &map.legend.scale {
            Scale::Continuous { range, colours, spread } => {
                Colours::Ramp { range: opened(range.unwrap_or_else(extremes)), map: *colours, spread: *spread }
            }
            Scale::Categories(all) => {
                Colours::Named(all.iter().map(|c| (c.value, c.label.clone(), c.colour)).collect())
            }
            Scale::Labels => Colours::Numbered { count: map.statistics().max.unwrap_or(0.0) as usize },
        };
        Self { colours }
    }

    fn colour(&self, value: f64) -> Rgb {
        match &self.colours {
            Colours::Ramp { range, map, spread } => map.at(spread.share(value, *range)),
            Colours::Named(all) => all.iter().find(|c| f64::from(c.0) == value).map_or(NODATA, |c| c.2),
            Colours::Numbered { .. } if value == 0.0 => [250; 3],
            Colours::Numbered { .. } => category(value as usize - 1),
        }
    }

    /// The map with its title above and its legend at the right.
    fn framed(&self, map: &Map, image: &Image) -> Image {
        let side = self.legend_width(&map.legend);
        let tall = image.height.max(LEAST).max(self.legend_height());
        let width = MARGIN + image.width + 14 + side + MARGIN;
        let mut canvas = Canvas::new(width.max(320), TITLE + tall + MARGIN, [255; 3]);
        let style = Text { size: 12.0, bold: true, ..Text::default() };
        let room = canvas.width() as f64 - 2.0 * MARGIN as f64;
        canvas.text(Point::new(MARGIN as f64, 24.0), &style.fitted(&map.legend.title, room), &style);
        canvas.paste(image, MARGIN, TITLE);
        rim(&mut canvas, bounds(MARGIN, TITLE, image.width, image.height));
        let at = bounds(MARGIN + image.width + 14, TITLE, side, tall.min(image.height.max(LEAST)).min(520));
        match &self.colours {
            Colours::Ramp { range, map: colours, spread } => {
                bar(&mut canvas, at, &map.legend.unit, &|t| colours.at(t), &spread.ticks(*range), &|v| {
                    spread.share(v, *range)
                })
            }
            Colours::Named(all) => {
                swatches(&mut canvas, at.min, &all.iter().map(|c| (c.2, c.1.clone())).collect::<Vec<_>>())
            }
            Colours::Numbered { count } => {
                let text = if *count == 1 { "1 part".to_owned() } else { format!("{count} parts") };
                canvas.text(at.min + Point::new(0.0, 12.0), &text, &Text::default());
            }
        }
        canvas.into_image()
    }

    fn legend_width(&self, legend: &Legend) -> usize {
        let style = Text::default();
        let widest = match &self.colours {
            Colours::Ramp { range, spread, .. } => {
                let ticks = spread.ticks(*range);
                let labels = ticks.values.iter().map(|v| BAR + 10.0 + style.width(&ticks.label(*v)));
                labels.chain([style.width(&legend.unit)]).fold(0.0, f64::max)
            }
            Colours::Named(all) => all.iter().map(|c| 24.0 + style.width(&c.1)).fold(0.0, f64::max),
            Colours::Numbered { count } => style.width(&format!("{count} parts")),
        };
        (widest.ceil() as usize).clamp(40, 320)
    }

    fn legend_height(&self) -> usize {
        match &self.colours {
            Colours::Named(all) => all.len() * 20 + 8,
            _ => 0,
        }
    }
}

/// A range with some extent: a map of one value is shown from zero to that value.
fn opened((min, max): (f64, f64)) -> (f64, f64) {
    match () {
        () if !(min.is_finite() && max.is_finite()) => (0.0, 1.0),
        () if max > min => (min, max),
        () if max == 0.0 => (0.0, 1.0),
        () => (max.min(0.0), max.max(0.0)),
    }
}

/// The colour bar with the unit above it and a label at each tick.
fn bar(
    canvas: &mut Canvas,
    at: Bounds,
    unit: &str,
    colour: &dyn Fn(f64) -> Rgb,
    ticks: &Ticks,
    share: &dyn Fn(f64) -> f64,
) {
    let style = Text::default();
    let top = at.min.y + if unit.is_empty() { 4.0 } else { 22.0 };
    canvas.text(Point::new(at.min.x, at.min.y + 10.0), unit, &style);
    let steps = Bounds::new(Point::new(at.min.x, top), Point::new(at.min.x + BAR, at.max.y));
    for y in top as usize..at.max.y as usize {
        let t = 1.0 - (y as f64 + 0.5 - top) / steps.height();
        let line = Bounds::new(Point::new(at.min.x, y as f64), Point::new(at.min.x + BAR, y as f64 + 1.0));
        canvas.rectangle(line, Ink::solid(colour(t)));
    }
    rim(canvas, steps);
    for value in &ticks.values {
        let y = (at.max.y - share(*value) * steps.height()).floor() + 0.5;
        let x = at.min.x + BAR;
        canvas.stroke(&[Point::new(x, y), Point::new(x + 4.0, y)], 1.0, Ink::solid([70; 3]));
        let level = (y + 4.5).clamp(top + 8.0, at.max.y);
        canvas.text(Point::new(x + 9.0, level), &ticks.label(*value), &Text { align: Align::Start, ..style });
    }
}

/// Classes below one another: a square of the colour, then the name.
fn swatches(canvas: &mut Canvas, at: Point, classes: &[(Rgb, String)]) {
    for (i, (colour, label)) in classes.iter().enumerate() {
        let corner = at + Point::new(0.0, 20.0 * i as f64);
        let square = Bounds::new(corner, corner + Point::new(15.0, 15.0));
        canvas.rectangle(square, Ink::solid(*colour));
        rim(canvas, square);
        canvas.text(corner + Point::new(23.0, 12.0), label, &Text::default());
    }
}

fn rim(canvas: &mut Canvas, b: Bounds) {
    let (lo, hi) = (b.min + Point::new(-0.5, -0.5), b.max + Point::new(0.5, 0.5));
    canvas.stroke(&[lo, Point::new(hi.x, lo.y), hi, Point::new(lo.x, hi.y), lo], 1.0, Ink::solid([90; 3]));
}

fn bounds(left: usize, top: usize, width: usize, height: usize) -> Bounds {
    let corner = Point::new(left as f64, top as f64);
    Bounds::new(corner, corner + Point::new(width as f64, height as f64))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::map::tests::classes;
    use crate::codec::map::tests::hills;

    fn bare(max_side: usize) -> PictureOptions<'static> {
        PictureOptions { max_side, legend: false, relief: None }
    }

    #[test]
    fn a_large_map_is_shown_at_the_size_asked_for_and_a_small_one_enlarged() {
        let large = hills(300, 200).picture(&bare(100));
        assert_eq!((large.width, large.height), (100, 67));
        let small = hills(20, 10).picture(&bare(1024));
        assert_eq!((small.width, small.height), (1020, 510));
    }

    #[test]
    fn colours_follow_the_values_and_holes_stay_out_of_the_means() {
        let mut map = hills(4, 2);
        let grid = *map.grid();
        map.data = MapData::F32(Raster { grid, data: vec![0.0, 0.0, 300.0, f32::NAN, 0.0, 0.0, f32::NAN, 300.0] });
        let painter = Painter::new(&map);
        let zoom = Zoom { cells: (4, 2), shrink: 2, grow: 1, width: 2, height: 1 };
        let at = |x| map.pixel(&painter, None, &zoom.block(x, 0));
        assert_eq!((at(0), at(1)), (ColourMap::Terrain.at(0.0), ColourMap::Terrain.at(1.0)));
    }

    #[test]
    fn a_map_of_zeros_is_white_and_one_of_a_single_value_is_full() {
        let density = |value: f32| {
            let mut map = hills(1, 1);
            map.legend = Legend::continuous("Density", "1/km²", ColourMap::Brown);
            map.data = MapData::F32(Raster::filled(*map.grid(), value));
            map.picture(&bare(1)).rgb[0]
        };
        assert_eq!((density(0.0), density(3.0)), (ColourMap::Brown.at(0.0), ColourMap::Brown.at(1.0)));
    }

    #[test]
    fn classes_are_never_mixed() {
        let map = classes();
        let picture = map.picture(&bare(64));
        let Scale::Categories(all) = &map.legend.scale else { panic!() };
        assert!(picture.rgb.iter().all(|p| all.iter().any(|c| c.colour == *p)));
    }

    #[test]
    fn maps_without_data_without_extent_or_of_one_cell_are_drawn() {
        let options = PictureOptions::default();
        for spread in [Spread::Linear, Spread::SquareRoot, Spread::Logarithmic] {
            for value in [f32::NAN, 0.0, 7.5, -1.0, f32::INFINITY] {
                let mut map = hills(1, 1);
                map.legend = Legend::continuous("One", "", ColourMap::Brown).with_spread(spread);
                map.data = MapData::F32(Raster::filled(*map.grid(), value));
                assert!(map.to_png(&options).is_ok());
            }
        }
    }

    #[test]
    fn the_picture_does_not_depend_on_the_number_of_threads() {
        let map = hills(300, 200);
        let MapData::F32(heights) = &map.data else { panic!() };
        let options = PictureOptions { relief: Some(heights), ..PictureOptions::default() };
        let on = |n| {
            rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap().install(|| map.to_png(&options).unwrap())
        };
        assert_eq!(on(1), on(2));
    }
}
