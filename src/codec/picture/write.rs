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
    /// An animated PNG. Programs that know only still pictures show the first frame. Each further
    /// frame holds only the rectangle that changes, see-through where it does not.
    ///
    /// Fails when there is no frame or one is of another size.
    pub fn to_apng(&self) -> Result<Vec<u8>, EncodingError> {
        let size = self.frames.first().map_or((0, 0), |f| (f.width, f.height));
        let mut bytes = Vec::new();
        let mut encoder = encoder(&mut bytes, size, ColorType::Rgba);
        encoder.set_animated(self.frames.len() as u32, 0)?;
        encoder.set_frame_delay(self.delay_ms, 1000)?;
        let mut writer = encoder.write_header()?;
        if let Some(first) = self.frames.first() {
            let opaque: Vec<[u8; 4]> = first.rgb.iter().map(|[r, g, b]| [*r, *g, *b, 255]).collect();
            writer.write_image_data(opaque.as_flattened())?;
        }
        for pair in self.frames.windows(2) {
            let patch = Patch::between(&pair[0], &pair[1]);
            writer.set_frame_position(0, 0)?;
            writer.set_frame_dimension(patch.width as u32, patch.height as u32)?;
            writer.set_frame_position(patch.left as u32, patch.top as u32)?;
            writer.set_blend_op(png::BlendOp::Over)?;
            writer.set_dispose_op(png::DisposeOp::None)?;
            writer.write_image_data(patch.rgba.as_flattened())?;
        }
        writer.finish()?;
        Ok(bytes)
    }
}

/// What makes one picture out of another when it is laid over it.
struct Patch {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
    rgba: Vec<[u8; 4]>,
}

impl Patch {
    /// From one frame to the next; of another size, all of the next.
    fn between(one: &Image, two: &Image) -> Self {
        let width = two.width.max(1);
        let same = (one.width, one.height) == (two.width, two.height);
        let differs = |i: usize| !same || one.rgb[i] != two.rgb[i];
        let changed: Vec<usize> = (0..two.rgb.len()).filter(|i| differs(*i)).collect();
        let columns = || changed.iter().map(|i| i % width);
        let (left, right) = (columns().min().unwrap_or(0), columns().max().unwrap_or(0));
        let (top, bottom) = (changed.first().map_or(0, |i| i / width), changed.last().map_or(0, |i| i / width));
        let pixel = |i: usize| match two.rgb.get(i) {
            Some([r, g, b]) if differs(i) => [*r, *g, *b, 255],
            _ => [0; 4],
        };
        let row = |row: usize| (left..=right).map(move |column| row * width + column);
        let rgba = (top..=bottom).flat_map(row).map(pixel).collect();
        Self { left, top, width: right - left + 1, height: bottom - top + 1, rgba }
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

    /// The frames of an animated PNG as a viewer shows them.
    fn shown(bytes: &[u8]) -> Vec<Vec<[u8; 3]>> {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let control = reader.info().animation_control.unwrap();
        assert_eq!(control.num_plays, 0);
        let (width, height) = (reader.info().width as usize, reader.info().height as usize);
        let (mut canvas, mut buffer) = (vec![[0; 3]; width * height], vec![0; width * height * 4]);
        let mut frames = Vec::new();
        for _ in 0..control.num_frames {
            let info = reader.next_frame(&mut buffer).unwrap();
            let place = reader.info().frame_control.unwrap();
            let (left, top) = (place.x_offset as usize, place.y_offset as usize);
            for (i, pixel) in buffer[..info.buffer_size()].as_chunks::<4>().0.iter().enumerate() {
                let at = (top + i / info.width as usize) * width + left + i % info.width as usize;
                if pixel[3] == 255 {
                    canvas[at] = [pixel[0], pixel[1], pixel[2]];
                }
            }
            frames.push(canvas.clone());
        }
        frames
    }

    #[test]
    fn an_animation_shows_all_its_frames() {
        let mut spot = gradient(30, 20);
        (5..9).for_each(|row| spot.rgb[row * 30 + 7..row * 30 + 12].fill([200; 3]));
        let grey = Image { width: 30, height: 20, rgb: vec![[7; 3]; 600] };
        let frames = vec![gradient(30, 20), gradient(30, 20), spot, gradient(30, 20), grey];
        let expected: Vec<Vec<[u8; 3]>> = frames.iter().map(|f| f.rgb.clone()).collect();
        assert_eq!(shown(&Animation { frames, delay_ms: 40 }.to_apng().unwrap()), expected);
    }

    #[test]
    fn an_animation_without_frames_or_with_a_misfit_is_refused() {
        assert!(Animation { frames: Vec::new(), delay_ms: 40 }.to_apng().is_err());
        assert!(Animation { frames: vec![gradient(3, 3), gradient(4, 4)], delay_ms: 40 }.to_apng().is_err());
    }
}
