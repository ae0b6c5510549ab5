use crate::compute::pcf::Element;
use crate::compute::pcf::PcfError;

/// Which classes look at which: an acyclic graph of (child, parent) pairs (T 3.3). A child is
/// laid out after its parents and keeps its correlation with each of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Dependencies {
    parents: Vec<Vec<usize>>,
    order: Vec<usize>,
}

impl Dependencies {
    /// The given (child, parent) pairs over `classes` classes. Pairs given twice count once.
    ///
    /// # Errors
    /// [`PcfError::EmptyClass`] for a class out of range, [`PcfError::Cycle`] naming a circle
    /// (a class that depends on itself is one).
    pub fn new(classes: usize, pairs: &[(usize, usize)]) -> Result<Self, PcfError> {
        let mut parents = vec![Vec::new(); classes];
        for (child, parent) in pairs {
            if let Some(class) = [*child, *parent].into_iter().find(|c| *c >= classes) {
                return Err(PcfError::EmptyClass { class });
            }
            parents[*child].push(*parent);
        }
        for list in &mut parents {
            list.sort_unstable();
            list.dedup();
        }
        let order = topological_order(&parents)?;
        Ok(Self { parents, order })
    }

    /// The default: every class depends on all earlier ones in the order of decreasing mean
    /// radius, equal means by class number.
    pub fn by_size(classes: usize, elements: &[Element]) -> Self {
        let mean = |class: usize| {
            let radii: Vec<f64> = elements.iter().filter(|e| e.class == class).map(|e| e.radius).collect();
            radii.iter().sum::<f64>() / radii.len().max(1) as f64
        };
        let means: Vec<f64> = (0..classes).map(mean).collect();
        let mut order: Vec<usize> = (0..classes).collect();
        order.sort_by(|a, b| means[*b].total_cmp(&means[*a]).then(a.cmp(b)));
        let mut parents = vec![Vec::new(); classes];
        for (place, class) in order.iter().enumerate() {
            parents[*class] = order[..place].to_vec();
            parents[*class].sort_unstable();
        }
        Self { parents, order }
    }

    /// The parents of `class`, ascending.
    pub fn parents(&self, class: usize) -> &[usize] {
        &self.parents[class]
    }

    /// All classes, parents before children.
    pub fn order(&self) -> &[usize] {
        &self.order
    }

    /// Every curve: (class, itself), then (class, parent) for each parent, classes in order.
    pub fn curves(&self) -> Vec<(usize, usize)> {
        let of = |class: &usize| {
            let class = *class;
            std::iter::once((class, class)).chain(self.parents[class].iter().map(move |p| (class, *p)))
        };
        self.order.iter().flat_map(of).collect()
    }
}

/// Parents before children, the lowest free class first.
fn topological_order(parents: &[Vec<usize>]) -> Result<Vec<usize>, PcfError> {
    let mut order: Vec<usize> = Vec::new();
    let mut placed = vec![false; parents.len()];
    while order.len() < parents.len() {
        let free = |c: &usize| !placed[*c] && parents[*c].iter().all(|p| placed[*p]);
        match (0..parents.len()).find(free) {
            Some(class) => {
                placed[class] = true;
                order.push(class);
            }
            None => return Err(PcfError::Cycle { classes: a_cycle(parents, &placed) }),
        }
    }
    Ok(order)
}

/// A circle among the classes not placed: each of them has a parent not placed, so following
/// those must come back.
fn a_cycle(parents: &[Vec<usize>], placed: &[bool]) -> Vec<usize> {
    let mut path: Vec<usize> = (0..parents.len()).find(|c| !placed[*c]).into_iter().collect();
    for _ in 0..=parents.len() {
        let Some(next) = path.last().and_then(|last| parents[*last].iter().find(|p| !placed[**p])) else { break };
        if let Some(start) = path.iter().position(|c| c == next) {
            path.drain(..start);
            path.push(*next);
            break;
        }
        path.push(*next);
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::geometry::Point;

    #[test]
    fn parents_come_before_children() {
        // The graph of T figure 3.8 in spirit: d looks at a and b only.
        let graph = Dependencies::new(5, &[(1, 0), (2, 1), (3, 0), (3, 1), (4, 2), (0, 4), (0, 4)]);
        assert_eq!(graph.unwrap_err(), PcfError::Cycle { classes: vec![0, 4, 2, 1, 0] });
        let graph = Dependencies::new(5, &[(1, 4), (2, 1), (3, 0), (3, 1)]).unwrap();
        assert_eq!(graph.order(), [0, 4, 1, 2, 3]);
        assert_eq!(graph.curves().len(), 5 + 4);
    }

    #[test]
    fn a_cycle_is_named() {
        let cycle = Dependencies::new(4, &[(1, 0), (2, 1), (3, 2), (1, 3)]).unwrap_err();
        assert_eq!(cycle, PcfError::Cycle { classes: vec![1, 3, 2, 1] });
        assert_eq!(Dependencies::new(2, &[(1, 1)]).unwrap_err(), PcfError::Cycle { classes: vec![1, 1] });
        assert_eq!(Dependencies::new(2, &[(1, 2)]).unwrap_err(), PcfError::EmptyClass { class: 2 });
    }

    #[test]
    fn by_default_smaller_classes_look_at_all_larger_ones() {
        let e = |class, radius| Element { centre: Point::default(), radius, class };
        let graph = Dependencies::by_size(3, &[e(0, 0.1), e(1, 2.0), e(2, 0.1)]);
        assert_eq!(graph.order(), [1, 0, 2]);
        assert_eq!((graph.parents(0), graph.parents(2)), ([1].as_slice(), [0, 1].as_slice()));
    }
}
