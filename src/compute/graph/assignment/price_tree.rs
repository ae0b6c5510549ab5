use crate::compute::geometry::Bounds;
use crate::compute::geometry::Point;

/// Places in a leaf.
const LEAF: usize = 8;

/// Depth of a tree over 2³² places, halved at every node, and room to spare.
const MAX_DEPTH: usize = 64;

/// Places with prices, ready to be asked for the cheapest from anywhere: a k-d tree whose nodes
/// know the lowest price below them.
pub(super) struct PriceTree {
    nodes: Vec<Node>,
    /// Places and prices in the order of the leaves.
    goods: Vec<Good>,
    /// Where each place, by its index, is among the goods.
    at: Vec<u32>,
    /// The leaf that holds each good.
    leaves: Vec<u32>,
}

#[derive(Debug, Clone, Copy)]
struct Good {
    place: Point,
    price: f64,
    index: u32,
}

struct Node {
    bounds: Bounds,
    lowest: f64,
    parent: u32,
    below: Below,
}

#[derive(Clone, Copy)]
enum Below {
    /// The two halves.
    Nodes(u32, u32),
    /// The goods from one to before the other.
    Goods(u32, u32),
}

/// What the places have to offer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Offer {
    /// The place of least cost plus price.
    pub best: usize,
    /// That cost plus price.
    pub least: f64,
    /// The next to least; infinite when there is only one place.
    pub second: f64,
}

impl PriceTree {
    /// All prices are 0.
    pub(super) fn new(places: &[Point]) -> Self {
        let good = |(index, place): (usize, &Point)| Good { place: *place, price: 0.0, index: index as u32 };
        let goods: Vec<Good> = places.iter().enumerate().map(good).collect();
        let mut tree = Self { nodes: Vec::new(), leaves: vec![0; goods.len()], at: vec![0; goods.len()], goods };
        if !places.is_empty() {
            tree.grow((0, places.len()), 0);
        }
        for (slot, good) in tree.goods.iter().enumerate() {
            tree.at[good.index as usize] = slot as u32;
        }
        tree
    }

    /// Adds the node over a range of goods and all below it; halves it across its longer side.
    fn grow(&mut self, (from, to): (usize, usize), parent: u32) -> u32 {
        let goods = &mut self.goods[from..to];
        let first = goods[0].place;
        let bounds = Bounds::of(goods.iter().map(|g| g.place)).unwrap_or(Bounds::new(first, first));
        let node = self.nodes.len() as u32;
        let below = Below::Goods(from as u32, to as u32);
        self.nodes.push(Node { bounds, lowest: 0.0, parent, below });
        if to - from <= LEAF {
            self.leaves[from..to].fill(node);
            return node;
        }
        let is_wide = bounds.width() >= bounds.height();
        let along = |g: &Good| if is_wide { g.place.x } else { g.place.y };
        let middle = (to - from) / 2;
        goods.select_nth_unstable_by(middle, |a, b| along(a).total_cmp(&along(b)).then(a.index.cmp(&b.index)));
        let (left, right) = (self.grow((from, from + middle), node), self.grow((from + middle, to), node));
        self.nodes[node as usize].below = Below::Nodes(left, right);
        node
    }

    /// Where the place `index` is.
    pub(super) fn place(&self, index: usize) -> Point {
        self.goods[self.at[index] as usize].place
    }

    /// What the place `index` costs beside the way.
    pub(super) fn price(&self, index: usize) -> f64 {
        self.goods[self.at[index] as usize].price
    }

    /// Raises the price of the place `index`.
    pub(super) fn raise(&mut self, index: usize, by: f64) {
        let slot = self.at[index] as usize;
        self.goods[slot].price += by;
        let mut node = self.leaves[slot];
        loop {
            let lowest = self.lowest(node);
            // Prices only rise: where the lowest is not this one, nothing changes above.
            if lowest == self.nodes[node as usize].lowest {
                return;
            }
            self.nodes[node as usize].lowest = lowest;
            if node == 0 {
                return;
            }
            node = self.nodes[node as usize].parent;
        }
    }

    fn lowest(&self, node: u32) -> f64 {
        match self.nodes[node as usize].below {
            Below::Nodes(left, right) => self.nodes[left as usize].lowest.min(self.nodes[right as usize].lowest),
            Below::Goods(from, to) => {
                self.goods[from as usize..to as usize].iter().map(|g| g.price).fold(f64::INFINITY, f64::min)
            }
        }
    }

    /// The two places that cost least from `p`, `cost` of the squared distance and price together.
    pub(super) fn best_two(&self, p: Point, cost: &impl Fn(f64) -> f64) -> Offer {
        let mut offer = Offer { best: 0, least: f64::INFINITY, second: f64::INFINITY };
        let bound = |node: u32| {
            let node = &self.nodes[node as usize];
            cost(distance_sq(&node.bounds, p)) + node.lowest
        };
        let mut open = [(0u32, f64::NEG_INFINITY); MAX_DEPTH];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let (node, least_here) = open[depth];
            if least_here >= offer.second {
                continue;
            }
            match self.nodes[node as usize].below {
                Below::Goods(from, to) => {
                    self.goods[from as usize..to as usize].iter().for_each(|good| {
                        offer.take(good.index as usize, cost(good.place.distance_sq(p)) + good.price);
                    });
                }
                Below::Nodes(left, right) => {
                    let (one, two) = ((left, bound(left)), (right, bound(right)));
                    let (near, far) = if two.1 < one.1 { (two, one) } else { (one, two) };
                    (open[depth], open[depth + 1]) = (far, near);
                    depth += 2;
                }
            }
        }
        offer
    }
}

impl Offer {
    fn take(&mut self, index: usize, value: f64) {
        if value < self.least {
            *self = Self { best: index, least: value, second: self.least };
        } else if value < self.second {
            self.second = value;
        }
    }
}

fn distance_sq(bounds: &Bounds, p: Point) -> f64 {
    let beyond = |v: f64, low: f64, high: f64| (low - v).max(v - high).max(0.0);
    let (dx, dy) = (beyond(p.x, bounds.min.x, bounds.max.x), beyond(p.y, bounds.min.y, bounds.max.y));
    dx * dx + dy * dy
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::random::Purpose;
    use crate::compute::random::Stream;

    #[test]
    fn the_tree_offers_what_looking_at_all_places_finds() {
        let mut random = Stream::new(1, Purpose::new("test.price-tree"), 0);
        let mut place = || Point::new((random.range(0.0, 9.0) * 4.0).round(), random.range(0.0, 9.0));
        let places: Vec<Point> = (0..500).map(|_| place()).collect();
        let asked: Vec<Point> = (0..500).map(|_| place()).collect();
        let mut tree = PriceTree::new(&places);
        for (k, p) in asked.into_iter().enumerate() {
            let mut all = Offer { best: 0, least: f64::INFINITY, second: f64::INFINITY };
            (0..places.len()).for_each(|i| all.take(i, places[i].distance(p) + tree.price(i)));
            let offer = tree.best_two(p, &f64::sqrt);
            assert_eq!((offer.least, offer.second), (all.least, all.second));
            tree.raise(offer.best, 0.01 * (k % 7) as f64 + offer.second - offer.least);
            assert_eq!(tree.place(offer.best), places[offer.best]);
        }
    }
}
