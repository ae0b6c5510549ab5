//! Fitness, plants and why some grow nowhere.

use crate::codec::binary;
use crate::codec::binary::Reader;
use crate::codec::binary::Writer;
use crate::compute::ecosystem::fitness::Fitness;
use crate::compute::ecosystem::fitness::Met;
use crate::compute::ecosystem::flora::Absence;
use crate::compute::ecosystem::flora::Crowded;
use crate::compute::ecosystem::flora::Flora;
use crate::compute::ecosystem::flora::Painted;
use crate::compute::ecosystem::flora::Reached;
use crate::compute::ecosystem::flora::Shortfall;
use crate::compute::ecosystem::flora::Total;
use crate::jobs::ecosystem::chain::Grown;
use crate::jobs::ecosystem::stored::Stored;
use crate::jobs::ecosystem::stored::read_f32;
use crate::jobs::ecosystem::stored::read_indices;
use crate::jobs::ecosystem::stored::read_u8;
use crate::jobs::ecosystem::stored::read_u16;
use crate::jobs::ecosystem::stored::write_all;
use crate::jobs::ecosystem::stored::write_f32;
use crate::jobs::ecosystem::stored::write_indices;
use crate::jobs::ecosystem::stored::write_u8;
use crate::jobs::ecosystem::stored::write_u16;

fn write_met(w: &mut Writer, m: &Met) {
    w.u64(m.illumination)
        .u64(m.temperature)
        .u64(m.moisture)
        .u64(m.texture)
        .u64(m.soil)
        .u64(m.survival)
        .u64(m.tree_line)
        .u64(m.all);
}

fn read_met(r: &mut Reader<'_>) -> Result<Met, binary::Error> {
    Ok(Met {
        illumination: r.u64()?,
        temperature: r.u64()?,
        moisture: r.u64()?,
        texture: r.u64()?,
        soil: r.u64()?,
        survival: r.u64()?,
        tree_line: r.u64()?,
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
        Absence::TreeLine => w.u8(10),
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
        10 => Absence::TreeLine,
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

fn write_flora(w: &mut Writer, flora: &Flora) {
    write_all(w, &flora.covers, write_u16);
    write_f32(w, &flora.left_light);
    write_f32(w, &flora.left_moisture);
    write_all(w, &flora.totals, write_total);
    w.bool(flora.reached.is_some());
    if let Some(reached) = &flora.reached {
        write_reached(w, reached);
    }
}

fn read_flora(r: &mut Reader<'_>) -> Result<Flora, binary::Error> {
    Ok(Flora {
        covers: r.list(read_u16)?,
        left_light: read_f32(r)?,
        left_moisture: read_f32(r)?,
        totals: r.list(read_total)?,
        reached: r.option(read_reached)?,
    })
}

fn write_painted(w: &mut Writer, (species, painted): &(usize, Painted)) {
    w.u64(*species as u64).f64(painted.lowered_m2).f64(painted.raised_m2);
    w.option(painted.shortfall.as_ref(), |w, s| w.u64(s.cells).f64(s.area_m2).u64(s.worst_cell as u64).f32(s.worst));
}

fn read_painted(r: &mut Reader<'_>) -> Result<(usize, Painted), binary::Error> {
    let species = r.u64()? as usize;
    let (lowered_m2, raised_m2) = (r.f64()?, r.f64()?);
    let shortfall = r.option(|r| {
        Ok(Shortfall { cells: r.u64()?, area_m2: r.f64()?, worst_cell: r.u64()? as usize, worst: r.f32()? })
    })?;
    Ok((species, Painted { lowered_m2, raised_m2, shortfall }))
}

impl Stored for Grown {
    const KIND: [u8; 4] = *b"EFLO";

    fn write(&self, w: &mut Writer) {
        write_flora(w, &self.flora);
        write_all(w, &self.painted, write_painted);
    }

    fn read(r: &mut Reader<'_>) -> Result<Self, binary::Error> {
        Ok(Self { flora: read_flora(r)?, painted: r.list(read_painted)? })
    }
}
