//! Stage 1b: **water bodies** and **drainage**: lakes, rivers and streams, given or derived from
//! the terrain by depression filling and flow accumulation.
//!
//! 1. `flood` – the terrain without depressions; `gorges` – those that are none are opened first
//! 2. `flow` – which way water runs over it, and how much land drains through each cell
//! 3. `lakes`, `streams` – where water stands or runs, how deep and how wide
//! 4. `shore` – how high the rest lies above it

mod depressions;
mod flood;
mod flow;
mod gorges;
mod lakes;
mod shore;
mod streams;

pub use flood::Flooded;
pub use flood::OUTLET;
pub use flood::flood;
pub use flow::Flow;
pub use gorges::GorgeRule;
pub use lakes::LakeRule;
pub use shore::REACH_M;
pub use streams::HydraulicGeometry;
pub use streams::StreamRule;

use crate::compute::ecosystem::water::shore::height_above_water;
use crate::compute::ecosystem::water::streams::Bed;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;

/// Where the water is, and how much land drains through each cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Water {
    /// Depth of the water in metres: of a lake, a river or a stream; 0 where dry, NaN where there
    /// is no data.
    pub depth_m: Raster<f32>,
    /// Width in metres of a stream narrower than a cell; 0 where there is none or the whole cell
    /// is under water.
    pub stream_width_m: Raster<f32>,
    /// **Drainage area**: the land that drains through the cell, itself included, m², by multiple
    /// flow; NaN where there is no data.
    pub drainage_m2: Raster<f32>,
    /// How far one climbs from the nearest water, m, with a fiftieth of the way's length added;
    /// 0 in water, infinite beyond [`REACH_M`] and where there is no data.
    pub above_water_m: Raster<f32>,
}

/// How water is derived from a terrain.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WaterRules {
    /// Which barriers are gorges that the height map does not show.
    pub gorges: GorgeRule,
    /// What counts as a lake.
    pub lakes: LakeRule,
    /// Where streams run and how large they are.
    pub streams: StreamRule,
}

impl Water {
    /// The water of a terrain of `height` (m, NaN for no data): its depressions hold lakes and
    /// its valleys streams, as `rules` say.
    pub fn derived(height: &Raster<f32>, rules: &WaterRules, run: &Run) -> Result<Self, Stopped> {
        let flooded = flood(height, run)?;
        let (cut, flooded) = match gorges::breached(height, &flooded, rules.gorges, run)? {
            Some(cut) => (Some(cut), None),
            None => (None, Some(flooded)),
        };
        let ground = cut.as_ref().unwrap_or(height);
        let flooded = flooded.map_or_else(|| flood(ground, run), Ok)?;
        let mut depth_m = lakes::lakes(ground, &flooded, rules.lakes, run)?;
        let (steepest, multiple) = rayon::join(
            || Flow::steepest(&flooded).accumulate(&flooded, run),
            || Flow::multiple(&flooded).accumulate(&flooded, run),
        );
        let mut stream_width_m = Raster::filled(height.grid, 0.0f32);
        Bed { level: &flooded.level, depth_m: &mut depth_m, stream_width_m: &mut stream_width_m }
            .add_streams(&steepest?, rules.streams);
        let above_water_m = height_above_water(&flooded.level, |c| depth_m.data[c] > 0.0, run)?;
        Ok(Self { depth_m, stream_width_m, drainage_m2: multiple?, above_water_m }.where_known())
    }

    /// The water that the caller says there is: `depth_m` on the grid of `height`, 0 (or less, or
    /// not a number) where dry. Drainage is derived as ever.
    pub fn given(height: &Raster<f32>, depth_m: &Raster<f32>, run: &Run) -> Result<Self, Stopped> {
        let flooded = flood(height, run)?;
        let drainage_m2 = Flow::multiple(&flooded).accumulate(&flooded, run)?;
        let depth_m = depth_m.map(|d| if d > 0.0 { d } else { 0.0 });
        let stream_width_m = Raster::filled(height.grid, 0.0f32);
        let above_water_m = height_above_water(&flooded.level, |c| depth_m.data[c] > 0.0, run)?;
        Ok(Self { depth_m, stream_width_m, drainage_m2, above_water_m }.where_known())
    }

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

    /// Marks what has no data.
    fn where_known(mut self) -> Self {
        for map in [&mut self.depth_m, &mut self.stream_width_m] {
            let cells = map.data.iter_mut().zip(&self.drainage_m2.data);
            cells.filter(|(_, drained)| drained.is_nan()).for_each(|(value, _)| *value = f32::NAN);
        }
        self
    }
}
