//! Water and resource maps.

use crate::codec::binary;
use crate::codec::binary::Reader;
use crate::codec::binary::Writer;
use crate::compute::ecosystem::resources::MONTHS;
use crate::compute::ecosystem::resources::MonthlyMap;
use crate::compute::ecosystem::resources::Resources;
use crate::compute::ecosystem::water::Water;
use crate::jobs::ecosystem::stored::Stored;
use crate::jobs::ecosystem::stored::read_f32;
use crate::jobs::ecosystem::stored::read_u8;
use crate::jobs::ecosystem::stored::write_all;
use crate::jobs::ecosystem::stored::write_f32;
use crate::jobs::ecosystem::stored::write_u8;

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
