use super::spread::Spread;
use crate::codec::binary;
use crate::codec::binary::Reader;
use crate::codec::binary::Writer;
use crate::codec::colours::ColourMap;
use crate::codec::colours::Rgb;

/// What the values of a map mean and how they are shown.
#[derive(Debug, Clone, PartialEq)]
pub struct Legend {
    /// What the map shows, for people: `Cover of Quercus ilex`.
    pub title: String,
    /// The unit, as people write it: `m`, `°C`, `individuals/km²`; empty for none.
    pub unit: String,
    /// From values to colours.
    pub scale: Scale,
}

/// From values to colours.
#[derive(Debug, Clone, PartialEq)]
pub enum Scale {
    /// A quantity.
    Continuous {
        /// The values at the two ends of the colour map; `None`: the map's own extremes.
        range: Option<(f64, f64)>,
        /// The colours.
        colours: ColourMap,
        /// How colours are spread between the ends.
        spread: Spread,
    },
    /// Named classes. Values that are not listed are drawn as no data.
    Categories(Vec<Category>),
    /// Numbered parts without names, such as regions: 0 is none, others take the colours of
    /// [`crate::codec::colours::category`] in turn.
    Labels,
}

/// One class of a categorical map.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Category {
    /// The value in the map.
    pub value: u32,
    /// Its name.
    pub label: String,
    /// Its colour.
    pub colour: Rgb,
}

impl Legend {
    /// A quantity shown over its own extremes.
    pub fn continuous(title: impl Into<String>, unit: impl Into<String>, colours: ColourMap) -> Self {
        let scale = Scale::Continuous { range: None, colours, spread: Spread::Linear };
        Self { title: title.into(), unit: unit.into(), scale }
    }

    /// The same, over a given range. Has no effect on classes.
    pub fn with_range(mut self, min: f64, max: f64) -> Self {
        if let Scale::Continuous { range, .. } = &mut self.scale {
            *range = Some((min, max));
        }
        self
    }

    /// The same, with another spread of the colours. Has no effect on classes.
    pub fn with_spread(mut self, new: Spread) -> Self {
        if let Scale::Continuous { spread, .. } = &mut self.scale {
            *spread = new;
        }
        self
    }

    /// Named classes.
    pub fn categories(title: impl Into<String>, categories: Vec<Category>) -> Self {
        Self { title: title.into(), unit: String::new(), scale: Scale::Categories(categories) }
    }

    /// Numbered parts.
    pub fn labels(title: impl Into<String>) -> Self {
        Self { title: title.into(), unit: String::new(), scale: Scale::Labels }
    }

    pub(super) fn write(&self, w: &mut Writer) {
        w.string(&self.title).string(&self.unit);
        match &self.scale {
            Scale::Continuous { range, colours, spread } => {
                w.u8(0).u8(colours.code()).u8(*spread as u8);
                w.option(range.as_ref(), |w, (min, max)| w.f64(*min).f64(*max));
            }
            Scale::Categories(categories) => {
                w.u8(1).list(categories, |w, c| {
                    let [red, green, blue] = c.colour;
                    w.u32(c.value).string(&c.label).u8(red).u8(green).u8(blue)
                });
            }
            Scale::Labels => {
                w.u8(2);
            }
        }
    }

    pub(super) fn read(r: &mut Reader) -> Result<Self, binary::Error> {
        let (title, unit) = (r.string()?, r.string()?);
        let scale =
            match r.u8()? {
                0 => Scale::Continuous {
                    colours: *ColourMap::ALL
                        .get(usize::from(r.u8()?))
                        .ok_or(binary::Error::Corrupt("an unknown colour map"))?,
                    spread: Spread::read(r)?,
                    range: r.option(|r| Ok((r.f64()?, r.f64()?)))?,
                },
                1 => Scale::Categories(r.list(|r| {
                    Ok(Category { value: r.u32()?, label: r.string()?, colour: [r.u8()?, r.u8()?, r.u8()?] })
                })?),
                2 => Scale::Labels,
                _ => return Err(binary::Error::Corrupt("an unknown kind of legend")),
            };
        Ok(Self { title, unit, scale })
    }
}
