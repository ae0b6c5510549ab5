//! The options of an animation over the defaults.

use biotope_api::herds::AxisInput;
use biotope_api::herds::GaitInput;
use biotope_api::herds::HerdAnimationInputs;
use biotope_api::herds::PairingInput;
use biotope_api::herds::SteeringInput;

use crate::compute::herds::animation::AnimationOptions;
use crate::compute::herds::animation::Gait;
use crate::compute::herds::animation::PairingMetric;
use crate::compute::herds::animation::Steering;

/// The options of a request.
pub fn options(inputs: &HerdAnimationInputs) -> AnimationOptions {
    AnimationOptions {
        gait: gait(&inputs.gait),
        pairing: pairing(inputs.pairing),
        steering: steering(&inputs.steering),
        step_s: inputs.step_s,
        keep_every: (inputs.every_s / inputs.step_s).round().max(1.0) as usize,
    }
}

fn gait(input: &GaitInput) -> Gait {
    let default = Gait::default();
    Gait {
        max_speed_m_per_s: input.max_speed_m_per_s.unwrap_or(default.max_speed_m_per_s),
        max_turn_rad_per_s: input.max_turn_rad_per_s.unwrap_or(default.max_turn_rad_per_s),
        max_acceleration_m_per_s2: input.max_acceleration_m_per_s2.unwrap_or(default.max_acceleration_m_per_s2),
        max_slip_rad: input.max_slip_rad.unwrap_or(default.max_slip_rad),
        blend_body_lengths: input.blend_body_lengths.unwrap_or(default.blend_body_lengths),
    }
}

fn pairing(input: PairingInput) -> PairingMetric {
    match input {
        PairingInput::Euclidean => PairingMetric::Euclidean,
        PairingInput::Power { exponent } => PairingMetric::Power { exponent },
        PairingInput::Axis { axis, penalty } => PairingMetric::Axis { along: axis == AxisInput::Along, penalty },
    }
}

fn steering(input: &SteeringInput) -> Steering {
    let default = Steering::default();
    Steering {
        separation: input.separation.unwrap_or(default.separation),
        alignment: input.alignment.unwrap_or(default.alignment),
        cohesion: input.cohesion.unwrap_or(default.cohesion),
        avoidance: input.avoidance.unwrap_or(default.avoidance),
        following_s: input.following_s.unwrap_or(default.following_s),
        foresight_s: input.foresight_s.unwrap_or(default.foresight_s),
        neighbourhood_body_lengths: input.neighbourhood_body_lengths.unwrap_or(default.neighbourhood_body_lengths),
    }
}
