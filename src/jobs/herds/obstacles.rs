//! Obstacles in.

use biotope_api::error::ErrorCode;
use biotope_api::herds::ObstaclesInput;

use crate::compute::geometry::Point;
use crate::compute::geometry::Region;
use crate::compute::herds::Obstacles;
use crate::jobs::Invalid;
use crate::jobs::Sources;
use crate::jobs::points::faults;
use crate::jobs::points::regions;

/// The obstacles at `/obstacles`.
///
/// # Errors
/// Disks that are none, areas that are no polygons, a mask that cannot be read or placed.
pub fn open(input: &ObstaclesInput, sources: &dyn Sources) -> Result<Obstacles, Invalid> {
    let mut all = Invalid::default();
    for (i, disk) in input.disks.iter().enumerate() {
        if ![disk.x, disk.y, disk.radius].iter().all(|v| v.is_finite()) {
            all.push(format!("/obstacles/disks/{i}"), ErrorCode::OutOfRange, "finite numbers", "others");
        }
    }
    let mut area = |(i, polygon): (usize, &biotope_api::points::PolygonInput)| {
        let region = Region::from_polygons(&[regions::polygon(polygon)]);
        all.keep(region.map_err(|error| {
            let mut fault = faults::polygon(&error, "");
            fault.errors.iter_mut().for_each(|e| e.pointer = format!("/obstacles/areas/{i}"));
            fault
        }))
    };
    let areas = input.areas.iter().enumerate().filter_map(&mut area).collect();
    let mask = input.mask.as_ref().map(|mask| regions::painted(mask, "/obstacles/mask", (None, sources)));
    let mask = mask.and_then(|raster| all.keep(raster));
    all.into_result().map(|()| Obstacles {
        disks: input.disks.iter().map(|d| (Point::new(d.x, d.y), d.radius)).collect(),
        areas,
        mask: mask.map(|raster| raster.map(|v| u8::from(f64::from(v) > input.mask_above))),
    })
}
