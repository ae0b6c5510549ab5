//! Stage 1b: **water bodies** and **drainage**: lakes, rivers and streams, given or derived from
//! the terrain by depression filling and flow accumulation.

use crate::compute::raster::Raster;

/// Where the water is, and how much land drains through each cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Water {
    /// Depth of the water in metres: of a lake, a river or a stream; 0 where dry, NaN where there
    /// is no data.
    pub depth_m: Raster<f32>,
    /// Width in metres of a stream narrower than a cell; 0 where there is none or the whole cell
    /// is under water.
    pub stream_width_m: Raster<f32>,
    /// **Drainage area**: the land that drains through the cell, itself included, m²; NaN where
    /// there is no data.
    pub drainage_m2: Raster<f32>,
    /// How far one goes up from the nearest water along the flow path, m, with
    /// [`SHORE_GRADE`] of the way's length added; 0 in water, infinite where the
    /// path meets no water, NaN where there is no data.
    pub above_water_m: Raster<f32>,
}

/// The share of the way to the water that counts as height above it (ours: 50 m of level ground
/// count as a rise of 1 m).
pub const SHORE_GRADE: f32 = 0.02;

impl Water {
    /// Whether there is any water in the cell, be it a stream: animals can drink here.
    pub fn is_wet(&self, cell: usize) -> bool {
        self.depth_m.data[cell] > 0.0
    }

    /// The share of the cell that is under water, 0..=1.
    pub fn share(&self, cell: usize) -> f32 {
        let width = self.stream_width_m.data[cell];
        match (self.is_wet(cell), width > 0.0) {
            (false, _) => 0.0,
            (true, false) => 1.0,
            (true, true) => (width / self.depth_m.grid.cell_m as f32).min(1.0),
        }
    }

    /// Whether more than half of the cell is under water: a lake or a river, not land.
    pub fn is_open(&self, cell: usize) -> bool {
        self.share(cell) > 0.5
    }
}
