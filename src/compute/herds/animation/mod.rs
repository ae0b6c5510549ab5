//! Animation of a herd between key-herds (T 4.3, H "Herd animation"): a spline through the
//! key-frames, animals paired by optimal transport, guides that move straight in the herd frame,
//! and a steering simulation that follows them.

mod aim;
mod choice;
mod error;
mod frames;
mod guides;
mod motion;
mod pairing;
mod report;
mod route;
mod simulate;
mod steering;
mod terrain;
mod tracks;
mod traffic;
mod trajectory;

pub use error::AnimationError;
pub use frames::KeyFrame;
pub use frames::KeyPose;
pub use motion::Gait;
pub use pairing::PairingMetric;
pub use pairing::pair;
pub use report::Arrival;
pub use report::Late;
pub use report::Report;
pub use report::Why;
pub use simulate::Simulation;
pub use steering::Steering;
pub use tracks::Pose;
pub use tracks::Tracks;
pub use trajectory::Trajectory;

use crate::compute::herds::Obstacles;
use crate::compute::raster::Raster;
use crate::compute::run::Run;

/// What may be chosen about an animation.
#[derive(Debug, Clone, PartialEq)]
pub struct AnimationOptions {
    /// How fast animals move and turn.
    pub gait: Gait,
    /// How animals of successive key-herds are paired. Default: squared distance.
    pub pairing: PairingMetric,
    /// The five steering forces.
    pub steering: Steering,
    /// Longest step of the simulation in seconds. Default: 0.1.
    pub step_s: f64,
    /// A pose is kept every so many steps, and at every key-frame. Default: 1.
    pub keep_every: usize,
}

impl Default for AnimationOptions {
    fn default() -> Self {
        Self {
            gait: Gait::default(),
            pairing: PairingMetric::Power { exponent: 2 },
            steering: Steering::default(),
            step_s: 0.1,
            keep_every: 1,
        }
    }
}

/// A herd that has walked.
#[derive(Debug, Clone, PartialEq)]
pub struct Animation {
    /// Where every animal was.
    pub tracks: Tracks,
    /// Who reached the key-frames in time, who did not and why.
    pub report: Report,
    /// The path of the herd frame.
    pub trajectory: Trajectory,
}

/// Everything that keeps `frames` and `options` from making an animation, as far as it can be said
/// before work begins: key-frames that make no path, options out of range, tracks too large. Empty
/// when nothing does.
pub fn faults(
    terrain: &Raster<f32>,
    obstacles: &Obstacles,
    frames: &[KeyFrame],
    options: &AnimationOptions,
) -> Vec<AnimationError> {
    let mut all = frames::faults(terrain, obstacles, frames);
    all.extend(options.faults());
    if all.is_empty() {
        all.extend(tracks::Plan::new(frames, options).err());
    }
    all
}

/// Lets a herd walk over `terrain` (heights in metres) through `frames`.
///
/// # Errors
/// Key-frames that make no path, options out of range, no way round the obstacles, tracks too
/// large, or a stop: see [`AnimationError`].
pub fn animate(
    terrain: &Raster<f32>,
    obstacles: &Obstacles,
    frames: &[KeyFrame],
    options: &AnimationOptions,
    run: &Run,
) -> Result<Animation, AnimationError> {
    // 1. Everything is checked before work begins.
    faults(terrain, obstacles, frames, options).into_iter().next().map_or(Ok(()), Err)?;
    let plan = tracks::Plan::new(frames, options)?;
    // 2. A clearance map of the surroundings, and a spline through the key-frames on it.
    let ground = terrain::Ground::new(terrain, obstacles, frames, run)?;
    let trajectory = Trajectory::new(&frames::centres(frames), ground.clearance(), frames::width(frames), run)?;
    run.progress("animation.path", 1, 1)?;
    // 3. Key-herds are brought into the herd frame and paired; guides move straight between them.
    let guides = guides::Guides::new(frames, &trajectory, options.pairing, run)?;
    run.progress("animation.pairing", 1, 1)?;
    // 4. Animals steer along their guides, step by step.
    let mut simulation = Simulation::new(&ground, &trajectory, &guides, options);
    let (tracks, report) = simulation.walk(&plan, run)?;
    Ok(Animation { tracks, report, trajectory })
}

impl AnimationOptions {
    fn faults(&self) -> Vec<AnimationError> {
        let step = !(0.001..=5.0).contains(&self.step_s);
        let bad = |field, expected, found| AnimationError::BadOption { field, expected, found };
        let own = [
            step.then(|| bad("step_s", "from 0.001 to 5", self.step_s)),
            (self.keep_every == 0).then(|| bad("keep_every", "at least 1", 0.0)),
        ];
        let parts = [self.pairing.check(), self.gait.check(), self.steering.check()];
        parts.into_iter().filter_map(Result::err).chain(own.into_iter().flatten()).collect()
    }
}
