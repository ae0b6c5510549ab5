//! A herd of an `ecosystem` result: its size and its path over the day.

use biotope_api::error::ErrorCode;
use biotope_api::herds::EcosystemHerdInput;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::compute::geometry::Point;
use crate::jobs::Invalid;
use crate::jobs::Sources;
use crate::jobs::given;

/// A row of the output `herds`, as far as it is looked at.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
struct HerdRow {
    herd: u64,
    species: String,
    size: u64,
}

/// A row of the output `paths`, as far as it is looked at.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
struct PathRow {
    herd: u64,
    t: f64,
    x: f64,
    y: f64,
}

/// A herd of an `ecosystem` result.
#[derive(Debug, Clone, PartialEq)]
pub struct Herd {
    /// Its species.
    pub species: String,
    /// Number of its animals.
    pub size: usize,
    /// When it was where: seconds and metres, times rising.
    pub path: Vec<(f64, Point)>,
}

/// The herd given at `pointer`, with the part of its path between `from_s` and `to_s`.
///
/// # Errors
/// When nothing stands behind a reference, it is no such table, or the herd is not in it.
pub fn open(input: &EcosystemHerdInput, pointer: &str, sources: &dyn Sources) -> Result<Herd, Invalid> {
    let mut all = Invalid::default();
    let herds = all.keep(given::follow::<Vec<HerdRow>>(&input.herds, &format!("{pointer}/herds"), sources));
    let paths = all.keep(given::follow::<Vec<PathRow>>(&input.paths, &format!("{pointer}/paths"), sources));
    let (Some(herds), Some(paths)) = (herds, paths) else { return Err(all) };
    let unknown =
        |expected: String| Invalid::new(format!("{pointer}/herd"), ErrorCode::NoSuchHerd, expected, input.herd);
    let row = herds.iter().find(|row| row.herd == input.herd);
    let row = row.ok_or_else(|| unknown(format!("a herd of the {} in the table", herds.len())))?;
    let (from_s, to_s) = (input.from_s.unwrap_or(f64::NEG_INFINITY), input.to_s.unwrap_or(f64::INFINITY));
    let mut path: Vec<(f64, Point)> = paths
        .iter()
        .filter(|step| step.herd == input.herd && (from_s..=to_s).contains(&step.t))
        .map(|step| (step.t, Point::new(step.x, step.y)))
        .collect();
    path.sort_by(|a, b| a.0.total_cmp(&b.0));
    path.dedup_by(|later, earlier| later.0 <= earlier.0);
    if path.len() < 2 {
        return Err(unknown(format!("a herd with a path between {from_s} and {to_s} s")));
    }
    Ok(Herd { species: row.species.clone(), size: usize::try_from(row.size).unwrap_or(usize::MAX), path })
}

impl Herd {
    /// Where it is at `time_s`; before and after its path, the ends.
    pub fn at(&self, time_s: f64) -> Point {
        let next = self.path.partition_point(|(t, _)| *t < time_s).clamp(1, self.path.len() - 1);
        let ((from, here), (to, there)) = (self.path[next - 1], self.path[next]);
        here.lerp(there, ((time_s - from) / (to - from)).clamp(0.0, 1.0))
    }

    /// The places it passes, each once although it may rest there.
    pub fn places(&self) -> Vec<Point> {
        let mut places: Vec<Point> = self.path.iter().map(|(_, place)| *place).collect();
        places.dedup();
        places
    }

    /// When its path begins and ends, seconds.
    pub fn span(&self) -> (f64, f64) {
        (self.path[0].0, self.path[self.path.len() - 1].0)
    }
}
