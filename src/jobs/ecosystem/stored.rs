//! The stored form of what each stage hands on, so that a solve that repeats a stage reads it
//! instead. Writer and reader of a type stand side by side.

use bytes::Bytes;

use crate::codec::binary;
use crate::codec::binary::Reader;
use crate::codec::binary::Writer;
use crate::compute::ecosystem::fitness::Fitness;
use crate::compute::ecosystem::fitness::Met;
use crate::compute::ecosystem::flora::Absence;
use crate::compute::ecosystem::flora::Crowded;
use crate::compute::ecosystem::flora::Flora;
use crate::compute::ecosystem::flora::Reached;
use crate::compute::ecosystem::flora::Total;
use crate::compute::ecosystem::resources::MONTHS;
use crate::compute::ecosystem::resources::MonthlyMap;
use crate::compute::ecosystem::resources::Resources;
use crate::compute::ecosystem::water::Water;
use crate::compute::geometry::Point;
use crate::compute::raster::Grid;
use crate::compute::raster::Raster;
use crate::jobs::Failure;
use crate::jobs::JobContext;
use crate::jobs::Stage;

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

/// The result of a stage: the stored one when it has run before, otherwise that of `work`, which
/// is then stored. Work that is done is not read back.
pub fn stage<T: Stored>(
    context: &JobContext<'_>,
    stage: Stage,
    work: impl FnOnce() -> Result<T, Failure>,
) -> Result<T, Failure> {
    let mut fresh = None;
    let bytes = context.memo(stage, || {
        let value = work()?;
        let mut w = Writer::new(T::KIND, VERSION);
        value.write(&mut w);
        fresh = Some(value);
        Ok(Bytes::from(w.finish()))
    })?;
    match fresh {
        Some(value) => Ok(value),
        None => decode(&bytes).map_err(Failure::fault),
    }
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
}

/// A list whose items write themselves by a function of no return value.
fn write_all<T>(w: &mut Writer, items: &[T], mut write: impl FnMut(&mut Writer, &T)) {
    w.u64(items.len() as u64);
    items.iter().for_each(|item| write(w, item));
}

fn write_monthly(w: &mut Writer, map: &MonthlyMap) {
    match map {
        MonthlyMap::Shifted { base, offset } => {
            w.u8(0).f32s(offset);
            write_f32(w, base);
        }
        MonthlyMap::Maps(maps) => {
            w.u8(1);
            write_all(w, maps, write_f32);
        }
    }
}

fn read_monthly(r: &mut Reader<'_>) -> Result<MonthlyMap, binary::Error> {
    const MONTHLY: binary::Error = binary::Error::Corrupt("a monthly map does not have twelve months");
    match r.u8()? {
        0 => {
            let offset: [f32; MONTHS] = r.f32s()?.try_into().map_err(|_| MONTHLY)?;
            Ok(MonthlyMap::Shifted { base: read_f32(r)?, offset })
        }
        1 => {
            let maps = r.list(read_f32)?;
            if maps.len() == MONTHS { Ok(MonthlyMap::Maps(maps)) } else { Err(MONTHLY) }
        }
        _ => Err(binary::Error::Corrupt("an unknown kind of monthly map")),
    }
}

impl Stored for Water {
    const KIND: [u8; 4] = *b"EWAT";

    fn write(&self, w: &mut Writer) {
        for map in [&self.depth_m, &self.stream_width_m, &self.drainage_m2, &self.above_water_m] {
            write_f32(w, map);
        }
    }

    fn read(r: &mut Reader<'_>) -> Result<Self, binary::Error> {
        Ok(Self {
            depth_m: read_f32(r)?,
            stream_width_m: read_f32(r)?,
            drainage_m2: read_f32(r)?,
            above_water_m: read_f32(r)?,
        })
    }
}

impl Stored for Resources {
    const KIND: [u8; 4] = *b"ERES";

    fn write(&self, w: &mut Writer) {
        for map in [&self.temperature_min_c, &self.temperature_max_c, &self.sunlight, &self.moisture] {
            write_monthly(w, map);
        }
        write_f32(w, &self.texture);
        write_u8(w, &self.soil);
    }

    fn read(r: &mut Reader<'_>) -> Result<Self, binary::Error> {
        Ok(Self {
            temperature_min_c: read_monthly(r)?,
            temperature_max_c: read_monthly(r)?,
            sunlight: read_monthly(r)?,
            moisture: read_monthly(r)?,
            texture: read_f32(r)?,
            soil: read_u8(r)?,
        })
    }
}

