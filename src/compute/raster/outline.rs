use crate::compute::geometry::Point;
use crate::compute::geometry::Polygon;
use crate::compute::geometry::ring_area_doubled;
use crate::compute::geometry::simple_rings;
use crate::compute::raster::Grid;
use crate::compute::raster::Raster;

/// East, north, west, south as steps between cell corners (columns, rows to the south).
const STEPS: [(isize, isize); 4] = [(1, 0), (0, -1), (-1, 0), (0, 1)];

/// The outline of the cells that are set, along the cell borders: polygons with holes in normal
/// form (outer rings counter-clockwise, holes clockwise, none touching itself), runs of equal
/// direction merged. Cells that meet only at a corner belong to different polygons.
pub fn outline(mask: &Raster<bool>) -> Vec<Polygon> {
    let mut corners = Corners::of(mask);
    let simple = |(ring, cell): (Vec<Point>, usize)| simple_rings(&ring).into_iter().map(move |ring| (ring, cell));
    let rings: Vec<(Vec<Point>, usize)> = std::iter::from_fn(|| corners.next_ring()).flat_map(simple).collect();
    let labels = labels(mask);
    let mut polygons: Vec<Polygon> = Vec::new();
    let mut polygon_of_label = vec![usize::MAX; labels.1];
    for (ring, cell) in rings.iter().filter(|(ring, _)| ring_area_doubled(ring) > 0.0) {
        polygon_of_label[labels.0[*cell] as usize] = polygons.len();
        polygons.push(Polygon { outer: ring.clone(), holes: Vec::new() });
    }
    for (ring, cell) in rings.into_iter().filter(|(ring, _)| ring_area_doubled(ring) < 0.0) {
        polygons[polygon_of_label[labels.0[cell] as usize]].holes.push(ring);
    }
    polygons
}

/// Labels of the side-by-side connected parts of the set cells, and their number.
fn labels(mask: &Raster<bool>) -> (Vec<u32>, usize) {
    let (grid, mut labels, mut count) = (mask.grid, vec![u32::MAX; mask.data.len()], 0);
    let mut open = Vec::new();
    for start in 0..mask.data.len() {
        if !mask.data[start] || labels[start] != u32::MAX {
            continue;
        }
        labels[start] = count;
        open.push(start);
        while let Some(cell) = open.pop() {
            for (dx, dy) in STEPS {
                let Some(next) = grid.offset(cell, dx, dy) else { continue };
                if mask.data[next] && labels[next] == u32::MAX {
                    labels[next] = count;
                    open.push(next);
                }
            }
        }
        count += 1;
    }
    (labels, count as usize)
}

/// Which border steps leave each cell corner, the set cells on their left.
struct Corners {
    grid: Grid,
    leaving: Vec<u8>,
    next: usize,
}

impl Corners {
    fn of(mask: &Raster<bool>) -> Self {
        let grid = mask.grid;
        let mut corners = Self { grid, leaving: vec![0; (grid.width + 1) * (grid.height + 1)], next: 0 };
        for index in (0..mask.data.len()).filter(|i| mask.data[*i]) {
            let cell = grid.cell(index);
            let is_open = |dx, dy| grid.offset(index, dx, dy).is_none_or(|n| !mask.data[n]);
            let sides = [(0, 1, 0, 1), (1, 0, 1, 1), (0, -1, 1, 0), (-1, 0, 0, 0)];
            for (direction, (dx, dy, column, row)) in sides.into_iter().enumerate() {
                if is_open(dx, dy) {
                    let corner = (cell.row + row) * (grid.width + 1) + cell.column + column;
                    corners.leaving[corner] |= 1 << direction;
                }
            }
        }
        corners
    }

    fn next_ring(&mut self) -> Option<(Vec<Point>, usize)> {
        self.next += self.leaving[self.next..].iter().position(|bits| *bits != 0)?;
        let start = self.next;
        let first = self.leaving[start].trailing_zeros() as usize;
        let (mut corner, mut direction, mut ring) = (start, first, vec![self.place(start)]);
        loop {
            self.leaving[corner] &= !(1 << direction);
            corner = self.step(corner, direction);
            // Left first keeps to the cell at hand where two meet at a corner.
            let turns = [1, 0, 3].into_iter().map(|turn| (direction + turn) % 4);
            let Some(next) = turns.into_iter().find(|d| self.leaving[corner] & (1 << d) != 0) else { break };
            if next != direction {
                ring.push(self.place(corner));
            }
            direction = next;
        }
        Some((ring, self.cell_left_of(start, first)))
    }

    fn step(&self, corner: usize, direction: usize) -> usize {
        let (dx, dy) = STEPS[direction];
        corner.wrapping_add_signed(dx + dy * (self.grid.width as isize + 1))
    }

    fn place(&self, corner: usize) -> Point {
        let (column, row) = (corner % (self.grid.width + 1), corner / (self.grid.width + 1));
        self.grid.origin + Point::new(column as f64, (self.grid.height - row) as f64) * self.grid.cell_m
    }

    fn cell_left_of(&self, corner: usize, direction: usize) -> usize {
        let (column, row) = (corner % (self.grid.width + 1), corner / (self.grid.width + 1));
        match direction {
            0 => self.grid.index(column, row - 1),
            1 => self.grid.index(column - 1, row - 1),
            2 => self.grid.index(column - 1, row),
            _ => self.grid.index(column, row),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::geometry::Region;
    use crate::compute::random::Purpose;
    use crate::compute::random::Stream;

    fn mask(rows: &[&str]) -> Raster<bool> {
        let data = rows.iter().flat_map(|r| r.chars().map(|c| c == '#')).collect();
        Raster::from_data(Grid::new(rows[0].len(), rows.len(), 1.0), data).unwrap()
    }

    #[test]
    fn a_ring_of_cells_is_one_polygon_with_one_hole() {
        let found = outline(&mask(&["####", "#..#", "#..#", "####"]));
        assert_eq!((found.len(), found[0].outer.len(), found[0].holes.len()), (1, 4, 1));
        assert!((Region::from_normal_form(found).unwrap().area() - 12.0).abs() < 1e-12);
    }

    #[test]
    fn cells_that_meet_at_a_corner_are_two_polygons() {
        assert_eq!(outline(&mask(&["#.", ".#"])).len(), 2);
        let hole = outline(&mask(&["####", "#.##", "##.#", "####"]));
        assert_eq!((hole.len(), hole[0].holes.iter().map(Vec::len).sum::<usize>()), (1, 8));
    }

    #[test]
    fn the_outline_of_random_cells_holds_exactly_their_centres() {
        let mut random = Stream::new(2, Purpose::new("test.outline"), 0);
        for _ in 0..20 {
            let grid = Grid { width: 13, height: 9, cell_m: 0.5, origin: Point::new(-3.0, 7.0) };
            let data: Vec<bool> = (0..grid.len()).map(|_| random.unit() < 0.6).collect();
            let cells = data.iter().filter(|set| **set).count();
            let raster = Raster::from_data(grid, data).unwrap();
            let region = Region::from_normal_form(outline(&raster)).unwrap();
            assert!((region.area() - cells as f64 * 0.25).abs() < 1e-9);
            assert!(Region::from_polygons(region.polygons()).is_ok(), "they are valid as input again");
            for i in 0..grid.len() {
                assert_eq!(region.contains(grid.centre(i)), raster.data[i]);
            }
        }
    }

    #[test]
    fn an_empty_mask_has_no_outline() {
        assert!(outline(&mask(&["..", ".."])).is_empty());
    }
}
