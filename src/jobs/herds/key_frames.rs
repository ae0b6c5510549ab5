//! Key-frames in: those of the request, and those along the path of a herd of an ecosystem.

use biotope_api::error::ErrorCode;
use biotope_api::herds::AlongPathInput;
use biotope_api::herds::HerdAnimationInputs;
use biotope_api::herds::KeyFrameInput;
use biotope_api::warning::Warning;
use biotope_api::warning::WarningCode;

use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Point;
use crate::compute::herds::animation::AnimationOptions;
use crate::compute::herds::animation::KeyFrame;
use crate::compute::herds::animation::KeyPose;
use crate::jobs::Invalid;
use crate::jobs::Sources;
use crate::jobs::given;
use crate::jobs::herds::ellipses;
use crate::jobs::herds::tie;
use crate::jobs::herds::walk_options;

/// Time between two key-frames along a path, seconds.
const EVERY_S: f64 = 300.0;

/// The most poses of all animals together: a table of them is a file of some 150 MB.
const MOST_POSES: usize = 2_000_000;

/// The most key-frames along a path.
const MOST_ALONG: f64 = 20_000.0;

/// Where key-frames along a path stand in a request.
const ALONG: &str = "/along/ecosystem_herd";

/// Key-frames in the order of their times.
pub struct KeyFrames {
    /// What the herd walks through.
    pub frames: Vec<KeyFrame>,
    /// Where each stands in the request.
    pub pointers: Vec<String>,
    /// What readers should know.
    pub warnings: Vec<Warning>,
}

/// The key-frames of a request.
///
/// # Errors
/// Those without a place or with two, references that lead nowhere.
pub fn open(inputs: &HerdAnimationInputs, sources: &dyn Sources) -> Result<KeyFrames, Invalid> {
    let mut all = Invalid::default();
    let mut given: Vec<(KeyFrame, String)> = Vec::new();
    for (i, input) in inputs.key_frames.iter().enumerate() {
        let pointer = format!("/key_frames/{i}");
        let before = i.checked_sub(1).map(|before| inputs.key_frames[before].time_s);
        // Those along a path are sorted in: afterwards nobody could tell.
        let before = before.filter(|before| inputs.along.is_some() && !(input.time_s > *before));
        if let Some(before) = before {
            let expected = format!("a time after {before} s, that of the key-frame before");
            all.push(format!("{pointer}/time_s"), ErrorCode::TimesNotRising, expected, format!("{} s", input.time_s));
        }
        given.extend(all.keep(frame(input, &pointer, sources)).map(|frame| (frame, pointer)));
    }
    let along = inputs.along.as_ref().and_then(|along| all.keep(along_path(along, &given, sources)));
    all.into_result()?;
    let mut warnings = Vec::new();
    if let Some((more, size)) = along {
        let found = given.iter().find_map(|(frame, _)| frame.herd()).map_or(0, <[Ellipse]>::len);
        if found > 0 && found != size {
            let message = format!("the key-herd has {found} animals, the herd of the ecosystem {size}");
            warnings.push(Warning::new(WarningCode::HerdSizeDiffers, "/key_frames", message));
        }
        given.extend(more);
        given.sort_by(|(a, _), (b, _)| a.time_s.total_cmp(&b.time_s));
        keep_resting(&mut given);
    }
    let (frames, pointers) = given.into_iter().unzip();
    let frames = KeyFrames { frames, pointers, warnings };
    frames.check_size(inputs).map(|()| frames)
}

fn frame(input: &KeyFrameInput, pointer: &str, sources: &dyn Sources) -> Result<KeyFrame, Invalid> {
    let pose = match (&input.position, &input.herd) {
        (Some([x, y]), None) => KeyPose::Position(Point::new(*x, *y)),
        (None, Some(herd)) => {
            let pointer = format!("{pointer}/herd");
            let animals = given::open(herd, &pointer, sources)?;
            if animals.is_empty() {
                return Err(Invalid::new(pointer, ErrorCode::WrongCount, "at least one animal", "none"));
            }
            KeyPose::Herd(ellipses::ellipses(&animals, &pointer)?)
        }
        (None, None) => {
            return Err(Invalid::new(pointer, ErrorCode::Missing, "a position or a herd", "neither"));
        }
        (Some(_), Some(_)) => {
            return Err(Invalid::new(pointer, ErrorCode::Inconsistent, "either a position or a herd", "both"));
        }
    };
    Ok(KeyFrame { time_s: input.time_s, pose })
}

/// Key-frames along the path of a herd, none near those that are given; and the herd's size.
fn along_path(
    input: &AlongPathInput,
    given: &[(KeyFrame, String)],
    sources: &dyn Sources,
) -> Result<(Vec<(KeyFrame, String)>, usize), Invalid> {
    let herd = tie::open(&input.ecosystem_herd, ALONG, sources)?;
    let every_s = input.every_s.unwrap_or(EVERY_S);
    let (begin, end) = herd.span();
    let start = input.ecosystem_herd.from_s.unwrap_or(begin).max(begin);
    let steps = ((end - start) / every_s).floor();
    if steps > MOST_ALONG {
        let expected = format!("at most {MOST_ALONG} key-frames along the path");
        return Err(Invalid::new("/along/every_s", ErrorCode::WrongCount, expected, steps));
    }
    let is_free = |t: f64| given.iter().all(|(frame, _)| (frame.time_s - t).abs() > 0.5 * every_s);
    let frame = |step: usize| {
        let t = step as f64 * every_s;
        let pose = KeyPose::Position(herd.at(start + t));
        is_free(t).then(|| (KeyFrame { time_s: t, pose }, ALONG.to_owned()))
    };
    Ok(((0..=steps as usize).filter_map(frame).collect(), herd.size))
}

/// Lets a herd that rests stay where it stands: the middle of a key-herd is seldom to a stride
/// where the path is, and nobody turns round for less than a body length.
fn keep_resting(given: &mut [(KeyFrame, String)]) {
    let herd = given.iter().find_map(|(frame, _)| frame.herd()).unwrap_or(&[]);
    let length_m = 2.0 * herd.iter().map(|e| e.a).fold(0.0, f64::max);
    for k in 1..given.len() {
        let before = given[k - 1].0.centre();
        if let (KeyFrame { pose: KeyPose::Position(place), .. }, ALONG) = (&mut given[k].0, given[k].1.as_str())
            && place.distance(before) < length_m
        {
            *place = before;
        }
    }
}

impl KeyFrames {
    /// Half the length and half the width of every animal, as in the first key-herd.
    pub fn bodies(&self) -> Vec<(f64, f64)> {
        let herd = self.frames.iter().find_map(KeyFrame::herd).unwrap_or(&[]);
        herd.iter().map(|e| (e.a, e.b)).collect()
    }

    /// About how many poses the tracks will hold.
    pub fn poses(&self, options: &AnimationOptions) -> usize {
        let time_s = self.frames.last().map_or(0.0, |l| l.time_s) - self.frames.first().map_or(0.0, |f| f.time_s);
        let steps = time_s / (options.step_s * options.keep_every as f64) + self.frames.len() as f64;
        (steps * self.bodies().len() as f64).clamp(0.0, 1e15) as usize
    }

    fn check_size(&self, inputs: &HerdAnimationInputs) -> Result<(), Invalid> {
        let poses = self.poses(&walk_options::options(inputs));
        if poses <= MOST_POSES {
            return Ok(());
        }
        let expected = format!("a time between poses with which there are at most {MOST_POSES} of them");
        Err(Invalid::new("/every_s", ErrorCode::OutOfRange, expected, format!("{poses} poses")))
    }
}
