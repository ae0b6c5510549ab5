//! What elements of a block and its parents see when one element is taken out for a while: copies
//! of the rows it is in, so that the block itself stays as it is and many can ask at one time.

use super::border_table::BorderTable;
use super::filling::Filling;
use super::kernel_rows::add;
use super::kernel_rows::add_products;
use super::partners::Partner;
use super::partners::Partners;
use super::patch::Patch;

/// Copies of some rows of a list.
#[derive(Debug, Clone, Default)]
struct Copies {
    /// One more than the copy's number; 0: none.
    numbers: Vec<u32>,
    copied: Vec<usize>,
    rows: Vec<Vec<f32>>,
}

impl Copies {
    fn clear(&mut self) {
        self.copied.drain(..).for_each(|j| self.numbers[j] = 0);
    }

    /// The copy of row `j`, which is `original`, or zeros where that is empty; `length` values.
    fn of(&mut self, j: usize, original: &[f32], length: usize) -> &mut [f32] {
        if self.numbers.len() <= j {
            self.numbers.resize(j + 1, 0);
        }
        if self.numbers[j] == 0 {
            self.copied.push(j);
            self.numbers[j] = self.copied.len() as u32;
            self.rows.resize_with(self.rows.len().max(self.copied.len()), Vec::new);
            let row = &mut self.rows[self.copied.len() - 1];
            row.clear();
            row.extend_from_slice(original);
            row.resize(length, 0.0);
        }
        &mut self.rows[self.numbers[j] as usize - 1]
    }

    fn row<'b>(&'b self, j: usize, original: &'b [f32]) -> &'b [f32] {
        match self.numbers.get(j) {
            Some(number) if *number > 0 => &self.rows[*number as usize - 1],
            _ => original,
        }
    }
}

/// A block without one of its elements, or with all.
#[derive(Debug, Clone, Default)]
pub(super) struct Absence {
    /// Who is taken out.
    pub(super) element: Option<usize>,
    /// The rows changed, one list a view.
    views: Vec<Copies>,
}

impl Absence {
    /// Takes element `i` out, and whoever was out before back in.
    pub(super) fn take_out(&mut self, i: usize, (patch, filling): (&Patch<'_>, &Filling)) {
        self.views.iter_mut().for_each(Copies::clear);
        self.views.resize_with(patch.scene.views.len(), Copies::default);
        self.element = Some(i);
        let factors = &patch.scene.views[0].goal.factors;
        let block = (&filling.inner, &*filling.borders);
        for_each_seeing(patch, (i, &filling.inner.list()[i]), block, |v, j, (first, kernel, weight)| {
            if v > 0 {
                add(&mut self.views[v].of(j, &filling.seen[v][j], factors.len())[first..], kernel, -weight);
            } else {
                let row = &mut self.views[0].of(j, &filling.curves[j], factors.len())[first..];
                add_products(row, (kernel, &factors[first..]), -weight);
            }
        });
    }

    /// What element or partner `j` of view `v` sees: `original`, but for the one taken out.
    pub(super) fn row<'b>(&'b self, v: usize, j: usize, original: &'b [f32]) -> &'b [f32] {
        self.views.get(v).map_or(original, |copies| copies.row(j, original))
    }
}

/// Calls `visit` for all that see element `i` of the block, `seen`: with the view (0: its own
/// class), their number, and where in their row it adds the kernel with what weight.
pub(super) fn for_each_seeing(
    patch: &Patch<'_>,
    (i, seen): (usize, &Partner),
    (inner, borders): (&Partners, &[BorderTable]),
    mut visit: impl FnMut(usize, usize, (usize, &[f32], f32)),
) {
    let scene = patch.scene;
    let extent = scene.rows.reach(scene.sparse.axis.extent);
    let mut term = |v: usize, j: usize, other: &Partner, weight: &dyn Fn(f64) -> f64| {
        let distance = other.place.distance(seen.place) / scene.unit;
        let place = scene.metric.value(distance, seen.radius, other.radius);
        if place <= extent {
            let (first, kernel) = scene.rows.around(place);
            visit(v, j, (first, kernel, (weight(distance) * seen.weight) as f32));
        }
    };
    inner.for_each_near(seen.place, scene.reach(inner, seen.radius, extent) * scene.unit, |j, other| {
        if j != i {
            term(0, j, other, &|d| borders[j].at(d));
        }
    });
    for (v, view) in scene.views.iter().enumerate().filter(|(_, view)| !view.borders.is_empty()) {
        let reach = scene.reach(&view.partners, seen.radius, extent) * scene.unit;
        view.partners.for_each_near(seen.place, reach, |j, parent| {
            term(v, j, parent, &|d| view.borders[j].at(d));
        });
    }
}