fn write_met(w: &mut Writer, m: &Met) {
    w.u64(m.illumination).u64(m.temperature).u64(m.moisture).u64(m.texture).u64(m.soil).u64(m.survival).u64(m.all);
}

fn read_met(r: &mut Reader<'_>) -> Result<Met, binary::Error> {
    Ok(Met {
        illumination: r.u64()?,
        temperature: r.u64()?,
        moisture: r.u64()?,
        texture: r.u64()?,
        soil: r.u64()?,
        survival: r.u64()?,
        all: r.u64()?,
    })
}

impl Stored for Fitness {
    const KIND: [u8; 4] = *b"EFIT";

    fn write(&self, w: &mut Writer) {
        write_all(w, &self.levels, write_u8);
        write_all(w, &self.met, write_met);
    }

    fn read(r: &mut Reader<'_>) -> Result<Self, binary::Error> {
        Ok(Self { levels: r.list(read_u8)?, met: r.list(read_met)? })
    }
}

fn write_absence(w: &mut Writer, absence: &Absence) {
    match absence {
        Absence::NotAsked => w.u8(0),
        Absence::Soil => w.u8(1),
        Absence::Texture => w.u8(2),
        Absence::Temperature => w.u8(3),
        Absence::Winter => w.u8(4),
        Absence::Moisture => w.u8(5),
        Absence::Illumination => w.u8(6),
        Absence::KeptOut => w.u8(7),
        Absence::NeverTogether(met) => {
            w.u8(8);
            write_met(w, met);
            w
        }
        Absence::Outcompeted(c) => w.u8(9).u64(c.dark).u64(c.shaded).u64(c.full).u64(c.dry).u64(c.free),
    };
}

fn read_absence(r: &mut Reader<'_>) -> Result<Absence, binary::Error> {
    Ok(match r.u8()? {
        0 => Absence::NotAsked,
        1 => Absence::Soil,
        2 => Absence::Texture,
        3 => Absence::Temperature,
        4 => Absence::Winter,
        5 => Absence::Moisture,
        6 => Absence::Illumination,
        7 => Absence::KeptOut,
        8 => Absence::NeverTogether(read_met(r)?),
        9 => Absence::Outcompeted(Crowded {
            dark: r.u64()?,
            shaded: r.u64()?,
            full: r.u64()?,
            dry: r.u64()?,
            free: r.u64()?,
        }),
        _ => return Err(binary::Error::Corrupt("an unknown reason of absence")),
    })
}

fn write_total(w: &mut Writer, total: &Total) {
    w.f64(total.cover_m2).u64(total.cells).bool(total.why_empty.is_some());
    if let Some(absence) = &total.why_empty {
        write_absence(w, absence);
    }
}

fn read_total(r: &mut Reader<'_>) -> Result<Total, binary::Error> {
    Ok(Total { cover_m2: r.f64()?, cells: r.u64()?, why_empty: r.option(read_absence)? })
}

fn write_indices(w: &mut Writer, indices: &[usize]) {
    w.u64s(&indices.iter().map(|i| *i as u64).collect::<Vec<_>>());
}

fn read_indices(r: &mut Reader<'_>) -> Result<Vec<usize>, binary::Error> {
    Ok(r.u64s()?.into_iter().map(|i| i as usize).collect())
}

fn write_reached(w: &mut Writer, reached: &Reached) {
    w.f64s(&reached.asked).f64s(&reached.reached).f64(reached.distance).bool(reached.held_back);
    write_indices(w, &reached.left_out);
    write_indices(w, &reached.out_of_room);
}

fn read_reached(r: &mut Reader<'_>) -> Result<Reached, binary::Error> {
    Ok(Reached {
        asked: r.f64s()?,
        reached: r.f64s()?,
        distance: r.f64()?,
        held_back: r.bool()?,
        left_out: read_indices(r)?,
        out_of_room: read_indices(r)?,
    })
}

impl Stored for Flora {
    const KIND: [u8; 4] = *b"EFLO";

    fn write(&self, w: &mut Writer) {
        write_all(w, &self.covers, write_u16);
        write_f32(w, &self.left_light);
        write_f32(w, &self.left_moisture);
        write_all(w, &self.totals, write_total);
        w.bool(self.reached.is_some());
        if let Some(reached) = &self.reached {
            write_reached(w, reached);
        }
    }

    fn read(r: &mut Reader<'_>) -> Result<Self, binary::Error> {
        Ok(Self {
            covers: r.list(read_u16)?,
            left_light: read_f32(r)?,
            left_moisture: read_f32(r)?,
            totals: r.list(read_total)?,
            reached: r.option(read_reached)?,
        })
    }
}
