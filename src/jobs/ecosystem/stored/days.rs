//! Plannings and tracks.

use crate::codec::binary;
use crate::codec::binary::Reader;
use crate::codec::binary::Writer;
use crate::compute::ecosystem::planning;
use crate::compute::ecosystem::planning::Activity;
use crate::compute::ecosystem::planning::Cause;
use crate::compute::ecosystem::planning::Herd;
use crate::compute::ecosystem::planning::Planning;
use crate::compute::ecosystem::planning::Plannings;
use crate::compute::ecosystem::planning::Reason;
use crate::compute::ecosystem::planning::Track;
use crate::compute::ecosystem::planning::Visit;
use crate::jobs::ecosystem::chain::Days;
use crate::jobs::ecosystem::stored::Stored;
use crate::jobs::ecosystem::stored::read_points;
use crate::jobs::ecosystem::stored::write_all;
use crate::jobs::ecosystem::stored::write_points;

const ACTIVITIES: [Activity; 6] =
    [Activity::Drink, Activity::Feed, Activity::Hunt, Activity::Rest, Activity::Wait, Activity::Pass];

const CAUSES: [Cause; 6] = [Cause::NoWay, Cause::TooFar, Cause::TooSmall, Cause::NoRoom, Cause::NoTime, Cause::NoPrey];

fn write_activity(w: &mut Writer, activity: Activity) {
    w.u8(ACTIVITIES.iter().position(|a| *a == activity).unwrap_or(0) as u8);
}

fn read_activity(r: &mut Reader<'_>) -> Result<Activity, binary::Error> {
    let code = usize::from(r.u8()?);
    ACTIVITIES.get(code).copied().ok_or(binary::Error::Corrupt("an unknown activity"))
}

fn write_herd(w: &mut Writer, h: &Herd) {
    w.u64(h.species as u64).u64(h.territory as u64).u64(h.region as u64).u64(h.number as u64).u32(h.size);
}

fn read_herd(r: &mut Reader<'_>) -> Result<Herd, binary::Error> {
    let (species, territory) = (r.u64()? as usize, r.u64()? as usize);
    let (region, number) = (r.u64()? as usize, r.u64()? as usize);
    Ok(Herd { species, territory, region, number, size: r.u32()? })
}

fn write_visit(w: &mut Writer, v: &Visit) {
    w.u64(v.node as u64).u64(v.cell as u64).f64(v.arrive_s).f64(v.leave_s);
    write_activity(w, v.activity);
    w.option(v.prey.as_ref(), |w, prey| w.u64(*prey as u64));
}

fn read_visit(r: &mut Reader<'_>) -> Result<Visit, binary::Error> {
    let (node, cell) = (r.u64()? as usize, r.u64()? as usize);
    let (arrive_s, leave_s) = (r.f64()?, r.f64()?);
    let activity = read_activity(r)?;
    Ok(Visit { node, cell, arrive_s, leave_s, activity, prey: r.option(|r| Ok(r.u64()? as usize))? })
}

fn write_reason(w: &mut Writer, reason: &Reason) {
    match reason {
        Reason::Crowded(seconds) => {
            w.u8(0).f64(*seconds);
        }
        Reason::NoRoomToRest => {
            w.u8(1);
        }
        Reason::Missed(activity, cause) => {
            w.u8(2);
            write_activity(w, *activity);
            w.u8(CAUSES.iter().position(|c| c == cause).unwrap_or(0) as u8);
        }
        Reason::PreyOutOfReach(seconds) => {
            w.u8(3).f64(*seconds);
        }
    }
}

fn read_reason(r: &mut Reader<'_>) -> Result<Reason, binary::Error> {
    match r.u8()? {
        0 => Ok(Reason::Crowded(r.f64()?)),
        1 => Ok(Reason::NoRoomToRest),
        2 => {
            let (activity, cause) = (read_activity(r)?, usize::from(r.u8()?));
            let cause = CAUSES.get(cause).copied().ok_or(binary::Error::Corrupt("an unknown cause"))?;
            Ok(Reason::Missed(activity, cause))
        }
        3 => Ok(Reason::PreyOutOfReach(r.f64()?)),
        _ => Err(binary::Error::Corrupt("an unknown reason")),
    }
}

impl Stored for Days {
    const KIND: [u8; 4] = *b"EDAY";

    fn write(&self, w: &mut Writer) {
        let Plannings { herds, days, warnings } = &self.plannings;
        write_all(w, herds, write_herd);
        write_all(w, days, |w, day| write_all(w, &day.visits, write_visit));
        write_all(w, warnings, |w, warning| {
            w.u64(warning.herd as u64);
            write_reason(w, &warning.reason);
        });
        write_all(w, &self.tracks, |w, track| {
            w.u64(track.herd as u64).f64(track.from_s).f64(track.step_s).f32s(&track.heights_m);
            write_points(w, &track.places);
        });
        w.list(&self.conflicts, |w, (herd, sentence)| w.u64(*herd as u64).string(sentence));
    }

    fn read(r: &mut Reader<'_>) -> Result<Self, binary::Error> {
        let herds = r.list(read_herd)?;
        let days = r.list(|r| Ok(Planning { visits: r.list(read_visit)? }))?;
        let warnings = r.list(|r| Ok(planning::Warning { herd: r.u64()? as usize, reason: read_reason(r)? }))?;
        let tracks = r.list(|r| {
            let (herd, from_s, step_s, heights_m) = (r.u64()? as usize, r.f64()?, r.f64()?, r.f32s()?);
            Ok(Track { herd, from_s, step_s, heights_m, places: read_points(r)? })
        })?;
        let conflicts = r.list(|r| Ok((r.u64()? as usize, r.string()?)))?;
        Ok(Self { plannings: Plannings { herds, days, warnings }, tracks, conflicts })
    }
}
