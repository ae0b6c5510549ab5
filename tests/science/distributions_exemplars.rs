//! Exemplars made for the tests, and the stands where they are present.

use biotope::compute::geometry::Bounds;
use biotope::compute::geometry::Point;
use biotope::compute::geometry::Region;
use biotope::compute::pcf;
use biotope::compute::pcf::Analysis;
use biotope::compute::pcf::AnalysisOptions;
use biotope::compute::pcf::Dependencies;
use biotope::compute::pcf::Element;
use biotope::compute::pcf::Metric;
use biotope::compute::pcf::Target;
use biotope::compute::random::Purpose;
use biotope::compute::random::Stream;
use biotope::compute::run::Run;
use std::f64::consts::TAU;

/// A pattern with its domain and the graph of its classes.
pub struct Exemplar {
    pub name: String,
    pub elements: Vec<Element>,
    pub domain: Region,
    pub graph: Dependencies,
    pub metric: Metric,
}

impl Exemplar {
    pub fn analysed(&self) -> Analysis {
        let options = AnalysisOptions { triplets: true, ..AnalysisOptions::of(self.metric) };
        pcf::analyse(&self.elements, &self.domain, (&self.graph, &options), &Run::silent()).unwrap()
    }

    pub fn counts(&self) -> Vec<usize> {
        self.graph.order().iter().enumerate().map(|(c, _)| self.of_class(c).len()).collect()
    }

    pub fn of_class(&self, class: usize) -> Vec<Element> {
        self.elements.iter().filter(|e| e.class == class).copied().collect()
    }

    /// The same domain and counts again.
    pub fn target(&self) -> Target<'_> {
        Target { domain: &self.domain, room: None, density: None, fixed: &[], counts: self.counts() }
    }
}

pub fn rectangle(x: f64, y: f64) -> Region {
    Region::rectangle(Bounds::new(Point::default(), Point::new(x, y))).unwrap()
}

/// Throws `count` elements of a class, each at the first of many random places that `fits`.
fn throw(
    elements: &mut Vec<Element>,
    (class, count): (usize, usize),
    mut draw: impl FnMut(&[Element]) -> Element,
    fits: impl Fn(&[Element], &Element) -> bool,
) {
    for _ in 0..count {
        let found = (0..20_000).find_map(|_| {
            let e = Element { class, ..draw(elements) };
            fits(elements, &e).then_some(e)
        });
        elements.extend(found);
    }
}

fn gap(a: &Element, b: &Element) -> f64 {
    a.centre.distance(b.centre) - a.radius - b.radius
}

/// The fairytale forest of T figure 3.11: 60 trees apart from each other, 200 tufts of grass
/// outside their shade and evenly spread, 200 mushrooms at the rim of the shade in small groups.
pub fn forest(seed: u64) -> Exemplar {
    let side = 100.0;
    let mut random = Stream::new(seed, Purpose::new("test.forest"), 0);
    let mut elements = Vec::new();
    let place = |r: &mut Stream| Point::new(r.range(0.0, side), r.range(0.0, side));
    let mut r = random.clone();
    throw(
        &mut elements,
        (0, 60),
        |_| Element { centre: place(&mut r), radius: r.range(3.0, 5.0), class: 0 },
        |all, e| all.iter().all(|o| gap(o, e) > 0.8),
    );
    random.bits();
    let mut r = Stream::new(seed, Purpose::new("test.forest"), 1);
    throw(
        &mut elements,
        (1, 200),
        |_| Element { centre: place(&mut r), radius: r.range(0.5, 0.8), class: 1 },
        |all, e| all.iter().all(|o| gap(o, e) > if o.class == 0 { 0.3 } else { 1.6 }),
    );
    let mut r = Stream::new(seed, Purpose::new("test.forest"), 2);
    throw(
        &mut elements,
        (2, 200),
        |all| {
            let tree = all[r.below(60)];
            let angle = (f64::from(r.below(4) as u32) * 1.7 + r.range(-0.35, 0.35)) % TAU;
            let radius = r.range(0.25, 0.45);
            let from_rim = r.range(-0.4, 0.4);
            let centre = tree.centre + Point::from_angle(angle) * (tree.radius + from_rim);
            Element { centre, radius, class: 2 }
        },
        |all, e| {
            let inside = (0.0..side).contains(&e.centre.x) && (0.0..side).contains(&e.centre.y);
            inside && all.iter().filter(|o| o.class > 0).all(|o| gap(o, e) > 0.05)
        },
    );
    let graph = Dependencies::new(3, &[(1, 0), (2, 0)]).unwrap();
    Exemplar { name: "forest".into(), elements, domain: rectangle(side, side), graph, metric: Metric::Disk }
}

