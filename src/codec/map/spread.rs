use crate::codec::binary;
use crate::codec::binary::Reader;
use crate::codec::draw::Ticks;

/// How colours are spread between the ends of a range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spread {
    /// Evenly.
    Linear,
    /// By the square root: for counts with many small and few large values, zero included.
    SquareRoot,
    /// By the logarithm over at most four decades below the upper end; what is below, zero
    /// included, takes the lower end's colour.
    Logarithmic,
}

impl Spread {
    /// Decades shown below the upper end of a logarithmic scale.
    const DECADES: f64 = 4.0;

    /// Where `value` lies between the ends: 0 at the lower, 1 at the upper.
    pub(super) fn share(self, value: f64, (min, max): (f64, f64)) -> f64 {
        let t = match self {
            Self::Logarithmic => {
                let floor = Self::floor(min, max);
                if value <= floor { 0.0 } else { (value / floor).log10() / (max / floor).log10() }
            }
            _ => (value - min) / (max - min),
        };
        if self == Self::SquareRoot { t.max(0.0).sqrt() } else { t }.clamp(0.0, 1.0)
    }

    fn floor(min: f64, max: f64) -> f64 {
        min.max(max * 10_f64.powf(-Self::DECADES)).min(max * 0.999).max(f64::MIN_POSITIVE)
    }

    pub(super) fn ticks(self, (min, max): (f64, f64)) -> Ticks {
        match self {
            Self::Logarithmic if max > 0.0 => Ticks::logarithmic(Self::floor(min, max), max),
            _ => Ticks::linear(min, max, 6),
        }
    }

    pub(super) fn read(r: &mut Reader) -> Result<Self, binary::Error> {
        const ALL: [Spread; 3] = [Spread::Linear, Spread::SquareRoot, Spread::Logarithmic];
        ALL.get(usize::from(r.u8()?)).copied().ok_or(binary::Error::Corrupt("an unknown spread of colours"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_spread_runs_from_zero_to_one_and_rises() {
        for spread in [Spread::Linear, Spread::SquareRoot, Spread::Logarithmic] {
            let shares: Vec<f64> = (0..=50).map(|i| spread.share(f64::from(i) * 2.0, (0.0, 100.0))).collect();
            assert_eq!((shares[0], shares[50]), (0.0, 1.0));
            assert!(shares.windows(2).all(|w| w[0] < w[1]), "{spread:?}");
        }
        assert_eq!(Spread::SquareRoot.share(25.0, (0.0, 100.0)), 0.5);
        assert!((Spread::Logarithmic.share(1.0, (0.0, 100.0)) - 0.5).abs() < 1e-12);
    }
}
