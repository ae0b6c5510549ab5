//! The five steering forces (T 4.3.2, after Reynolds 1987 and 1999): separation, alignment,
//! cohesion, obstacle avoidance by prediction, and following the guide.

use super::AnimationError;
use super::motion::Mover;
use super::terrain::Ground;
use crate::compute::geometry::Point;
use crate::compute::herds::contact::Footprint;

/// Weights and ranges of the forces. The text gives none: all defaults are ours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steering {
    /// Pushes neighbours apart that are closer than their guides are, as a share of V_max.
    /// Default: 0.6.
    pub separation: f64,
    /// Takes on the neighbours' velocity, as far as the animal is away from its guide. Default: 0.3.
    pub alignment: f64,
    /// Draws towards the neighbours, likewise, as a share of V_max. Default: 0.1.
    pub cohesion: f64,
    /// Steers away from where a collision with an obstacle is predicted, as a share of V_max.
    /// Default: 1.
    pub avoidance: f64,
    /// Seconds in which an animal makes up what it lacks to its guide. Default: 1.
    pub following_s: f64,
    /// How far ahead collisions with obstacles are predicted, in seconds. Default: 2.
    pub foresight_s: f64,
    /// Neighbours are those within this many body lengths. Default: 2.
    pub neighbourhood_body_lengths: f64,
}

impl Default for Steering {
    fn default() -> Self {
        Self {
            separation: 0.6,
            alignment: 0.3,
            cohesion: 0.1,
            avoidance: 1.0,
            following_s: 1.0,
            foresight_s: 2.0,
            neighbourhood_body_lengths: 2.0,
        }
    }
}

impl Steering {
    pub(super) fn check(&self) -> Result<(), AnimationError> {
        let rules = [
            ("steering.separation", self.separation, 0.0..=10.0, "from 0 to 10"),
            ("steering.alignment", self.alignment, 0.0..=10.0, "from 0 to 10"),
            ("steering.cohesion", self.cohesion, 0.0..=10.0, "from 0 to 10"),
            ("steering.avoidance", self.avoidance, 0.0..=10.0, "from 0 to 10"),
            ("steering.following_s", self.following_s, 0.05..=60.0, "from 0.05 to 60"),
            ("steering.foresight_s", self.foresight_s, 0.0..=60.0, "from 0 to 60"),
            ("steering.neighbourhood_body_lengths", self.neighbourhood_body_lengths, 0.5..=10.0, "from 0.5 to 10"),
        ];
        match rules.into_iter().find(|(_, found, range, _)| !range.contains(found)) {
            Some((field, found, _, expected)) => Err(AnimationError::BadOption { field, expected, found }),
            None => Ok(()),
        }
    }

    /// The force of the guide: its velocity, and what makes up the lag within `following_s`.
    pub(super) fn follow(&self, place: Point, guide: Point, guide_velocity: Point) -> Point {
        guide_velocity + (guide - place) * (1.0 / self.following_s)
    }

    /// The force away from an obstacle that the animal would come near: judged where it is, where
    /// it will be in `foresight_s`, and half-way there. It pushes off the obstacle, the stronger
    /// the nearer, but not back along `course`: the way past is found by looking, not by pushing.
    pub(super) fn avoid(
        &self,
        mover: &Mover,
        ground: &Ground<'_>,
        (course, half_width, speed): (Point, f64, f64),
    ) -> Point {
        let comfort = 2.0 * half_width;
        let clearance = ground.clearance();
        if clearance.at(mover.place) > comfort + speed * self.foresight_s {
            return Point::default();
        }
        let ahead = |share: f64| mover.place + mover.velocity() * (self.foresight_s * share);
        let force = [0.0, 0.5, 1.0].into_iter().map(ahead).fold(Point::default(), |force, p| {
            let lack = 1.0 - clearance.at(p) / comfort;
            match clearance.away(p).or_else(|| clearance.away(mover.place)) {
                Some(away) if lack > 0.0 => force + away * (lack.min(1.5) * self.avoidance * speed / 3.0),
                _ => force,
            }
        });
        force + course * (-force.dot(course)).max(0.0)
    }
}

/// What an animal sees of its neighbours, summed in the order they are met.
#[derive(Debug, Clone, Copy)]
pub(super) struct Company {
    apart: Point,
    velocity: Point,
    centre: Point,
    count: f64,
    room_ahead: f64,
}

