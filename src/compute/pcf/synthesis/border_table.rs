use crate::compute::geometry::Point;
use crate::compute::geometry::Region;
use crate::compute::pcf::WEIGHT_CAP;

/// Values of a table beyond the nearest border.
const VALUES: usize = 32;

/// The border weights around a place, for every distance up to a reach: tabulated, as they are
/// asked for many times. Kept in the table itself, as there is one for every element.
#[derive(Debug, Clone)]
pub(super) struct BorderTable {
    clearance: f64,
    /// 0: 1 everywhere.
    per_step: f64,
    values: [f32; VALUES + 1],
}

impl BorderTable {
    /// The weights around `p` up to `reach` r_max (`unit` metres) in `domain`.
    pub(super) fn new(domain: &Region, p: Point, (reach, unit): (f64, f64)) -> Self {
        let is_deep = domain.clearance(p, reach * unit) >= reach * unit && domain.contains(p);
        if is_deep || reach <= 0.0 {
            return Self { clearance: reach, per_step: 0.0, values: [1.0; VALUES + 1] };
        }
        let around = domain.surroundings(p, reach * unit);
        let clearance = if around.is_inside() { around.clearance().min(reach * unit) / unit } else { 0.0 };
        let step = (reach - clearance) / VALUES as f64;
        let weight = |k: usize| {
            let inside = around.arc_inside_roughly((clearance + k as f64 * step) * unit) / std::f64::consts::TAU;
            (1.0 / inside.max(1e-12)).min(WEIGHT_CAP)
        };
        let at_border = if around.is_inside() { 1.0 } else { weight(0) };
        let value = |k: usize| if k == 0 { at_border } else { weight(k) };
        Self { clearance, per_step: 1.0 / step, values: std::array::from_fn(|k| value(k) as f32) }
    }

    /// How far the border is, in r_max, at most as far as the table reaches; 0 outside the domain.
    pub(super) fn clearance(&self) -> f64 {
        self.clearance
    }

    /// The weight of a pair at `distance`, in r_max.
    pub(super) fn at(&self, distance: f64) -> f64 {
        if distance <= self.clearance || self.per_step == 0.0 {
            return 1.0;
        }
        let at = ((distance - self.clearance) * self.per_step).min(VALUES as f64);
        let cell = (at as usize).min(VALUES - 1);
        let share = at - cell as f64;
        f64::from(self.values[cell]) * (1.0 - share) + f64::from(self.values[cell + 1]) * share
    }
}
