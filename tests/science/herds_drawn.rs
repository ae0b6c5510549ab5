//! Photos drawn for tests: animals of known place, size and angle on textured, noisy ground.

use biotope::compute::geometry::CellGrid;
use biotope::compute::geometry::Ellipse;
use biotope::compute::geometry::Point;
use biotope::compute::herds::extraction::Mark;
use biotope::compute::herds::extraction::Photo;
use biotope::compute::herds::extraction::Scribbles;
use biotope::compute::herds::extraction::Stroke;
use biotope::compute::random::Purpose;
use biotope::compute::random::Stream;
use biotope::compute::random::hash2;
use biotope::compute::random::unit;

/// What to draw.
pub struct Scene {
    pub width: usize,
    pub height: usize,
    pub animals: usize,
    /// Semi-minor axes are drawn from this range; semi-major ones are 1.6 to 2.6 times as long.
    pub b: (f64, f64),
    /// Share of the animals that touch or overlap their neighbour.
    pub touching: f64,
    /// Standard deviation of the noise of a pixel, in levels of 256.
    pub noise: f64,
    pub seed: u64,
}

/// A drawn photo and the truth about it.
pub struct Drawn {
    pub photo: Photo,
    pub animals: Vec<Ellipse>,
}

const PLACE: Purpose = Purpose::new("test.drawn.place");
const NOISE: Purpose = Purpose::new("test.drawn.noise");
const TEXTURE: Purpose = Purpose::new("test.drawn.texture");

impl Scene {
    pub fn draw(&self) -> Drawn {
        self.with(self.place())
    }

    /// The scene with given animals.
    pub fn with(&self, animals: Vec<Ellipse>) -> Drawn {
        let mut rgb = vec![0u8; 3 * self.width * self.height];
        for row in 0..self.height {
            for column in 0..self.width {
                let p = Point::new(column as f64 + 0.5, (self.height - row) as f64 - 0.5);
                self.put(&mut rgb, (column, row), ground(p, self.seed));
            }
        }
        for (i, e) in animals.iter().enumerate() {
            let coat = unit(hash2(self.seed, TEXTURE, 9, i as u64));
            let (low, high) = (e.centre - Point::new(e.a, e.a), e.centre + Point::new(e.a, e.a));
            let rows = (self.height as f64 - high.y).max(0.0) as usize..=(self.height as f64 - low.y) as usize;
            for row in rows.filter(|r| *r < self.height) {
                for column in low.x.max(0.0) as usize..=(high.x as usize).min(self.width - 1) {
                    let p = Point::new(column as f64 + 0.5, (self.height - row) as f64 - 0.5);
                    if e.scale_to(p) <= 1.0 {
                        self.put(&mut rgb, (column, row), fur(p, coat, self.seed));
                    }
                }
            }
        }
        Drawn { photo: Photo::new(self.width, self.height, rgb).unwrap(), animals }
    }

    fn put(&self, rgb: &mut [u8], (column, row): (usize, usize), colour: [f64; 3]) {
        let pixel = row * self.width + column;
        for (c, value) in colour.into_iter().enumerate() {
            // The sum of four uniform numbers has variance 1/3.
            let noise: f64 =
                (0..4).map(|k| unit(hash2(self.seed, NOISE, (4 * c + k) as u64, pixel as u64)) - 0.5).sum();
            rgb[3 * pixel + c] = (value + noise * self.noise * 3f64.sqrt()).clamp(0.0, 255.0) as u8;
        }
    }

    /// Apart animals keep a gap of two pixels; touching ones are put against an animal that is there.
    fn place(&self) -> Vec<Ellipse> {
        let mut random = Stream::new(self.seed, PLACE, 0);
        let mut animals: Vec<Ellipse> = Vec::new();
        let pairs = (self.touching * self.animals as f64 / 2.0).round() as usize;
        for _ in 0..200 * self.animals {
            if animals.len() >= self.animals - pairs {
                break;
            }
            let b = random.range(self.b.0, self.b.1);
            let a = b * random.range(1.6, 2.6);
            let centre = Point::new(
                random.range(a + 3.0, self.width as f64 - a - 3.0),
                random.range(a + 3.0, self.height as f64 - a - 3.0),
            );
            let e = Ellipse { centre, a, b, theta: random.range(-3.1, 3.1) };
            if animals.iter().all(|o| gap(o, &e) >= 2.0) {
                animals.push(e);
            }
        }
        let alone = animals.len();
        for host in 0..alone {
            if animals.len() >= alone + pairs {
                break;
            }
            for _ in 0..60 {
                let mut e = Ellipse { theta: random.range(-3.1, 3.1), ..animals[host] };
                let away = Point::from_angle(random.range(-3.1, 3.1));
                let mut distance = 2.0 * e.a + 2.0;
                // Slide in until the rims overlap by a tenth of a body's width.
                while gap(&animals[host], &Ellipse { centre: e.centre + away * distance, ..e }) > -0.2 * e.b
                    && distance > 0.0
                {
                    distance -= 0.25;
                }
                e.centre = e.centre + away * distance;
                let inside = e.centre.x > e.a + 3.0
                    && e.centre.y > e.a + 3.0
                    && e.centre.x < self.width as f64 - e.a - 3.0
                    && e.centre.y < self.height as f64 - e.a - 3.0;
                if inside && animals.iter().enumerate().all(|(i, o)| i == host || gap(o, &e) >= 2.0) {
                    animals.push(e);
                    break;
                }
            }
        }
        animals
    }
}

