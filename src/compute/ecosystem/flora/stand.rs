//! The plants of one cell: what they take, what they leave, and which give way.

use crate::compute::ecosystem::flora::rule;
use crate::compute::ecosystem::flora::rule::FULL_COVER;
use crate::compute::ecosystem::flora::rule::Rule;
use crate::compute::ecosystem::flora::rule::WHOLE_CELL_USE;
use crate::compute::ecosystem::flora::rule::moisture_parts;
use crate::compute::ecosystem::flora::rule::moisture_scale_units;
use crate::compute::ecosystem::scales::Scale;
use crate::compute::ecosystem::species::Stratum;

/// Share of the light that a closed stratum keeps from the strata below it.
const SHADE: f32 = 0.8;

/// What a cell offers before anything grows there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Site<'a> {
    /// Physical light fraction, mean of the growing season.
    pub light: f32,
    /// Physical light fraction that can be used over the year, and its scale; `None` where light
    /// does not count.
    pub light_drawn: Option<(f32, &'a Scale)>,
    /// Moisture on the scale, mean of the year.
    pub moisture: f32,
    /// Cover that each stratum has room for: [`super::FULL_COVER`] but for what is kept bare.
    pub room: u16,
}

/// The plants of a cell, and the account of what they take.
pub(super) struct Stand<'a> {
    rules: &'a [Rule],
    site: Site<'a>,
    capacity: u64,
    /// Cover by species.
    cover: &'a mut [u16],
    /// Cover by stratum.
    taken: [u16; 3],
    /// Cover by stratum that its light bears.
    borne: [u16; 3],
    drawn: u64,
}

impl<'a> Stand<'a> {
    /// The stand of the plants with these covers, one a rule.
    pub(super) fn new(rules: &'a [Rule], site: Site<'a>, cover: &'a mut [u16]) -> Self {
        let (mut taken, mut drawn) = ([0; 3], 0);
        for (rule, cover) in rules.iter().zip(cover.iter()) {
            taken[rule.stratum as usize] += cover;
            drawn += rule.use_per_cover * u64::from(*cover);
        }
        let capacity = moisture_parts(site.moisture);
        let mut stand = Self { rules, site, capacity, cover, taken, borne: [FULL_COVER; 3], drawn };
        stand.light_from(Stratum::Tree);
        stand
    }

    /// The physical light fraction that reaches a stratum through the strictly taller ones.
    pub(super) fn light(&self, stratum: Stratum) -> f32 {
        self.through(self.site.light, stratum)
    }

    /// What is left of `light` below the strictly taller strata. One that covers all that its
    /// light bears is closed.
    fn through(&self, light: f32, stratum: Stratum) -> f32 {
        let taller = self.taken.iter().zip(&self.borne).take(stratum as usize);
        taller.filter(|(taken, _)| **taken > 0).fold(light, |light, (taken, borne)| {
            let closed = f32::from(*taken) / f32::from(*borne.max(taken));
            light * (1.0 - SHADE * closed)
        })
    }

    /// Works out anew what the light bears in `tallest` and the strata below.
    fn light_from(&mut self, tallest: Stratum) {
        let Some((light, scale)) = self.site.light_drawn else { return };
        for stratum in &Stratum::ALL[tallest as usize..] {
            let units = scale.at(f64::from(self.through(light, *stratum)));
            self.borne[*stratum as usize] = rule::cover((units / WHOLE_CELL_USE) as f32);
        }
    }

    /// Moisture not drawn, on the scale.
    pub(super) fn moisture_left(&self) -> f32 {
        moisture_scale_units(self.capacity.saturating_sub(self.drawn))
    }

    /// The physical light fraction below which a unit of a species dies.
    pub(super) fn least_light(&self, species: usize) -> f32 {
        self.rules[species].least_light
    }

    /// Whether a species would have the light it needs.
    pub(super) fn is_lit(&self, species: usize) -> bool {
        self.light(self.rules[species].stratum) >= self.least_light(species)
    }

    /// The room left in the stratum of a species: on the ground, and of the light.
    pub(super) fn room(&self, species: usize) -> u16 {
        let stratum = self.rules[species].stratum as usize;
        self.site.room.min(self.borne[stratum]).saturating_sub(self.taken[stratum])
    }

