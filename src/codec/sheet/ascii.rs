use super::Affine;
use super::Coding;
use super::Format;
use super::RasterError;
use super::Sheet;
use super::SheetOptions;
use super::SourceCrs;
use super::check_size;
use rayon::prelude::*;

/// Bytes a parallel piece of the values has.
const PIECE: usize = 1 << 18;

/// Reads an ESRI ASCII grid: keys in any case and order, corner or centre of the south-west
/// cell, `cellsize` or `dx` and `dy`, values broken into lines at will. Without a
/// `NODATA_value`, −9999 stands for it, as the format says.
pub(super) fn read(bytes: &[u8], options: &SheetOptions) -> Result<Sheet, RasterError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let (header, rest) = Header::read(bytes)?;
    let (width, height) = header.size()?;
    check_size(width, height, options.max_cells)?;
    let place = header.place(height)?;
    let nodata = header.nodata.unwrap_or(-9999.0) as f32;
    let values = parse(rest, nodata)?;
    let expected = width * height;
    if values.len() as u64 != expected {
        return Err(RasterError::CountMismatch { what: "values", expected, found: values.len() as u64 });
    }
    Ok(Sheet {
        format: Format::AsciiGrid,
        width: width as usize,
        height: height as usize,
        values,
        coding: Coding::Values,
        levels: None,
        place: Some(place),
        crs: SourceCrs::Unknown,
        height_unit_m: None,
        warnings: Vec::new(),
    })
}

/// The keys of the header, as far as they are there.
#[derive(Debug, Default)]
struct Header {
    columns: Option<f64>,
    rows: Option<f64>,
    corner: [Option<f64>; 2],
    centre: [Option<f64>; 2],
    cell: [Option<f64>; 2],
    nodata: Option<f64>,
}

impl Header {
    /// The header and what follows it.
    fn read(bytes: &[u8]) -> Result<(Self, &[u8]), RasterError> {
        let mut header = Self::default();
        let mut rest = bytes;
        while let Some((key, after)) = word(rest) {
            if !key[0].is_ascii_alphabetic() || is_number_word(key) {
                break;
            }
            let name = String::from_utf8_lossy(key).to_ascii_lowercase();
            let (text, after) = word(after).ok_or_else(|| unreadable(format!("no value after {name}")))?;
            header.set(&name, number(text)?)?;
            rest = after;
        }
        Ok((header, rest))
    }

    fn set(&mut self, name: &str, value: f64) -> Result<(), RasterError> {
        let some = Some(value);
        match name {
            "ncols" => self.columns = some,
            "nrows" => self.rows = some,
            "xllcorner" => self.corner[0] = some,
            "yllcorner" => self.corner[1] = some,
            "xllcenter" | "xllcentre" => self.centre[0] = some,
            "yllcenter" | "yllcentre" => self.centre[1] = some,
            "cellsize" => self.cell = [some; 2],
            "dx" | "xdim" => self.cell[0] = some,
            "dy" | "ydim" => self.cell[1] = some,
            "nodata_value" | "nodata" => self.nodata = some,
            other => return Err(unreadable(format!("the unknown key {other} in its header"))),
        }
        Ok(())
    }

    fn size(&self) -> Result<(u64, u64), RasterError> {
        let whole = |value: Option<f64>, name: &str| match value {
            Some(v) if v >= 0.0 && v.fract() == 0.0 && v < 1e15 => Ok(v as u64),
            Some(v) => Err(unreadable(format!("{name} is {v}"))),
            None => Err(unreadable(format!("no {name} in its header"))),
        };
        Ok((whole(self.columns, "ncols")?, whole(self.rows, "nrows")?))
    }

    /// The place of the cells; the origin is 0 where the header has none.
    fn place(&self, rows: u64) -> Result<Affine, RasterError> {
        let [Some(dx), Some(dy)] = self.cell else {
            return Err(RasterError::NoCellSize { format: Format::AsciiGrid });
        };
        let edge = |axis: usize, cell: f64| match (self.corner[axis], self.centre[axis]) {
            (Some(corner), _) => corner,
            (None, Some(centre)) => centre - cell / 2.0,
            (None, None) => 0.0,
        };
        let (west, south) = (edge(0, dx), edge(1, dy));
        Ok(Affine { x0: west, a: dx, b: 0.0, y0: south + rows as f64 * dy, d: 0.0, e: -dy })
    }
}

/// All numbers of `text`, in order; pieces are read in parallel.
fn parse(text: &[u8], nodata: f32) -> Result<Vec<f32>, RasterError> {
    let pieces: Vec<Vec<f32>> = pieces(text)
        .into_par_iter()
        .map(|piece| {
            let words = piece.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
            words.map(|w| value(w, nodata)).collect::<Result<Vec<f32>, _>>()
        })
        .collect::<Vec<_>>()
        .into_iter()
        .collect::<Result<_, _>>()?;
    Ok(pieces.concat())
}

