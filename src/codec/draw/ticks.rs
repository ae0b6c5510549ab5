/// Round values along an axis, and how they are written.
#[derive(Debug, Clone, PartialEq)]
pub struct Ticks {
    /// The values, ascending.
    pub values: Vec<f64>,
    decimals: usize,
    scientific: bool,
}

impl Ticks {
    /// Multiples of 1, 2 or 5 times a power of ten within [`min`, `max`], about `count` of them.
    pub fn linear(min: f64, max: f64, count: usize) -> Self {
        let span = max - min;
        if !(span.is_finite() && span > 0.0 && span / count.max(1) as f64 > 0.0) {
            return Self::of(if min.is_finite() { vec![min] } else { Vec::new() }, min.abs());
        }
        let step = round_step(span / count.max(1) as f64);
        let (first, last) = ((min / step - 1e-9).ceil(), (max / step + 1e-9).floor());
        let n = (last - first).clamp(0.0, 1000.0) as usize;
        Self::of((0..=n).map(|i| (first + i as f64) * step).collect(), step)
    }

    /// Powers of ten within [`min`, `max`], both positive; with 2 and 5 times them where fewer
    /// than three powers fit.
    pub fn logarithmic(min: f64, max: f64) -> Self {
        let decades = min.log10().floor() as i32..=max.log10().ceil() as i32;
        let of = |factors: &[f64]| -> Vec<f64> {
            let all = decades.clone().flat_map(|d| factors.iter().map(move |f| f * 10_f64.powi(d)));
            all.filter(|v| (min * 0.999..=max * 1.001).contains(v)).collect()
        };
        let powers = of(&[1.0]);
        let values = if powers.len() < 3 { of(&[1.0, 2.0, 5.0]) } else { powers };
        let least = values.first().copied().unwrap_or(1.0);
        Self::of(values, least)
    }

    /// The given values, written finely enough to tell steps of `step` apart.
    pub fn of(values: Vec<f64>, step: f64) -> Self {
        let largest = values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let scientific = largest >= 1e6 || (largest > 0.0 && largest < 1e-3);
        let decimals = if step > 0.0 { (-step.log10().floor()).clamp(0.0, 9.0) as usize } else { 0 };
        Self { values, decimals, scientific }
    }

    /// How `value` is written.
    pub fn label(&self, value: f64) -> String {
        let clean = if value == 0.0 { 0.0 } else { value };
        if self.scientific && clean != 0.0 {
            let text = format!("{clean:.2e}");
            let (digits, power) = text.split_once('e').unwrap_or((&text, "0"));
            let digits = digits.trim_end_matches('0').trim_end_matches('.');
            return format!("{digits}e{power}");
        }
        format!("{clean:.*}", self.decimals)
    }
}

fn round_step(rough: f64) -> f64 {
    let power = 10_f64.powf(rough.log10().floor());
    let factor = match rough / power {
        f if f < 1.5 => 1.0,
        f if f < 3.5 => 2.0,
        f if f < 7.5 => 5.0,
        _ => 10.0,
    };
    factor * power
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(t: &Ticks) -> Vec<String> {
        t.values.iter().map(|v| t.label(*v)).collect()
    }

    #[test]
    fn ticks_are_round_and_written_as_briefly_as_they_can_be() {
        assert_eq!(labels(&Ticks::linear(0.0, 1.0, 5)), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(&Ticks::linear(236.0, 1076.0, 5)), ["400", "600", "800", "1000"]);
        assert_eq!(labels(&Ticks::linear(-0.3, 0.3, 3)), ["-0.2", "0.0", "0.2"]);
        assert_eq!(labels(&Ticks::logarithmic(0.01, 100.0)), ["0.01", "0.10", "1.00", "10.00", "100.00"]);
        assert_eq!(labels(&Ticks::linear(0.0, 4e6, 2)), ["0", "2e6", "4e6"]);
    }

    #[test]
    fn an_axis_without_extent_has_one_tick_and_a_broken_one_none() {
        assert_eq!(Ticks::linear(3.0, 3.0, 5).values, [3.0]);
        assert!(Ticks::linear(f64::NAN, 1.0, 5).values.is_empty());
        assert_eq!(Ticks::linear(0.0, f64::MIN_POSITIVE, 5).values.len(), 1 + 4);
    }
}
