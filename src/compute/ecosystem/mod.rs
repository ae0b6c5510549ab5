//! A whole ecosystem on a terrain at its steady state.
//!
//! Sources: L = "Authoring Consistent Landscapes with Flora and Fauna" (2021), T = thesis of
//! 2020, chapter 5 and appendix A. One file or folder per stage, one pure function per stage;
//! `jobs/ecosystem` chains them:
//!
//! 1. `terrain` – slope and aspect of the height map; `water` – lakes, rivers, drainage
//! 2. `climate` – monthly temperature, sunlight with cast shadows, moisture; `soil`
//! 3. `flora` – plants compete: one cover map a species, what is left of light and moisture
//! 4. `regions` – where each animal can go: accessibility and confinement regions
//! 5. `rag`, `travel` – the Resource Access Graph and its travel times
//! 6. `fauna` – herbivores, then carnivores compete: herds per region
//! 7. `trails` – the paths they wear
//! 8. `planning` – what each herd does all day
//! 9. `biomes`, `summary` – what the experts look at

pub mod allometry;
pub mod biomes;
pub mod climate;
mod curve;
pub mod fauna;
pub mod fitness;
pub mod flora;
pub mod food_chain;
pub mod habitat;
pub mod paths;
pub mod planning;
pub mod presence;
pub mod rag;
pub mod regions;
pub mod resources;
pub mod scales;
mod slabs;
pub mod soil;
pub mod species;
pub mod summary;
pub mod terrain;
pub mod trails;
pub mod travel;
pub mod valley;
pub mod water;
pub mod ways;
