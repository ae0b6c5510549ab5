//! Stage 6: herbivores, then carnivores, level by level, compete for what the levels below can
//! spare (L 4 and 5.2, T 5.4); their herds are the next level's food.
//!
//! For each level of the food chain:
//! 1. make the nodes of the Resource Access Graph: banks, and the food that is left ([`super::rag`]);
//! 2. let the species compete for it ([`contest`]): with wanted shares L Algorithm 1, else 2;
//! 3. book what was eaten ([`stocks`]), and the young of those that settled;
//! 4. share the individuals out to herds ([`herds`]).
//!
//! Readings of ours: the unit is the smallest typical group; shares count individuals; the
//! leanest season bounds the herd; an animal takes what is there, liked food first.

mod contest;
mod herds;
mod larder;
mod maps;
mod populate;
mod stocks;

pub use contest::distance;
pub use herds::herds_of;
pub use maps::density_per_m2;
pub use maps::surplus_of_animal;
pub use maps::surplus_of_plant;
pub use populate::Absence;
pub use populate::FaunaOptions;
pub use populate::Habitable;
pub use populate::Population;
pub use populate::populate;
pub use stocks::Stock;
pub use stocks::Stocks;

#[cfg(test)]
pub(crate) mod sample;
#[cfg(test)]
mod tests;