/// One neighbour.
pub(super) struct Neighbour<'a> {
    pub print: &'a Footprint,
    /// Metres a second.
    pub velocity: Point,
    /// How far apart the two guides are, in metres.
    pub guides_apart: f64,
    /// Whether it gives way rather than the animal that looks at it.
    pub yields: bool,
}

/// Neighbours keep at most this many times the distance at which they touch (ours).
const COMFORT: f64 = 1.4;

/// However near the animal in front, one goes on this slowly, in metres a second (ours): the rule
/// of the road stops it where there is no room, and where there is it must not wait for ever.
const CREEP_M_PER_S: f64 = 0.4;

/// And at least this share of it, where their guides are as close (ours): `touch` is taken along
/// the line of centres, and bodies that stand askew come nearer.
const CLOSEST: f64 = 0.6;

/// How much less a neighbour that yields pushes, and how much more the other does (ours):
/// without a difference two that meet head on would wait for each other.
const YIELDING: (f64, f64) = (0.6, 1.4);

/// A gap to an animal in front is used up within this many seconds (ours).
const FOLLOWING_S: f64 = 0.7;

impl Company {
    pub(super) fn new() -> Self {
        let none = Point::default();
        Self { apart: none, velocity: none, centre: none, count: 0.0, room_ahead: f64::INFINITY }
    }

    /// Takes in a neighbour, seen from `own`.
    pub(super) fn meet(&mut self, own: &Footprint, neighbour: &Neighbour<'_>) {
        let offset = own.centre() - neighbour.print.centre();
        let distance = offset.norm();
        self.velocity = self.velocity + neighbour.velocity;
        self.centre = self.centre + neighbour.print.centre();
        self.count += 1.0;
        let Some(away) = offset.normalised() else { return };
        let touch = own.support(away) + neighbour.print.support(away);
        let comfort = (neighbour.guides_apart / touch).clamp(CLOSEST, COMFORT);
        let lack = comfort - distance / touch;
        if lack > 0.0 {
            let weight = if neighbour.yields { YIELDING.0 } else { YIELDING.1 };
            self.apart = self.apart + away * ((lack / 0.3).min(2.0) * weight);
        }
        // Who walks in front is not run into.
        let heading = own.heading();
        if -away.dot(heading) > 0.7 {
            let leaves = neighbour.velocity.dot(heading).max(0.0);
            let gap = (distance - touch * comfort.min(1.0)).max(0.0);
            self.room_ahead = self.room_ahead.min(leaves + gap / FOLLOWING_S + CREEP_M_PER_S);
        }
    }

    /// The fastest that does not run into who walks in front, in metres a second.
    pub(super) fn room_ahead(&self) -> f64 {
        self.room_ahead
    }

