use super::Coding;
use super::Format;
use super::RasterError;
use super::Sheet;
use super::SheetOptions;
use super::SourceCrs;
use super::check_size;
use crate::codec::warning;
use crate::codec::warning::Warning;

/// Which byte of a sample comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ByteOrder {
    /// The lowest ("Windows"), as engines write unless told otherwise.
    #[default]
    LittleEndian,
    /// The highest ("Mac").
    BigEndian,
}

/// Which row comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RowOrder {
    /// The northernmost, as in pictures.
    #[default]
    NorthFirst,
    /// The southernmost, as Unity writes.
    SouthFirst,
}

/// How the samples of a headerless file lie: unsigned integers of 16 bits (or 8, where the file
/// has just one byte a cell), row by row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RawLayout {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Byte order.
    pub order: ByteOrder,
    /// Row order.
    pub rows: RowOrder,
}

/// How much smoother swapped samples must be before it is remarked on.
const SMOOTHER: f64 = 4.0;

pub(super) fn read(bytes: &[u8], layout: &RawLayout, options: &SheetOptions) -> Result<Sheet, RasterError> {
    check_size(layout.width as u64, layout.height as u64, options.max_cells)?;
    let cells = layout.width * layout.height;
    let (mut values, levels): (Vec<f32>, u32) = match bytes.len() {
        n if n == cells * 2 => (bytes.chunks_exact(2).map(|b| f32::from(layout.order.sample(b))).collect(), 65_535),
        n if n == cells => (bytes.iter().map(|b| f32::from(*b)).collect(), 255),
        n => return Err(RasterError::CountMismatch { what: "bytes", expected: cells as u64 * 2, found: n as u64 }),
    };
    if layout.rows == RowOrder::SouthFirst {
        values = values.chunks_exact(layout.width).rev().flatten().copied().collect();
    }
    let mut warnings = Vec::new();
    if levels == 65_535 && roughness(bytes, layout.order) > SMOOTHER * roughness(bytes, layout.order.other()) {
        let message = "neighbouring samples differ far less with their bytes swapped: the byte order may be wrong";
        warnings.push(Warning::new(warning::LOOKS_BYTESWAPPED, message));
    }
    Ok(Sheet {
        format: Format::Raw,
        width: layout.width,
        height: layout.height,
        values,
        coding: Coding::Levels(levels),
        levels: Some(levels),
        place: None,
        crs: SourceCrs::Unknown,
        height_unit_m: None,
        warnings,
    })
}

impl ByteOrder {
    const fn sample(self, bytes: &[u8]) -> u16 {
        match self {
            Self::LittleEndian => u16::from_le_bytes([bytes[0], bytes[1]]),
            Self::BigEndian => u16::from_be_bytes([bytes[0], bytes[1]]),
        }
    }

    const fn other(self) -> Self {
        match self {
            Self::LittleEndian => Self::BigEndian,
            Self::BigEndian => Self::LittleEndian,
        }
    }
}

/// Mean difference between neighbouring samples, plus one so that ratios of smooth files mean
/// little.
fn roughness(bytes: &[u8], order: ByteOrder) -> f64 {
    let samples = bytes.chunks_exact(2).map(|b| order.sample(b));
    let total: u64 = samples.clone().zip(samples.skip(1)).map(|(a, b)| u64::from(a.abs_diff(b))).sum();
    1.0 + total as f64 / (bytes.len() / 2).max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAYOUT: RawLayout =
        RawLayout { width: 40, height: 30, order: ByteOrder::LittleEndian, rows: RowOrder::NorthFirst };

    fn slope() -> Vec<u16> {
        (0..1200_u16).map(|i| 1000 + 37 * (i % 40) + 11 * (i / 40)).collect()
    }

    fn bytes(order: ByteOrder) -> Vec<u8> {
        let write = |v: u16| if order == ByteOrder::LittleEndian { v.to_le_bytes() } else { v.to_be_bytes() };
        slope().into_iter().flat_map(write).collect()
    }

    #[test]
    fn either_byte_order_and_either_row_order_give_the_same_heights() {
        let little = read(&bytes(ByteOrder::LittleEndian), &LAYOUT, &SheetOptions::default()).unwrap();
        let big = RawLayout { order: ByteOrder::BigEndian, ..LAYOUT };
        let big = read(&bytes(ByteOrder::BigEndian), &big, &SheetOptions::default()).unwrap();
        assert_eq!(little.values, big.values);
        assert!(little.warnings.is_empty() && big.warnings.is_empty());
        let south = RawLayout { rows: RowOrder::SouthFirst, ..LAYOUT };
        let flipped: Vec<u8> = bytes(ByteOrder::LittleEndian).chunks_exact(80).rev().flatten().copied().collect();
        assert_eq!(read(&flipped, &south, &SheetOptions::default()).unwrap().values, little.values);
    }

    #[test]
    fn the_wrong_byte_order_is_remarked_on() {
        let sheet = read(&bytes(ByteOrder::BigEndian), &LAYOUT, &SheetOptions::default()).unwrap();
        assert_eq!(sheet.warnings[0].code, warning::LOOKS_BYTESWAPPED);
    }

    #[test]
    fn a_size_that_does_not_fit_the_bytes_is_refused() {
        let wrong = RawLayout { width: 41, ..LAYOUT };
        let error = read(&bytes(ByteOrder::LittleEndian), &wrong, &SheetOptions::default()).unwrap_err();
        assert_eq!(error, RasterError::CountMismatch { what: "bytes", expected: 2460, found: 2400 });
        let huge = RawLayout { width: usize::MAX, ..LAYOUT };
        assert!(matches!(read(&[0; 8], &huge, &SheetOptions::default()), Err(RasterError::TooLarge { .. })));
    }
}
