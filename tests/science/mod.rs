//! What must be true: closed forms, invariants, conserved sums, outside checks.

mod distributions_analysis;
pub mod distributions_exemplars;
mod distributions_quality;
mod distributions_synthesis;
mod distributions_uniform;
mod fauna;
mod flora;
mod flora_lines;
mod flora_study;
mod herds_animation;
mod herds_drawn;
pub mod herds_example;
mod herds_extraction;
mod herds_key_herd;
mod herds_made;
mod herds_photo;
mod planning;
mod resources;
mod tautavel;
mod terrain_files;
mod trails;
pub mod worlds;
