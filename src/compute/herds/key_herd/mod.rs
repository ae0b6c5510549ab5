//! Key-herds (T 4.2, H "Analysis and synthesis of herds"): a herd of any number of animals on the
//! ground that looks like the herd of a photo, by its correlation curve, its orientation field
//! and its density map.

mod darts;
mod edits;
mod error;
mod exemplar;
mod hull;
mod maps;
mod placement;

pub use edits::OrientationEdit;
pub use error::KeyHerdError;
pub use exemplar::Headings;
pub use maps::DensitySource;
pub use placement::Site;

use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Point;
use crate::compute::geometry::Polygon;
use crate::compute::geometry::Region;
use crate::compute::herds::contact;
use crate::compute::pcf::AnalysisOptions;
use crate::compute::pcf::Curve;
use crate::compute::pcf::Metric;
use crate::compute::pcf::PcfError;
use crate::compute::pcf::analyse_ellipses;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use exemplar::Exemplar;

/// What may be chosen about a key-herd.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyHerdOptions {
    /// Number of animals N, from 1 to 100,000.
    pub count: usize,
    /// Semi-axes of an animal in metres: half its length and half its width. All animals are of
    /// this one size (T 4.2.4, "each animal being of constant size"). Default: 1.2 and 0.5.
    pub body: (f64, f64),
    /// Where the herd stands, in metres.
    pub centre: Point,
    /// The direction of the trajectory there, radians counter-clockwise from east: the mean
    /// heading of the exemplar is turned to it.
    pub direction: f64,
    /// Whether the exemplar's headings can be trusted.
    pub headings: Headings,
    /// Where the density map comes from.
    pub density: DensitySource,
    /// An orientation field painted on the ground, in radians; laid over the exemplar's where it
    /// is a number.
    pub orientation: Option<Raster<f32>>,
    /// Changes of the orientation field (T 4.2.5), in this order.
    pub orientation_edits: Vec<OrientationEdit>,
    /// Darts after which the best so far is taken although the error does not fall. T gives
    /// 1,000 for disks and none here. Default: 48 (ours: more changes the curve little).
    pub max_fails: usize,
    /// Seed of the darts and of noise.
    pub seed: u64,
}

impl Default for KeyHerdOptions {
    fn default() -> Self {
        Self {
            count: 100,
            body: (1.2, 0.5),
            centre: Point::default(),
            direction: 0.0,
            headings: Headings::default(),
            density: DensitySource::default(),
            orientation: None,
            orientation_edits: Vec::new(),
            max_fails: 48,
            seed: 0,
        }
    }
}

/// A herd on the ground.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyHerd {
    /// The animals: exactly as many as asked for, none in an obstacle.
    pub ellipses: Vec<Ellipse>,
    /// The density map used: animals per square metre.
    pub density: Raster<f32>,
    /// The orientation field used: radians; an animal has the angle of the cell that holds it.
    pub orientation: Raster<f32>,
    /// How it came out.
    pub report: KeyHerdReport,
}

/// How a key-herd came out.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyHerdReport {
    /// Metres in a unit of the exemplar, from the animals' sizes.
    pub metres_per_unit: f64,
    /// How many times larger than the exemplar's the herd is, along a side.
    pub scale: f64,
    /// The exemplar's curve; `None` for a herd of one, two or in a line, which has no hull.
    pub target: Option<Curve>,
    /// The key-herd's curve; `None` likewise and for one animal.
    pub curve: Option<Curve>,
    /// Animals for which no dart lowered the error.
    pub forced: usize,
    /// The deepest overlap in metres.
    pub deepest_m: f64,
}

/// Makes a key-herd that looks like `exemplar` (animals of a photo, y up, in any unit).
///
/// A herd of one, two or in a line has no hull and so no curve, field or map: its domain is then
/// everything near the line, all animals look in its mean direction, and each is placed as far
/// from the others as the best of a few darts.
///
/// # Errors
/// An empty or broken exemplar, options out of range, no room, or a stop: see [`KeyHerdError`].
pub fn key_herd(
    exemplar: &[Ellipse],
    site: Site<'_>,
    options: &KeyHerdOptions,
    run: &Run,
) -> Result<KeyHerd, KeyHerdError> {
    options.check()?;
    // 1. What the exemplar looks like: its domain and maps, and its curve by the ellipse metric.
    let learnt = Exemplar::new(exemplar, options.headings)?;
    let target = learnt.is_wide().then(|| curve(exemplar, &region(&learnt.corners)?, run)).transpose()?;
    run.progress("key-herd.analysis", 1, 1)?;
    // 2. Rotated to the trajectory, in metres, and scaled until there is room for all.
    let metres_per_unit = (options.body_area() / learnt.mean_area).sqrt();
    let to = (options.centre, Point::from_angle(options.direction));
    let (placement, scale) = match options.density {
        DensitySource::Painted(_) => placement::unscaled(&learnt, to, (options.count, exemplar.len()), metres_per_unit),
        _ => placement::fit(&learnt, site, to, (options, metres_per_unit), run)?,
    };
    // 3. The maps on the ground, obstacles masked, edits made.
    let maps = maps::on_ground(&learnt, placement, site, options)?;
    run.progress("key-herd.maps", 1, 1)?;
    // 4. Darts.
    let domain = region(&maps.corners)?;
    let depth_m = contact::deepest(exemplar) * metres_per_unit;
    let goal = darts::Target { curve: target.as_ref().map(|curve| (curve, &domain)), depth_m };
    let layout = darts::throw(&maps, &goal, site, options, run)?;
    let made = (target.is_some() && layout.ellipses.len() > 1).then(|| curve(&layout.ellipses, &domain, run));
    let report = KeyHerdReport {
        metres_per_unit,
        scale,
        target,
        curve: made.transpose()?,
        forced: layout.forced,
        deepest_m: contact::deepest(&layout.ellipses),
    };
    Ok(KeyHerd { ellipses: layout.ellipses, density: maps.density, orientation: maps.orientation, report })
}

fn region(corners: &[Point]) -> Result<Region, KeyHerdError> {
    let polygon = Polygon { outer: corners.to_vec(), holes: Vec::new() };
    Ok(Region::from_polygons(&[polygon]).map_err(PcfError::from)?)
}

fn curve(ellipses: &[Ellipse], domain: &Region, run: &Run) -> Result<Curve, KeyHerdError> {
    Ok(analyse_ellipses(ellipses, domain, &AnalysisOptions::of(Metric::Ellipse), run)?)
}

impl KeyHerdOptions {
    fn body_area(&self) -> f64 {
        std::f64::consts::PI * self.body.0 * self.body.1
    }

    fn check(&self) -> Result<(), KeyHerdError> {
        let bad = |field, expected, found| Err(KeyHerdError::BadOption { field, expected, found });
        if !(1..=100_000).contains(&self.count) {
            return bad("count", "from 1 to 100,000", self.count as f64);
        }
        if !(self.body.1 > 0.0 && self.body.0 <= 100.0 && self.body.0 >= self.body.1) {
            return bad("body", "half a length of at most 100 and not below half the width", self.body.0);
        }
        if !(self.centre.is_finite() && self.direction.is_finite()) {
            return bad("direction", "a finite angle at a finite place", self.direction);
        }
        if !(1..=100_000).contains(&self.max_fails) {
            return bad("max_fails", "from 1 to 100,000", self.max_fails as f64);
        }
        self.orientation_edits.iter().try_for_each(OrientationEdit::check)
    }
}