/// The over-constrained nest of T figure 3.13: a large disk, in it one a third its size, in that
/// one a small one, all nests apart.
pub fn nested(seed: u64) -> Exemplar {
    let side = 40.0;
    let mut r = Stream::new(seed, Purpose::new("test.nested"), 0);
    let mut elements = Vec::new();
    throw(
        &mut elements,
        (0, 70),
        |_| Element { centre: Point::new(r.range(0.0, side), r.range(0.0, side)), radius: 1.6, class: 0 },
        |all, e| all.iter().all(|o| gap(o, e) > 0.3),
    );
    for i in 0..elements.len() {
        let outer = elements[i];
        let middle = outer.centre + Point::from_angle(r.range(0.0, TAU)) * r.range(0.5, 0.75);
        elements.push(Element { centre: middle, radius: 0.7, class: 1 });
        let inner = middle + Point::from_angle(r.range(0.0, TAU)) * r.range(0.1, 0.3);
        elements.push(Element { centre: inner, radius: 0.3, class: 2 });
    }
    let domain = rectangle(side, side);
    elements.retain(|e| domain.contains(e.centre));
    let graph = Dependencies::new(3, &[(1, 0), (2, 1), (2, 0)]).unwrap();
    Exemplar { name: "nested".into(), elements, domain, graph, metric: Metric::Disk }
}

/// A hexagonal grid of points (T figure 3.19).
pub fn hexagonal() -> Exemplar {
    let mut elements = Vec::new();
    for row in 0..14 {
        for column in 0..12 {
            let x = f64::from(column) + 0.5 * f64::from(row % 2) + 0.25;
            let centre = Point::new(x, (f64::from(row) + 0.5) * 3.0_f64.sqrt() / 2.0);
            elements.push(Element { centre, radius: 0.0, class: 0 });
        }
    }
    let domain = rectangle(12.0, 7.0 * 3.0_f64.sqrt());
    let graph = Dependencies::new(1, &[]).unwrap();
    Exemplar { name: "hexagonal".into(), elements, domain, graph, metric: Metric::Point }
}

/// The stands of the shared data, where they are present (see its PROVENANCE): anemones, cells,
/// finpines, lansing (six species), longleaf as points, and the one of real tree crowns.
pub fn stands() -> Vec<Exemplar> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/stands");
    if !folder.is_dir() {
        return Vec::new();
    }
    let windows = [
        ("anemones", [0.0, 0.0, 280.0, 180.0]),
        ("cells", [0.0, 0.0, 1.0, 1.0]),
        ("finpines", [-5.0, -8.0, 5.0, 2.0]),
        ("lansing", [0.0, 0.0, 1.0, 1.0]),
        ("longleaf", [0.0, 0.0, 200.0, 200.0]),
    ];
    let mut stands: Vec<Exemplar> = windows
        .iter()
        .map(|(name, window)| {
            let text = std::fs::read_to_string(folder.join(format!("{name}.csv"))).unwrap();
            stand(name, &text, *window)
        })
        .collect();
    let crowns = std::fs::read_to_string(folder.join("crowns_2019_YELL_2_541000_4977000.csv")).unwrap();
    stands.push(crowns_of(&crowns));
    stands
}

fn stand(name: &str, text: &str, window: [f64; 4]) -> Exemplar {
    let species = if name == "lansing" { species_of(text) } else { vec![String::new()] };
    let element = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let class = species.iter().position(|s| s.is_empty() || fields[2] == s).unwrap();
        Element { centre: Point::new(fields[0].parse().unwrap(), fields[1].parse().unwrap()), radius: 0.0, class }
    };
    let elements: Vec<Element> = text.lines().skip(1).map(element).collect();
    let bounds = Bounds::new(Point::new(window[0], window[1]), Point::new(window[2], window[3]));
    let graph = Dependencies::by_size(species.len(), &elements);
    let domain = Region::rectangle(bounds).unwrap();
    Exemplar { name: name.into(), elements, domain, graph, metric: Metric::Point }
}

