//! Stage 6: herbivores, then carnivores compete for what the level below can spare (L 4).

#[cfg(test)]
pub(crate) mod sample;
