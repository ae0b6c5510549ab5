//! The support vector machine: sequential minimal optimisation, to be stopped at any time.

use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;

/// A colour with each part standardised.
pub(super) type Feature = [f64; 3];

/// The solver ends when the two samples that most contradict the optimum differ by less: the
/// default of LIBSVM.
const TOLERANCE: f64 = 1e-3;

/// It ends in any case after this many steps a sample (ours): a few are enough where colours can
/// be told apart at all, and what has not settled then is within the noise of the scribbles.
const STEPS_PER_SAMPLE: usize = 100;

/// Steps between two looks at the stop flag.
const LOOK_EVERY: usize = 256;

/// The least curvature along a pair, for samples of one colour (LIBSVM's τ).
const LEAST_CURVATURE: f64 = 1e-12;

/// A support vector machine with the kernel exp(−d²/3), the customary width for three
/// standardised features.
pub(super) struct Machine {
    /// Support vectors with their signed multipliers.
    support: Vec<(Feature, f64)>,
    bias: f64,
}

/// A sample to learn from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    pub feature: Feature,
    /// 1 or −1.
    pub side: f64,
    /// What it costs at most to have it on the wrong side.
    pub price: f64,
}

fn kernel(p: &Feature, q: &Feature) -> f64 {
    let d: f64 = (0..3).map(|i| (p[i] - q[i]) * (p[i] - q[i])).sum();
    libm::exp(-d / 3.0)
}

impl Machine {
    /// Learns from samples of both sides.
    pub(super) fn train(samples: &[Sample], run: &Run) -> Result<Self, Stopped> {
        let mut solver = Solver::new(samples);
        run.check()?;
        for step in 0..STEPS_PER_SAMPLE * samples.len() {
            if step.is_multiple_of(LOOK_EVERY) {
                run.check()?;
            }
            if !solver.step() {
                break;
            }
        }
        let bias = solver.bias();
        let signed = samples.iter().zip(solver.multipliers).map(|(s, a)| (s.feature, s.side * a));
        Ok(Self { support: signed.filter(|(_, a)| *a != 0.0).collect(), bias })
    }

    /// Positive on the side of 1; ±1 at the margin.
    pub(super) fn decide(&self, feature: Feature) -> f64 {
        self.support.iter().map(|(s, alpha)| alpha * kernel(s, &feature)).sum::<f64>() + self.bias
    }
}

/// The dual problem: maximise Σα − ½ Σ αᵢαⱼyᵢyⱼKᵢⱼ for 0 ≤ αᵢ ≤ Cᵢ, Σαᵢyᵢ = 0.
struct Solver<'a> {
    samples: &'a [Sample],
    kernel: Vec<Vec<f64>>,
    multipliers: Vec<f64>,
    /// yᵢ less the decision value of sample i without bias: equal for all free samples at the
    /// optimum.
    lacks: Vec<f64>,
}

impl<'a> Solver<'a> {
    fn new(samples: &'a [Sample]) -> Self {
        let row = |p: &Sample| samples.iter().map(|q| kernel(&p.feature, &q.feature)).collect();
        Self {
            samples,
            kernel: samples.par_iter().map(row).collect(),
            multipliers: vec![0.0; samples.len()],
            lacks: samples.iter().map(|s| s.side).collect(),
        }
    }

    /// How far the decision value of sample `i` may still be pushed up (`side` 1) or down (−1).
    fn room(&self, i: usize, side: f64) -> f64 {
        let Sample { side: own, price, .. } = self.samples[i];
        if own == side { price - self.multipliers[i] } else { self.multipliers[i] }
    }

    /// One step on the pair that Fan, Chen and Lin (2005) choose: the sample that lacks most, and
    /// the one with which the dual gains most to second order. `false` at the optimum.
    fn step(&mut self) -> bool {
        let n = self.samples.len();
        let upward = (0..n).filter(|i| self.room(*i, 1.0) > 0.0);
        let Some(i) = upward.max_by(|i, j| self.lacks[*i].total_cmp(&self.lacks[*j]).then(j.cmp(i))) else {
            return false;
        };
        let (most, row) = (self.lacks[i], &self.kernel[i]);
        let curvature = |j: usize| (self.kernel[j][j] + row[i] - 2.0 * row[j]).max(LEAST_CURVATURE);
        let (mut least, mut best, mut gain) = (f64::INFINITY, i, 0.0);
        for j in (0..n).filter(|j| self.room(*j, -1.0) > 0.0) {
            let lead = most - self.lacks[j];
            least = least.min(self.lacks[j]);
            if lead > 0.0 && lead * lead / curvature(j) > gain {
                (gain, best) = (lead * lead / curvature(j), j);
            }
        }
        if most - least < TOLERANCE || best == i {
            return false;
        }
        self.push(i, best, (most - self.lacks[best]) / curvature(best));
        true
    }

