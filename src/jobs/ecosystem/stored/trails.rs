//! Trails and the paths along them.

use crate::codec::binary;
use crate::codec::binary::Reader;
use crate::codec::binary::Writer;
use crate::compute::ecosystem::paths::Path;
use crate::compute::ecosystem::paths::Paths;
use crate::compute::ecosystem::trails::Stretch;
use crate::compute::ecosystem::trails::Trail;
use crate::compute::ecosystem::trails::Trails;
use crate::jobs::ecosystem::stored::Stored;
use crate::jobs::ecosystem::stored::read_f32;
use crate::jobs::ecosystem::stored::read_points;
use crate::jobs::ecosystem::stored::write_all;
use crate::jobs::ecosystem::stored::write_f32;
use crate::jobs::ecosystem::stored::write_points;

fn write_stretch(w: &mut Writer, s: &Stretch) {
    w.u64(*s.points.start() as u64).u64(*s.points.end() as u64);
    w.f64(s.kg_per_year).f64(s.width_m).f64(s.depth_m);
    w.list(&s.species, |w, (species, share)| w.u64(*species as u64).f64(*share));
}

fn read_stretch(r: &mut Reader<'_>) -> Result<Stretch, binary::Error> {
    let points = r.u64()? as usize..=r.u64()? as usize;
    let (kg_per_year, width_m, depth_m) = (r.f64()?, r.f64()?, r.f64()?);
    let species = r.list(|r| Ok((r.u64()? as usize, r.f64()?)))?;
    Ok(Stretch { points, kg_per_year, species, width_m, depth_m })
}

impl Stored for Trails {
    const KIND: [u8; 4] = *b"ETRA";

    fn write(&self, w: &mut Writer) {
        write_all(w, &self.lines, |w, trail| {
            write_points(w, &trail.points);
            write_all(w, &trail.stretches, write_stretch);
        });
        for map in [&self.usage, &self.worn, &self.carving_m] {
            write_f32(w, map);
        }
        w.list(self.paths.list(), |w, path| w.u64(path.species as u64).f64(path.seconds).u32s(&path.cells));
        w.f64(self.kept_share).u64(self.without_way as u64);
    }

    fn read(r: &mut Reader<'_>) -> Result<Self, binary::Error> {
        let lines = r.list(|r| Ok(Trail { points: read_points(r)?, stretches: r.list(read_stretch)? }))?;
        let (usage, worn, carving_m) = (read_f32(r)?, read_f32(r)?, read_f32(r)?);
        let path = |r: &mut Reader<'_>| Ok(Path { species: r.u64()? as usize, seconds: r.f64()?, cells: r.u32s()? });
        let paths = Paths::new(r.list(path)?);
        Ok(Self { lines, usage, worn, carving_m, paths, kept_share: r.f64()?, without_way: r.u64()? as usize })
    }
}
