use crate::codec::sheet::RasterError;
use crate::compute::geometry::Point;
use proj4rs::Proj;
use proj4rs::transform::transform;

/// Longitude and latitude on WGS 84.
const WGS84: u16 = 4326;

/// Between a geographic coordinate system and a planar one in metres.
pub(super) struct Projection {
    geographic: Proj,
    planar: Proj,
}

impl Projection {
    /// From the geographic system of that code (WGS 84 where none is named) to a planar one.
    pub(super) fn between(geographic: Option<u16>, planar: u16) -> Result<Self, RasterError> {
        Ok(Self { geographic: system(geographic.unwrap_or(WGS84))?, planar: system(planar)? })
    }

    /// Longitude and latitude in degrees of a point of the plane; `None` outside the
    /// projection's range.
    pub(super) fn to_degrees(&self, p: Point) -> Option<Point> {
        let q = moved(&self.planar, &self.geographic, p)?;
        Some(Point::new(q.x.to_degrees(), q.y.to_degrees()))
    }

    /// The same, with the longitude counted so that it lies within half a turn of `near`.
    pub(super) fn to_degrees_near(&self, p: Point, near: f64) -> Option<Point> {
        let q = self.to_degrees(p)?;
        Some(Point::new(q.x + 360.0 * ((near - q.x) / 360.0).round(), q.y))
    }

    /// The point of the plane at that longitude and latitude in degrees.
    pub(super) fn to_plane(&self, degrees: Point) -> Option<Point> {
        moved(&self.geographic, &self.planar, Point::new(degrees.x.to_radians(), degrees.y.to_radians()))
    }
}

fn moved(from: &Proj, to: &Proj, p: Point) -> Option<Point> {
    let mut q = (p.x, p.y, 0.0);
    transform(from, to, &mut q).ok()?;
    Some(Point::new(q.0, q.1)).filter(|q| q.is_finite())
}

fn system(code: u16) -> Result<Proj, RasterError> {
    Proj::from_epsg_code(code).map_err(|_| RasterError::UnknownCrs { found: format!("EPSG:{code}") })
}

/// Whether a code names a geographic coordinate system.
pub(super) fn is_geographic(code: u16) -> Result<bool, RasterError> {
    Ok(system(code)?.is_latlong())
}

/// Metres a unit of the planar coordinate system of that code.
pub(super) fn metres_a_unit(code: u16) -> Result<f64, RasterError> {
    Ok(system(code)?.to_meter())
}

/// The EPSG code of the UTM zone that holds a place, on WGS 84; near the poles of the Universal
/// Polar Stereographic.
pub(super) fn utm(degrees: Point) -> u16 {
    let turned = (degrees.x + 180.0).rem_euclid(360.0);
    let zone = (turned / 6.0).floor() as u16 + 1;
    match degrees.y {
        lat if lat > 84.0 => 32661,
        lat if lat < -80.0 => 32761,
        lat if lat >= 0.0 => 32600 + zone.min(60),
        _ => 32700 + zone.min(60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_fall_into_their_zone() {
        assert_eq!(utm(Point::new(-84.4, 36.6)), 32616);
        assert_eq!(utm(Point::new(2.75, 42.81)), 32631);
        assert_eq!(utm(Point::new(151.2, -33.9)), 32756);
        assert_eq!(utm(Point::new(180.0, 10.0)), 32601);
        assert_eq!(utm(Point::new(0.0, -89.0)), 32761);
    }

    #[test]
    fn a_zone_agrees_with_known_coordinates() {
        // As PROJ gives it from EPSG:4326 to EPSG:32616.
        let zone = Projection::between(None, 32616).unwrap();
        let p = zone.to_plane(Point::new(-84.4, 36.6)).unwrap();
        assert!(p.distance(Point::new(732_567.198, 4_053_647.962_5)) < 0.001, "{p:?}");
        let back = zone.to_degrees(p).unwrap();
        assert!(back.distance(Point::new(-84.4, 36.6)) < 1e-9);
    }

    #[test]
    fn an_unknown_code_is_refused() {
        assert!(matches!(Projection::between(Some(1), 32616), Err(RasterError::UnknownCrs { .. })));
    }
}
