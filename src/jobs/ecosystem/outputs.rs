//! The maps of land, climate and plants, each with its legend.

use crate::codec::colours;
use crate::codec::colours::ColourMap;
use crate::codec::map::Category;
use crate::codec::map::Georeference;
use crate::codec::map::Legend;
use crate::codec::map::Map;
use crate::codec::map::MapData;
use crate::codec::map::Spread;
use crate::compute::ecosystem::biomes;
use crate::compute::ecosystem::flora::Flora;
use crate::compute::ecosystem::resources::MONTHS;
use crate::compute::ecosystem::resources::MonthlyMap;
use crate::compute::ecosystem::resources::Resources;
use crate::compute::ecosystem::species::Soil;
use crate::compute::ecosystem::terrain::Terrain;
use crate::compute::ecosystem::water::Water;
use crate::compute::raster::Raster;
use crate::jobs::Artefact;
use crate::jobs::Failure;
use crate::jobs::JobContext;
use crate::jobs::ecosystem::request::Biomes;
use crate::jobs::ecosystem::request::Request;
use crate::jobs::ecosystem::species::slug;

/// Names of the months, for titles.
const MONTH_NAMES: [&str; MONTHS] = [
    "January",
    "February",
    "March",
    "April",
    "May",
    "June",
    "July",
    "August",
    "September",
    "October",
    "November",
    "December",
];

/// Puts maps that share a place.
pub struct Maps<'a, 'b> {
    /// Where they go.
    pub context: &'a mut JobContext<'b>,
    /// Where they lie.
    pub georeference: Georeference,
}

impl Maps<'_, '_> {
    /// Puts a map of quantities, made only when it is wanted.
    pub fn quantities(&mut self, id: &str, legend: Legend, map: impl FnOnce() -> Raster<f32>) -> Result<(), Failure> {
        self.put(id, legend, || MapData::F32(map()))
    }

    /// Puts a map of any values, made only when it is wanted.
    pub fn put(&mut self, id: &str, legend: Legend, data: impl FnOnce() -> MapData) -> Result<(), Failure> {
        self.context.run.check()?;
        if !self.context.wants(id) {
            return Ok(());
        }
        let map = Map { data: data(), legend, georeference: self.georeference.clone() };
        self.context.put(id, Artefact::Map(map))
    }

    /// Height, slope and water.
    pub fn land(&mut self, terrain: &Terrain, water: &Water) -> Result<(), Failure> {
        let height = Legend::continuous("Height", "m", ColourMap::Terrain);
        self.quantities("terrain.height", height, || terrain.height.clone())?;
        let slope = Legend::continuous("Slope", "rise over run", ColourMap::Viridis);
        self.quantities("terrain.slope", slope, || terrain.slope.clone())?;
        let depth = Legend::continuous("Depth of the water", "m", ColourMap::Water).with_spread(Spread::SquareRoot);
        self.quantities("terrain.water", depth, || water.depth_m.clone())
    }

    /// The monthly maps that are asked for, and the soil.
    pub fn climate(&mut self, resources: &Resources) -> Result<(), Failure> {
        let families: [(&str, &str, &str, ColourMap, &MonthlyMap); 4] = [
            ("temperature_min", "Mean daily minimum", "°C", ColourMap::Inferno, &resources.temperature_min_c),
            ("temperature_max", "Mean daily maximum", "°C", ColourMap::Inferno, &resources.temperature_max_c),
            ("sunlight", "Sunlight", "light fraction", ColourMap::Inferno, &resources.sunlight),
            ("moisture", "Moisture", "scale 1-9", ColourMap::Water, &resources.moisture),
        ];
        for (family, title, unit, colours, map) in families {
            for (month, name) in MONTH_NAMES.iter().enumerate() {
                let legend = Legend::continuous(format!("{title}, {name}"), unit, colours);
                self.quantities(&format!("climate.{family}.{:02}", month + 1), legend, || map.month(month))?;
            }
        }
        self.put("soil", Legend::categories("Soil", soil_categories()), || MapData::U8(resources.soil.clone()))
    }

    /// Cover of each plant and what is left of light and moisture.
    pub fn plants(&mut self, request: &Request, flora: &Flora) -> Result<(), Failure> {
        for (s, plant) in request.plants.species.iter().enumerate() {
            let legend = Legend::continuous(format!("Cover of {}", plant.name), "share of the cell", ColourMap::Green);
            let id = format!("plants.cover.{}", slug(&plant.name));
            self.quantities(&id, legend.with_range(0.0, 1.0), || flora.cover_map(s))?;
        }
        let light = Legend::continuous("Light that reaches the ground", "light fraction", ColourMap::Inferno);
        self.quantities("plants.left.light", light, || flora.left_light.clone())?;
        let moisture = Legend::continuous("Moisture that plants leave", "scale 1-9", ColourMap::Water);
        self.quantities("plants.left.moisture", moisture, || flora.left_moisture.clone())
    }
}

impl Maps<'_, '_> {
    /// The dominant biome, and the densest cells of each.
    pub fn biomes(&mut self, request: &Request, flora: &Flora) -> Result<(), Failure> {
        let Biomes { names, of } = &request.biomes;
        let legend = Legend::categories("Dominant biome", named_classes(names.iter().map(String::as_str)));
        self.put("plants.biome", legend, || {
            let none = |b: u8| if usize::from(b) < names.len() { b } else { MapData::NODATA_U8 };
            MapData::U8(biomes::dominant(flora, of).map(none))
        })?;
        for (i, name) in names.iter().enumerate() {
            let legend = Legend::continuous(format!("Densest cells of the biome {name}"), "weight", ColourMap::Green);
            self.quantities(&format!("plants.densest.{}", slug(name)), legend, || {
                biomes::densest(&biomes::density(flora, of, i), biomes::DENSEST_SHARE)
            })?;
        }
        Ok(())
    }
}

fn soil_categories() -> Vec<Category> {
    let label = |soil| match soil {
        Soil::Limestone => ("limestone", [225, 214, 178]),
        Soil::Water => ("water", [70, 120, 180]),
        Soil::Marl => ("marl", [170, 150, 110]),
        Soil::FallenRocks => ("fallen rocks", [120, 120, 120]),
        Soil::Alluvium => ("alluvium", [140, 170, 90]),
    };
    Soil::ALL
        .into_iter()
        .map(|soil| {
            let (label, colour) = label(soil);
            Category { value: soil as u32, label: label.to_owned(), colour }
        })
        .collect()
}

/// Classes numbered from 0 by the order of their names, in the palette's colours.
pub fn named_classes<'n>(names: impl IntoIterator<Item = &'n str>) -> Vec<Category> {
    let category =
        |(i, name): (usize, &str)| Category { value: i as u32, label: name.to_owned(), colour: colours::category(i) };
    names.into_iter().enumerate().map(category).collect()
}
