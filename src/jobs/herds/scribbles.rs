//! What the user marks on a photo.

use biotope_api::error::ErrorCode;
use biotope_api::herds::MarkInput;
use biotope_api::herds::ScribblesInput;
use biotope_api::herds::StrokeInput;
use biotope_api::reference::Reference;

use crate::codec::picture::MAX_PIXELS;
use crate::codec::sheet::Sheet;
use crate::codec::sheet::SheetOptions;
use crate::compute::geometry::Point;
use crate::compute::herds::extraction::Mark;
use crate::compute::herds::extraction::Scribbles;
use crate::compute::herds::extraction::Stroke;
use crate::compute::raster::Grid;
use crate::compute::run::Run;
use crate::jobs::Invalid;
use crate::jobs::Sources;
use crate::jobs::herds::faults;
use crate::jobs::rasters;

const POINTER: &str = "/scribbles";

/// The scribbles over a photo of the size of `grid`, checked.
///
/// # Errors
/// None or both kinds of scribbles, places outside the picture, marks of one kind only or
/// contradicting ones, a label image of another size or with other values.
pub fn open(input: &ScribblesInput, grid: Grid, sources: &dyn Sources) -> Result<Scribbles, Invalid> {
    let scribbles = match (&input.strokes, &input.labels) {
        (Some(strokes), None) => Scribbles::Strokes(strokes.iter().map(stroke).collect()),
        (None, Some(labels)) => Scribbles::Labels(marks(labels, grid, sources)?),
        (None, None) => {
            return Err(Invalid::new(POINTER, ErrorCode::Missing, "strokes or a label image", "neither"));
        }
        (Some(_), Some(_)) => {
            return Err(Invalid::new(POINTER, ErrorCode::Inconsistent, "either strokes or a label image", "both"));
        }
    };
    match scribbles.check(grid, &Run::silent()) {
        Ok(()) => Ok(scribbles),
        Err(error) => Err(faults::extraction(&error).unwrap_or_default()),
    }
}

fn stroke(input: &StrokeInput) -> Stroke {
    let mark = match input.mark {
        MarkInput::Animal => Mark::Animal,
        MarkInput::Ground => Mark::Ground,
    };
    Stroke { mark, points: input.points.iter().map(|p| Point::new(p[0], p[1])).collect(), width: input.width }
}

/// The marks of a label image.
fn marks(labels: &Reference, grid: Grid, sources: &dyn Sources) -> Result<Vec<Mark>, Invalid> {
    let pointer = format!("{POINTER}/labels");
    let source = sources.open(labels).map_err(|error| error.at(&pointer))?;
    let sheet = match (source.map(), source.bytes()) {
        (Some(map), _) => Sheet::from(map.clone()),
        (None, Some((_, bytes))) => Sheet::read(bytes, &SheetOptions { max_cells: MAX_PIXELS, raw: None })
            .map_err(|error| rasters::fault(&error, &pointer))?,
        (None, None) => {
            return Err(Invalid::new(pointer, ErrorCode::Unreadable, "a grey picture", "another kind of output"));
        }
    };
    if (sheet.width, sheet.height) != (grid.width, grid.height) {
        let size = |(width, height)| format!("{width} × {height} pixels");
        let (expected, found) = (size((grid.width, grid.height)), size((sheet.width, sheet.height)));
        return Err(Invalid::new(pointer, ErrorCode::SizeMismatch, format!("{expected}, as the photo has"), found));
    }
    let mark = |value: &f32| match *value {
        0.0 => Ok(Mark::Unmarked),
        1.0 | 255.0 => Ok(Mark::Animal),
        2.0 | 128.0 => Ok(Mark::Ground),
        nan if nan.is_nan() => Ok(Mark::Unmarked),
        other => Err(Invalid::new(&pointer, ErrorCode::NotOneOf, "0, 1 or 255, 2 or 128 in every pixel", other)),
    };
    sheet.values.iter().map(mark).collect()
}
