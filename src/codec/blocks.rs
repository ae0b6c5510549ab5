//! Slices of numbers as independent blocks: delta, byte shuffle, LZ4.
//!
//! Each block of [`BLOCK`] values is stored as the planes of its bytes (all lowest bytes, then
//! all second bytes, …) of the differences between neighbours' bit patterns, because the high
//! bytes of a smooth map then are runs of zeros. Lossless for every bit pattern. Blocks are
//! packed and unpacked in parallel; the bytes do not depend on the number of threads.

use rayon::prelude::*;

/// Values in a block.
const BLOCK: usize = 1 << 16;

/// An LZ4 block cannot grow by more than this factor when unpacked.
const LZ4_MAX_RATIO: usize = 255;

/// A number that can be packed. Its bit pattern is what is kept.
pub trait Number: Copy + Default + Send + Sync {
    /// Bytes of its bit pattern.
    const BYTES: usize;
    /// Its bit pattern.
    fn bits(self) -> u64;
    /// The number with the low [`Number::BYTES`] bytes of `bits` as its pattern.
    fn from_bits(bits: u64) -> Self;
}

macro_rules! integer {
    ($($t:ty),*) => {$(
        impl Number for $t {
            const BYTES: usize = size_of::<$t>();
            #[allow(clippy::unnecessary_cast, reason = "one of the types is u64 itself")]
            fn bits(self) -> u64 {
                self as u64
            }
            #[allow(clippy::unnecessary_cast, reason = "one of the types is u64 itself")]
            fn from_bits(bits: u64) -> Self {
                bits as Self
            }
        }
    )*};
}

integer!(u8, u16, u32, u64);

impl Number for f32 {
    const BYTES: usize = 4;
    fn bits(self) -> u64 {
        u64::from(self.to_bits())
    }
    fn from_bits(bits: u64) -> Self {
        Self::from_bits(bits as u32)
    }
}

impl Number for f64 {
    const BYTES: usize = 8;
    fn bits(self) -> u64 {
        self.to_bits()
    }
    fn from_bits(bits: u64) -> Self {
        Self::from_bits(bits)
    }
}

/// What is wrong with packed bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// The table of blocks or a block reaches beyond the end.
    #[error("packed numbers are cut short")]
    CutShort,
    /// A block claims to hold more than its bytes can.
    #[error("a packed block does not hold what it claims")]
    Corrupt,
}

/// Packs `values`: the packed length of each block (u32), then the blocks. The count is not
/// stored.
pub fn pack<T: Number>(values: &[T], out: &mut Vec<u8>) {
    let blocks: Vec<Vec<u8>> = values.par_chunks(BLOCK).map(pack_block).collect();
    for block in &blocks {
        out.extend_from_slice(&(block.len() as u32).to_le_bytes());
    }
    blocks.iter().for_each(|block| out.extend_from_slice(block));
}

/// Unpacks `count` values from the front of `bytes`; returns them and the bytes used.
///
/// Allocates at most 255 times the length of `bytes`, whatever `count` says.
pub fn unpack<T: Number>(bytes: &[u8], count: usize) -> Result<(Vec<T>, usize), Error> {
    let blocks = table::<T>(bytes, count)?;
    let used = blocks.last().map_or(0, |b| b.end);
    let mut values = vec![T::default(); count];
    values.par_chunks_mut(BLOCK).zip(blocks).try_for_each(|(values, range)| unpack_block(&bytes[range], values))?;
    Ok((values, used))
}

/// Where each block lies, after checking that it can hold what it must.
fn table<T: Number>(bytes: &[u8], count: usize) -> Result<Vec<std::ops::Range<usize>>, Error> {
    let n = count.div_ceil(BLOCK);
    let head = n.checked_mul(4).filter(|h| *h <= bytes.len()).ok_or(Error::CutShort)?;
    let mut at = head;
    let mut blocks = Vec::with_capacity(n);
    for (i, len) in bytes[..head].chunks_exact(4).enumerate() {
        let len = u32::from_le_bytes([len[0], len[1], len[2], len[3]]) as usize;
        let end = at.checked_add(len).filter(|e| *e <= bytes.len()).ok_or(Error::CutShort)?;
        let raw = (count - i * BLOCK).min(BLOCK) * T::BYTES;
        if len > raw || raw > len.saturating_mul(LZ4_MAX_RATIO) {
            return Err(Error::Corrupt);
        }
        blocks.push(at..end);
        at = end;
    }
    Ok(blocks)
}

