use super::ExtractionError;
use super::Found;
use crate::compute::geometry::Bounds;
use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Point;
use crate::compute::raster::Grid;

/// What the user changes in the animals found: input to a second run on the same photo and
/// scribbles, so that the ids are those of the first.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Corrections {
    /// Ids of regions that are no animals.
    pub remove: Vec<u64>,
    /// Regions to be replaced by one or several ellipses; a replaced animal is no longer suspect.
    pub replace: Vec<Replacement>,
    /// Animals that were missed; they get the ids after all others, in this order.
    pub add: Vec<Ellipse>,
    /// Ids of animals that face the other way.
    pub flip: Vec<u64>,
    /// Whether all animals found face the other way; those in `flip` are turned once more.
    pub flip_all: bool,
}

/// One region and the ellipses that the user drew instead.
#[derive(Debug, Clone, PartialEq)]
pub struct Replacement {
    /// The region.
    pub id: u64,
    /// What to put there: the first keeps the id, the others get new ones.
    pub by: Vec<Ellipse>,
}

/// The animals as corrected, in the order of their ids.
pub(super) fn apply(mut found: Vec<Found>, changes: &Corrections, grid: Grid) -> Result<Vec<Found>, ExtractionError> {
    require_known(&found, changes)?;
    require_valid(changes, grid)?;
    for animal in &mut found {
        if changes.flip_all != changes.flip.contains(&animal.id) {
            animal.ellipse = animal.ellipse.flipped();
        }
    }
    let mut next = found.len() as u64;
    let mut fresh = |ellipse: Ellipse| {
        next += 1;
        Found { id: next - 1, ellipse, suspicions: Vec::new() }
    };
    let mut extra = Vec::new();
    for replacement in &changes.replace {
        let drawn = &replacement.by;
        if let Some(animal) = found.iter_mut().find(|a| a.id == replacement.id) {
            if let Some(first) = drawn.first() {
                *animal = Found { id: replacement.id, ellipse: *first, suspicions: Vec::new() };
            }
            extra.extend(drawn.iter().skip(1).map(|e| fresh(*e)));
        }
    }
    extra.extend(changes.add.iter().map(|e| fresh(*e)));
    found.retain(|a| !changes.remove.contains(&a.id));
    found.extend(extra);
    Ok(found)
}

fn require_known(found: &[Found], changes: &Corrections) -> Result<(), ExtractionError> {
    let named = changes.remove.iter().chain(&changes.flip).copied().chain(changes.replace.iter().map(|r| r.id));
    match named.into_iter().find(|id| *id >= found.len() as u64) {
        Some(id) => Err(ExtractionError::UnknownAnimal { id, count: found.len() }),
        None => Ok(()),
    }
}

fn require_valid(changes: &Corrections, grid: Grid) -> Result<(), ExtractionError> {
    let picture = Bounds::new(Point::default(), Point::new(grid.width as f64, grid.height as f64));
    let drawn = changes.add.iter().chain(changes.replace.iter().flat_map(|r| &r.by));
    match drawn.into_iter().position(|e| !e.is_valid() || !picture.contains(e.centre)) {
        Some(index) => Err(ExtractionError::BadEllipse { index }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64) -> Ellipse {
        Ellipse { centre: Point::new(x, 5.0), a: 2.0, b: 1.0, theta: 0.0 }
    }

    fn three() -> Vec<Found> {
        (0..3).map(|id| Found { id, ellipse: at(id as f64), suspicions: Vec::new() }).collect()
    }

    #[test]
    fn corrections_keep_the_ids_of_the_rest() {
        let changes = Corrections {
            remove: vec![0],
            replace: vec![Replacement { id: 1, by: vec![at(7.0), at(8.0)] }],
            add: vec![at(9.0)],
            flip: vec![2],
            flip_all: false,
        };
        let out = apply(three(), &changes, Grid::new(10, 10, 1.0)).unwrap();
        let ids: Vec<(u64, f64)> = out.iter().map(|a| (a.id, a.ellipse.centre.x)).collect();
        assert_eq!(ids, [(1, 7.0), (2, 2.0), (3, 8.0), (4, 9.0)]);
        assert!((out[1].ellipse.theta.abs() - std::f64::consts::PI).abs() < 1e-12);
    }

    #[test]
    fn corrections_of_strangers_and_of_places_outside_are_refused() {
        let grid = Grid::new(10, 10, 1.0);
        let stranger = Corrections { remove: vec![3], ..Corrections::default() };
        assert_eq!(apply(three(), &stranger, grid).unwrap_err(), ExtractionError::UnknownAnimal { id: 3, count: 3 });
        let outside = Corrections { add: vec![at(2.0), at(11.0)], ..Corrections::default() };
        assert_eq!(apply(three(), &outside, grid).unwrap_err(), ExtractionError::BadEllipse { index: 1 });
    }
}
