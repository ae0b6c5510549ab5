use crate::compute::ecosystem::rag::PlantGrowth;
use crate::compute::ecosystem::regions::NOWHERE;
use crate::compute::ecosystem::regions::Regions;
use crate::compute::ecosystem::species::AnimalSpecies;
use crate::compute::ecosystem::species::Food;
use crate::compute::ecosystem::species::PlantSpecies;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;

/// What has grown of one food in each part of the partition, and what was eaten of it; kg a year.
#[derive(Debug, Clone, PartialEq)]
pub struct Stock {
    /// **Yearly growth** per part (L 3): dry matter of a plant, mass of the young of an animal.
    pub growth_kg: Vec<f64>,
    /// The share of the growth that may be eaten, 0..=1.
    pub offtake: f64,
    /// What was eaten per part.
    pub eaten_kg: Vec<f64>,
}

impl Stock {
    fn none(parts: usize, offtake: f64) -> Self {
        Self { growth_kg: vec![0.0; parts], offtake: offtake.clamp(0.0, 1.0), eaten_kg: vec![0.0; parts] }
    }

    /// What may still be eaten in a part.
    pub fn left_kg(&self, part: usize) -> f64 {
        (self.growth_kg[part] * self.offtake - self.eaten_kg[part]).max(0.0)
    }

    /// What may still be eaten per kg that grew in the part.
    pub fn left_share(&self, part: usize) -> f64 {
        if self.growth_kg[part] > 0.0 { self.left_kg(part) / self.growth_kg[part] } else { 0.0 }
    }

    /// The share of the growth in the part that nobody eats: the **surplus**.
    pub fn surplus_share(&self, part: usize) -> f64 {
        if self.growth_kg[part] > 0.0 { 1.0 - self.eaten_kg[part] / self.growth_kg[part] } else { 1.0 }
    }

    /// Notes that `kg` were eaten in `parts`, shared out by what is left there.
    pub(super) fn eat(&mut self, parts: &[u32], kg: f64) {
        let left: Vec<f64> = parts.iter().map(|part| self.left_kg(*part as usize)).collect();
        let sum: f64 = left.iter().sum();
        let share = if sum > 0.0 { (kg / sum).min(1.0) } else { 0.0 };
        parts.iter().zip(left).for_each(|(part, left)| self.eaten_kg[*part as usize] += left * share);
    }
}

/// The stocks of all foods: plants, then animals.
#[derive(Debug, Clone, PartialEq)]
pub struct Stocks {
    pub(crate) plants: Vec<Stock>,
    pub(crate) animals: Vec<Stock>,
}

impl Stocks {
    /// The growth of the plants that any of `animals` eats; that of the animals is still 0, and
    /// that of plants nobody eats is not counted.
    pub(super) fn new(
        regions: &Regions,
        plants: &[PlantSpecies],
        growth: &dyn PlantGrowth,
        animals: &[AnimalSpecies],
        run: &Run,
    ) -> Result<Self, Stopped> {
        let eaten = |plant: usize| animals.iter().any(|a| a.diet.iter().any(|d| d.food == Food::Plant(plant)));
        let stock = |plant: usize| {
            let mut stock = Stock::none(regions.parts(), plants[plant].offtake);
            if eaten(plant) {
                sum_growth(regions, growth, plant, &mut stock.growth_kg, run)?;
            }
            Ok(stock)
        };
        let plants = (0..plants.len()).into_par_iter().map(stock).collect::<Result<_, Stopped>>()?;
        let animals = animals.iter().map(|a| Stock::none(regions.parts(), a.offtake)).collect();
        Ok(Self { plants, animals })
    }

    /// The stock of a food; `None` for a species that does not exist.
    pub fn of(&self, food: Food) -> Option<&Stock> {
        match food {
            Food::Plant(p) => self.plants.get(p),
            Food::Animal(a) => self.animals.get(a),
        }
    }

    pub(super) fn of_mut(&mut self, food: Food) -> Option<&mut Stock> {
        match food {
            Food::Plant(p) => self.plants.get_mut(p),
            Food::Animal(a) => self.animals.get_mut(a),
        }
    }

    /// Notes that `individuals` of an animal live in one of its regions: their young are spread
    /// evenly over it.
    pub(super) fn settle(
        &mut self,
        regions: &Regions,
        animals: &[AnimalSpecies],
        (s, region): (usize, usize),
        individuals: u64,
    ) {
        let young_kg = individuals as f64 * animals[s].growth_per_year.max(0.0) * animals[s].mass_kg;
        let per_cell = young_kg / f64::from(regions.region_cells[s][region]);
        for part in (0..regions.parts()).filter(|part| regions.region_of_part(s, *part) == Some(region)) {
            self.animals[s].growth_kg[part] = per_cell * f64::from(regions.part_cells[part]);
        }
    }
}

fn sum_growth(
    regions: &Regions,
    growth: &dyn PlantGrowth,
    plant: usize,
    sums: &mut [f64],
    run: &Run,
) -> Result<(), Stopped> {
    let grid = regions.grid();
    let mut row_kg = vec![0.0f32; grid.width];
    for row in 0..grid.height {
        run.check()?;
        growth.row(plant, row, &mut row_kg);
        let parts = &regions.part.data[row * grid.width..][..grid.width];
        for (kg, part) in row_kg.iter().zip(parts).filter(|(kg, part)| **kg > 0.0 && **part != NOWHERE) {
            sums[*part as usize] += f64::from(*kg);
        }
    }
    Ok(())
}