/// One block: LZ4 where that is shorter, else the planes themselves.
fn pack_block<T: Number>(values: &[T]) -> Vec<u8> {
    let mut planes = vec![0; values.len() * T::BYTES];
    for (p, plane) in planes.chunks_exact_mut(values.len()).enumerate() {
        let mut previous = 0;
        for (byte, value) in plane.iter_mut().zip(values) {
            let bits = value.bits();
            *byte = (bits.wrapping_sub(previous) >> (8 * p)) as u8;
            previous = bits;
        }
    }
    let packed = lz4_flex::block::compress(&planes);
    if packed.len() < planes.len() { packed } else { planes }
}

fn unpack_block<T: Number>(packed: &[u8], values: &mut [T]) -> Result<(), Error> {
    let raw = values.len() * T::BYTES;
    if packed.len() == raw {
        unshuffle(packed, values);
        return Ok(());
    }
    let mut planes = vec![0; raw];
    match lz4_flex::block::decompress_into(packed, &mut planes) {
        Ok(n) if n == raw => unshuffle(&planes, values),
        _ => return Err(Error::Corrupt),
    }
    Ok(())
}

fn unshuffle<T: Number>(planes: &[u8], values: &mut [T]) {
    let n = values.len();
    let mut previous = 0_u64;
    for (i, value) in values.iter_mut().enumerate() {
        let delta = (0..T::BYTES).fold(0, |bits, p| bits | u64::from(planes[p * n + i]) << (8 * p));
        previous = previous.wrapping_add(delta);
        *value = T::from_bits(previous);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn round_trip<T: Number + PartialEq + std::fmt::Debug>(values: &[T]) {
        let mut bytes = Vec::new();
        pack(values, &mut bytes);
        bytes.extend_from_slice(b"rest");
        let (back, used) = unpack::<T>(&bytes, values.len()).unwrap();
        assert_eq!(used + 4, bytes.len());
        assert!(values.iter().zip(&back).all(|(a, b)| a.bits() == b.bits()));
    }

    #[test]
    fn every_bit_pattern_comes_back() {
        let odd = [f32::NAN, -0.0, f32::INFINITY, f32::MIN_POSITIVE, -1.5, f32::from_bits(0xffff_ffff)];
        round_trip(&odd);
        round_trip::<f32>(&[]);
        round_trip(&[u64::MAX, 0, 1, u64::MAX]);
        round_trip(&(0..200_000_u32).collect::<Vec<_>>());
        round_trip(&(0..70_000).map(|i| (f64::from(i) * 0.1).sin()).collect::<Vec<_>>());
    }

    #[test]
    fn a_smooth_map_shrinks_and_a_constant_one_almost_vanishes() {
        let smooth: Vec<f32> = (0..BLOCK).map(|i| 500.0 + (i as f32 * 1e-3).sin()).collect();
        let mut bytes = Vec::new();
        pack(&smooth, &mut bytes);
        assert!(bytes.len() < smooth.len() * 3);
        bytes.clear();
        pack(&vec![f32::NAN; 1 << 20], &mut bytes);
        assert!(bytes.len() < (1 << 20) / 50);
    }

    #[test]
    fn a_small_file_that_claims_a_huge_count_is_refused_without_allocating() {
        assert_eq!(unpack::<f32>(&[0; 64], usize::MAX / 8).unwrap_err(), Error::CutShort);
        let many = vec![1; 4096];
        assert!(unpack::<f32>(&many, 1000 * BLOCK).is_err());
    }

    proptest! {
        #[test]
        fn garbage_is_an_error_or_a_value_but_never_a_panic(bytes in prop::collection::vec(any::<u8>(), 0..300), count in 0_usize..200_000) {
            let _ = unpack::<u32>(&bytes, count);
        }
    }
}
