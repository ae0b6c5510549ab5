use crate::compute::ecosystem::species::Mobility;

/// Steps of the table per unit of slope: so chosen that the fastest slope, −0.05, is one of them.
const FINENESS: f32 = 1000.0;

/// Slopes beyond ±this are looked up as this: steeper than anything is climbed.
const STEEPEST: f32 = 8.0;

/// How fast an animal walks on a slope: **Tobler's function** (W. Tobler, "Three presentations on
/// geographical analysis and modeling", 1993), v(S) = 6 km/h · exp(−3.5·|S + 0.05|), scaled so
/// that the species' own speed holds on flat ground, and cut at its steepest slopes.
#[derive(Debug, Clone)]
pub struct Gait {
    slowness: Vec<f32>,
    up: f32,
    down: f32,
}

impl Gait {
    /// The gait of an animal of this mobility.
    pub fn new(mobility: &Mobility) -> Self {
        let n = (2.0 * STEEPEST * FINENESS) as usize + 2;
        let slope = |i: usize| i as f64 / f64::from(FINENESS) - f64::from(STEEPEST);
        let slowness = (0..n).map(|i| exact_slowness(mobility.speed_m_per_s, slope(i)) as f32).collect();
        Self { slowness, up: mobility.max_slope_up as f32, down: mobility.max_slope_down as f32 }
    }

    /// Seconds per metre of horizontal distance where the ground rises by `slope` (rise over run,
    /// negative downhill); infinite beyond the steepest slopes.
    pub fn slowness(&self, slope: f32) -> f32 {
        if self.allows(slope) { self.unbounded(slope) } else { f32::INFINITY }
    }

    /// Whether a rise of `slope` is walked.
    pub fn allows(&self, slope: f32) -> bool {
        slope <= self.up && slope >= -self.down
    }

    /// Like [`Gait::slowness`] where the user opened a way: a slope too steep counts as the
    /// steepest walked.
    pub fn forced(&self, slope: f32) -> f32 {
        self.unbounded(slope.clamp(-self.down, self.up))
    }

    /// The least seconds per metre on any slope.
    pub fn least(&self) -> f32 {
        self.unbounded((-0.05f32).max(-self.down))
    }

    /// Whether a rise of `slope` is walked in both directions.
    pub fn both_ways(&self, slope: f32) -> bool {
        slope.abs() <= self.both_ways_up_to()
    }

    /// The steepest slope that is walked in both directions.
    pub(super) fn both_ways_up_to(&self) -> f32 {
        self.up.min(self.down)
    }

    /// [`Gait::slowness`] of a slope that is known to be walked: by linear interpolation in the table (relative error below 10⁻⁵).
    pub(super) fn unbounded(&self, slope: f32) -> f32 {
        let at = (slope.clamp(-STEEPEST, STEEPEST) + STEEPEST) * FINENESS;
        let i = (at as usize).min(self.slowness.len() - 2);
        let (a, b) = (self.slowness[i], self.slowness[i + 1]);
        a + (b - a) * (at - i as f32)
    }
}

/// Tobler's slowness, s/m, of an animal that walks `speed` m/s on flat ground.
pub fn exact_slowness(speed: f64, slope: f64) -> f64 {
    libm::exp(3.5 * ((slope + 0.05).abs() - 0.05)) / speed.max(1e-6)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mobility() -> Mobility {
        Mobility { speed_m_per_s: 1.4, max_slope_up: 0.5, max_slope_down: 0.7, ford_depth_m: 0.5, max_tree_cover: 1.0 }
    }

    #[test]
    fn flat_ground_is_walked_at_the_species_own_speed_and_a_gentle_descent_faster() {
        let gait = Gait::new(&mobility());
        assert!((gait.slowness(0.0) * 1.4 - 1.0).abs() < 1e-5);
        assert!((gait.least() * 1.4 - 0.839_457).abs() < 1e-4, "exp(-0.175)");
        assert!(gait.slowness(0.2) > gait.slowness(-0.2));
    }

    #[test]
    fn the_table_follows_the_formula_and_ends_at_the_steepest_slopes() {
        let gait = Gait::new(&mobility());
        for i in -690..500 {
            let slope = f64::from(i) / 1000.0;
            let exact = exact_slowness(1.4, slope);
            assert!((f64::from(gait.slowness(slope as f32)) / exact - 1.0).abs() < 1e-5, "{slope}");
        }
        assert!(gait.slowness(0.501).is_infinite() && gait.slowness(-0.701).is_infinite());
        assert_eq!(gait.forced(3.0), gait.slowness(0.5));
        assert!(gait.both_ways(-0.5) && !gait.both_ways(0.6));
    }
}
