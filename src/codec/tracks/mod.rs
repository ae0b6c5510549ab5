//! The tracks of a herd as files: columns of numbers, OGC Moving Features JSON, glTF.
//!
//! | file | holds |
//! |---|---|
//! | [`binary`] | `BTRK`: little-endian columns |
//! | [`moving_features`] | OGC 19-045r3 |
//! | [`gltf`] | glTF 2.0 with one node an animal |

mod binary;
mod gltf;
mod moving_features;

use crate::codec::map::Georeference;
use crate::compute::geometry::Point;
use crate::compute::herds::animation::Tracks;

/// Tracks that are to be written.
#[derive(Debug, Clone, Copy)]
pub struct TrackFile<'a> {
    /// Where every animal was.
    pub tracks: &'a Tracks,
    /// Half the length and half the width of each, metres.
    pub bodies: &'a [(f64, f64)],
    /// What the places lie on.
    pub georeference: &'a Georeference,
    /// Subtracted from places in the forms of 32-bit floats, which cannot hold coordinates of
    /// countries: the terrain's corner, or (0, 0) in a local frame.
    pub origin: Point,
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::compute::herds::animation::Pose;

    /// Two animals at three times: one goes east, one turns through half a turn to the left.
    pub(crate) fn tracks() -> Tracks {
        let pose = |x: f64, y: f64, heading: f64| Pose { place: Point::new(x, y), z: 5.0 + x, heading };
        let poses = vec![
            pose(10.0, 20.0, 0.0),
            pose(12.0, 25.0, 1.5),
            pose(11.0, 20.0, 0.0),
            pose(12.0, 26.0, 3.1),
            pose(13.0, 20.0, 0.0),
            pose(11.0, 26.0, -3.1),
        ];
        Tracks { times_s: vec![60.0, 60.5, 61.25], animals: 2, poses }
    }

    pub(crate) fn file<'a>(tracks: &'a Tracks, georeference: &'a Georeference) -> TrackFile<'a> {
        TrackFile { tracks, bodies: &[(1.2, 0.5), (1.0, 0.4)], georeference, origin: Point::new(1.0, 2.0) }
    }
}
