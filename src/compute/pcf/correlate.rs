//! The sums behind every curve: who stands around an element, weighted for the border.

use crate::compute::geometry::CellGrid;
use crate::compute::geometry::Point;
use crate::compute::geometry::Region;
use crate::compute::geometry::Surroundings;
use crate::compute::pcf::Frame;
use crate::compute::pcf::Kernel;
use crate::compute::pcf::Metric;

/// The most a pair is weighted for the border. A circle of which less than a hundredth lies
/// inside the domain would otherwise let one pair decide a curve; spatstat cuts at the same
/// value by default.
pub const WEIGHT_CAP: f64 = 100.0;

/// An element as curves see it.
#[derive(Debug, Clone, Copy)]
pub struct Body {
    /// Centre, in metres.
    pub centre: Point,
    /// Radius in the metric's unit; only the disk metric looks at it.
    pub radius: f64,
    /// The frame in which the rings around it are circles.
    pub frame: Frame,
}

/// The border weight of pairs seen from one element (T eq. 3.8): 2π over the angle of the circle
/// through the other that lies inside the domain, in the element's own frame, where the ring of
/// an ellipse is a circle too.
#[derive(Debug, Clone)]
pub struct BorderWeight {
    around: Surroundings,
    clearance: f64,
    cap: f64,
}

impl BorderWeight {
    /// For pairs of `body` up to `reach` (in its frame) in `domain`.
    pub fn new(domain: &Region, body: &Body, reach: f64, cap: f64) -> Self {
        let around = domain.surroundings(body.centre, body.frame.farthest(reach)).mapped(|p| body.frame.map(p));
        let clearance = if around.is_inside() { around.clearance() } else { 0.0 };
        Self { around, clearance, cap }
    }

    /// How far the border is, in the element's frame; 0 outside the domain.
    pub fn clearance(&self) -> f64 {
        self.clearance
    }

    /// The weight of a pair at `distance`, in the element's frame; from 1 to the cap.
    pub fn at(&self, distance: f64) -> f64 {
        if distance <= self.clearance {
            return 1.0;
        }
        let inside = self.around.arc_inside_roughly(distance) / std::f64::consts::TAU;
        (1.0 / inside.max(1e-12)).min(self.cap)
    }
}

/// The elements that may stand around another, ready to be searched.
#[derive(Debug, Clone)]
pub struct Crowd {
    bodies: Vec<Body>,
    grid: CellGrid,
    largest_radius: f64,
}

impl Crowd {
    /// Sorts `bodies` into cells about `cell` metres wide.
    pub fn new(bodies: Vec<Body>, cell: f64) -> Self {
        let centres: Vec<Point> = bodies.iter().map(|b| b.centre).collect();
        let largest_radius = bodies.iter().map(|b| b.radius).fold(0.0, f64::max);
        Self { grid: CellGrid::new(&centres, cell), bodies, largest_radius }
    }

    /// Calls `visit` with the centres of all bodies within `radius` metres of `p`, and some beyond.
    pub fn for_each_near(&self, p: Point, radius: f64, mut visit: impl FnMut(Point)) {
        self.grid.for_each_near(p, radius, |j| visit(self.bodies[j].centre));
    }

    /// The bodies, in the order given.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }
}

/// How pairs become curves.
#[derive(Debug, Clone)]
pub struct Correlator {
    /// The distance of the axis.
    pub metric: Metric,
    /// The kernel over the axis.
    pub kernel: Kernel,
    /// The most a pair is weighted for the border.
    pub weight_cap: f64,
    power: i32,
}

impl Correlator {
    /// Pairs at distances of `metric`, smoothed by `kernel`, weighted up to `weight_cap`.
    pub fn new(metric: Metric, kernel: Kernel, weight_cap: f64) -> Self {
        Self { metric, kernel, weight_cap, power: 1 }
    }

    /// How far, in the frame of `body`, partners in `crowd` can add to its curve.
    pub fn reach(&self, body: &Body, crowd: &Crowd) -> f64 {
        self.metric.reach(self.kernel.axis().reach(), body.radius, crowd.largest_radius)
    }

    /// The places of the axis, from the first, at which all partners of `body` in `crowd` are
    /// nearer than `distance` (in its frame).
    pub fn places_within(&self, body: &Body, crowd: &Crowd, distance: f64) -> usize {
        self.kernel.axis().bins_up_to(self.metric.value(distance, body.radius, crowd.largest_radius))
    }

    /// The same for sums of squared terms.
    pub fn squared(&self) -> Self {
        Self { kernel: self.kernel.squared(), power: 2, ..self.clone() }
    }

    /// Adds to `row` the kernel sum of `body` over all of `crowd` but the one at `itself`.
    pub fn add_row(&self, row: &mut [f64], seen_from: (&Body, &BorderWeight), crowd: &Crowd, itself: Option<usize>) {
        let (body, weight) = seen_from;
        let reach = self.reach(body, crowd);
        crowd.grid.for_each_near(body.centre, body.frame.farthest(reach), |j| {
            let other = &crowd.bodies[j];
            let distance = body.frame.map(other.centre - body.centre).norm();
            if distance > reach || itself == Some(j) {
                return;
            }
            let place = self.metric.value(distance, body.radius, other.radius);
            if place <= self.kernel.axis().reach() {
                self.kernel.add(row, place, weight.at(distance).powi(self.power));
            }
        });
    }
}
