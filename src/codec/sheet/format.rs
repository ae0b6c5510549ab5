use std::fmt;

/// The formats in which rasters are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// TIFF with or without place, any numeric samples.
    GeoTiff,
    /// Grey PNG of 1 to 16 bits.
    Png,
    /// ESRI ASCII grid.
    AsciiGrid,
    /// Headerless integers (`.r16`, `.raw`).
    Raw,
    /// The compact form of another job's map.
    Map,
}

impl Format {
    /// All of them, for people.
    pub const READ: &'static str = "a GeoTIFF, a grey PNG, an ESRI ASCII grid, or raw samples of a stated size";

    /// The format of `bytes` by their beginning; raw samples cannot be told.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        let tiff: [&[u8]; 4] = [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"];
        match bytes {
            _ if tiff.iter().any(|magic| bytes.starts_with(magic)) => Some(Self::GeoTiff),
            _ if bytes.starts_with(b"\x89PNG\r\n\x1a\n") => Some(Self::Png),
            _ if bytes.starts_with(b"BMAP") => Some(Self::Map),
            _ if begins_as_ascii_grid(bytes) => Some(Self::AsciiGrid),
            _ => None,
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::GeoTiff => "GeoTIFF",
            Self::Png => "PNG",
            Self::AsciiGrid => "ASCII grid",
            Self::Raw => "raw file",
            Self::Map => "map",
        })
    }
}

fn begins_as_ascii_grid(bytes: &[u8]) -> bool {
    let head = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let head = head[..head.len().min(64)].trim_ascii_start().to_ascii_lowercase();
    let keys: [&[u8]; 7] = [b"ncols", b"nrows", b"xll", b"yll", b"cellsize", b"dx", b"nodata_value"];
    keys.iter().any(|key| head.starts_with(key))
}

/// What bytes in no known format look like.
pub(crate) fn described(bytes: &[u8]) -> String {
    let known: [(&[u8], &str); 8] = [
        (b"\xff\xd8\xff", "a JPEG picture"),
        (b"GIF8", "a GIF picture"),
        (b"\x76\x2f\x31\x01", "an OpenEXR picture"),
        (b"PK\x03\x04", "a ZIP or NPZ archive"),
        (b"\x89HDF", "an HDF5 or NetCDF file"),
        (b"CDF", "a NetCDF file"),
        (b"{", "a JSON document"),
        (b"%PDF", "a PDF document"),
    ];
    match known.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        Some((_, name)) => (*name).to_owned(),
        None => format!("{} bytes that begin with {:02x?}", bytes.len(), &bytes[..bytes.len().min(4)]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_beginning_tells_the_format() {
        assert_eq!(Format::of(b"MM\0*...."), Some(Format::GeoTiff));
        assert_eq!(Format::of(b"\x89PNG\r\n\x1a\nrest"), Some(Format::Png));
        assert_eq!(Format::of(b"  NCOLS 4\n"), Some(Format::AsciiGrid));
        assert_eq!(Format::of(b"xllcenter 0"), Some(Format::AsciiGrid));
        assert_eq!(Format::of(b"\x01\x02\x03"), None);
        assert_eq!(Format::of(b""), None);
        assert_eq!(described(b"\xff\xd8\xff\xe0"), "a JPEG picture");
    }
}
