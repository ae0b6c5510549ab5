//! A small binary form for what is stored between stages: little-endian, checked, deterministic.
//!
//! A [`Writer`] begins with four letters that name the kind and a version; a [`Reader`] refuses
//! any other. Values follow in the order in which they were written; nothing else is recorded,
//! so reader and writer of a kind stand side by side in the code. Reading arbitrary bytes gives
//! an [`Error`], never a panic, and allocates in proportion to the bytes at hand.
//!
//! ```
//! use biotope::codec::binary::{Reader, Writer};
//! let mut w = Writer::new(*b"DEMO", 1);
//! w.string("heights").f32s(&[1.0, 2.5]).option(Some(&7), |w, n| w.u32(*n));
//! let bytes = w.finish();
//! let mut r = Reader::new(&bytes, *b"DEMO", 1)?;
//! assert_eq!(r.string()?, "heights");
//! assert_eq!(r.f32s()?, [1.0, 2.5]);
//! assert_eq!(r.option(Reader::u32)?, Some(7));
//! r.finish()?;
//! # Ok::<(), biotope::codec::binary::Error>(())
//! ```

use crate::codec::blocks;
use crate::codec::blocks::Number;
use crate::compute::run::Run;

/// Why bytes could not be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// The bytes end before the value does.
    #[error("the stored value is cut short: {needed} bytes were needed and {left} are left")]
    CutShort {
        /// Bytes that were needed.
        needed: u64,
        /// Bytes that were left.
        left: usize,
    },
    /// Another kind of value.
    #[error("a stored value of kind {expected} was expected, this is {found}")]
    Kind {
        /// The kind asked for.
        expected: String,
        /// What stands there.
        found: String,
    },
    /// A version this program does not read.
    #[error("version {expected} of the stored form was expected, this is version {found}")]
    Version {
        /// The version asked for.
        expected: u16,
        /// What stands there.
        found: u16,
    },
    /// A value outside what its place allows.
    #[error("the stored value is corrupt: {0}")]
    Corrupt(&'static str),
    /// Bytes are left over.
    #[error("{0} bytes are left over after the stored value")]
    Trailing(usize),
}

impl From<blocks::Error> for Error {
    fn from(error: blocks::Error) -> Self {
        match error {
            blocks::Error::CutShort => Self::Corrupt("packed numbers are cut short"),
            blocks::Error::Corrupt => Self::Corrupt("a packed block does not hold what it claims"),
        }
    }
}

/// Writes values one after the other. Every method returns the writer, so calls can be chained.
#[derive(Debug)]
pub struct Writer {
    bytes: Vec<u8>,
    run: Run,
}

impl Writer {
    /// A value of the kind named by four letters, in this version of its form.
    pub fn new(kind: [u8; 4], version: u16) -> Self {
        Self::for_run(kind, version, &Run::silent())
    }

    /// Like [`Writer::new`], as a part of `run`: once that is stopped, no more numbers are packed,
    /// and what has been written is to be thrown away.
    pub fn for_run(kind: [u8; 4], version: u16, run: &Run) -> Self {
        let mut writer = Self { bytes: kind.to_vec(), run: run.clone() };
        writer.u16(version);
        writer
    }

    /// The bytes.
    pub fn finish(self) -> Vec<u8> {
        self.bytes
    }

    /// A sequence: its length, then each item by `write`.
    pub fn list<T>(
        &mut self,
        items: &[T],
        mut write: impl for<'w> FnMut(&'w mut Self, &T) -> &'w mut Self,
    ) -> &mut Self {
        self.u64(items.len() as u64);
        items.iter().fold(self, |w, item| write(w, item))
    }

    /// A value that may be absent.
    pub fn option<T>(
        &mut self,
        value: Option<&T>,
        write: impl for<'w> FnOnce(&'w mut Self, &T) -> &'w mut Self,
    ) -> &mut Self {
        self.bool(value.is_some());
        match value {
            Some(value) => write(self, value),
            None => self,
        }
    }

    /// A text.
    pub fn string(&mut self, text: &str) -> &mut Self {
        self.raw(text.as_bytes())
    }

    /// Bytes as they are, with their length; for another value's stored form, say.
    pub fn raw(&mut self, bytes: &[u8]) -> &mut Self {
        self.u64(bytes.len() as u64);
        self.bytes.extend_from_slice(bytes);
        self
    }

    /// A truth value.
    pub fn bool(&mut self, value: bool) -> &mut Self {
        self.u8(u8::from(value))
    }

    fn packed<T: Number>(&mut self, values: &[T]) -> &mut Self {
        self.u64(values.len() as u64);
        if !self.run.is_stopped() {
            blocks::pack(values, &mut self.bytes);
        }
        self
    }
}

