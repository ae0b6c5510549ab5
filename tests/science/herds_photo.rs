//! Extraction on a real photo: about eighty white pelicans on bleached wood, some under bushes.
//! Runs where the photo is present.

use biotope::compute::geometry::Point;
use biotope::compute::herds::extraction::Extraction;
use biotope::compute::herds::extraction::ExtractionOptions;
use biotope::compute::herds::extraction::Mark;
use biotope::compute::herds::extraction::Photo;
use biotope::compute::herds::extraction::Scribbles;
use biotope::compute::herds::extraction::Stroke;
use biotope::compute::herds::extraction::extract;
use biotope::compute::run::Run;
use std::path::Path;

/// Width and corners from the upper left.
type Line = (f64, &'static [(f64, f64)]);

/// Birds of which at least half can be seen, marked by eye, from the upper left.
#[rustfmt::skip]
const BIRDS: [(f64, f64); 70] = [
    (760.0, 107.0), (706.0, 143.0), (801.0, 149.0), (756.0, 174.0), (870.0, 95.0), (881.0, 111.0), (961.0, 42.0), (920.0, 147.0), (965.0, 185.0), (990.0, 202.0), (1032.0, 183.0), (831.0, 203.0), (888.0, 200.0), (625.0, 231.0), (697.0, 228.0), (765.0, 253.0), (923.0, 251.0), (925.0, 286.0), (843.0, 276.0), (1005.0, 275.0), (1041.0, 313.0), (660.0, 312.0), (694.0, 303.0), (773.0, 303.0), (729.0, 352.0), (635.0, 376.0), (713.0, 378.0), (667.0, 412.0), (872.0, 370.0), (984.0, 336.0), (937.0, 384.0), (1044.0, 387.0), (795.0, 406.0), (826.0, 420.0), (773.0, 440.0), (931.0, 431.0), (877.0, 470.0), (810.0, 487.0), (941.0, 492.0), (620.0, 541.0), (947.0, 562.0), (1014.0, 566.0), (956.0, 625.0), (949.0, 650.0), (634.0, 703.0), (664.0, 759.0), (627.0, 801.0), (856.0, 813.0), (901.0, 832.0), (913.0, 819.0), (933.0, 850.0), (860.0, 882.0), (750.0, 861.0), (799.0, 863.0), (775.0, 912.0), (815.0, 927.0), (617.0, 917.0), (625.0, 968.0), (582.0, 957.0), (908.0, 764.0), (1025.0, 975.0), (881.0, 507.0), (993.0, 990.0), (290.0, 826.0), (365.0, 852.0), (378.0, 909.0), (455.0, 927.0), (548.0, 816.0), (510.0, 888.0), (448.0, 977.0),
];

const BIRD_STROKES: &[Line] = &[
    (5.0, &[(757.0, 97.0), (759.0, 112.0)]),
    (5.0, &[(702.0, 135.0), (708.0, 150.0)]),
    (5.0, &[(754.0, 170.0), (756.0, 184.0)]),
    (5.0, &[(822.0, 200.0), (836.0, 212.0)]),
    (5.0, &[(648.0, 314.0), (670.0, 308.0)]),
    (5.0, &[(627.0, 372.0), (640.0, 382.0)]),
    (5.0, &[(838.0, 270.0), (850.0, 284.0)]),
    (5.0, &[(770.0, 292.0), (772.0, 314.0)]),
    (5.0, &[(922.0, 384.0), (942.0, 384.0)]),
    (5.0, &[(548.0, 812.0), (556.0, 826.0)]),
    (5.0, &[(352.0, 854.0), (374.0, 852.0)]),
    (5.0, &[(287.0, 832.0), (292.0, 818.0)]),
    (5.0, &[(624.0, 790.0), (626.0, 812.0)]),
    (5.0, &[(735.0, 858.0), (762.0, 864.0)]),
    (3.0, &[(1012.0, 384.0), (1040.0, 386.0)]),
    (3.0, &[(1032.0, 312.0), (1046.0, 322.0)]),
];
const GROUND_STROKES: &[Line] = &[
    (8.0, &[(30.0, 580.0), (45.0, 780.0), (60.0, 870.0)]),
    (8.0, &[(90.0, 850.0), (160.0, 800.0), (240.0, 540.0)]),
    (6.0, &[(560.0, 520.0), (600.0, 600.0), (596.0, 760.0)]),
    (6.0, &[(820.0, 90.0), (870.0, 230.0)]),
    (6.0, &[(910.0, 280.0), (1000.0, 430.0)]),
    (5.0, &[(560.0, 150.0), (640.0, 178.0), (820.0, 230.0)]),
    (6.0, &[(720.0, 430.0), (770.0, 510.0)]),
    (8.0, &[(500.0, 620.0), (560.0, 700.0)]),
    (8.0, &[(300.0, 200.0), (400.0, 300.0)]),
    (8.0, &[(60.0, 290.0), (140.0, 270.0)]),
    (8.0, &[(620.0, 70.0), (720.0, 60.0)]),
    (8.0, &[(680.0, 590.0), (820.0, 600.0)]),
    (5.0, &[(700.0, 860.0), (760.0, 780.0)]),
    (5.0, &[(400.0, 330.0), (480.0, 260.0)]),
    (5.0, &[(100.0, 450.0), (270.0, 470.0)]),
    (6.0, &[(640.0, 460.0), (700.0, 480.0)]),
    (5.0, &[(820.0, 960.0), (900.0, 930.0)]),
    (5.0, &[(980.0, 640.0), (1010.0, 640.0)]),
    (4.0, &[(455.0, 696.0), (470.0, 714.0)]),
    (5.0, &[(920.0, 200.0), (940.0, 250.0)]),
    (4.0, &[(600.0, 880.0), (690.0, 810.0)]),
    (4.0, &[(955.0, 320.0), (1005.0, 430.0)]),
    (3.0, &[(716.0, 428.0), (756.0, 500.0)]),
    (4.0, &[(598.0, 660.0), (602.0, 740.0), (570.0, 840.0), (530.0, 900.0)]),
    (3.0, &[(140.0, 830.0), (180.0, 770.0)]),
    (3.0, &[(770.0, 750.0), (790.0, 770.0)]),
    (3.0, &[(810.0, 640.0), (850.0, 640.0)]),
    (3.0, &[(985.0, 630.0), (1020.0, 640.0)]),
    (3.0, &[(990.0, 770.0), (1020.0, 800.0)]),
    (3.0, &[(640.0, 870.0), (700.0, 800.0)]),
    (3.0, &[(700.0, 930.0), (720.0, 960.0)]),
    (3.0, &[(740.0, 770.0), (690.0, 880.0)]),
    (3.0, &[(1005.0, 270.0), (1040.0, 285.0)]),
    (3.0, &[(600.0, 900.0), (640.0, 930.0)]),
    (3.0, &[(800.0, 880.0), (802.0, 960.0)]),
    (3.0, &[(870.0, 885.0), (872.0, 930.0)]),
    (3.0, &[(990.0, 640.0), (1010.0, 655.0)]),
    (3.0, &[(985.0, 790.0), (1010.0, 790.0)]),
    (3.0, &[(1010.0, 640.0), (1030.0, 660.0)]),
    (3.0, &[(960.0, 190.0), (990.0, 240.0)]),
    (3.0, &[(818.0, 962.0), (824.0, 968.0)]),
];

fn strokes(mark: Mark, lines: &[Line], height: f64) -> impl Iterator<Item = Stroke> {
    lines.iter().map(move |(width, points)| Stroke {
        mark,
        points: points.iter().map(|&(x, y)| Point::new(x, height - y)).collect(),
        width: *width,
    })
}

fn pelicans() -> Option<(Extraction, f64)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/herds/pelicans.jpg");
    let picture = image::open(path).ok()?.to_rgb8();
    let (width, height) = picture.dimensions();
    let photo = Photo::new(width as usize, height as usize, picture.into_raw())?;
    let height = f64::from(height);
    let scribbles =
        strokes(Mark::Animal, BIRD_STROKES, height).chain(strokes(Mark::Ground, GROUND_STROKES, height)).collect();
    let found = extract(&photo, &Scribbles::Strokes(scribbles), &ExtractionOptions::default(), &Run::silent()).unwrap();
    Some((found, height))
}

#[test]
fn most_pelicans_of_the_real_photo_are_found() {
    let Some((extraction, height)) = pelicans() else { return };
    let found = |&&(x, y): &&(f64, f64)| {
        let bird = Point::new(x, height - y);
        extraction.animals.iter().any(|a| a.ellipse.scale_to(bird) < 1.0)
    };
    let birds = BIRDS.iter().filter(found).count();
    let clean = extraction.animals.iter().filter(|a| a.suspicions.is_empty());
    let holds_a_bird = |a: &&biotope::compute::herds::extraction::Found| {
        BIRDS.iter().any(|&(x, y)| a.ellipse.scale_to(Point::new(x, height - y)) < 1.0)
    };
    let (right, all) = (clean.clone().filter(holds_a_bird).count(), clean.count());
    println!("{birds} of {} birds found; {right} of {all} unsuspected regions are birds", BIRDS.len());
    assert!(birds >= 63, "{birds} of {} birds found", BIRDS.len());
    assert!(right as f64 >= 0.85 * all as f64, "{right} of {all} regions without suspicion are birds");
}
