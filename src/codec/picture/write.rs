use super::Image;
use png::BitDepth;
use png::ColorType;
use png::Compression;
use png::Encoder;
use png::EncodingError;

/// A picture with transparency, for overlays.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rgba {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Red, green, blue and opacity, row by row from the top.
    pub rgba: Vec<[u8; 4]>,
}

/// Pictures of one size shown one after the other, for ever.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Animation {
    /// The pictures, all of the size of the first.
    pub frames: Vec<Image>,
    /// Time between two of them, milliseconds.
    pub delay_ms: u16,
}

impl Image {
    /// An 8-bit RGB PNG.
    pub fn to_png(&self) -> Result<Vec<u8>, EncodingError> {
        let mut bytes = Vec::new();
        let mut writer = encoder(&mut bytes, (self.width, self.height), ColorType::Rgb).write_header()?;
        writer.write_image_data(self.rgb.as_flattened())?;
        writer.finish()?;
        Ok(bytes)
    }
}

impl Rgba {
    /// An 8-bit RGBA PNG.
    pub fn to_png(&self) -> Result<Vec<u8>, EncodingError> {
        let mut bytes = Vec::new();
        let mut writer = encoder(&mut bytes, (self.width, self.height), ColorType::Rgba).write_header()?;
        writer.write_image_data(self.rgba.as_flattened())?;
        writer.finish()?;
        Ok(bytes)
    }
}

impl Animation {
    /// An animated PNG. Programs that know only still pictures show the first frame.
    ///
    /// Fails when there is no frame or one is of another size.
    pub fn to_apng(&self) -> Result<Vec<u8>, EncodingError> {
        let size = self.frames.first().map_or((0, 0), |f| (f.width, f.height));
        let mut bytes = Vec::new();
        let mut encoder = encoder(&mut bytes, size, ColorType::Rgb);
        encoder.set_animated(self.frames.len() as u32, 0)?;
        encoder.set_frame_delay(self.delay_ms, 1000)?;
        let mut writer = encoder.write_header()?;
        for frame in &self.frames {
            writer.write_image_data(frame.rgb.as_flattened())?;
        }
        writer.finish()?;
        Ok(bytes)
    }
}

fn encoder(bytes: &mut Vec<u8>, size: (usize, usize), colour: ColorType) -> Encoder<'_, &mut Vec<u8>> {
    let mut encoder = Encoder::new(bytes, size.0 as u32, size.1 as u32);
    encoder.set_color(colour);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Fast);
    encoder
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gradient(width: usize, height: usize) -> Image {
        let rgb = (0..width * height).map(|i| [(i % width) as u8, (i / width) as u8, 9]).collect();
        Image { width, height, rgb }
    }

    #[test]
    fn a_picture_comes_back_pixel_for_pixel() {
        let picture = gradient(70, 41);
        let back = image::load_from_memory(&picture.to_png().unwrap()).unwrap().to_rgb8();
        assert_eq!((back.width(), back.height()), (70, 41));
        assert_eq!(back.as_raw().as_slice(), picture.rgb.as_flattened());
    }

    #[test]
    fn transparency_is_kept() {
        let overlay = Rgba { width: 2, height: 1, rgba: vec![[1, 2, 3, 0], [4, 5, 6, 128]] };
        let back = image::load_from_memory(&overlay.to_png().unwrap()).unwrap().to_rgba8();
        assert_eq!(back.as_raw().as_slice(), overlay.rgba.as_flattened());
    }

    #[test]
    fn an_animation_holds_all_its_frames() {
        let frames = vec![gradient(30, 20), gradient(30, 20), Image { width: 30, height: 20, rgb: vec![[7; 3]; 600] }];
        let bytes = Animation { frames, delay_ms: 40 }.to_apng().unwrap();
        let reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        let control = reader.info().animation_control.unwrap();
        assert_eq!((control.num_frames, control.num_plays), (3, 0));
    }

    #[test]
    fn an_animation_without_frames_or_with_a_misfit_is_refused() {
        assert!(Animation { frames: Vec::new(), delay_ms: 40 }.to_apng().is_err());
        assert!(Animation { frames: vec![gradient(3, 3), gradient(4, 4)], delay_ms: 40 }.to_apng().is_err());
    }
}
