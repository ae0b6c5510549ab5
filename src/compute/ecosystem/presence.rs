//! Where the animals of a territory are, and where they go next (L equations 1 and 2).

use super::rag::Node;
use super::rag::Rag;
use super::rag::Resource;
use super::rag::Territory;
use super::species::AnimalSpecies;
use super::species::Food;

/// Places nearer than this many seconds are equally near: without it two nodes on the same spot
/// would draw all animals for ever (ours).
const NEAR_S: f64 = 30.0;

/// The largest share of the active time that drinking may take (ours).
const MOST_DRINKING: f64 = 0.5;

/// The largest share of the moves that all way-points of a territory may draw (ours).
const MOST_PASSING: f64 = 0.5;

/// How much of the active time goes to drinking.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drinking {
    /// Drinks a day. Default: 2, as in the authors' sample.
    pub times_per_day: u32,
    /// Seconds by the water each time. Default: 5 400, the shortest of the authors' stays.
    pub stay_s: f64,
}

impl Default for Drinking {
    fn default() -> Self {
        Self { times_per_day: 2, stay_s: 5400.0 }
    }
}

impl Drinking {
    /// c(s, water)/c(s, R(s)): the share of the active time a species drinks, at most a half.
    pub fn share(&self, species: &AnimalSpecies) -> f64 {
        let asked = f64::from(self.times_per_day) * self.stay_s / species.active_s;
        if species.needs_water && asked.is_finite() { asked.clamp(0.0, MOST_DRINKING) } else { 0.0 }
    }
}

/// **P_s(v)** (L equation 1): the probability that an animal is at the i-th node of the
/// territory; sums to 1 (an empty territory gives an empty list).
///
/// The text's c(s, r)/c(s, R(s)) is read as the share of the active time spent on r, for water
/// is infinite: drinking takes [`Drinking::share`], food the rest. The alternatives r of a diet
/// share the rest by preference × q(r, C), Manly's law of selection, so that
/// q(r, v)/q(r, C) · c(s, r) is preference × q(r, v) over its sum. Water nodes share by the length
/// of their banks, that is by area, as banks are one cell wide. The shares of resources that the
/// territory lacks go to the others; where it has none at all, nodes share by area.
///
/// Way-points draw the shares of [`Node::draws`], together at most a half, and what is used the
/// rest.
pub fn presence(rag: &Rag, territory: &Territory, species: &AnimalSpecies, drinking: &Drinking) -> Vec<f64> {
    let nodes: Vec<&Node> = territory.nodes.iter().map(|&n| &rag.nodes[n]).collect();
    let drawn: f64 = nodes.iter().map(|node| node.draws).sum();
    let scale = if drawn > MOST_PASSING { MOST_PASSING / drawn } else { 1.0 };
    let used = in_use(&nodes, species, drinking);
    let at = nodes.iter().zip(used).map(|(node, p)| scale * node.draws + (1.0 - scale * drawn) * p);
    at.collect()
}

/// P_s(v) of a territory without way-points.
fn in_use(nodes: &[&Node], species: &AnimalSpecies, drinking: &Drinking) -> Vec<f64> {
    let water = shares(nodes, |node| if node.resource == Resource::Water { node.area_m2 } else { 0.0 });
    let food = shares(nodes, |node| liking(species, node));
    match (water, food) {
        (Some(water), Some(food)) => {
            let drinks = drinking.share(species);
            water.iter().zip(&food).map(|(w, f)| drinks * w + (1.0 - drinks) * f).collect()
        }
        (Some(only), None) | (None, Some(only)) => only,
        (None, None) => shares(nodes, |node| node.area_m2).unwrap_or_else(|| shares_of_equals(nodes.len())),
    }
}

/// **P_s(v'|v)** (L equation 2) for v = the `from`-th node of the territory: the probability that
/// an animal leaving v goes to the i-th node next; 0 for v itself. Sums to 1, or is 0 everywhere
/// when nothing can be reached (a territory of one node has no edges).
pub fn onward(territory: &Territory, presence: &[f64], from: usize) -> Vec<f64> {
    let pull_of = |to: usize| if to == from { 0.0 } else { pull(presence[to], territory.time_s(from, to)) };
    let pulls: Vec<f64> = (0..presence.len()).map(pull_of).collect();
    normalised(&pulls).unwrap_or(pulls)
}

/// The numerator of equation 2: how much a node with this presence, this many seconds away, draws.
pub(crate) fn pull(presence: f64, seconds: f64) -> f64 {
    if seconds.is_finite() { presence / seconds.max(NEAR_S) } else { 0.0 }
}

/// preference × q(r, v); 0 where the species eats nothing.
fn liking(species: &AnimalSpecies, node: &Node) -> f64 {
    match node.resource {
        Resource::Water | Resource::WayPoint(_) => 0.0,
        Resource::Food(food) => preference(species, food) * node.quantity_kg,
    }
}

fn preference(species: &AnimalSpecies, food: Food) -> f64 {
    species.diet.iter().find(|item| item.food == food).map_or(0.0, |item| item.preference)
}

fn shares(nodes: &[&Node], amount: impl Fn(&Node) -> f64) -> Option<Vec<f64>> {
    normalised(&nodes.iter().map(|node| amount(node)).collect::<Vec<f64>>())
}

fn shares_of_equals(n: usize) -> Vec<f64> {
    vec![1.0 / n as f64; n]
}

