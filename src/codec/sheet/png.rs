use super::Coding;
use super::Format;
use super::RasterError;
use super::Sheet;
use super::SheetOptions;
use super::SourceCrs;
use super::check_size;
use png::BitDepth;
use png::ColorType;
use png::Decoder;
use png::Limits;
use png::Reader;
use png::Transformations;
use std::io::Cursor;

/// Bytes the decoder may spend on metadata.
const METADATA_BYTES: usize = 16 << 20;

/// Reads a grey picture as levels: linear, without gamma and without colour management. Pixels
/// that are wholly transparent hold no data.
pub(super) fn read(bytes: &[u8], options: &SheetOptions) -> Result<Sheet, RasterError> {
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: METADATA_BYTES });
    decoder.set_transformations(Transformations::IDENTITY);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let header = decoder.read_header_info().map_err(unreadable)?;
    let (width, height, depth) = (header.width, header.height, header.bit_depth);
    // The size is checked here because the decoder's limits do not cover the picture itself.
    check_size(u64::from(width), u64::from(height), options.max_cells)?;
    let channels = match header.color_type {
        ColorType::Grayscale => 1,
        ColorType::GrayscaleAlpha => 2,
        other => return Err(RasterError::Colour { found: format!("a PNG of type {other:?}") }),
    };
    let reader = decoder.read_info().map_err(unreadable)?;
    let samples = samples(reader, (width as usize * channels, height as usize), depth)?;
    let values = match channels {
        1 => samples,
        _ => samples.chunks_exact(2).map(|p| if p[1] == 0.0 { f32::NAN } else { p[0] }).collect(),
    };
    Ok(Sheet {
        format: Format::Png,
        width: width as usize,
        height: height as usize,
        values,
        coding: Coding::Levels((1 << depth as u32) - 1),
        levels: Some((1 << depth as u32) - 1),
        place: None,
        crs: SourceCrs::Unknown,
        height_unit_m: None,
        warnings: Vec::new(),
    })
}

/// All samples row by row, unpacked.
fn samples(
    mut reader: Reader<Cursor<&[u8]>>,
    (across, height): (usize, usize),
    depth: BitDepth,
) -> Result<Vec<f32>, RasterError> {
    let row_bytes = (across * depth as usize).div_ceil(8);
    let mut buffer = vec![0; row_bytes * height];
    reader.next_frame(&mut buffer).map_err(unreadable)?;
    let mut samples = Vec::with_capacity(across * height);
    for row in buffer.chunks_exact(row_bytes) {
        match depth {
            BitDepth::Sixteen => {
                samples.extend(row.chunks_exact(2).map(|b| f32::from(u16::from_be_bytes([b[0], b[1]]))));
            }
            BitDepth::Eight => samples.extend(row.iter().map(|b| f32::from(*b))),
            _ => samples.extend((0..across).map(|i| f32::from(packed(row, i, depth as usize)))),
        }
    }
    Ok(samples)
}

/// The `i`-th of samples of 1, 2 or 4 bits, the highest bits first.
fn packed(row: &[u8], i: usize, bits: usize) -> u8 {
    let at = i * bits;
    let shift = 8 - bits - at % 8;
    (row[at / 8] >> shift) & ((1 << bits) - 1)
}

fn unreadable(error: png::DecodingError) -> RasterError {
    RasterError::Unreadable { format: Format::Png, reason: error.to_string() }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use png::Encoder;

    /// A PNG of that kind with these bytes as its rows.
    pub(crate) fn png(size: (u32, u32), colour: ColorType, depth: BitDepth, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, size.0, size.1);
        encoder.set_color(colour);
        encoder.set_depth(depth);
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        bytes
    }

    /// The same file with another size in its header.
    pub(crate) fn claiming(bytes: &[u8], width: u32, height: u32) -> Vec<u8> {
        let mut bytes = bytes.to_vec();
        bytes[16..20].copy_from_slice(&width.to_be_bytes());
        bytes[20..24].copy_from_slice(&height.to_be_bytes());
        let mut crc = flate2::Crc::new();
        crc.update(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&crc.sum().to_be_bytes());
        bytes
    }

    fn read(bytes: &[u8]) -> Result<Sheet, RasterError> {
        super::read(bytes, &SheetOptions::default())
    }

    #[test]
    fn grey_of_every_depth_is_read_as_levels() {
        let deep = read(&png((2, 1), ColorType::Grayscale, BitDepth::Sixteen, &[0x12, 0x34, 0xff, 0xff])).unwrap();
        assert_eq!((deep.values, deep.coding), (vec![f32::from(0x1234_u16), 65535.0], Coding::Levels(65_535)));
        let plain = read(&png((2, 2), ColorType::Grayscale, BitDepth::Eight, &[0, 7, 255, 8])).unwrap();
        assert_eq!((plain.values, plain.coding), (vec![0.0, 7.0, 255.0, 8.0], Coding::Levels(255)));
        let two = read(&png((3, 1), ColorType::Grayscale, BitDepth::Two, &[0b0111_0000])).unwrap();
        assert_eq!((two.values, two.coding), (vec![1.0, 3.0, 0.0], Coding::Levels(3)));
        let bits = read(&png((9, 1), ColorType::Grayscale, BitDepth::One, &[0b1010_0001, 0x80])).unwrap();
        assert_eq!(bits.values, [1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0]);
    }

    #[test]
    fn transparent_pixels_hold_no_data() {
        let sheet = read(&png((2, 1), ColorType::GrayscaleAlpha, BitDepth::Eight, &[9, 255, 9, 0])).unwrap();
        assert!(sheet.values[0] == 9.0 && sheet.values[1].is_nan());
    }

    #[test]
    fn a_picture_in_colour_is_refused() {
        let colour = png((1, 1), ColorType::Rgb, BitDepth::Eight, &[1, 2, 3]);
        assert_eq!(read(&colour).unwrap_err().code(), "COLOR_PNG");
    }

    #[test]
    fn a_header_that_claims_a_huge_picture_is_refused_before_it_is_allocated() {
        let small = png((1, 1), ColorType::Grayscale, BitDepth::Sixteen, &[0, 0]);
        for (width, height) in [(40_000, 40_000), (u32::MAX >> 1, u32::MAX >> 1)] {
            let error = read(&claiming(&small, width, height)).unwrap_err();
            assert!(matches!(error, RasterError::TooLarge { .. }), "{error}");
        }
    }

    #[test]
    fn every_cut_is_an_error() {
        let bytes = png((5, 4), ColorType::Grayscale, BitDepth::Eight, &[3; 20]);
        for n in 0..bytes.len() - 12 {
            assert!(read(&bytes[..n]).is_err(), "cut at {n}");
        }
    }
}
