use super::Image;
use image::DynamicImage;
use image::ImageDecoder;
use image::codecs::jpeg::JpegDecoder;
use image::codecs::png::PngDecoder;
use std::io::Cursor;

/// Pixels a photo may have unless the caller says otherwise: 24 times 2²⁰, which holds every
/// camera sold as one of 24 megapixels (6,000 × 4,000 and a little more).
pub const MAX_PIXELS: u64 = 24 << 20;

/// Why a photo cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PhotoError {
    /// No bytes.
    #[error("the file is empty")]
    Empty,
    /// Neither JPEG nor PNG.
    #[error("a JPEG or PNG was expected, this is {found}")]
    UnknownFormat {
        /// What the first bytes look like.
        found: String,
    },
    /// The file is damaged, or uses a part of its format that is not read.
    #[error("the picture cannot be read: {reason}")]
    Unreadable {
        /// What is wrong.
        reason: String,
    },
    /// More pixels than allowed; found out before they were allocated.
    #[error("{width} × {height} pixels are more than the {max_pixels} allowed")]
    TooLarge {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// Pixels allowed.
        max_pixels: u64,
    },
    /// Several frames.
    #[error("the picture is animated; a still one is needed")]
    Animated,
    /// Four printing colours.
    #[error("the picture is in the printing colours CMYK; red, green and blue are needed")]
    Cmyk,
}

impl PhotoError {
    /// The stable code of the problem.
    pub const fn code(&self) -> &'static str {
        match self {
            Self::Empty | Self::UnknownFormat { .. } | Self::Unreadable { .. } => "unreadable",
            Self::TooLarge { .. } => "picture-too-large",
            Self::Animated => "picture-animated",
            Self::Cmyk => "picture-cmyk",
        }
    }

    /// What was expected.
    pub fn expected(&self) -> String {
        match self {
            Self::Empty | Self::UnknownFormat { .. } => "a JPEG or PNG picture".to_owned(),
            Self::Unreadable { .. } => "a whole JPEG or PNG picture".to_owned(),
            Self::TooLarge { max_pixels, .. } => format!("at most {max_pixels} pixels"),
            Self::Animated => "a still picture".to_owned(),
            Self::Cmyk => "a picture in red, green and blue, or grey".to_owned(),
        }
    }

    /// What was found.
    pub fn found(&self) -> String {
        match self {
            Self::Empty => "0 bytes".to_owned(),
            Self::UnknownFormat { found } | Self::Unreadable { reason: found } => found.clone(),
            Self::TooLarge { width, height, .. } => format!("{width} × {height} pixels"),
            Self::Animated => "an animated PNG".to_owned(),
            Self::Cmyk => "a JPEG of four colours".to_owned(),
        }
    }
}

impl Image {
    /// Reads a photo: JPEG or PNG of at most `max_pixels`, turned upright as its EXIF data says,
    /// see-through parts on white.
    ///
    /// # Errors
    /// See [`PhotoError`]; size and kind are checked before the pixels are allocated.
    pub fn read(bytes: &[u8], max_pixels: u64) -> Result<Self, PhotoError> {
        match bytes {
            [] => Err(PhotoError::Empty),
            [0xff, 0xd8, 0xff, ..] => {
                if components(bytes) == Some(4) {
                    return Err(PhotoError::Cmyk);
                }
                decoded(JpegDecoder::new(Cursor::new(bytes)).map_err(unreadable)?, max_pixels)
            }
            _ if bytes.starts_with(b"\x89PNG\r\n\x1a\n") => {
                let decoder = PngDecoder::new(Cursor::new(bytes)).map_err(unreadable)?;
                if decoder.is_apng().map_err(unreadable)? {
                    return Err(PhotoError::Animated);
                }
                decoded(decoder, max_pixels)
            }
            _ => Err(PhotoError::UnknownFormat { found: crate::codec::sheet::described(bytes) }),
        }
    }
}

fn decoded(mut decoder: impl ImageDecoder, max_pixels: u64) -> Result<Image, PhotoError> {
    let (width, height) = decoder.dimensions();
    if u64::from(width) * u64::from(height) > max_pixels {
        return Err(PhotoError::TooLarge { width, height, max_pixels });
    }
    let orientation = decoder.orientation().map_err(unreadable)?;
    let mut picture = DynamicImage::from_decoder(decoder).map_err(unreadable)?;
    picture.apply_orientation(orientation);
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    let rgb = match picture {
        DynamicImage::ImageRgb8(rgb) => rgb.into_raw().as_chunks::<3>().0.to_vec(),
        other => other.into_rgba8().as_raw().as_chunks::<4>().0.iter().map(on_white).collect(),
    };
    Ok(Image { width, height, rgb })
}

fn on_white(&[r, g, b, a]: &[u8; 4]) -> [u8; 3] {
    [r, g, b].map(|v| ((u16::from(v) * u16::from(a) + 255 * (255 - u16::from(a)) + 127) / 255) as u8)
}

