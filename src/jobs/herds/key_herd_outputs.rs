//! What a key-herd process hands back: maps, report, pictures.

use serde_json::Value;
use serde_json::json;

use crate::codec::colours::ColourMap;
use crate::codec::colours::Rgb;
use crate::codec::colours::category;
use crate::codec::draw::Canvas;
use crate::codec::draw::Curve as Line;
use crate::codec::draw::Ink;
use crate::codec::draw::Plot;
use crate::codec::map::Georeference;
use crate::codec::map::Legend;
use crate::codec::map::Map;
use crate::codec::map::MapData;
use crate::compute::geometry::Bounds;
use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Point;
use crate::compute::herds::Obstacles;
use crate::compute::herds::key_herd::KeyHerd;
use crate::compute::pcf::Curve;
use crate::compute::raster::Raster;
use crate::jobs::Artefact;
use crate::jobs::Failure;
use crate::jobs::herds::ellipses::Row;
use crate::jobs::herds::pictures;
use crate::jobs::herds::scene::Scene;
use crate::jobs::rasters::Land;

/// Longer side of the picture, in pixels, and space for the key below it.
const SIDE: f64 = 1200.0;
const KEY: usize = 30;

const COAT: Rgb = [62, 38, 24];
const DENSITY: Rgb = [200, 120, 20];
const WAY: Rgb = [200, 30, 60];

/// The animals as rows of the table.
pub fn rows(ellipses: &[Ellipse]) -> Vec<Row> {
    (0..).zip(ellipses).map(|(id, ellipse)| Row { id, ellipse: *ellipse, why: String::new() }).collect()
}

/// The density map.
pub fn density(map: Raster<f32>, georeference: Georeference) -> Artefact {
    let legend = Legend::continuous("Density of the herd", "animals/m²", ColourMap::Brown);
    Artefact::Map(Map { data: MapData::F32(map), legend, georeference })
}

/// The orientation field.
pub fn orientation(map: Raster<f32>, georeference: Georeference) -> Artefact {
    let turn = std::f64::consts::PI;
    let legend = Legend::continuous("Orientation of the herd", "rad", ColourMap::Diverging).with_range(-turn, turn);
    Artefact::Map(Map { data: MapData::F32(map), legend, georeference })
}

/// The document `report`.
pub fn report(herd: &KeyHerd, (centre, direction): (Point, f64)) -> Value {
    let report = &herd.report;
    let error = report.target.as_ref().zip(report.curve.as_ref()).map(|(target, curve)| rms(target, curve));
    json!({
        "animals": herd.ellipses.len(),
        "centre": [centre.x, centre.y],
        "direction": direction,
        "metres_per_unit": report.metres_per_unit,
        "scale": report.scale,
        "curve_error_rms": error,
        "forced": report.forced,
        "deepest_overlap_m": report.deepest_m,
        "exemplar_curve": report.target.as_ref().map(curve),
        "curve": report.curve.as_ref().map(curve),
    })
}

fn curve(curve: &Curve) -> Value {
    json!({"r": curve.axis.places(), "mean": curve.mean, "lower": curve.lower, "upper": curve.upper})
}

/// Root mean square difference of two curves.
fn rms(one: &Curve, two: &Curve) -> f64 {
    let pairs = || one.mean.iter().zip(&two.mean).filter(|(a, b)| a.is_finite() && b.is_finite());
    let sum: f64 = pairs().map(|(a, b)| (a - b).powi(2)).sum();
    (sum / pairs().count().max(1) as f64).sqrt()
}

/// The ground with density, obstacles, the way and every animal.
///
/// # Errors
/// When it cannot be encoded.
pub fn picture(
    herd: &KeyHerd,
    (land, obstacles): (Option<&Land>, &Obstacles),
    way: &[Point],
) -> Result<Artefact, Failure> {
    let body = herd.ellipses.first().map_or(1.0, |e| e.a);
    let world = Bounds::of(herd.ellipses.iter().map(|e| e.centre))
        .unwrap_or(Bounds::new(Point::default(), Point::default()))
        .grown(4.0 * body);
    let mut scene = Scene::new(world, SIDE, KEY);
    if let Some(land) = land {
        scene.terrain(&land.height, KEY);
    }
    scene.veil(&herd.density, DENSITY, 0.55);
    scene.obstacles(obstacles);
    let shown = scene.view.all(way);
    scene.canvas.stroke(&shown, 2.0, Ink::veil(WAY, 0.8));
    herd.ellipses.iter().for_each(|e| scene.animal(e, COAT));
    scene.scale_bar(KEY);
    let (width, height) = (scene.canvas.width() as f64, scene.canvas.height() as f64);
    let strip = Bounds::new(Point::new(0.0, height - KEY as f64), Point::new(width, height));
    scene.canvas.rectangle(strip, Ink::solid([255; 3]));
    let mut entries = vec![(COAT, format!("{} animals", herd.ellipses.len())), (DENSITY, "density".to_owned())];
    if !way.is_empty() {
        entries.push((WAY, "way".to_owned()));
    }
    pictures::key(&mut scene.canvas, &entries);
    pictures::encoded(scene.canvas)
}

/// The exemplar's correlation curve with its envelope, and the key-herd's.
///
/// # Errors
/// When it cannot be encoded.
pub fn curves(target: &Curve, made: Option<&Curve>) -> Result<Artefact, Failure> {
    let points = |curve: &Curve| curve.axis.places().into_iter().zip(curve.mean.iter().copied()).collect();
    let band = target.lower.iter().copied().zip(target.upper.iter().copied()).collect();
    let mut curves = vec![Line { label: "exemplar".to_owned(), colour: category(0), points: points(target), band }];
    curves.extend(made.map(|curve| Line {
        label: "key-herd".to_owned(),
        colour: category(1),
        points: points(curve),
        band: Vec::new(),
    }));
    let highest = |curve: &Curve| curve.mean.iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
    let top = 1.3 * highest(target).max(made.map_or(0.0, highest)).max(1.2);
    let plot = Plot {
        title: "Correlation of the animals".to_owned(),
        x_label: "r (body sizes)".to_owned(),
        y_label: "correlation".to_owned(),
        x_range: None,
        y_range: Some((0.0, top)),
        reference: Some(1.0),
        curves,
    };
    let (width, height) = (720.0, 460.0);
    let mut canvas = Canvas::new(width as usize, height as usize, [255; 3]);
    plot.draw(&mut canvas, Bounds::new(Point::default(), Point::new(width, height)));
    pictures::encoded(canvas)
}