/// Uneven ground: patches of grass and soil of several sizes.
fn ground(p: Point, seed: u64) -> [f64; 3] {
    let patches = value_noise(p, 37.0, seed) * 0.6 + value_noise(p, 11.0, seed + 1) * 0.4;
    let fine = value_noise(p, 2.5, seed + 2) - 0.5;
    let (grass, soil) = ([96.0, 120.0, 60.0], [139.0, 116.0, 88.0]);
    [0, 1, 2].map(|c| grass[c] + (soil[c] - grass[c]) * patches + 36.0 * fine)
}

/// A brown to dark coat with streaks.
fn fur(p: Point, coat: f64, seed: u64) -> [f64; 3] {
    let streaks = value_noise(p, 4.0, seed + 3) - 0.5;
    let (dark, brown) = ([38.0, 30.0, 28.0], [92.0, 58.0, 34.0]);
    [0, 1, 2].map(|c| dark[c] + (brown[c] - dark[c]) * coat + 24.0 * streaks)
}

/// Smooth noise in [0, 1) with features of about `size` pixels.
fn value_noise(p: Point, size: f64, seed: u64) -> f64 {
    let (u, v) = (p.x / size, p.y / size);
    let (i, j) = (u.floor(), v.floor());
    let (fu, fv) = (u - i, v - j);
    let at = |di: f64, dj: f64| unit(hash2(seed, TEXTURE, (i + di) as u64, (j + dj) as u64));
    let ease = |t: f64| t * t * (3.0 - 2.0 * t);
    let (south, north) = (
        at(0.0, 0.0) + (at(1.0, 0.0) - at(0.0, 0.0)) * ease(fu),
        at(0.0, 1.0) + (at(1.0, 1.0) - at(0.0, 1.0)) * ease(fu),
    );
    south + (north - south) * ease(fv)
}

/// Gap between two rims, negative when they overlap: the least over points on both rims.
pub fn gap(one: &Ellipse, two: &Ellipse) -> f64 {
    if one.centre.distance(two.centre) > one.a + two.a + 10.0 {
        return f64::INFINITY;
    }
    let rim = |e: &Ellipse| -> Vec<Point> {
        (0..72)
            .map(|k| {
                let t = f64::from(k) * std::f64::consts::TAU / 72.0;
                e.centre + Point::new(e.a * t.cos(), e.b * t.sin()).rotated(e.theta)
            })
            .collect()
    };
    let signed = |e: &Ellipse, p: Point| {
        let scale = e.scale_to(p);
        p.distance(e.centre) * (1.0 - 1.0 / scale.max(1e-9))
    };
    let from = |e: &Ellipse, o: &Ellipse| rim(o).into_iter().map(|p| signed(e, p)).fold(f64::INFINITY, f64::min);
    from(one, two).min(from(two, one))
}

/// A short stroke over some animals and some strokes over ground that is free.
pub fn scribbles(drawn: &Drawn, count: usize) -> Scribbles {
    let centres: Vec<Point> = drawn.animals.iter().map(|e| e.centre).collect();
    let near = CellGrid::new(&centres, 30.0);
    let reach = drawn.animals.iter().map(|e| e.a).fold(0.0, f64::max);
    let mut strokes: Vec<Stroke> = drawn
        .animals
        .iter()
        .step_by((drawn.animals.len() / count).max(1))
        .take(count)
        .map(|e| {
            let half = e.heading() * (0.6 * e.a);
            Stroke { mark: Mark::Animal, points: vec![e.centre - half, e.centre + half], width: (0.6 * e.b).max(1.0) }
        })
        .collect();
    let grid = drawn.photo.grid();
    let mut random = Stream::new(5, PLACE, 1);
    for _ in 0..100 * count {
        if strokes.len() >= 3 * count {
            break;
        }
        let from =
            Point::new(random.range(30.0, grid.width as f64 - 30.0), random.range(10.0, grid.height as f64 - 10.0));
        let to = from + Point::new(random.range(-25.0, 25.0), 0.0);
        let mut free = true;
        near.for_each_near(from, reach + 35.0, |i| {
            let e = Ellipse { a: drawn.animals[i].a + 4.0, b: drawn.animals[i].b + 4.0, ..drawn.animals[i] };
            free &= (0..=10).all(|k| e.scale_to(from.lerp(to, f64::from(k) / 10.0)) > 1.0);
        });
        if free {
            strokes.push(Stroke { mark: Mark::Ground, points: vec![from, to], width: 3.0 });
        }
    }
    Scribbles::Strokes(strokes)
}
