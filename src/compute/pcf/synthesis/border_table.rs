use crate::compute::geometry::Point;
use crate::compute::geometry::Region;
use crate::compute::pcf::Body;
use crate::compute::pcf::BorderWeight;
use crate::compute::pcf::Frame;
use crate::compute::pcf::WEIGHT_CAP;

/// Values of a table beyond the nearest border.
const VALUES: usize = 32;

/// The border weights around an element that does not move, for every distance up to its reach:
/// tabulated, as they are asked for once a candidate.
#[derive(Debug, Clone)]
pub(super) struct BorderTable {
    clearance: f64,
    per_step: f64,
    values: Vec<f64>,
}

impl BorderTable {
    /// The weights around `p` up to `reach` r_max (`unit` metres) in `domain`.
    pub(super) fn new(domain: &Region, p: Point, (reach, unit): (f64, f64)) -> Self {
        let clearance = domain.clearance(p, reach * unit) / unit;
        if clearance >= reach || reach <= 0.0 {
            return Self { clearance: reach, per_step: 0.0, values: Vec::new() };
        }
        let body = Body { centre: p, radius: 0.0, frame: Frame::of_unit(unit) };
        let exact = BorderWeight::new(domain, &body, reach, WEIGHT_CAP);
        let step = (reach - clearance) / VALUES as f64;
        let values = (0..=VALUES).map(|k| exact.at(clearance + k as f64 * step)).collect();
        Self { clearance, per_step: 1.0 / step, values }
    }

    /// The weight of a pair at `distance`, in r_max.
    pub(super) fn at(&self, distance: f64) -> f64 {
        if distance <= self.clearance || self.values.is_empty() {
            return 1.0;
        }
        let at = ((distance - self.clearance) * self.per_step).min(VALUES as f64);
        let cell = (at as usize).min(VALUES - 1);
        let share = at - cell as f64;
        self.values[cell] * (1.0 - share) + self.values[cell + 1] * share
    }
}
