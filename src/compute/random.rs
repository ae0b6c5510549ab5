//! Random numbers as a function of (seed, purpose, index), never of order.
//!
//! A *purpose* is a dotted name such as `plants.tie`; two purposes give unrelated numbers for
//! the same seed. [`hash`] gives one number per index, for ties and per-cell draws;
//! [`Stream`] gives a sequence per index, for a loop that belongs to one item.
//!
//! The mixing is the finaliser of splitmix64 (Steele, Lea and Flood, OOPSLA 2014), the sequence
//! is PCG64-MCG (O'Neill 2014). Both are pinned by tests: a change of their numbers would change
//! every result and is a new version of the service.

use rand::Rng;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

/// What random numbers are drawn for; made once from a name, as a constant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Purpose(u64);

impl Purpose {
    /// The purpose with this name (FNV-1a of its bytes).
    pub const fn new(name: &str) -> Self {
        let bytes = name.as_bytes();
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut i = 0;
        while i < bytes.len() {
            hash = (hash ^ bytes[i] as u64).wrapping_mul(0x0000_0100_0000_01b3);
            i += 1;
        }
        Self(hash)
    }
}

const fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// 64 random bits for (seed, purpose, index).
pub const fn hash(seed: u64, purpose: Purpose, index: u64) -> u64 {
    let key = mix(seed.wrapping_add(GOLDEN) ^ mix(purpose.0.wrapping_add(GOLDEN)));
    mix(key ^ mix(index.wrapping_add(GOLDEN)))
}

/// 64 random bits for (seed, purpose, index a, index b).
pub const fn hash2(seed: u64, purpose: Purpose, a: u64, b: u64) -> u64 {
    mix(hash(seed, purpose, a) ^ mix(b.wrapping_add(GOLDEN)))
}

/// The number in [0, 1) that the upper 53 bits of `bits` spell.
pub const fn unit(bits: u64) -> f64 {
    (bits >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

/// A sequence of random numbers that belongs to one (seed, purpose, index).
#[derive(Debug, Clone)]
pub struct Stream(Pcg64Mcg);

impl Stream {
    /// The sequence of (seed, purpose, index).
    pub fn new(seed: u64, purpose: Purpose, index: u64) -> Self {
        Self(Pcg64Mcg::seed_from_u64(hash(seed, purpose, index)))
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        unit(self.bits())
    }

    /// Uniform in [low, high).
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform in 0..n (0 when n is 0), by multiplication of the upper bits.
    pub fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.bits()) * n as u128) >> 64) as usize
    }

    /// Standard normal, by the polar form of Box and Muller (bounded rejection, 21 % a try).
    pub fn normal(&mut self) -> f64 {
        for _ in 0..64 {
            let (u, v) = (self.range(-1.0, 1.0), self.range(-1.0, 1.0));
            let s = u * u + v * v;
            if s > 0.0 && s < 1.0 {
                return u * libm::sqrt(-2.0 * libm::log(s) / s);
            }
        }
        0.0
    }

    /// Shuffles `items` (Fisher and Yates).
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEST: Purpose = Purpose::new("test");

    #[test]
    fn the_numbers_of_a_seed_are_pinned() {
        assert_eq!(hash(0, TEST, 0), PINNED_HASH);
        assert_eq!(Stream::new(0, TEST, 0).bits(), PINNED_STREAM);
    }
    const PINNED_HASH: u64 = 15_996_500_612_510_217_039;
    const PINNED_STREAM: u64 = 9338911001371394857;

    #[test]
    fn seeds_purposes_and_indices_are_unrelated() {
        let other = Purpose::new("other");
        let all = [hash(0, TEST, 0), hash(1, TEST, 0), hash(0, other, 0), hash(0, TEST, 1), hash2(0, TEST, 0, 0)];
        for (i, a) in all.iter().enumerate() {
            for b in &all[i + 1..] {
                assert!((20..=44).contains(&(a ^ b).count_ones()), "{a:x} {b:x}");
            }
        }
    }

    #[test]
    fn unit_numbers_have_the_moments_of_the_uniform_law() {
        let n = 100_000;
        let mut stream = Stream::new(7, TEST, 0);
        let draws: Vec<f64> = (0..n).map(|_| stream.unit()).collect();
        let mean = draws.iter().sum::<f64>() / n as f64;
        let variance = draws.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n as f64;
        assert!((mean - 0.5).abs() < 0.005 && (variance - 1.0 / 12.0).abs() < 0.001, "{mean} {variance}");
    }

    #[test]
    fn below_stays_below_and_reaches_every_value() {
        let mut stream = Stream::new(3, TEST, 1);
        let mut seen = [false; 7];
        for _ in 0..1000 {
            seen[stream.below(7)] = true;
        }
        assert_eq!(seen, [true; 7]);
        assert_eq!(stream.below(0), 0);
    }
}