/// Reads values in the order in which they were written.
#[derive(Debug, Clone)]
pub struct Reader<'a> {
    bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    /// Checks kind and version and stands at the first value.
    pub fn new(bytes: &'a [u8], kind: [u8; 4], version: u16) -> Result<Self, Error> {
        let mut reader = Self { bytes };
        let found = reader.take(4)?;
        if found != kind {
            let text = |b: &[u8]| String::from_utf8_lossy(b).into_owned();
            return Err(Error::Kind { expected: text(&kind), found: text(found) });
        }
        match reader.u16()? {
            v if v == version => Ok(reader),
            found => Err(Error::Version { expected: version, found }),
        }
    }

    /// Fails when bytes are left over.
    pub fn finish(self) -> Result<(), Error> {
        if self.bytes.is_empty() { Ok(()) } else { Err(Error::Trailing(self.bytes.len())) }
    }

    /// A sequence written by [`Writer::list`]; every item takes at least one byte.
    pub fn list<T>(&mut self, mut read: impl FnMut(&mut Self) -> Result<T, Error>) -> Result<Vec<T>, Error> {
        let count = self.u64()?;
        if count > self.bytes.len() as u64 {
            return Err(Error::CutShort { needed: count, left: self.bytes.len() });
        }
        (0..count).map(|_| read(self)).collect()
    }

    /// A value written by [`Writer::option`].
    pub fn option<T>(&mut self, read: impl FnOnce(&mut Self) -> Result<T, Error>) -> Result<Option<T>, Error> {
        if self.bool()? { read(self).map(Some) } else { Ok(None) }
    }

    /// A text.
    pub fn string(&mut self) -> Result<String, Error> {
        let bytes = self.raw()?;
        std::str::from_utf8(bytes).map(str::to_owned).map_err(|_| Error::Corrupt("a text is not UTF-8"))
    }

    /// Bytes written by [`Writer::raw`].
    pub fn raw(&mut self) -> Result<&'a [u8], Error> {
        let length = self.u64()?;
        self.take(length)
    }

    /// A truth value.
    pub fn bool(&mut self) -> Result<bool, Error> {
        match self.u8()? {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(Error::Corrupt("a truth value is neither 0 nor 1")),
        }
    }

    fn take(&mut self, length: u64) -> Result<&'a [u8], Error> {
        let short = Error::CutShort { needed: length, left: self.bytes.len() };
        let length = usize::try_from(length).map_err(|_| short.clone())?;
        let (head, rest) = self.bytes.split_at_checked(length).ok_or(short)?;
        self.bytes = rest;
        Ok(head)
    }

    fn packed<T: Number>(&mut self) -> Result<Vec<T>, Error> {
        let count = usize::try_from(self.u64()?).map_err(|_| Error::Corrupt("a count is too large"))?;
        let (values, used) = blocks::unpack(self.bytes, count)?;
        self.bytes = &self.bytes[used..];
        Ok(values)
    }
}

macro_rules! numbers {
    ($($one:ident $many:ident)*) => {
        impl Writer {$(
            #[doc = concat!("One `", stringify!($one), "`.")]
            pub fn $one(&mut self, value: $one) -> &mut Self {
                self.bytes.extend_from_slice(&value.to_le_bytes());
                self
            }

            #[doc = concat!("Many `", stringify!($one), "`, packed in blocks.")]
            pub fn $many(&mut self, values: &[$one]) -> &mut Self {
                self.packed(values)
            }
        )*}

        impl Reader<'_> {$(
            #[doc = concat!("One `", stringify!($one), "`.")]
            pub fn $one(&mut self) -> Result<$one, Error> {
                let mut bytes = [0; size_of::<$one>()];
                bytes.copy_from_slice(self.take(size_of::<$one>() as u64)?);
                Ok($one::from_le_bytes(bytes))
            }

            #[doc = concat!("Many `", stringify!($one), "`.")]
            pub fn $many(&mut self) -> Result<Vec<$one>, Error> {
                self.packed()
            }
        )*}
    };
}

