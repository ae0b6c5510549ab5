//! Convex polygons: the domains of herds (T 4.2.2). Corners run counter-clockwise.

use crate::compute::geometry::Point;
use std::f64::consts::PI;

/// The convex hull of `points` (Andrew's monotone chain); fewer than three corners when they lie
/// on a line.
pub(super) fn convex(points: &[Point]) -> Vec<Point> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|p, q| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let half = |points: &mut dyn Iterator<Item = &Point>| {
        let mut chain: Vec<Point> = Vec::new();
        for p in points {
            while chain.len() >= 2 {
                let (a, b) = (chain[chain.len() - 2], chain[chain.len() - 1]);
                if (b - a).cross(*p - b) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(*p);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut sorted.iter());
    hull.extend(half(&mut sorted.iter().rev()));
    hull
}

/// Area.
pub(super) fn area(corners: &[Point]) -> f64 {
    let next = |i: usize| corners[(i + 1) % corners.len()];
    (0..corners.len()).map(|i| corners[i].cross(next(i))).sum::<f64>() / 2.0
}

fn centroid(corners: &[Point]) -> Point {
    let next = |i: usize| corners[(i + 1) % corners.len()];
    let sum = (0..corners.len()).fold(Point::default(), |s, i| s + (corners[i] + next(i)) * corners[i].cross(next(i)));
    sum * (1.0 / (6.0 * area(corners)))
}

/// Whether a hull is a domain: at least three corners, and nowhere thinner than a tenth of a
/// body (ours).
pub(super) fn is_wide(hull: &[Point], mean_area: f64) -> bool {
    if hull.len() < 3 {
        return false;
    }
    let longest = hull.iter().flat_map(|p| hull.iter().map(|q| p.distance(*q))).fold(0.0, f64::max);
    area(hull) / longest > 0.1 * (mean_area / PI).sqrt()
}

/// A hull enlarged about its centroid by 1/√(1 − m/n), m its corners and n the points: the
/// estimate by Ripley and Rasson (1977) of the domain the points were drawn from.
pub(super) fn enlarged(hull: &[Point], points: usize) -> Vec<Point> {
    // All points on the hull would make it endless.
    let share = (hull.len() as f64 / points as f64).min(0.75);
    scaled(hull, centroid(hull), 1.0 / (1.0 - share).sqrt())
}

/// Corners moved away from `centre` by a factor.
fn scaled(corners: &[Point], centre: Point, factor: f64) -> Vec<Point> {
    corners.iter().map(|p| centre + (*p - centre) * factor).collect()
}

/// The fallback for herds of one, two or in a line: everything within half the mean distance to
/// the next along the line, at least two body radii (ours), as a polygon of sixteen corners.
pub(super) fn around(points: &[Point], mean_area: f64) -> Vec<Point> {
    let ends = convex(points);
    let length = ends.iter().flat_map(|p| ends.iter().map(|q| p.distance(*q))).fold(0.0, f64::max);
    let reach = (0.5 * length / (points.len().max(2) - 1) as f64).max(2.0 * (mean_area / PI).sqrt());
    let round = |p: &Point| {
        (0..16).map(|k| Point::from_angle(f64::from(k) * PI / 8.0) * reach).map(|d| *p + d).collect::<Vec<_>>()
    };
    convex(&ends.iter().flat_map(round).collect::<Vec<_>>())
}

/// Whether `p` lies inside or on the rim.
pub(super) fn contains(corners: &[Point], p: Point) -> bool {
    (0..corners.len()).all(|i| (corners[(i + 1) % corners.len()] - corners[i]).cross(p - corners[i]) >= 0.0)
}

/// How far along the segment the place nearest to `p` lies, from 0 to 1.
pub(super) fn share_along((from, to): (Point, Point), p: Point) -> f64 {
    let d = to - from;
    if d.norm_sq() > 0.0 { ((p - from).dot(d) / d.norm_sq()).clamp(0.0, 1.0) } else { 0.0 }
}

/// The place on the rim nearest to `p`.
pub(super) fn nearest(corners: &[Point], p: Point) -> Point {
    let on = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        a.lerp(b, share_along((a, b), p))
    };
    (0..corners.len()).map(on).min_by(|a, b| a.distance_sq(p).total_cmp(&b.distance_sq(p))).unwrap_or(p)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Vec<Point> {
        [(0.0, 0.0), (4.0, 0.0), (2.0, 1.0), (4.0, 4.0), (0.0, 4.0), (2.0, 0.0)].map(|(x, y)| Point::new(x, y)).to_vec()
    }

    #[test]
    fn the_hull_has_only_corners_and_its_area() {
        let hull = convex(&square());
        assert_eq!(hull.len(), 4);
        assert_eq!(area(&hull), 16.0);
        assert_eq!(centroid(&hull), Point::new(2.0, 2.0));
        assert!(contains(&hull, Point::new(1.0, 3.9)) && !contains(&hull, Point::new(4.1, 1.0)));
        assert_eq!(nearest(&hull, Point::new(6.0, 3.0)), Point::new(4.0, 3.0));
    }

    #[test]
    fn enlarging_by_ripley_and_rasson_divides_the_area_by_one_less_the_share_of_corners() {
        let hull = convex(&square());
        assert!((area(&enlarged(&hull, 40)) - 16.0 / 0.9).abs() < 1e-9);
        assert!(area(&enlarged(&hull, 4)).is_finite());
    }
}
