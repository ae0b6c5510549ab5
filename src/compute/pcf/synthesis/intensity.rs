use crate::compute::geometry::Point;
use crate::compute::pcf::PcfError;
use crate::compute::raster::Raster;

/// Partners in places painted thinner than this are not counted as more than 1/0.05 partners.
const FLOOR: f64 = 0.05;

/// How dense elements lie, relative to the mean of the domain: 1 everywhere, or painted.
///
/// With a painted density each partner counts as 1/(relative density at its place), so that the
/// curve tells the arrangement apart from the trend (the intensity-reweighted correlation of
/// Baddeley, Møller and Waagepetersen 2000, with the outer mean over the pattern's elements).
#[derive(Debug, Clone, Copy)]
pub(super) struct Intensity<'a> {
    painted: Option<&'a Raster<f32>>,
    mean: f64,
}

impl<'a> Intensity<'a> {
    pub(super) fn new(painted: Option<&'a Raster<f32>>) -> Result<Self, PcfError> {
        let bad = |v: &f32| v.is_infinite() || *v < 0.0;
        match painted {
            Some(map) if map.data.iter().any(bad) => Err(PcfError::BadDensity { reason: "negative or infinite" }),
            _ => Ok(Self { painted, mean: 1.0 }),
        }
    }

    /// The same, divided by `mean`.
    pub(super) fn relative_to(self, mean: f64) -> Self {
        Self { mean, ..self }
    }

    /// Whether it is 1 everywhere.
    pub(super) fn is_flat(&self) -> bool {
        self.painted.is_none()
    }

    /// The density at `p`; 0 outside a painted map.
    pub(super) fn at(&self, p: Point) -> f64 {
        match self.painted {
            Some(map) => map.sample(p).unwrap_or(0.0) / self.mean,
            None => 1.0,
        }
    }

    /// What a partner at `p` counts as.
    pub(super) fn weight(&self, p: Point) -> f64 {
        match self.painted {
            Some(_) => 1.0 / self.at(p).max(FLOOR),
            None => 1.0,
        }
    }
}
