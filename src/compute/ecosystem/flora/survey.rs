//! What grows in all, what it leaves of light and moisture, and why some species are absent.

use crate::compute::ecosystem::fitness::Fitness;
use crate::compute::ecosystem::flora::Flora;
use crate::compute::ecosystem::flora::Total;
use crate::compute::ecosystem::flora::explain;
use crate::compute::ecosystem::flora::rule::FULL_COVER;
use crate::compute::ecosystem::flora::rule::Rule;
use crate::compute::ecosystem::flora::sites::Sites;
use crate::compute::ecosystem::flora::stand::Stand;
use crate::compute::ecosystem::flora::targets::Reached;
use crate::compute::ecosystem::slabs;
use crate::compute::ecosystem::slabs::Slab;
use crate::compute::ecosystem::species::Stratum;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;

/// The flora that these covers make.
pub(super) fn flora(
    run: &Run,
    rules: &[Rule],
    sites: &Sites,
    fitness: &Fitness,
    (covers, reached): (Vec<Raster<u16>>, Option<Reached>),
) -> Result<Flora, Stopped> {
    let (left_light, left_moisture) = left(run, rules, sites, &covers)?;
    let mut totals = Vec::with_capacity(rules.len());
    for (species, map) in covers.iter().enumerate() {
        run.check()?;
        let (area, cells) = sums(map);
        let cover_m2 = area as f64 / f64::from(FULL_COVER) * map.grid.cell_area_m2();
        totals.push(Total { cover_m2, cells, why_empty: None });
        if cells == 0 {
            let excluded = reached.as_ref().is_some_and(|r| r.asked[species] <= 0.0);
            let why = if excluded {
                explain::Absence::NotAsked
            } else {
                explain::absence(rules, sites, fitness, (&covers, species))
            };
            totals[species].why_empty = Some(why);
        }
    }
    Ok(Flora { covers, left_light, left_moisture, totals, reached })
}

/// Light at the ground and moisture not drawn.
fn left(
    run: &Run,
    rules: &[Rule],
    sites: &Sites,
    covers: &[Raster<u16>],
) -> Result<(Raster<f32>, Raster<f32>), Stopped> {
    let (mut light, mut moisture) = (sites.light.clone(), sites.moisture.clone());
    let slabs = slabs::cut([light.data.as_mut_slice(), moisture.data.as_mut_slice()], light.grid.len());
    slabs::each(run, "plants.left", slabs, |slab: Slab<f32>| {
        let mut cover = vec![0; rules.len()];
        let [light, moisture] = slab.maps.try_into().ok()?;
        for (i, cell) in slab.cells.enumerate() {
            gather(covers, cell, &mut cover);
            let stand = Stand::new(rules, sites.at(cell), &mut cover);
            light[i] = stand.light(Stratum::Herb);
            moisture[i] = if moisture[i].is_nan() { f32::NAN } else { stand.moisture_left() };
        }
        Some(())
    })?;
    Ok((light, moisture))
}

/// The covers of all species in one cell.
pub(super) fn gather(covers: &[Raster<u16>], cell: usize, cover: &mut [u16]) {
    cover.iter_mut().zip(covers).for_each(|(c, map)| *c = map.data[cell]);
}

fn sums(map: &Raster<u16>) -> (u64, u64) {
    map.data.iter().fold((0, 0), |(area, cells), c| (area + u64::from(*c), cells + u64::from(*c > 0)))
}
