use super::ExtractionError;
use crate::compute::geometry::Bounds;
use crate::compute::geometry::Point;
use crate::compute::raster::Grid;
use crate::compute::run::Run;

/// What the user says a pixel shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// Nothing said.
    Unmarked,
    /// An animal: the foreground of T 4.2.1.
    Animal,
    /// Ground or anything else that is no animal: the background.
    Ground,
}

/// One line drawn by the user.
#[derive(Debug, Clone, PartialEq)]
pub struct Stroke {
    /// What lies under the line.
    pub mark: Mark,
    /// The line's corners in pixels of the photo's map frame; one point is a dot.
    pub points: Vec<Point>,
    /// Width of the line in pixels, at least 1.
    pub width: f64,
}

/// The user's annotation of a photo.
#[derive(Debug, Clone, PartialEq)]
pub enum Scribbles {
    /// Lines drawn over it.
    Strokes(Vec<Stroke>),
    /// A mark for every pixel, row-major from the upper left.
    Labels(Vec<Mark>),
}

impl Scribbles {
    /// Whether they can be learnt from over a picture of the size of `grid`.
    ///
    /// # Errors
    /// Points outside the picture, contradicting marks, only one kind of mark, a label image of
    /// another size, or a stop.
    pub fn check(&self, grid: Grid, run: &Run) -> Result<(), ExtractionError> {
        rasterise(self, grid, run).map(drop)
    }
}

/// A mark per pixel.
///
/// # Errors
/// Points outside the picture, contradicting marks, only one kind of mark, a label image of
/// another size, or a stop.
pub(super) fn rasterise(scribbles: &Scribbles, grid: Grid, run: &Run) -> Result<Vec<Mark>, ExtractionError> {
    let marks = match scribbles {
        Scribbles::Labels(labels) if labels.len() == grid.len() => labels.clone(),
        Scribbles::Labels(labels) => {
            return Err(ExtractionError::LabelSize { expected: grid.len(), found: labels.len() });
        }
        Scribbles::Strokes(strokes) => draw(strokes, grid, run)?,
    };
    for (mark, missing) in [(Mark::Animal, "animal"), (Mark::Ground, "ground")] {
        if !marks.contains(&mark) {
            return Err(ExtractionError::OneKindOnly { missing });
        }
    }
    Ok(marks)
}

fn draw(strokes: &[Stroke], grid: Grid, run: &Run) -> Result<Vec<Mark>, ExtractionError> {
    let mut marks = vec![Mark::Unmarked; grid.len()];
    let mut contradictions = Vec::new();
    for (index, stroke) in strokes.iter().enumerate() {
        require_inside(index, stroke, grid)?;
        let last = stroke.points.len().saturating_sub(1);
        for (i, &from) in stroke.points.iter().enumerate() {
            run.check()?;
            if i == last && i > 0 {
                break;
            }
            let to = stroke.points[(i + 1).min(last)];
            for_each_under(grid, (from, to), stroke.width.max(1.0) / 2.0, |pixel| match marks[pixel] {
                Mark::Unmarked => marks[pixel] = stroke.mark,
                mark if mark != stroke.mark => contradictions.push(pixel),
                _ => {}
            });
        }
    }
    contradictions.sort_unstable();
    contradictions.dedup();
    match contradictions.first().map(|&first| grid.cell(first)) {
        None => Ok(marks),
        Some(cell) => {
            Err(ExtractionError::Contradiction { count: contradictions.len(), column: cell.column, row: cell.row })
        }
    }
}

fn require_inside(index: usize, stroke: &Stroke, grid: Grid) -> Result<(), ExtractionError> {
    let picture = Bounds::new(Point::default(), Point::new(grid.width as f64, grid.height as f64));
    match stroke.points.iter().position(|p| !p.is_finite() || !picture.contains(*p)) {
        None => Ok(()),
        Some(point) => Err(ExtractionError::OutsidePicture {
            stroke: index,
            point,
            x: stroke.points[point].x,
            y: stroke.points[point].y,
            width: grid.width,
            height: grid.height,
        }),
    }
}

/// Calls `visit` with every pixel whose centre lies within `radius` of the segment, and with the
/// pixel that holds its start.
fn for_each_under(grid: Grid, (from, to): (Point, Point), radius: f64, mut visit: impl FnMut(usize)) {
    let at = |p: Point| (p.x.clamp(0.0, grid.width as f64 - 0.5), p.y.clamp(0.0, grid.height as f64 - 0.5));
    let (low_x, low_y) = at(Point::new(from.x.min(to.x) - radius, from.y.min(to.y) - radius));
    let (high_x, high_y) = at(Point::new(from.x.max(to.x) + radius, from.y.max(to.y) + radius));
    let start = at(from);
    let start = grid.at(Point::new(start.0, start.1.max(f64::MIN_POSITIVE)));
    start.into_iter().for_each(&mut visit);
    let rows = grid.height - 1 - high_y as usize..=grid.height - 1 - low_y as usize;
    for row in rows {
        for column in low_x as usize..=high_x as usize {
            let pixel = grid.index(column, row);
            if Some(pixel) != start && distance_to_segment(grid.centre(pixel), from, to) <= radius {
                visit(pixel);
            }
        }
    }
}

fn distance_to_segment(p: Point, from: Point, to: Point) -> f64 {
    let along = to - from;
    let t = if along.norm_sq() > 0.0 { ((p - from).dot(along) / along.norm_sq()).clamp(0.0, 1.0) } else { 0.0 };
    p.distance(from + along * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stroke(mark: Mark, points: &[(f64, f64)], width: f64) -> Stroke {
        Stroke { mark, points: points.iter().map(|&(x, y)| Point::new(x, y)).collect(), width }
    }

    #[test]
    fn a_stroke_marks_the_pixels_under_it_and_a_dot_its_own_pixel() {
        let grid = Grid::new(20, 10, 1.0);
        let strokes =
            vec![stroke(Mark::Animal, &[(2.5, 5.5), (12.5, 5.5)], 3.0), stroke(Mark::Ground, &[(20.0, 0.0)], 1.0)];
        let marks = rasterise(&Scribbles::Strokes(strokes), grid, &Run::silent()).unwrap();
        let animals: Vec<usize> = (0..grid.len()).filter(|&i| marks[i] == Mark::Animal).collect();
        assert_eq!(animals.len(), 3 * (11 + 2));
        assert!(animals.iter().all(|&i| (3..=5).contains(&grid.cell(i).row)));
        assert_eq!(marks[grid.index(19, 9)], Mark::Ground);
        assert_eq!(marks.iter().filter(|m| **m == Mark::Ground).count(), 1);
    }

    #[test]
    fn crossing_strokes_contradict_each_other_where_they_cross() {
        let grid = Grid::new(20, 20, 1.0);
        let strokes = vec![
            stroke(Mark::Animal, &[(1.5, 10.5), (18.5, 10.5)], 1.0),
            stroke(Mark::Ground, &[(7.5, 1.5), (7.5, 18.5)], 1.0),
        ];
        let error = rasterise(&Scribbles::Strokes(strokes), grid, &Run::silent()).unwrap_err();
        assert_eq!(error, ExtractionError::Contradiction { count: 1, column: 7, row: 9 });
    }
}
