//! Where a key-herd stands and looks.

use biotope_api::error::ErrorCode;
use biotope_api::herds::SiteInput;

use crate::compute::geometry::Point;
use crate::compute::herds::animation::Trajectory;
use crate::jobs::Invalid;
use crate::jobs::Sources;
use crate::jobs::herds::tie;
use crate::jobs::herds::tie::Herd;

const POINTER: &str = "/place";

/// Headings of a trajectory are those of a chord that reaches this share of its length either way.
const REACH: f64 = 0.02;

/// Where a key-herd stands and looks.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// The herd's middle, metres.
    pub centre: Point,
    /// Radians counter-clockwise from east.
    pub direction: f64,
    /// The way it walks, if one is given.
    pub way: Vec<Point>,
    /// The herd of an ecosystem, if one is given.
    pub herd: Option<Herd>,
}

/// The place of a request.
///
/// # Errors
/// None or several of the three ways to give one, a trajectory without length, a herd that is not
/// there.
pub fn open(input: &SiteInput, sources: &dyn Sources) -> Result<Place, Invalid> {
    let given = [input.position.is_some(), input.trajectory.is_some(), input.ecosystem_herd.is_some()];
    match given.into_iter().filter(|g| *g).count() {
        0 => return Err(Invalid::new(POINTER, ErrorCode::Missing, "a position, a trajectory or a herd", "none")),
        1 => {}
        several => {
            let expected = "one of a position, a trajectory and a herd";
            return Err(Invalid::new(POINTER, ErrorCode::Inconsistent, expected, several));
        }
    }
    if let Some([x, y]) = input.position {
        if input.along.is_some() {
            let expected = "no place along a trajectory beside a position";
            return Err(Invalid::new(format!("{POINTER}/along"), ErrorCode::Inconsistent, expected, "one"));
        }
        let direction = input.direction.unwrap_or(0.0);
        return Ok(Place { centre: Point::new(x, y), direction, way: Vec::new(), herd: None });
    }
    if input.direction.is_some() {
        let expected = "no direction beside a trajectory, which gives it";
        return Err(Invalid::new(format!("{POINTER}/direction"), ErrorCode::Inconsistent, expected, "one"));
    }
    if let Some(trajectory) = &input.trajectory {
        let corners: Vec<Point> = trajectory.iter().map(|p| Point::new(p[0], p[1])).collect();
        return along(&corners, input, None, &format!("{POINTER}/trajectory"));
    }
    let pointer = format!("{POINTER}/ecosystem_herd");
    match &input.ecosystem_herd {
        Some(herd) => {
            let herd = tie::open(herd, &pointer, sources)?;
            along(&herd.places(), input, Some(herd), &pointer)
        }
        None => Err(Invalid::new(POINTER, ErrorCode::Missing, "a place", "none")),
    }
}

fn along(corners: &[Point], input: &SiteInput, herd: Option<Herd>, pointer: &str) -> Result<Place, Invalid> {
    let length: f64 = corners.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
    let straight =
        || Invalid::new(pointer, ErrorCode::OutOfRange, "a way of some finite length", format!("{length} m"));
    if !(length.is_finite() && length > 0.0) {
        return Err(straight());
    }
    let way = Trajectory::on_open_ground(corners, REACH * length).ok_or_else(straight)?;
    let s = input.along.unwrap_or(0.0) * way.length();
    Ok(Place { centre: way.at(s), direction: way.heading(s).angle(), way: way.points().to_vec(), herd })
}
