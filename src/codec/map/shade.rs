use crate::codec::colours::Rgb;
use crate::compute::raster::Raster;

/// **Hillshade**: how bright the ground is under a lamp in the north-west, 45° high.
///
/// The gradient is Horn's (1981), as in common GIS tools; relief is exaggerated where the
/// terrain is flat, so that it can be seen.
pub(super) struct Shade<'a> {
    heights: &'a Raster<f32>,
    exaggeration: f64,
}

impl<'a> Shade<'a> {
    pub(super) fn new(heights: &'a Raster<f32>) -> Self {
        let mut shade = Self { heights, exaggeration: 1.0 };
        let step = (heights.data.len() / 20_000).max(1);
        let slopes: Vec<f64> =
            (0..heights.data.len()).step_by(step).filter_map(|i| shade.gradient(i)).map(|(x, y)| x.hypot(y)).collect();
        let mean = slopes.iter().sum::<f64>() / slopes.len().max(1) as f64;
        shade.exaggeration = (0.25 / mean.max(1e-6)).clamp(1.0, 20.0);
        shade
    }

    /// `colour` as the cells of a pixel would show it in the mean.
    pub(super) fn over(&self, colour: Rgb, cells: impl Iterator<Item = usize>) -> Rgb {
        let (sum, n) = cells.filter_map(|i| self.light(i)).fold((0.0, 0_usize), |(s, n), v| (s + v, n + 1));
        if n == 0 {
            return colour;
        }
        let light = sum / n as f64;
        colour.map(|c| (f64::from(c) * (0.35 + 0.65 * light / Self::FLAT)).clamp(0.0, 255.0) as u8)
    }

    /// Light on level ground.
    const FLAT: f64 = std::f64::consts::FRAC_1_SQRT_2;

    /// 0 in full shade to 1 where the lamp is met square on.
    fn light(&self, i: usize) -> Option<f64> {
        let (x, y) = self.gradient(i)?;
        let (x, y) = (x * self.exaggeration, y * self.exaggeration);
        // The lamp's direction is (−1, 1, √2) / 2: west, north, up.
        let dot = (x - y) * 0.5 + Self::FLAT;
        Some((dot / (1.0 + x * x + y * y).sqrt()).clamp(0.0, 1.0))
    }

    /// Rise over run to the east and to the north.
    fn gradient(&self, i: usize) -> Option<(f64, f64)> {
        let grid = &self.heights.grid;
        let centre = self.heights.data[i];
        if centre.is_nan() {
            return None;
        }
        let at = |dx, dy| {
            let value = grid.offset(i, dx, dy).map_or(centre, |j| self.heights.data[j]);
            f64::from(if value.is_nan() { centre } else { value })
        };
        let east = at(1, -1) + 2.0 * at(1, 0) + at(1, 1);
        let west = at(-1, -1) + 2.0 * at(-1, 0) + at(-1, 1);
        let north = at(-1, -1) + 2.0 * at(0, -1) + at(1, -1);
        let south = at(-1, 1) + 2.0 * at(0, 1) + at(1, 1);
        let run = 8.0 * grid.cell_m;
        Some(((east - west) / run, (north - south) / run))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::raster::Grid;

    #[test]
    fn slopes_that_face_the_lamp_are_brighter_than_level_ground_and_others_darker() {
        let grid = Grid::new(9, 9, 1.0);
        let plane = |east: f64, north: f64| {
            let data = (0..81).map(|i| (grid.centre(i).x * east + grid.centre(i).y * north) as f32).collect();
            let heights = Raster { grid, data };
            Shade { heights: &heights, exaggeration: 1.0 }.light(40).unwrap()
        };
        let level = plane(0.0, 0.0);
        assert!((level - Shade::FLAT).abs() < 1e-12);
        assert!(plane(0.5, -0.5) > level && plane(-0.5, 0.5) < level);
        assert!((plane(0.5, 0.5) - plane(-0.5, -0.5)).abs() < 1e-12);
    }
}
