use crate::compute::raster::Raster;
use crate::compute::run::Run;
use crate::compute::run::Stopped;
use rayon::prelude::*;

/// Columns handled together in the first pass.
const STRIP: usize = 256;

/// Exact Euclidean distance, in cells, of the centre of every cell that is not 0 to the centre of
/// the nearest cell that is, and 0 in those (Meijster, Roerdink and Hesselink 2000: a scan of the
/// columns, then the lower envelope of parabolas along each row). What lies outside the map is
/// not 0. Without any cell of 0 all distances are width + height.
///
/// # Errors
/// [`Stopped`] when the work was stopped.
pub fn distance_to_zero(mask: &Raster<u8>, run: &Run) -> Result<Raster<f32>, Stopped> {
    let (width, height) = (mask.grid.width, mask.grid.height);
    let vertical = vertical_distances(mask);
    run.check()?;
    let mut data = vec![0f32; mask.data.len()];
    data.par_chunks_mut(width).enumerate().for_each_init(
        || Envelope::new(width),
        |envelope, (y, out)| {
            let row = &vertical[y * width..(y + 1) * width];
            if row.iter().any(|g| *g > 0) && !run.is_stopped() {
                envelope.fill(row, out, width + height);
            }
        },
    );
    run.check()?;
    Ok(Raster { grid: mask.grid, data })
}

/// Distance to the nearest cell of 0 in the same column; width + height where there is none.
fn vertical_distances(mask: &Raster<u8>) -> Vec<u32> {
    let (width, height) = (mask.grid.width, mask.grid.height);
    let far = (width + height) as u32;
    let strips: Vec<Vec<u32>> = (0..width.div_ceil(STRIP))
        .into_par_iter()
        .map(|s| {
            let columns = s * STRIP..((s + 1) * STRIP).min(width);
            let n = columns.len();
            let mut out = vec![far; n * height];
            for y in 0..height {
                for (k, x) in columns.clone().enumerate() {
                    let above = if y > 0 { out[(y - 1) * n + k] } else { far };
                    out[y * n + k] = if mask.data[y * width + x] == 0 { 0 } else { far.min(above + 1) };
                }
            }
            for y in (0..height.saturating_sub(1)).rev() {
                for k in 0..n {
                    out[y * n + k] = out[y * n + k].min(out[(y + 1) * n + k] + 1);
                }
            }
            out
        })
        .collect();
    let mut all = vec![0u32; width * height];
    all.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        for (part, strip) in row.chunks_mut(STRIP).zip(&strips) {
            let n = part.len();
            part.copy_from_slice(&strip[y * n..(y + 1) * n]);
        }
    });
    all
}

/// The lower envelope of the parabolas (x − i)² + g(i)² of one row.
struct Envelope {
    apex: Vec<usize>,
    from: Vec<i64>,
}

impl Envelope {
    fn new(width: usize) -> Self {
        Self { apex: Vec::with_capacity(width), from: Vec::with_capacity(width) }
    }

    fn fill(&mut self, g: &[u32], out: &mut [f32], far: usize) {
        let value = |x: i64, i: usize| (x - i as i64).pow(2) + i64::from(g[i]).pow(2);
        self.apex.clear();
        self.from.clear();
        for u in 0..g.len() {
            while let (Some(&i), Some(&from)) = (self.apex.last(), self.from.last()) {
                if value(from, i) <= value(from, u) {
                    break;
                }
                self.apex.pop();
                self.from.pop();
            }
            let from = self.apex.last().map_or(0, |&i| 1 + separation(i, u, g));
            if from < g.len() as i64 {
                self.apex.push(u);
                self.from.push(from);
            }
        }
        let mut k = self.apex.len();
        for x in (0..g.len()).rev() {
            while k > 1 && self.from[k - 1] > x as i64 {
                k -= 1;
            }
            if g[x] > 0 {
                out[x] = (value(x as i64, self.apex[k - 1]) as f64).sqrt().min(far as f64) as f32;
            }
        }
    }
}

/// The last place where the parabola of `i` is not above that of `u` > `i`.
fn separation(i: usize, u: usize, g: &[u32]) -> i64 {
    let (i64i, i64u) = (i as i64, u as i64);
    (i64u.pow(2) - i64i.pow(2) + i64::from(g[u]).pow(2) - i64::from(g[i]).pow(2)).div_euclid(2 * (i64u - i64i))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::random::Purpose;
    use crate::compute::random::Stream;
    use crate::compute::raster::Grid;

    #[test]
    fn distances_equal_the_naive_search() {
        let grid = Grid::new(41, 33, 1.0);
        for (seed, share) in [(1, 0.02), (2, 0.3), (3, 0.9)] {
            let mut random = Stream::new(seed, Purpose::new("test.distance"), 0);
            let data = (0..grid.len()).map(|_| u8::from(random.unit() > share)).collect();
            let mask = Raster { grid, data };
            let found = distance_to_zero(&mask, &Run::silent()).unwrap();
            for i in 0..grid.len() {
                let zeros = (0..grid.len()).filter(|&j| mask.data[j] == 0);
                let naive = zeros.map(|j| grid.centre(i).distance(grid.centre(j))).fold(f64::INFINITY, f64::min);
                assert!((f64::from(found.data[i]) - naive).abs() < 1e-5, "{seed} {i}: {} {naive}", found.data[i]);
            }
        }
    }

    #[test]
    fn a_map_without_zeros_has_finite_distances() {
        let grid = Grid::new(7, 5, 1.0);
        let found = distance_to_zero(&Raster::filled(grid, 1), &Run::silent()).unwrap();
        assert!(found.data.iter().all(|d| *d == 12.0));
    }
}
