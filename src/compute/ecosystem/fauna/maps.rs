use super::populate::Population;
use super::stocks::Stock;
use crate::compute::ecosystem::rag::PlantGrowth;
use crate::compute::ecosystem::regions::NOWHERE;
use crate::compute::ecosystem::regions::Regions;
use crate::compute::ecosystem::species::Food;
use crate::compute::raster::Raster;
use rayon::prelude::*;

/// The **density map** of an animal (L 4.4): individuals per m², the same all over each of its
/// confinement regions; 0 elsewhere.
pub fn density_per_m2(population: &Population, regions: &Regions, species: usize) -> Raster<f32> {
    let mut of_part = vec![0.0; regions.parts()];
    for (part, density) in of_part.iter_mut().enumerate() {
        if let Some(region) = regions.region_of_part(species, part) {
            let individuals = population.individuals(species, region) as f64;
            *density = (individuals / regions.area_m2(species, region)) as f32;
        }
    }
    by_part(regions, &of_part)
}

/// The **surplus map** of a plant: the growth that no animal eats, kg of dry matter a year per
/// cell. `growth` must be the one the animals were settled with.
pub fn surplus_of_plant(
    population: &Population,
    regions: &Regions,
    growth: &dyn PlantGrowth,
    plant: usize,
) -> Raster<f32> {
    let grid = regions.grid();
    let mut map = Raster::filled(grid, 0.0f32);
    let shares = population.stocks.of(Food::Plant(plant)).map(|stock| shares_of(stock, regions)).unwrap_or_default();
    map.data.par_chunks_mut(grid.width).enumerate().for_each(|(row, kg)| {
        growth.row(plant, row, kg);
        for (kg, part) in kg.iter_mut().zip(&regions.part.data[row * grid.width..]) {
            *kg *= shares.get(*part as usize).copied().unwrap_or(1.0);
        }
    });
    map
}

/// The **surplus map** of an animal: the mass of its young that no other animal eats, kg a year
/// per cell.
pub fn surplus_of_animal(population: &Population, regions: &Regions, species: usize) -> Raster<f32> {
    let Some(stock) = population.stocks.of(Food::Animal(species)) else { return Raster::filled(regions.grid(), 0.0) };
    let left = |part: usize| stock.growth_kg[part] * stock.surplus_share(part) / f64::from(regions.part_cells[part]);
    by_part(regions, &(0..regions.parts()).map(|part| left(part) as f32).collect::<Vec<f32>>())
}

fn shares_of(stock: &Stock, regions: &Regions) -> Vec<f32> {
    (0..regions.parts()).map(|part| stock.surplus_share(part) as f32).collect()
}

fn by_part(regions: &Regions, of_part: &[f32]) -> Raster<f32> {
    let value = |part: &u32| if *part == NOWHERE { 0.0 } else { of_part[*part as usize] };
    Raster { grid: regions.grid(), data: regions.part.data.par_iter().map(value).collect() }
}
