//! The photo of the worked examples is drawn here: a herd on uneven ground that walks to the
//! right, denser and more orderly in front.

use super::herds_drawn::Drawn;
use super::herds_drawn::Scene;
use super::herds_drawn::gap;
use biotope::codec::picture::Image;
use biotope::codec::picture::MAX_PIXELS;
use biotope::compute::geometry::Ellipse;
use biotope::compute::geometry::Point;
use biotope::compute::random::Purpose;
use biotope::compute::random::Stream;
use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;
use std::path::Path;

const SIZE: (usize, usize) = (1000, 680);
const ANIMALS: usize = 64;
const HERD: Purpose = Purpose::new("test.example.herd");

/// Animals by dart throwing in an egg with its blunt end in front; the tail of the herd fans out.
fn herd() -> Vec<Ellipse> {
    let mut random = Stream::new(3, HERD, 0);
    let mut animals: Vec<Ellipse> = Vec::new();
    let middle = Point::new(520.0, 345.0);
    for _ in 0..100_000 {
        if animals.len() == ANIMALS {
            break;
        }
        let offset = Point::new(random.range(-400.0, 400.0), random.range(-250.0, 250.0));
        let along = (offset.x + 400.0) / 800.0;
        let half_width = 250.0 * (4.0 * along * (1.0 - along)).sqrt() * (0.55 + 0.45 * along);
        let b = random.range(7.5, 8.8);
        let a = b * random.range(1.95, 2.25);
        let fan = 0.9 * (1.0 - along) * offset.y / 250.0;
        let theta = 0.18 - fan + 0.10 * random.normal();
        let e = Ellipse { centre: middle + offset, a, b, theta };
        let apart = 3.0 + 26.0 * (1.0 - along);
        if offset.y.abs() < half_width && animals.iter().all(|o| gap(o, &e) >= apart) {
            animals.push(e);
        }
    }
    animals
}

pub fn drawn() -> Drawn {
    let scene =
        Scene { width: SIZE.0, height: SIZE.1, animals: ANIMALS, b: (7.5, 8.8), touching: 0.0, noise: 5.0, seed: 11 };
    scene.with(herd())
}

fn jpeg(drawn: &Drawn) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = JpegEncoder::new_with_quality(&mut bytes, 80);
    encoder.encode(drawn.photo.rgb(), SIZE.0 as u32, SIZE.1 as u32, ExtendedColorType::Rgb8).unwrap();
    bytes
}

#[test]
fn the_committed_photo_is_what_the_generator_draws() {
    let drawn = drawn();
    assert_eq!(drawn.animals.len(), ANIMALS);
    let (path, made) = (Path::new(env!("CARGO_MANIFEST_DIR")).join("api/examples/herd.jpg"), jpeg(&drawn));
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&path, &made).unwrap();
        drawn
            .animals
            .iter()
            .for_each(|e| println!("{:.1} {:.1} {:.1} {:.1} {:.3}", e.centre.x, e.centre.y, e.a, e.b, e.theta));
    }
    let found = Image::read(&std::fs::read(&path).unwrap(), MAX_PIXELS).unwrap();
    assert!(found == Image::read(&made, MAX_PIXELS).unwrap(), "herd.jpg is out of date: run this test with UPDATE=1");
}
