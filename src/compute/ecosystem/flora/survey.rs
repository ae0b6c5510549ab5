//! What grows in all, what it leaves of light and moisture, and why some species are absent.

use crate::compute::ecosystem::fitness::Fitness;
use crate::compute::ecosystem::flora::Flora;
use crate::compute::ecosystem::flora::Total;
use crate::compute::ecosystem::flora::explain;
use crate::compute::ecosystem::flora::rule::FULL_COVER;
use crate::compute::ecosystem::flora::rule::Rule;
use crate::compute::ecosystem::flora::sites::Offer;
use crate::compute::ecosystem::flora::sites::Sites;
use crate::compute::ecosystem::flora::stand::Site;
use crate::compute::ecosystem::flora::stand::Stand;
use crate::compute::ecosystem::flora::targets::Reached;
use crate::compute::ecosystem::slabs;
use crate::compute::ecosystem::slabs::Slab;
use crate::compute::ecosystem::species::Stratum;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;

/// The flora that these covers make.
pub(super) fn flora(
    run: &Run,
    rules: &[Rule],
    sites: &Sites,
    fitness: &Fitness,
    (covers, reached): (Vec<Raster<u16>>, Option<Reached>),
) -> Result<Flora, Stopped> {
    let mut left = (sites.light.clone(), sites.moisture.clone());
    leave(run, (rules, &|cell| sites.at(cell)), (&covers, |_| true), (&mut left.0, &mut left.1))?;
    let mut totals = totals(run, &covers)?;
    explain_empty(run, (rules, sites, fitness), (&covers, reached.as_ref()), &mut totals)?;
    Ok(Flora { covers, left_light: left.0, left_moisture: left.1, totals, reached })
}

/// The flora after its covers were changed in the cells that are `touched`. A species that grew
/// nowhere before keeps its reason.
pub(super) fn again(
    run: &Run,
    (rules, offer, fitness): (&[Rule], &Offer, &Fitness),
    flora: Flora,
    touched: impl Fn(usize) -> bool + Sync,
) -> Result<Flora, Stopped> {
    let Flora { covers, mut left_light, mut left_moisture, totals: before, reached } = flora;
    leave(run, (rules, &|cell| offer.at(cell)), (&covers, touched), (&mut left_light, &mut left_moisture))?;
    let mut totals = totals(run, &covers)?;
    for (now, before) in totals.iter_mut().zip(before).filter(|(now, _)| now.cells == 0) {
        now.why_empty = before.why_empty;
    }
    if totals.iter().any(|now| now.cells == 0 && now.why_empty.is_none()) {
        let sites = Sites::new(run, offer)?;
        explain_empty(run, (rules, &sites, fitness), (&covers, reached.as_ref()), &mut totals)?;
    }
    Ok(Flora { covers, left_light, left_moisture, totals, reached })
}

/// Sets the light at the ground and the moisture not drawn in the cells that are `touched`;
/// without data on moisture it stays so.
pub(super) fn leave<'s>(
    run: &Run,
    (rules, site): (&[Rule], &(impl Fn(usize) -> Site<'s> + Sync)),
    (covers, touched): (&[Raster<u16>], impl Fn(usize) -> bool + Sync),
    (light, moisture): (&mut Raster<f32>, &mut Raster<f32>),
) -> Result<(), Stopped> {
    let cells = light.grid.len();
    let slabs = slabs::cut([light.data.as_mut_slice(), moisture.data.as_mut_slice()], cells);
    slabs::each(run, "plants.left", slabs, |slab: Slab<f32>| {
        let mut cover = vec![0; rules.len()];
        let [light, moisture] = slab.maps.try_into().ok()?;
        for (i, cell) in slab.cells.enumerate().filter(|(_, cell)| touched(*cell)) {
            gather(covers, cell, &mut cover);
            let stand = Stand::new(rules, site(cell), &mut cover);
            light[i] = stand.light(Stratum::Herb);
            moisture[i] = if moisture[i].is_nan() { f32::NAN } else { stand.moisture_left() };
        }
        Some(())
    })?;
    Ok(())
}

/// What there is of each species, without reasons.
pub(super) fn totals(run: &Run, covers: &[Raster<u16>]) -> Result<Vec<Total>, Stopped> {
    covers
        .par_iter()
        .map(|map| {
            run.check()?;
            let (area, cells) = sums(map);
            let cover_m2 = area as f64 / f64::from(FULL_COVER) * map.grid.cell_area_m2();
            Ok(Total { cover_m2, cells, why_empty: None })
        })
        .collect()
}

/// Says why the species that cover nothing do so, where that is not known yet.
pub(super) fn explain_empty(
    run: &Run,
    (rules, sites, fitness): (&[Rule], &Sites, &Fitness),
    (covers, reached): (&[Raster<u16>], Option<&Reached>),
    totals: &mut [Total],
) -> Result<(), Stopped> {
    for (species, total) in totals.iter_mut().enumerate().filter(|(_, total)| total.cells == 0) {
        if reached.is_some_and(|r| r.asked[species] <= 0.0) {
            total.why_empty = Some(explain::Absence::NotAsked);
        }
    }
    let unexplained = |(_, total): &(usize, &Total)| total.cells == 0 && total.why_empty.is_none();
    let empty: Vec<usize> = totals.iter().enumerate().filter(unexplained).map(|(species, _)| species).collect();
    let why = explain::absences(run, (rules, sites, fitness), covers, &empty)?;
    empty.into_iter().zip(why).for_each(|(species, why)| totals[species].why_empty = Some(why));
    Ok(())
}

/// The covers of all species in one cell.
pub(super) fn gather(covers: &[Raster<u16>], cell: usize, cover: &mut [u16]) {
    cover.iter_mut().zip(covers).for_each(|(c, map)| *c = map.data[cell]);
}

fn sums(map: &Raster<u16>) -> (u64, u64) {
    map.data.iter().fold((0, 0), |(area, cells), c| (area + u64::from(*c), cells + u64::from(*c > 0)))
}