fn normalised(amounts: &[f64]) -> Option<Vec<f64>> {
    let sum: f64 = amounts.iter().sum();
    (sum > 0.0 && sum.is_finite()).then(|| amounts.iter().map(|a| a / sum).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::ecosystem::rag::Area;
    use crate::compute::ecosystem::species::DietItem;
    use crate::compute::ecosystem::species::Mobility;
    use crate::compute::geometry::Point;

    fn node(resource: Resource, area_m2: f64, quantity_kg: f64) -> Node {
        let area = Area::default();
        let (place, below) = (Point::default(), Vec::new());
        Node { level: 1, resource, area, cell: 0, place, area_m2, quantity_kg, draws: 0.0, below }
    }

    /// A way-point that draws a share of the moves.
    fn way_point(draws: f64) -> Node {
        Node { draws, ..node(Resource::WayPoint(0), 9.0, 0.0) }
    }

    fn deer(diet: &[(usize, f64)]) -> AnimalSpecies {
        let item = |&(plant, preference): &(usize, f64)| DietItem { food: Food::Plant(plant), preference };
        AnimalSpecies {
            name: "deer".into(),
            level: 1,
            mass_kg: 100.0,
            group_min: 5,
            group_max: 10,
            diet: diet.iter().map(item).collect(),
            food_kg_per_year: 1000.0,
            needs_water: true,
            growth_per_year: 0.3,
            offtake: 0.5,
            mobility: Mobility {
                speed_m_per_s: 1.5,
                max_slope_up: 0.5,
                max_slope_down: 0.6,
                ford_depth_m: 0.5,
                max_tree_cover: 1.0,
            },
            active_from_s: 6.0 * 3600.0,
            active_s: 18.0 * 3600.0,
            target: None,
        }
    }

    fn territory(rag: &Rag, times_s: Vec<f32>) -> Territory {
        Territory { species: 0, region: 0, nodes: (0..rag.nodes.len()).collect(), times_s, herds: vec![8] }
    }

    #[test]
    fn time_is_shared_between_drinking_and_what_there_is_to_eat() {
        let rag = Rag {
            nodes: vec![
                node(Resource::Water, 300.0, f64::INFINITY),
                node(Resource::Water, 100.0, f64::INFINITY),
                node(Resource::Food(Food::Plant(0)), 1.0, 600.0),
                node(Resource::Food(Food::Plant(1)), 1.0, 100.0),
                node(Resource::Food(Food::Plant(7)), 1.0, 900.0),
            ],
            territories: Vec::new(),
        };
        let p = presence(&rag, &territory(&rag, vec![0.0; 25]), &deer(&[(0, 1.0), (1, 2.0)]), &Drinking::default());
        // Drinks 3 of 18 hours; 600 : 2 × 100 of the rest; plant 7 is not eaten.
        let expected = [0.75 / 6.0, 0.25 / 6.0, 0.75 * 5.0 / 6.0, 0.25 * 5.0 / 6.0, 0.0];
        for (got, want) in p.iter().zip(expected) {
            assert!((got - want).abs() < 1e-12, "{p:?}");
        }
    }

    #[test]
    fn the_share_of_what_is_absent_goes_to_the_rest() {
        let dry = Rag { nodes: vec![node(Resource::Food(Food::Plant(0)), 1.0, 3.0)], territories: Vec::new() };
        assert_eq!(presence(&dry, &territory(&dry, vec![0.0]), &deer(&[(0, 1.0)]), &Drinking::default()), [1.0]);
        let bare = Rag {
            nodes: vec![node(Resource::Food(Food::Plant(3)), 1.0, 3.0), node(Resource::Food(Food::Plant(3)), 3.0, 3.0)],
            territories: Vec::new(),
        };
        let p = presence(&bare, &territory(&bare, vec![0.0; 4]), &deer(&[(0, 1.0)]), &Drinking::default());
        assert_eq!(p, [0.25, 0.75]);
    }

    #[test]
    fn way_points_draw_their_shares_and_together_at_most_a_half() {
        let meadow = || node(Resource::Food(Food::Plant(0)), 1.0, 600.0);
        let at = |nodes: Vec<Node>| {
            let rag = Rag { nodes, territories: Vec::new() };
            let n = rag.nodes.len();
            presence(&rag, &territory(&rag, vec![0.0; n * n]), &deer(&[(0, 1.0)]), &Drinking::default())
        };
        let close = |a: Vec<f64>, b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(close(at(vec![meadow(), way_point(0.1), meadow()]), &[0.45, 0.1, 0.45]));
        assert!(close(at(vec![meadow(), way_point(0.9), way_point(0.3)]), &[0.5, 0.375, 0.125]));
    }

    #[test]
    fn near_nodes_are_preferred_by_the_inverse_of_the_way() {
        let rag = Rag { nodes: vec![node(Resource::Water, 1.0, f64::INFINITY); 3], territories: Vec::new() };
        let territory = territory(&rag, vec![0.0, 100.0, 300.0, 150.0, 0.0, f32::INFINITY, 0.0, 0.0, 0.0]);
        let p = [0.2, 0.4, 0.4];
        let row = onward(&territory, &p, 0);
        assert!((row[1] - 0.75).abs() < 1e-12 && (row[2] - 0.25).abs() < 1e-12 && row[0] == 0.0, "{row:?}");
        assert_eq!(onward(&territory, &p, 1), [1.0, 0.0, 0.0]);
        let here = onward(&territory, &p, 2);
        assert!((here.iter().sum::<f64>() - 1.0).abs() < 1e-12 && here[2] == 0.0);
    }

    #[test]
    fn a_territory_of_one_node_has_no_edges() {
        let rag = Rag { nodes: vec![node(Resource::Water, 1.0, f64::INFINITY)], territories: Vec::new() };
        assert_eq!(onward(&territory(&rag, vec![0.0]), &[1.0], 0), [0.0]);
    }
}