fn species_of(text: &str) -> Vec<String> {
    let mut species: Vec<String> = text.lines().skip(1).map(|l| l.split(',').nth(2).unwrap().to_string()).collect();
    species.sort();
    species.dedup();
    species
}

fn crowns_of(text: &str) -> Exemplar {
    let sizes: Vec<f64> = text.lines().next().unwrap().split_whitespace().filter_map(|w| w.parse().ok()).collect();
    let element = |line: &str| {
        let fields: Vec<f64> = line.split(',').take(3).map(|f| f.parse().unwrap()).collect();
        Element { centre: Point::new(fields[0], fields[1]), radius: fields[2], class: 0 }
    };
    let elements = text.lines().skip(2).map(element).collect();
    let graph = Dependencies::new(1, &[]).unwrap();
    Exemplar { name: "crowns".into(), elements, domain: rectangle(sizes[0], sizes[1]), graph, metric: Metric::Disk }
}

/// Points at least 0.75 of a spacing apart, by sequential inhibition, in a square of side 10.
pub fn hard_core(count: usize, seed: u64) -> Exemplar {
    let mut r = Stream::new(seed, Purpose::new("test.hard-core"), 0);
    let least = 0.75 * 10.0 / (count as f64).sqrt();
    let mut elements = Vec::new();
    throw(
        &mut elements,
        (0, count),
        |_| Element { centre: Point::new(r.range(0.0, 10.0), r.range(0.0, 10.0)), radius: 0.0, class: 0 },
        |all, e| all.iter().all(|o| o.centre.distance(e.centre) >= least),
    );
    let graph = Dependencies::new(1, &[]).unwrap();
    Exemplar { name: "hard-core".into(), elements, domain: rectangle(10.0, 10.0), graph, metric: Metric::Point }
}

/// 300 points in a square of side 10, independent or in groups of six.
pub fn scattered(in_groups: bool, seed: u64) -> Exemplar {
    let mut r = Stream::new(seed, Purpose::new("test.scattered"), 0);
    let domain = rectangle(10.0, 10.0);
    let mut elements = Vec::new();
    while elements.len() < 300 {
        let middle = Point::new(r.range(0.0, 10.0), r.range(0.0, 10.0));
        let places: Vec<Point> = if in_groups {
            (0..6).map(|_| middle + Point::new(r.normal(), r.normal()) * 0.3).collect()
        } else {
            vec![middle]
        };
        let inside = places.into_iter().filter(|p| domain.contains(*p));
        elements.extend(inside.map(|centre| Element { centre, radius: 0.0, class: 0 }));
    }
    elements.truncate(300);
    let name = if in_groups { "groups" } else { "independent" };
    let graph = Dependencies::new(1, &[]).unwrap();
    Exemplar { name: name.into(), elements, domain, graph, metric: Metric::Point }
}

/// Elements at least 0.75 of a spacing apart, about 300 in a square of side 10 that is cut out of a
/// larger one, and so as dense at its border as within; disks of the disk metric do not overlap.
pub fn cut_out_of_more(metric: Metric, seed: u64) -> Exemplar {
    let mut r = Stream::new(seed, Purpose::new("test.cut-out"), 0);
    let (least, margin) = (0.75 * 10.0 / 300.0_f64.sqrt(), 2.0);
    let radius = if metric == Metric::Disk { 0.48 * least } else { 0.0 };
    let mut elements = Vec::new();
    let mut from_margin = || r.range(-margin, 10.0 + margin);
    throw(
        &mut elements,
        (0, (300.0 * (1.0 + 0.2 * margin).powi(2)) as usize),
        |_| Element { centre: Point::new(from_margin(), from_margin()), radius, class: 0 },
        |all, e| all.iter().all(|o| o.centre.distance(e.centre) >= least),
    );
    let domain = rectangle(10.0, 10.0);
    elements.retain(|e| domain.contains(e.centre));
    let graph = Dependencies::new(1, &[]).unwrap();
    Exemplar { name: "cut out".into(), elements, domain, graph, metric }
}