    /// The largest cover of a species that the moisture left can bear.
    pub(super) fn watered(&self, species: usize) -> u16 {
        let left = self.capacity.saturating_sub(self.drawn);
        let cover = left.checked_div(self.rules[species].use_per_cover).unwrap_or(u64::MAX);
        cover.min(u64::from(u16::MAX)) as u16
    }

    /// The largest cover of a species that can be added, units or not.
    pub(super) fn most(&self, species: usize) -> u16 {
        if self.is_lit(species) { self.room(species).min(self.watered(species)) } else { 0 }
    }

    /// The cover of as many whole units of a species as fit, at least one and, from the second
    /// on, within `about`; the last unit of a stratum is cut to the room left. 0: none fits.
    pub(super) fn units(&self, species: usize, about: u16) -> u16 {
        let unit = self.rules[species].unit;
        let room = self.room(species);
        if room == 0 || !self.is_lit(species) {
            return 0;
        }
        let watered = self.watered(species);
        let within = room.min(about.max(unit));
        if watered >= within && within == room {
            return room;
        }
        within.min(watered) / unit * unit
    }

    /// The cover of a species.
    pub(super) fn cover(&self, species: usize) -> u16 {
        self.cover[species]
    }

    /// Adds `cover` of a species, which must fit. Lower plants that lose the light they need give
    /// way and give back what they took, and where the light bears less than stands in a lower
    /// stratum its species thin out alike: says whether lower plants fared otherwise than before.
    pub(super) fn plant(&mut self, species: usize, cover: u16) -> bool {
        self.plant_telling(species, cover, |_, _| ())
    }

    /// Like [`Stand::plant`]; tells each species that gives way and the cover it loses.
    pub(super) fn plant_telling(&mut self, species: usize, cover: u16, mut tell: impl FnMut(usize, u16)) -> bool {
        self.change(species, self.cover[species] + cover);
        // Less light leaves less room below, and a last unit cut to that may need less moisture.
        let mut any = self.site.light_drawn.is_some() && self.rules[species].stratum != Stratum::Herb;
        for stratum in Stratum::ALL.into_iter().filter(|s| *s > self.rules[species].stratum) {
            any |= self.thin_out(stratum, Self::kept_when_lit, &mut tell);
            any |= self.thin_out(stratum, Self::kept_by_light, &mut tell);
        }
        any
    }

    /// Leaves of each species of a stratum what `kept` says; tells whether any lost something.
    fn thin_out(
        &mut self,
        stratum: Stratum,
        kept: impl Fn(&Self, usize, u16) -> u16,
        tell: &mut impl FnMut(usize, u16),
    ) -> bool {
        let stands = self.taken[stratum as usize];
        let mut any = false;
        for species in 0..if stands == 0 { 0 } else { self.rules.len() } {
            let cover = self.cover[species];
            if cover == 0 || self.rules[species].stratum != stratum {
                continue;
            }
            let lost = cover - kept(self, species, stands);
            if lost > 0 {
                self.change(species, cover - lost);
                tell(species, lost);
                any = true;
            }
        }
        any
    }

    fn kept_when_lit(&self, species: usize, _: u16) -> u16 {
        if self.is_lit(species) { self.cover[species] } else { 0 }
    }

    /// Its part of what the light bears of a stratum in which so much `stands`.
    fn kept_by_light(&self, species: usize, stands: u16) -> u16 {
        let (cover, borne) = (self.cover[species], self.borne[self.rules[species].stratum as usize]);
        if borne >= stands { cover } else { (u32::from(cover) * u32::from(borne) / u32::from(stands)) as u16 }
    }

    /// Takes `cover` of a species away.
    pub(super) fn remove(&mut self, species: usize, cover: u16) {
        self.change(species, self.cover[species].saturating_sub(cover));
    }

    fn change(&mut self, species: usize, cover: u16) {
        let (rule, old) = (&self.rules[species], self.cover[species]);
        let taken = &mut self.taken[rule.stratum as usize];
        *taken = *taken - old + cover;
        self.drawn = self.drawn - rule.use_per_cover * u64::from(old) + rule.use_per_cover * u64::from(cover);
        self.cover[species] = cover;
        if let Some(next) = Stratum::ALL.get(rule.stratum as usize + 1) {
            self.light_from(*next);
        }
    }
}
