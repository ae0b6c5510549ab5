use crate::codec::sheet::RasterError;
use crate::compute::geometry::Point;
use proj4rs::Proj;
use proj4rs::transform::transform;

/// Longitude and latitude on WGS 84.
const WGS84: u16 = 4326;

/// Between the coordinate system of a file and a planar one in metres.
pub(super) struct Projection {
    file: Proj,
    planar: Proj,
    /// Whether the file's coordinates are degrees, not lengths.
    degrees: bool,
}

impl Projection {
    /// From the system of that code (WGS 84 in degrees where none is named) to a planar one.
    pub(super) fn between(file: Option<u16>, planar: u16) -> Result<Self, RasterError> {
        let (file, planar) = (system(file.unwrap_or(WGS84))?, system(planar)?);
        Ok(Self { degrees: file.is_latlong(), file, planar })
    }

    /// A point of the plane in the file's coordinates, degrees or lengths; `None` outside the
    /// projection's range.
    pub(super) fn to_file(&self, p: Point) -> Option<Point> {
        let q = moved(&self.planar, &self.file, p)?;
        Some(if self.degrees { Point::new(q.x.to_degrees(), q.y.to_degrees()) } else { q })
    }

    /// The same, with a longitude counted so that it lies within half a turn of `near`.
    pub(super) fn to_file_near(&self, p: Point, near: f64) -> Option<Point> {
        let q = self.to_file(p)?;
        let turns = if self.degrees { ((near - q.x) / 360.0).round() } else { 0.0 };
        Some(Point::new(q.x + 360.0 * turns, q.y))
    }

    /// The point of the plane at those coordinates of the file.
    pub(super) fn to_plane(&self, p: Point) -> Option<Point> {
        let q = if self.degrees { Point::new(p.x.to_radians(), p.y.to_radians()) } else { p };
        moved(&self.file, &self.planar, q)
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

/// Whether a code names web Mercator, whose metres are stretched by 1 / cos(latitude).
pub(super) const fn is_web_mercator(code: u16) -> bool {
    matches!(code, 3857 | 3785)
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
        let back = zone.to_file(p).unwrap();
        assert!(back.distance(Point::new(-84.4, 36.6)) < 1e-9);
    }

    #[test]
    fn an_unknown_code_is_refused() {
        assert!(matches!(Projection::between(Some(1), 32616), Err(RasterError::UnknownCrs { .. })));
    }
}
