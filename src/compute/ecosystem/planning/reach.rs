//! Travel times between the places of a territory.

use crate::compute::ecosystem::habitat::Habitat;
use crate::compute::ecosystem::paths::Paths;
use crate::compute::ecosystem::rag::Territory;
use crate::compute::ecosystem::ways::Ways;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use std::collections::BTreeMap;

/// Travel times of one species between a fixed set of cells. Those between the nodes of its
/// territory are those over the trails where these lead, else in the graph; those to where its prey stays are asked for when first needed, one
/// search per source, and kept.
pub(crate) struct Reach<'a> {
    ways: &'a dyn Ways,
    paths: Option<&'a Paths>,
    species: usize,
    run: &'a Run,
    /// Ascending.
    cells: Vec<usize>,
    rows: BTreeMap<usize, Vec<f64>>,
}

impl<'a> Reach<'a> {
    /// Times between the nodes of the territory and `others`, cells where prey may be.
    pub(crate) fn new(habitat: &Habitat<'a>, territory: &Territory, others: &[usize], run: &'a Run) -> Self {
        let Habitat { rag, ways, paths, .. } = *habitat;
        let own: Vec<usize> = territory.nodes.iter().map(|&n| rag.nodes[n].cell).collect();
        let mut cells: Vec<usize> = own.iter().chain(others).copied().collect();
        cells.sort_unstable();
        cells.dedup();
        let mut reach = Self { ways, paths, species: territory.species, run, cells, rows: BTreeMap::new() };
        if others.is_empty() {
            reach.read(territory, &own);
        }
        reach
    }

    /// Seconds from one of the cells to another; infinite where there is no way.
    pub(crate) fn seconds(&mut self, from: usize, to: usize) -> Result<f64, Stopped> {
        if from == to {
            return Ok(0.0);
        }
        if !self.rows.contains_key(&from) {
            let row = self.ways.times_s(self.species, from, &self.cells, self.run)?;
            self.keep(from, row);
        }
        let place = self.cells.binary_search(&to).ok();
        Ok(place.map_or(f64::INFINITY, |place| self.rows[&from][place]))
    }

    fn read(&mut self, territory: &Territory, own: &[usize]) {
        let position = |cell: &usize| own.iter().position(|c| c == cell).unwrap_or(0);
        let positions: Vec<usize> = self.cells.iter().map(position).collect();
        for (cell, &from) in self.cells.clone().iter().zip(&positions) {
            let row = positions.iter().map(|&to| territory.time_s(from, to)).collect();
            self.keep(*cell, row);
        }
    }

    /// Keeps the times from a cell: those over the trails where these lead.
    fn keep(&mut self, from: usize, mut row: Vec<f64>) {
        if let Some(paths) = self.paths {
            let trodden = paths.times_s(self.species, from, &self.cells);
            row.iter_mut().zip(trodden).filter(|(_, over)| over.is_finite()).for_each(|(time, over)| *time = over);
        }
        self.rows.insert(from, row);
    }
}