/// The number of colours in the frame header of a JPEG (ITU T.81, B.2.2).
fn components(bytes: &[u8]) -> Option<u8> {
    let mut at = 2;
    loop {
        let [0xff, marker, high, low] = *bytes.get(at..at + 4)? else {
            return None;
        };
        let is_frame = matches!(marker, 0xc0..=0xcf) && !matches!(marker, 0xc4 | 0xc8 | 0xcc);
        if is_frame {
            return bytes.get(at + 9).copied();
        }
        at += 2 + usize::from(u16::from_be_bytes([high, low]));
    }
}

fn unreadable(error: image::ImageError) -> PhotoError {
    PhotoError::Unreadable { reason: error.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::picture::Animation;
    use crate::codec::sheet::png::tests::claiming;
    use image::codecs::jpeg::JpegEncoder;

    fn picture() -> Image {
        let rgb = (0..40 * 24).map(|i| if i % 40 < 20 { [220, 30, 30] } else { [20, 40, 200] }).collect();
        Image { width: 40, height: 24, rgb }
    }

    fn jpeg() -> Vec<u8> {
        let mut bytes = Vec::new();
        let picture = picture();
        let mut encoder = JpegEncoder::new_with_quality(&mut bytes, 95);
        encoder.encode(picture.rgb.as_flattened(), 40, 24, image::ExtendedColorType::Rgb8).unwrap();
        bytes
    }

    /// The same file with an EXIF orientation in front.
    fn turned(jpeg: &[u8], orientation: u8) -> Vec<u8> {
        let exif =
            [b"Exif\0\0MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0".as_slice(), &[orientation], &[0; 6]].concat();
        let head = [0xff, 0xd8, 0xff, 0xe1, 0, exif.len() as u8 + 2];
        [&head, exif.as_slice(), &jpeg[2..]].concat()
    }

    fn is_red(image: &Image, x: usize, y: usize) -> bool {
        image.rgb[y * image.width + x][0] > 128
    }

    #[test]
    fn jpeg_and_png_give_the_same_picture() {
        let photo = Image::read(&jpeg(), MAX_PIXELS).unwrap();
        assert_eq!((photo.width, photo.height), (40, 24));
        assert!(is_red(&photo, 5, 12) && !is_red(&photo, 35, 12));
        assert_eq!(Image::read(&picture().to_png().unwrap(), MAX_PIXELS).unwrap(), picture());
    }

    #[test]
    fn a_photo_is_turned_upright() {
        let quarter = Image::read(&turned(&jpeg(), 6), MAX_PIXELS).unwrap();
        assert_eq!((quarter.width, quarter.height), (24, 40));
        assert!(is_red(&quarter, 12, 5) && !is_red(&quarter, 12, 35));
        let half = Image::read(&turned(&jpeg(), 3), MAX_PIXELS).unwrap();
        assert!(!is_red(&half, 5, 12) && is_red(&half, 35, 12));
    }

    #[test]
    fn pictures_of_other_kinds_are_refused_by_their_kind() {
        let error = |bytes: &[u8]| Image::read(bytes, MAX_PIXELS).unwrap_err();
        assert_eq!(error(b""), PhotoError::Empty);
        assert_eq!(error(b"GIF89a").found(), "a GIF picture");
        let moving = Animation { frames: vec![picture(), picture()], delay_ms: 20 }.to_apng().unwrap();
        assert_eq!(error(&moving), PhotoError::Animated);
        let cmyk = [0xff, 0xd8, 0xff, 0xc0, 0, 20, 8, 0, 1, 0, 1, 4, 1, 0x11, 0];
        assert_eq!(error(&cmyk), PhotoError::Cmyk);
    }

    #[test]
    fn a_huge_picture_is_refused_before_it_is_allocated() {
        let png = claiming(&picture().to_png().unwrap(), 60_000, 60_000);
        assert_eq!(Image::read(&png, MAX_PIXELS).unwrap_err().code(), "picture-too-large");
        let mut huge = jpeg();
        let frame = huge.windows(2).position(|w| w == [0xff, 0xc0]).unwrap();
        huge[frame + 5..frame + 9].copy_from_slice(&[0xff, 0xff, 0xff, 0xff]);
        assert_eq!(Image::read(&huge, MAX_PIXELS).unwrap_err().code(), "picture-too-large");
    }

    #[test]
    fn damaged_pictures_never_panic() {
        for file in [jpeg(), picture().to_png().unwrap()] {
            for at in (0..file.len()).step_by(3) {
                let mut damaged = file.clone();
                damaged[at] ^= 0x5a;
                let _ = Image::read(&damaged, 10_000);
                let _ = Image::read(&file[..at], 10_000);
            }
        }
    }

    #[test]
    fn see_through_parts_lie_on_white() {
        assert_eq!((on_white(&[10, 20, 30, 0]), on_white(&[10, 20, 30, 255])), ([255; 3], [10, 20, 30]));
        assert_eq!(on_white(&[0, 0, 0, 128]), [127; 3]);
    }
}