    /// Separation, alignment and cohesion as one velocity. `lost` from 0 (at the guide) to 1
    /// (two body lengths away) weighs the last two: the guide knows better.
    pub(super) fn forces(&self, steering: &Steering, mover: &Mover, (speed, lost): (f64, f64)) -> Point {
        if self.count == 0.0 {
            return Point::default();
        }
        let mean = 1.0 / self.count;
        let align = (self.velocity * mean - mover.velocity()) * (steering.alignment * lost);
        let centre = (self.centre * mean - mover.place).normalised().unwrap_or_default();
        self.apart * (steering.separation * speed) + align + centre * (steering.cohesion * speed * lost)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compute::geometry::Ellipse;
    use crate::compute::herds::Obstacles;
    use crate::compute::herds::animation::KeyFrame;
    use crate::compute::herds::animation::KeyPose;
    use crate::compute::raster::Grid;
    use crate::compute::raster::Raster;
    use crate::compute::run::Run;

    fn animal(x: f64, y: f64) -> Footprint {
        Footprint::new(&Ellipse { centre: Point::new(x, y), a: 1.2, b: 0.5, theta: 0.0 })
    }

    /// The forces at 2 m/s on an animal at the origin that walks east at 1 m/s.
    fn force(neighbours: &[(Footprint, Point, f64)], steering: &Steering, lost: f64) -> Point {
        let mut company = Company::new();
        for (print, velocity, guides_apart) in neighbours {
            let neighbour = Neighbour { print, velocity: *velocity, guides_apart: *guides_apart, yields: false };
            company.meet(&animal(0.0, 0.0), &neighbour);
        }
        let mover = Mover { speed: 1.0, ..Mover::standing(Point::default(), 0.0) };
        company.forces(steering, &mover, (2.0, lost))
    }

    const ALONE: Steering = Steering {
        separation: 0.0,
        alignment: 0.0,
        cohesion: 0.0,
        avoidance: 0.0,
        following_s: 1.0,
        foresight_s: 2.0,
        neighbourhood_body_lengths: 2.0,
    };

    const EAST: Point = Point { x: 1.0, y: 0.0 };

    #[test]
    fn a_guide_gives_its_velocity_and_what_is_lacking_to_it() {
        let steering = Steering { following_s: 2.0, ..ALONE };
        let force = steering.follow(Point::new(1.0, 1.0), Point::new(5.0, 3.0), Point::new(0.5, -0.5));
        assert_eq!(force, Point::new(2.5, 0.5));
    }

    #[test]
    fn separation_pushes_off_who_is_nearer_than_its_guide_and_nobody_else() {
        let separation = Steering { separation: 1.0, ..ALONE };
        let beside = force(&[(animal(0.0, 1.1), EAST, 2.0)], &separation, 0.0);
        assert!(beside.y < -0.5 && beside.x.abs() < 1e-9, "{beside:?}");
        let nearer = force(&[(animal(0.0, 1.02), EAST, 2.0)], &separation, 0.0);
        assert!(nearer.y < beside.y, "{nearer:?}");
        assert_eq!(force(&[(animal(0.0, 1.5), EAST, 2.0)], &separation, 0.0), Point::default());
        // Those whose guides are as near may be.
        assert_eq!(force(&[(animal(0.0, 1.1), EAST, 1.1)], &separation, 0.0), Point::default());
        assert_eq!(force(&[(animal(0.0, 1.1), EAST, 2.0)], &ALONE, 0.0), Point::default());
    }

    #[test]
    fn alignment_takes_on_the_neighbours_velocity_away_from_the_guide() {
        let alignment = Steering { alignment: 0.5, ..ALONE };
        let north = Point::new(0.0, 2.0);
        let neighbours = [(animal(0.0, 4.0), north, 4.0), (animal(3.0, -4.0), north, 5.0)];
        assert_eq!(force(&neighbours, &alignment, 1.0), Point::new(-0.5, 1.0));
        assert_eq!(force(&neighbours, &alignment, 0.5), Point::new(-0.25, 0.5));
        assert_eq!(force(&neighbours, &alignment, 0.0), Point::default());
    }

    #[test]
    fn cohesion_draws_to_the_middle_of_the_neighbours_away_from_the_guide() {
        let cohesion = Steering { cohesion: 0.5, ..ALONE };
        let neighbours = [(animal(-3.0, 4.0), EAST, 5.0), (animal(3.0, 4.0), EAST, 5.0)];
        let drawn = force(&neighbours, &cohesion, 1.0);
        assert!((drawn.y - 1.0).abs() < 1e-9 && drawn.x.abs() < 1e-9, "{drawn:?}");
        assert_eq!(force(&neighbours, &cohesion, 0.0), Point::default());
        assert_eq!(force(&[], &cohesion, 1.0), Point::default());
    }

    #[test]
    fn obstacles_push_off_where_a_collision_is_predicted_but_never_back() {
        let terrain = Raster::filled(Grid::new(60, 60, 1.0), 0f32);
        let rock = Obstacles { disks: vec![(Point::new(30.0, 30.0), 3.0)], ..Obstacles::default() };
        let body = Ellipse { centre: Point::new(20.0, 29.0), a: 1.2, b: 0.5, theta: 0.0 };
        let frames = [
            KeyFrame { time_s: 0.0, pose: KeyPose::Herd(vec![body]) },
            KeyFrame { time_s: 9.0, pose: KeyPose::Position(Point::new(40.0, 29.0)) },
        ];
        let ground = Ground::new(&terrain, &rock, &frames, &Run::silent()).unwrap();
        let steering = Steering { avoidance: 1.0, ..ALONE };
        let push = |x: f64, y: f64, heading: f64| {
            let mover = Mover { speed: 2.0, ..Mover::standing(Point::new(x, y), heading) };
            steering.avoid(&mover, &ground, (Point::from_angle(heading), 0.5, 2.0))
        };
        // It passes the rock's south side in two seconds, then in ten.
        let near = push(23.0, 28.5, 0.0);
        assert!(near.y < -0.1 && near.x >= -1e-9, "{near:?}");
        assert_eq!(push(8.0, 28.5, 0.0), Point::default());
        // Away from the rock nothing pushes.
        assert_eq!(push(23.0, 28.5, std::f64::consts::PI), Point::default());
    }
}