numbers! { u8 u8s u16 u16s u32 u32s u64 u64s f32 f32s f64 f64s }

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::run::StopFlag;

    #[test]
    fn a_stopped_run_packs_no_more_numbers() {
        let flag = StopFlag::default();
        let mut w = Writer::for_run(*b"STOP", 1, &Run::stoppable(flag.clone()));
        let numbers: Vec<u32> = (0..100_000_u32).map(|i| i.wrapping_mul(2_654_435_761) >> 7).collect();
        let packed = w.u32s(&numbers).bytes.len();
        flag.stop();
        assert!(w.u32s(&numbers).bytes.len() < packed + 16);
    }
    use proptest::prelude::*;

    fn sample() -> Vec<u8> {
        let mut w = Writer::new(*b"TEST", 3);
        w.u8(1).u16(2).u32(3).u64(4).f32(0.5).f64(f64::NAN).bool(true).string("Chêne vert");
        w.u8s(&[1, 2, 3]).u32s(&[7; 1000]).f64s(&[]).raw(b"inner");
        w.list(&["a", "bc"], |w, s| w.string(s));
        w.option(Some(&9), |w, n| w.u64(*n)).option(None::<&u64>, |w, n| w.u64(*n));
        w.finish()
    }

    fn read(bytes: &[u8]) -> Result<(), Error> {
        let mut r = Reader::new(bytes, *b"TEST", 3)?;
        assert_eq!((r.u8()?, r.u16()?, r.u32()?, r.u64()?), (1, 2, 3, 4));
        assert!(r.f32()? == 0.5 && r.f64()?.is_nan() && r.bool()?);
        assert_eq!(r.string()?, "Chêne vert");
        assert_eq!((r.u8s()?, r.u32s()?, r.f64s()?), (vec![1, 2, 3], vec![7; 1000], vec![]));
        assert_eq!(r.raw()?, b"inner");
        assert_eq!(r.list(Reader::string)?, ["a", "bc"]);
        assert_eq!((r.option(Reader::u64)?, r.option(Reader::u64)?), (Some(9), None));
        r.finish()
    }

    #[test]
    fn what_is_written_is_read_back() {
        assert_eq!(read(&sample()), Ok(()));
    }

    #[test]
    fn another_kind_another_version_and_left_over_bytes_are_refused() {
        let bytes = sample();
        assert!(matches!(Reader::new(&bytes, *b"ELSE", 3), Err(Error::Kind { .. })));
        assert_eq!(Reader::new(&bytes, *b"TEST", 4).unwrap_err(), Error::Version { expected: 4, found: 3 });
        let longer = [bytes, vec![0]].concat();
        assert_eq!(read(&longer), Err(Error::Trailing(1)));
    }

    #[test]
    fn every_cut_is_an_error() {
        let bytes = sample();
        for n in 0..bytes.len() {
            let cut = std::panic::catch_unwind(|| read(&bytes[..n]));
            assert!(matches!(cut, Ok(Err(_))), "cut at {n}");
        }
    }

    #[test]
    fn a_list_that_claims_to_be_endless_ends() {
        let mut w = Writer::new(*b"TEST", 3);
        w.u64(u64::MAX);
        let bytes = w.finish();
        let mut r = Reader::new(&bytes, *b"TEST", 3).unwrap();
        assert!(r.list(Reader::u8).is_err());
    }

    proptest! {
        #[test]
        fn garbage_never_panics(tail in prop::collection::vec(any::<u8>(), 0..200)) {
            let bytes = [b"TEST\x03\x00".to_vec(), tail].concat();
            let mut r = Reader::new(&bytes, *b"TEST", 3).unwrap();
            let _ = r.clone().string();
            let _ = r.clone().f32s();
            let _ = r.clone().list(Reader::u64s);
            let _ = r.option(Reader::raw);
        }
    }
}
