//! The plants of one cell: what they take, what they leave, and which give way.

use crate::compute::ecosystem::flora::rule::Rule;
use crate::compute::ecosystem::flora::rule::moisture_parts;
use crate::compute::ecosystem::flora::rule::moisture_scale_units;
use crate::compute::ecosystem::flora::rule::share;
use crate::compute::ecosystem::species::Stratum;

/// Share of the light that a closed stratum keeps from the strata below it (ours).
const SHADE: f32 = 0.8;

/// What a cell offers before anything grows there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Site {
    /// Physical light fraction, mean of the growing season.
    pub light: f32,
    /// Moisture on the scale, mean of the year.
    pub moisture: f32,
    /// Cover that each stratum has room for: [`super::FULL_COVER`] but for what is kept bare.
    pub room: u16,
}

/// The plants of a cell, and the account of what they take.
pub(super) struct Stand<'a> {
    rules: &'a [Rule],
    site: Site,
    capacity: u64,
    /// Cover by species.
    cover: &'a mut [u16],
    /// Cover by stratum.
    taken: [u16; 3],
    drawn: u64,
}

impl<'a> Stand<'a> {
    /// The stand of the plants with these covers, one a rule.
    pub(super) fn new(rules: &'a [Rule], site: Site, cover: &'a mut [u16]) -> Self {
        let (mut taken, mut drawn) = ([0; 3], 0);
        for (rule, cover) in rules.iter().zip(cover.iter()) {
            taken[rule.stratum as usize] += cover;
            drawn += rule.use_per_cover * u64::from(*cover);
        }
        Self { rules, site, capacity: moisture_parts(site.moisture), cover, taken, drawn }
    }

    /// The physical light fraction that reaches a stratum through the strictly taller ones.
    pub(super) fn light(&self, stratum: Stratum) -> f32 {
        let taller = &self.taken[..stratum as usize];
        taller.iter().fold(self.site.light, |light, cover| light * (1.0 - SHADE * share(*cover)))
    }

    /// Moisture not drawn, on the scale.
    pub(super) fn moisture_left(&self) -> f32 {
        moisture_scale_units(self.capacity.saturating_sub(self.drawn))
    }

    /// Whether a species would have the light it needs.
    pub(super) fn is_lit(&self, species: usize) -> bool {
        let rule = &self.rules[species];
        self.light(rule.stratum) >= rule.least_light
    }

    /// The room left in the stratum of a species.
    pub(super) fn room(&self, species: usize) -> u16 {
        self.site.room.saturating_sub(self.taken[self.rules[species].stratum as usize])
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

    /// Adds `cover` of a species, which must fit. Units of lower strata that lose the light they
    /// need give way and give back what they took: says whether any did.
    pub(super) fn plant(&mut self, species: usize, cover: u16) -> bool {
        self.plant_telling(species, cover, |_, _| ())
    }

    /// Like [`Stand::plant`]; tells each species that gives way and the cover it loses.
    pub(super) fn plant_telling(&mut self, species: usize, cover: u16, mut tell: impl FnMut(usize, u16)) -> bool {
        self.change(species, self.cover[species] + cover);
        let stratum = self.rules[species].stratum;
        let mut any = false;
        for lower in 0..if stratum == Stratum::Herb { 0 } else { self.rules.len() } {
            let lost = self.cover[lower];
            if lost > 0 && self.rules[lower].stratum > stratum && !self.is_lit(lower) {
                self.change(lower, 0);
                tell(lower, lost);
                any = true;
            }
        }
        any
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
    }
}
