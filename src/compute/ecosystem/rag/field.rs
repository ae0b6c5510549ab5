use crate::compute::ecosystem::regions::NOWHERE;
use crate::compute::ecosystem::regions::Regions;
use crate::compute::raster::Raster;

/// Yearly growth of the plants, row by row, so that nobody needs to hold all maps at once.
pub trait PlantGrowth: Sync {
    /// Writes the yearly growth, kg of dry matter per cell, of `plant` in the cells of a row of
    /// the terrain to `out`; 0 (or not a number) where it does not grow.
    fn row(&self, plant: usize, row: usize, out: &mut [f32]);
}

/// One map of kg per cell a plant.
impl PlantGrowth for Vec<Raster<f32>> {
    fn row(&self, plant: usize, row: usize, out: &mut [f32]) {
        let width = self[plant].grid.width;
        out.copy_from_slice(&self[plant].data[row * width..][..width]);
    }
}

/// Where one resource is, and how much of it can be taken.
pub(crate) enum Source<'a> {
    /// The banks of lakes, rivers and streams: cells with water in them or beside them.
    Banks { depth: &'a Raster<f32> },
    /// A plant: its growth in each cell.
    Plant { growth: &'a dyn PlantGrowth, plant: usize },
    /// The same in every cell of a part: animals, which are anywhere in their region.
    Even,
}

/// A resource over the terrain, cut into the **groups** of parts that the same species reach.
pub(crate) struct Field<'a> {
    pub(crate) source: Source<'a>,
    /// What each cell of a part offers, in kg per unit of the source.
    pub(crate) share: Vec<f64>,
    /// The group of each part; [`NOWHERE`] where nobody who wants the resource can go.
    pub(crate) group: Vec<u32>,
}

impl Field<'_> {
    /// Writes what the source holds in the cells of a row: 0 where the resource is absent.
    fn source_row(&self, row: usize, out: &mut [f32]) {
        match self.source {
            Source::Banks { depth } => bank_row(depth, row, out),
            Source::Plant { growth, plant } => growth.row(plant, row, out),
            Source::Even => out.fill(1.0),
        }
    }

    /// Calls `visit(column, part, group, kg)` for each cell of the row that offers something.
    pub(crate) fn visit_row(
        &self,
        regions: &Regions,
        row: usize,
        buffer: &mut [f32],
        mut visit: impl FnMut(usize, u32, u32, f64),
    ) {
        self.source_row(row, buffer);
        let parts = &regions.part.data[row * buffer.len()..][..buffer.len()];
        for (column, (amount, part)) in buffer.iter().zip(parts).enumerate() {
            if *part == NOWHERE {
                continue;
            }
            let (group, share) = (self.group[*part as usize], self.share[*part as usize]);
            if *amount > 0.0 && group != NOWHERE && share > 0.0 {
                visit(column, *part, group, f64::from(*amount) * share);
            }
        }
    }
}

/// 1 where there is water in the cell or in one of its eight neighbours, else 0.
fn bank_row(depth: &Raster<f32>, row: usize, out: &mut [f32]) {
    let (width, height) = (depth.grid.width, depth.grid.height);
    let rows = row.saturating_sub(1)..(row + 2).min(height);
    out.fill(0.0);
    for wet in rows.flat_map(|r| (0..width).filter(move |c| depth.data[r * width + c] > 0.0)) {
        out[wet.saturating_sub(1)..(wet + 2).min(width)].fill(1.0);
    }
}