/// Pieces of about [`PIECE`] bytes that end between words.
fn pieces(mut text: &[u8]) -> Vec<&[u8]> {
    let mut all = Vec::new();
    while !text.is_empty() {
        let from = PIECE.min(text.len());
        let end = text[from..].iter().position(u8::is_ascii_whitespace).map_or(text.len(), |n| from + n);
        all.push(&text[..end]);
        text = &text[end..];
    }
    all
}

fn value(word: &[u8], nodata: f32) -> Result<f32, RasterError> {
    let value = number(word)? as f32;
    Ok(if value == nodata { f32::NAN } else { value })
}

fn number(word: &[u8]) -> Result<f64, RasterError> {
    let text = std::str::from_utf8(&word[..word.len().min(64)]).unwrap_or("something that is not text");
    text.parse().map_err(|_| match text.contains(',') {
        true => RasterError::DecimalComma { found: text.to_owned() },
        false => unreadable(format!("“{text}” where a number belongs")),
    })
}

/// Whether a word that begins with a letter is a number after all.
fn is_number_word(word: &[u8]) -> bool {
    let lower = word.to_ascii_lowercase();
    matches!(lower.as_slice(), b"nan" | b"inf" | b"infinity")
}

/// The first word and what follows it.
fn word(text: &[u8]) -> Option<(&[u8], &[u8])> {
    let text = text.trim_ascii_start();
    let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
    (end > 0).then(|| text.split_at(end))
}

fn unreadable(reason: String) -> RasterError {
    RasterError::Unreadable { format: Format::AsciiGrid, reason }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Sheet, RasterError> {
        super::read(text.as_bytes(), &SheetOptions::default())
    }

    #[test]
    fn corner_and_centre_give_the_same_place_in_any_case_and_order() {
        let corner = "ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 10\nNODATA_value -1\n1 2 3\n4 -1 6\n";
        let centre = "YLLCENTER 205\nXLLCenter 105\nCELLSIZE 10\nnodata_value -1\nNROWS 2\nNCOLS 3\n1 2 3\n4 -1 6";
        let (a, b) = (read(corner).unwrap(), read(centre).unwrap());
        assert_eq!((a.place, a.width, a.height), (b.place, b.width, b.height));
        assert_eq!(a.place, Some(Affine { x0: 100.0, a: 10.0, b: 0.0, y0: 220.0, d: 0.0, e: -10.0 }));
        assert!(a.values[4].is_nan() && a.values[5] == 6.0);
    }

    #[test]
    fn cells_need_not_be_square_and_lines_need_not_be_rows() {
        let sheet = read("ncols 2\nnrows 3\ndx 10\ndy 20\n1 2 3\r\n4\t5\n\n6 ").unwrap();
        assert_eq!(sheet.values, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!(sheet.place.map(|p| (p.a, p.e, p.y0)), Some((10.0, -20.0, 60.0)));
    }

    #[test]
    fn a_decimal_comma_is_refused_and_shown() {
        let error = read("ncols 2\nnrows 1\ncellsize 1\n1,5 2,5").unwrap_err();
        assert_eq!(error, RasterError::DecimalComma { found: "1,5".into() });
        assert!(matches!(read("ncols 2\nnrows 1\ncellsize 1,0\n1 2"), Err(RasterError::DecimalComma { .. })));
    }

    #[test]
    fn what_is_wrong_is_said() {
        let code = |text: &str| read(text).unwrap_err().to_string();
        assert!(code("ncols 2\nnrows 2\ncellsize 1\n1 2 3").contains("4 values were expected, 3 were found"));
        assert!(code("ncols 2\nnrows 1\n1 2").contains("how large a cell is"));
        assert!(code("nrows 1\ncellsize 1\n1 2").contains("no ncols"));
        assert!(code("ncols 2\nnrows 1\ncellsize 1\n1 x").contains("“x”"));
        assert!(code("ncols 40000\nnrows 40000\ncellsize 1\n").contains("more than"));
        assert!(code("ncols 1e300\nnrows 1\ncellsize 1\n").contains("ncols"));
        assert!(code("ncols 2\nbogus 1\n").contains("bogus"));
        assert!(code("ncols").contains("no value after"));
    }

    #[test]
    fn many_pieces_keep_their_order() {
        let n = 200_000;
        let body: Vec<String> = (0..n).map(|i| format!("{i}.25")).collect();
        let text = format!("ncols {n}\nnrows 1\ncellsize 1\n{}", body.join(" "));
        let sheet = read(&text).unwrap();
        assert!(sheet.values.iter().enumerate().all(|(i, v)| *v == i as f32 + 0.25));
    }
}
