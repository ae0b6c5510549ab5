use crate::compute::geometry::Point;
use crate::compute::geometry::Region;
use crate::compute::pcf::PcfError;

/// Elements may lie outside their domain by this fraction of its extent: rounding in files.
const OUTSIDE_TOLERANCE: f64 = 1e-6;

/// The largest coordinate or radius: beyond it squares lose their meaning.
const LARGEST: f64 = 1e12;

/// A point or disk of a class.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Element {
    /// Centre.
    pub centre: Point,
    /// Radius, 0 for a point.
    pub radius: f64,
    /// Class, from 0.
    pub class: usize,
}

/// The maximal spacing r_max = 2·√(A/(2√3·n)) of `count` elements in `area`: the unit in which
/// their distances are measured (T eq. 3.1).
pub fn maximal_spacing(area: f64, count: usize) -> f64 {
    2.0 * (area / (2.0 * 3.0_f64.sqrt() * count.max(1) as f64)).sqrt()
}

/// Checks places, radii and duplicates.
///
/// # Errors
/// Fewer than two elements; a coordinate or radius that is not finite, too large, or a negative
/// radius; two elements of one class at one place with one radius.
pub fn check_elements(elements: &[Element]) -> Result<(), PcfError> {
    if elements.len() < 2 {
        return Err(PcfError::TooFewElements { found: elements.len() });
    }
    for (index, e) in elements.iter().enumerate() {
        let fields = [("x", e.centre.x, -LARGEST), ("y", e.centre.y, -LARGEST), ("radius", e.radius, 0.0)];
        for (field, found, least) in fields {
            if !(least..=LARGEST).contains(&found) {
                let expected = if field == "radius" { "a number from 0 to 1e12" } else { "a number within ±1e12" };
                return Err(PcfError::BadElement { index, field, expected, found });
            }
        }
    }
    let same = |a: &Element, b: &Element| a == b;
    match first_pair(elements, same) {
        Some((first, second)) => Err(PcfError::Duplicate { first, second }),
        None => Ok(()),
    }
}

/// Elements of different classes at one place: allowed, worth a warning. At most one pair a
/// place.
pub fn shared_places(elements: &[Element]) -> Vec<(usize, usize)> {
    let order = by_place(elements);
    let shared = |pair: &[usize]| elements[pair[0]].centre == elements[pair[1]].centre;
    let mut pairs: Vec<(usize, usize)> =
        order.windows(2).filter(|p| shared(p)).map(|p| (p[0].min(p[1]), p[0].max(p[1]))).collect();
    pairs.sort_unstable();
    pairs
}

/// The first element outside `region`, if any.
///
/// # Errors
/// [`PcfError::Outside`] with its place.
pub fn check_inside(elements: &[Element], region: &Region) -> Result<(), PcfError> {
    let tolerance = region.bounds().width().max(region.bounds().height()) * OUTSIDE_TOLERANCE;
    match elements.iter().position(|e| !region.contains_within(e.centre, tolerance)) {
        Some(index) => Err(PcfError::Outside { index, x: elements[index].centre.x, y: elements[index].centre.y }),
        None => Ok(()),
    }
}

fn by_place(elements: &[Element]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..elements.len()).collect();
    let key = |i: &usize| elements[*i];
    order.sort_by(|a, b| {
        let (a, b) = (key(a), key(b));
        a.centre
            .x
            .total_cmp(&b.centre.x)
            .then(a.centre.y.total_cmp(&b.centre.y))
            .then(a.class.cmp(&b.class))
            .then(a.radius.total_cmp(&b.radius))
    });
    order
}

fn first_pair(elements: &[Element], is_pair: impl Fn(&Element, &Element) -> bool) -> Option<(usize, usize)> {
    let order = by_place(elements);
    let found = order.windows(2).filter(|p| is_pair(&elements[p[0]], &elements[p[1]]));
    found.map(|p| (p[0].min(p[1]), p[0].max(p[1]))).min()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, radius: f64, class: usize) -> Element {
        Element { centre: Point::new(x, 0.0), radius, class }
    }

    #[test]
    fn bad_elements_are_named() {
        assert_eq!(check_elements(&[at(0.0, 0.0, 0)]), Err(PcfError::TooFewElements { found: 1 }));
        let bad = |e: Element| check_elements(&[at(0.0, 0.0, 0), e]);
        assert!(matches!(bad(at(f64::NAN, 0.0, 0)), Err(PcfError::BadElement { index: 1, field: "x", .. })));
        assert!(matches!(bad(at(f64::INFINITY, 0.0, 0)), Err(PcfError::BadElement { field: "x", .. })));
        assert!(matches!(bad(at(1.0, -0.5, 0)), Err(PcfError::BadElement { field: "radius", .. })));
    }

    #[test]
    fn duplicates_are_refused_and_shared_places_are_listed() {
        let list = [at(1.0, 0.5, 0), at(2.0, 0.5, 0), at(1.0, 0.5, 1), at(1.0, 0.4, 0)];
        assert_eq!(check_elements(&list), Ok(()));
        assert!(!shared_places(&list).is_empty());
        let twice = [at(1.0, 0.5, 0), at(2.0, 0.5, 0), at(1.0, 0.5, 0)];
        assert_eq!(check_elements(&twice), Err(PcfError::Duplicate { first: 0, second: 2 }));
    }

    #[test]
    fn the_spacing_is_the_one_of_the_hexagonal_packing() {
        // A hexagonal lattice of unit spacing has one point in √3/2.
        assert!((maximal_spacing(3.0_f64.sqrt() / 2.0 * 100.0, 100) - 1.0).abs() < 1e-12);
    }
}