    /// Pushes sample `i` up and `j` down by `by`, or as far as their prices allow.
    fn push(&mut self, i: usize, j: usize, by: f64) {
        let (up, down) = (self.room(i, 1.0), self.room(j, -1.0));
        let by = by.min(up).min(down);
        let at_rest = |multiplier: f64, room: f64, price: f64, sign: f64| match (by == room, sign > 0.0) {
            // Exactly on the bound, so that rounding leaves no room.
            (true, true) => price,
            (true, false) => 0.0,
            (false, _) => multiplier + sign * by,
        };
        let (one, two) = (self.samples[i], self.samples[j]);
        self.multipliers[i] = at_rest(self.multipliers[i], up, one.price, one.side);
        self.multipliers[j] = at_rest(self.multipliers[j], down, two.price, -two.side);
        let (rows, lacks) = (&self.kernel, &mut self.lacks);
        lacks.iter_mut().zip(rows[i].iter().zip(&rows[j])).for_each(|(lack, (a, b))| *lack -= by * (a - b));
    }

    /// The mean lack of the samples strictly between their bounds, or the middle between those
    /// that could still be pushed up and down.
    fn bias(&self) -> f64 {
        let n = self.samples.len();
        let free: Vec<usize> = (0..n).filter(|i| self.room(*i, 1.0) > 0.0 && self.room(*i, -1.0) > 0.0).collect();
        if !free.is_empty() {
            return free.iter().map(|i| self.lacks[*i]).sum::<f64>() / free.len() as f64;
        }
        let of = |side: f64| (0..n).filter(move |i| self.room(*i, side) > 0.0).map(|i| self.lacks[i]);
        let (up, down) = (of(1.0).fold(f64::NEG_INFINITY, f64::max), of(-1.0).fold(f64::INFINITY, f64::min));
        if up.is_finite() && down.is_finite() { 0.5 * (up + down) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::random::Purpose;
    use crate::compute::random::Stream;
    use crate::compute::run::StopFlag;

    fn cloud(n: usize, apart: f64, seed: u64) -> Vec<Sample> {
        let mut random = Stream::new(seed, Purpose::new("test.machine"), 0);
        (0..n)
            .map(|i| {
                let side = if i % 2 == 0 { 1.0 } else { -1.0 };
                let shift = [side * apart / 2.0, 0.0, 0.0];
                Sample { feature: shift.map(|s| s + random.normal()), side, price: 10.0 }
            })
            .collect()
    }

    #[test]
    fn the_optimum_satisfies_its_conditions() {
        let samples = cloud(300, 2.0, 1);
        let mut solver = Solver::new(&samples);
        while solver.step() {}
        let balance: f64 = samples.iter().zip(&solver.multipliers).map(|(s, a)| s.side * a).sum();
        assert!(balance.abs() < 1e-9);
        let machine = Machine::train(&samples, &Run::silent()).unwrap();
        // A sample with no multiplier is right by a margin of 1, one in between is on the margin,
        // one at its price is within it (Karush, Kuhn and Tucker).
        for (s, a) in samples.iter().zip(&solver.multipliers) {
            let margin = s.side * machine.decide(s.feature);
            assert!(*a >= 0.0 && *a <= s.price);
            match *a {
                0.0 => assert!(margin > 1.0 - 2e-3, "{margin}"),
                a if a == s.price => assert!(margin < 1.0 + 2e-3, "{margin}"),
                _ => assert!((margin - 1.0).abs() < 2e-3, "{margin}"),
            }
        }
    }

    #[test]
    fn sides_apart_are_told_apart_and_a_pair_is_parted_in_the_middle() {
        let samples = cloud(400, 8.0, 2);
        let machine = Machine::train(&samples, &Run::silent()).unwrap();
        assert!(samples.iter().all(|s| s.side * machine.decide(s.feature) > 0.0));
        let pair = [1.0, -1.0].map(|side| Sample { feature: [side, 0.0, 0.0], side, price: 10.0 });
        let machine = Machine::train(&pair, &Run::silent()).unwrap();
        assert!(machine.decide([0.0, 0.3, 0.0]).abs() < 1e-9);
        assert!((machine.decide([1.0, 0.0, 0.0]) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn samples_that_contradict_each_other_end_all_the_same_and_a_stop_is_heard() {
        let mut same = cloud(2000, 0.0, 3);
        same.iter_mut().for_each(|s| s.feature = s.feature.map(|v| (v * 2.0).round()));
        let machine = Machine::train(&same, &Run::silent()).unwrap();
        assert!(machine.decide([0.0; 3]).is_finite());
        let flag = StopFlag::default();
        flag.stop();
        assert!(Machine::train(&same, &Run::stoppable(flag)).is_err());
    }
}
