//! The stored form of what each stage hands on, so that a solve that repeats a stage reads it
//! instead. Writer and reader of a type stand side by side.

mod animals;
mod days;
mod land;
mod plants;
mod trails;

use crate::codec::binary;
use crate::codec::binary::Reader;
use crate::codec::binary::Writer;
use crate::compute::geometry::Point;
use crate::compute::raster::Grid;
use crate::compute::raster::Raster;
use crate::jobs::Failure;
use crate::jobs::JobContext;
use crate::jobs::Stage;
use bytes::Bytes;

/// Version of the whole stored form.
const VERSION: u16 = 1;

/// A value that has a stored form.
pub trait Stored: Sized {
    /// Four letters that name the kind.
    const KIND: [u8; 4];
    /// Writes it.
    fn write(&self, w: &mut Writer);
    /// Reads what [`Stored::write`] wrote.
    fn read(r: &mut Reader<'_>) -> Result<Self, binary::Error>;
}

/// The result of a stage: the stored one when it has run before and can be read, otherwise that of
/// `work`, which is then stored.
pub fn stage<T: Stored>(
    context: &JobContext<'_>,
    stage: Stage,
    work: impl FnOnce() -> Result<T, Failure>,
) -> Result<T, Failure> {
    match context.recall(stage)?.map(|bytes| decode(&bytes)) {
        Some(Ok(value)) => return Ok(value),
        Some(Err(error)) => {
            tracing::warn!(stage = stage.name, %error, "a stored stage cannot be read and is made again")
        }
        None => {}
    }
    context.run.check()?;
    let value = work()?;
    let mut w = Writer::for_run(T::KIND, VERSION, &context.run);
    value.write(&mut w);
    context.run.check()?;
    context.remember(stage, Bytes::from(w.finish()))?;
    Ok(value)
}

fn decode<T: Stored>(bytes: &[u8]) -> Result<T, binary::Error> {
    let mut r = Reader::new(bytes, T::KIND, VERSION)?;
    let value = T::read(&mut r)?;
    r.finish().map(|()| value)
}

fn write_grid(w: &mut Writer, grid: &Grid) {
    w.u32(grid.width as u32).u32(grid.height as u32).f64(grid.cell_m).f64(grid.origin.x).f64(grid.origin.y);
}

fn read_grid(r: &mut Reader<'_>) -> Result<Grid, binary::Error> {
    let (width, height) = (r.u32()? as usize, r.u32()? as usize);
    Ok(Grid { width, height, cell_m: r.f64()?, origin: Point::new(r.f64()?, r.f64()?) })
}

const UNFIT: binary::Error = binary::Error::Corrupt("a map does not fit its grid");

/// Rasters, by the type of their values.
macro_rules! rasters {
    ($($write:ident $read:ident $many:ident $number:ty;)*) => {$(
        fn $write(w: &mut Writer, raster: &Raster<$number>) {
            write_grid(w, &raster.grid);
            w.$many(&raster.data);
        }

        fn $read(r: &mut Reader<'_>) -> Result<Raster<$number>, binary::Error> {
            let grid = read_grid(r)?;
            Raster::from_data(grid, r.$many()?).ok_or(UNFIT)
        }
    )*};
}

rasters! {
    write_f32 read_f32 f32s f32;
    write_u8 read_u8 u8s u8;
    write_u16 read_u16 u16s u16;
    write_u32 read_u32 u32s u32;
}

/// A list whose items write themselves by a function of no return value.
fn write_all<T>(w: &mut Writer, items: &[T], mut write: impl FnMut(&mut Writer, &T)) {
    w.u64(items.len() as u64);
    items.iter().for_each(|item| write(w, item));
}

fn write_indices(w: &mut Writer, indices: &[usize]) {
    w.u64s(&indices.iter().map(|i| *i as u64).collect::<Vec<_>>());
}

fn read_indices(r: &mut Reader<'_>) -> Result<Vec<usize>, binary::Error> {
    Ok(r.u64s()?.into_iter().map(|i| i as usize).collect())
}

fn write_points(w: &mut Writer, points: &[Point]) {
    w.f64s(&points.iter().map(|p| p.x).collect::<Vec<_>>()).f64s(&points.iter().map(|p| p.y).collect::<Vec<_>>());
}

fn read_points(r: &mut Reader<'_>) -> Result<Vec<Point>, binary::Error> {
    let (x, y) = (r.f64s()?, r.f64s()?);
    if x.len() == y.len() {
        Ok(x.into_iter().zip(y).map(|(x, y)| Point::new(x, y)).collect())
    } else {
        Err(binary::Error::Corrupt("a line has more of one coordinate than of the other"))
    }
}
