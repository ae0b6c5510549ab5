//! A terrain with its animals in place: what trails and plannings are made from.

use super::paths::Paths;
use super::rag::Rag;
use super::species::AnimalSpecies;
use super::ways::Ways;
use crate::compute::raster::Grid;

/// The results of the stages before, as trails and plannings read them.
#[derive(Clone, Copy)]
pub struct Habitat<'a> {
    /// Where the cells of the terrain lie.
    pub grid: &'a Grid,
    /// Resources, and the herds that live on them.
    pub rag: &'a Rag,
    /// The animal species; territories and foods name them by index.
    pub animals: &'a [AnimalSpecies],
    /// How they walk.
    pub ways: &'a dyn Ways,
    /// Where trails lead, once they are known: there herds keep to them.
    pub paths: Option<&'a Paths>,
}
