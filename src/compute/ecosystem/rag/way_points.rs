//! **Way-points**: places that animals pass or walk to, whatever is there. The authors set them at
//! the ways in and out of their valley, before the animals were placed (L 7.2; "exit locations" in
//! T figure 5.15).

use super::Area;
use super::Node;
use super::Resource;
use crate::compute::ecosystem::regions::Place;
use crate::compute::ecosystem::regions::Regions;
use crate::compute::ecosystem::regions::cells_of_place;

/// A place that draws animals for its own sake: a node of the graph that feeds nobody.
#[derive(Debug, Clone, PartialEq)]
pub struct WayPoint {
    /// Where it is.
    pub place: Place,
    /// The share of their moves that its users make to it, 0..=1; 0 draws nobody.
    pub share: f64,
    /// The species that use it, ascending; empty: all.
    pub species: Vec<usize>,
}

impl WayPoint {
    /// Whether it draws animals of the species.
    pub fn draws(&self, species: usize) -> bool {
        self.share > 0.0 && (self.species.is_empty() || self.species.binary_search(&species).is_ok())
    }
}

/// Where a species meets a way-point: its region, and of the cells of the place that lie in a
/// region the one nearest the centre (the first of equals). `None` where it can stand on none.
pub fn reached(regions: &Regions, species: usize, way_point: &WayPoint) -> Option<(usize, usize)> {
    let (grid, centre) = (regions.grid(), way_point.place.centre);
    let cells = cells_of_place(&grid, &way_point.place).into_iter();
    let inside = cells.filter_map(|cell| Some((regions.region(species, cell)?, cell)));
    inside.min_by(|a, b| {
        let far = |cell: usize| grid.centre(cell).distance_sq(centre);
        far(a.1).total_cmp(&far(b.1)).then(a.1.cmp(&b.1))
    })
}

/// The nodes of one level for its `species`, and the homes (species, region) that use each. Two
/// species that stand on the same cell of a way-point share its node.
pub(crate) fn way_point_nodes(
    way_points: &[WayPoint],
    regions: &Regions,
    (level, species): (usize, &[usize]),
) -> Vec<(Node, Vec<(usize, usize)>)> {
    let grid = regions.grid();
    let mut nodes: Vec<(Node, Vec<(usize, usize)>)> = Vec::new();
    for (number, way_point) in way_points.iter().enumerate() {
        let first = nodes.len();
        for &s in species.iter().filter(|s| way_point.draws(**s)) {
            let Some((region, cell)) = reached(regions, s, way_point) else { continue };
            match nodes[first..].iter_mut().find(|(node, _)| node.cell == cell) {
                Some((_, homes)) => homes.push((s, region)),
                None => {
                    let cells = cells_of_place(&grid, &way_point.place);
                    let area = Area::of(cells.into_iter().filter(|c| regions.region(s, *c) == Some(region)));
                    let node = Node {
                        level,
                        resource: Resource::WayPoint(number),
                        area_m2: area.len() as f64 * grid.cell_area_m2(),
                        area,
                        cell,
                        place: grid.centre(cell),
                        quantity_kg: 0.0,
                        draws: way_point.share.clamp(0.0, 1.0),
                        below: Vec::new(),
                    };
                    nodes.push((node, vec![(s, region)]));
                }
            }
        }
    }
    nodes
}
