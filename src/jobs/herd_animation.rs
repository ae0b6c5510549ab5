//! `herd-animation`: a herd walks over the ground through its key-frames (T 4.3).

use biotope_api::herds::HerdAnimationInputs;
use biotope_api::warning::Warning;
use bytes::Bytes;
use serde_json::Value;

use crate::codec::map::Georeference;
use crate::codec::tracks::TrackFile;
use crate::compute::geometry::Point;
use crate::compute::herds::Obstacles;
use crate::compute::herds::animation;
use crate::compute::herds::animation::Animation;
use crate::compute::herds::animation::AnimationOptions;
use crate::jobs::Artefact;
use crate::jobs::Description;
use crate::jobs::Estimate;
use crate::jobs::Failure;
use crate::jobs::Invalid;
use crate::jobs::Job;
use crate::jobs::JobContext;
use crate::jobs::Output;
use crate::jobs::Process;
use crate::jobs::Sources;
use crate::jobs::artefact::Kind;
use crate::jobs::herds::arrivals;
use crate::jobs::herds::faults;
use crate::jobs::herds::key_frames;
use crate::jobs::herds::key_frames::KeyFrames;
use crate::jobs::herds::obstacles;
use crate::jobs::herds::tracks;
use crate::jobs::herds::walk_options;
use crate::jobs::process::ASYNC;
use crate::jobs::process::inputs_schema;
use crate::jobs::rasters;
use crate::jobs::rasters::Land;
use crate::jobs::schema::read;

/// The process.
pub struct HerdAnimation;

impl Process for HerdAnimation {
    fn description(&self) -> Description {
        Description {
            id: "herd-animation",
            title: "Herd animation",
            text: "Lets a herd walk over a terrain through key-frames, each with a key-herd or only a place, round \
                   obstacles, and gives the track of every animal.",
            version: "3",
            keywords: &["herd", "animation", "tracks", "crowd simulation", "steering"],
            control: ASYNC,
            inputs: inputs_schema::<HerdAnimationInputs>(),
            outputs: outputs(),
        }
    }

    fn parse(&self, inputs: Value, sources: &dyn Sources) -> Result<Box<dyn Job>, Invalid> {
        let inputs: HerdAnimationInputs = read(inputs)?;
        let mut all = Invalid::default();
        let options = walk_options::options(&inputs);
        let land = all.keep(rasters::terrain(&inputs.terrain, sources));
        let obstacles = all.keep(obstacles::open(&inputs.obstacles, sources));
        let frames = all.keep(key_frames::open(&inputs, sources));
        let (Some(land), Some(obstacles), Some(frames)) = (land, obstacles, frames) else { return Err(all) };
        let found = animation::faults(&land.height, &obstacles, &frames.frames, &options);
        faults::animations(&found, &frames).into_result()?;
        Ok(Box::new(AnimationJob { inputs, land, obstacles, frames, options }))
    }
}

fn outputs() -> Vec<Output> {
    let file = |id, title, text, kind| Output::new(id, title, text, kind);
    vec![
        Output::new("picture", "Tracks", "The ground with the way of every animal and the key-herds.", Kind::Picture),
        Output::new("preview", "Preview", "A short animated PNG of the herd as it walks.", Kind::Picture),
        Output::new(
            "report",
            "Report",
            "Who was at their place at each key-frame, who was late and why, and how much time was needed.",
            Kind::Json,
        ),
        Output::new(
            "tracks",
            "Tracks",
            "Where every animal is: id, t, x, y, z, heading, animal by animal; metres, seconds, radians \
             counter-clockwise from east.",
            Kind::Table,
        ),
        file(
            "tracks.bin",
            "Tracks, binary",
            "BTRK, u32 version 1, u32 animals, u32 steps, then little-endian f32 columns: t (a value a step), x, y, \
             z, heading (animal by animal). x and y are from the origin that the report names.",
            Kind::file("application/octet-stream", "bin"),
        ),
        file(
            "tracks.gltf",
            "Tracks, glTF",
            "A glTF 2.0 scene with a node and a linear animation an animal; y up, metres from the origin that the \
             report names, seconds from the first pose.",
            Kind::file("model/gltf+json", "gltf"),
        ),
        file(
            "tracks.mfjson",
            "Tracks, Moving Features",
            "OGC Moving Features JSON: a MovingPoint in the plane an animal, its height and heading as temporal \
             properties. Second 0 is 2000-01-01T00:00Z; marked as simulated.",
            Kind::file("application/geo+json", "mfjson"),
        ),
    ]
}

/// The job.
struct AnimationJob {
    inputs: HerdAnimationInputs,
    land: Land,
    obstacles: Obstacles,
    frames: KeyFrames,
    options: AnimationOptions,
}

impl Job for AnimationJob {
    fn estimate(&self) -> Estimate {
        // A pose is held as numbers, as columns of the table, and as text while it is written.
        let poses = self.frames.poses(&self.options) as u64;
        Estimate { memory_bytes: (256 << 20) + 8 * self.land.height.data.len() as u64 + 400 * poses }
    }

    fn parameters(&self) -> Value {
        serde_json::to_value(&self.inputs).unwrap_or_default()
    }

    fn stages(&self) -> &'static [(&'static str, u32)] {
        &[("animation.path", 5), ("animation.pairing", 15), ("animation.steps", 80)]
    }

    fn run(self: Box<Self>, context: &mut JobContext<'_>) -> Result<(), Failure> {
        let Self { land, obstacles, frames, options, .. } = *self;
        // 1. What is known beforehand.
        land.warnings.iter().chain(&frames.warnings).for_each(|warning| context.warn(warning.clone()));
        // 2. The herd walks.
        let walked = animation::animate(&land.height, &obstacles, &frames.frames, &options, &context.run)
            .map_err(|error| faults::animation_failure(error, &frames))?;
        // 3. Who came late.
        let warnings: Vec<Warning> = arrivals::warnings(&walked, &frames);
        warnings.into_iter().for_each(|warning| context.warn(warning));
        let origin = origin(&land);
        context.put("report", Artefact::Json(arrivals::report(&walked, &frames, origin)))?;
        // 4. The tracks.
        put_tracks(context, &walked, &frames, (&land.georeference, origin))?;
        // 5. Pictures.
        let place = tracks::Place { land: &land, obstacles: &obstacles, frames: &frames };
        if context.wants("picture") {
            context.put("picture", tracks::picture(&walked, &place)?)?;
        }
        if context.wants("preview") {
            context.put("preview", tracks::preview(&walked, &place, &context.run)?)?;
        }
        Ok(())
    }
}

/// What is subtracted from places in 32-bit forms: nothing in a local frame, else the terrain's
/// south-west corner.
fn origin(land: &Land) -> Point {
    match land.georeference {
        Georeference::Local { .. } => Point::default(),
        _ => land.height.grid.origin,
    }
}

fn put_tracks(
    context: &mut JobContext<'_>,
    walked: &Animation,
    frames: &KeyFrames,
    (georeference, origin): (&Georeference, Point),
) -> Result<(), Failure> {
    let bodies = frames.bodies();
    let file = TrackFile { tracks: &walked.tracks, bodies: &bodies, georeference, origin };
    let bytes = |media_type: &str, extension: &str, bytes: Bytes| Artefact::Bytes {
        media_type: media_type.to_owned(),
        extension: extension.to_owned(),
        bytes,
    };
    if context.wants("tracks") {
        context.put("tracks", Artefact::Table(tracks::table(&walked.tracks)))?;
    }
    if context.wants("tracks.bin") {
        context.put("tracks.bin", bytes("application/octet-stream", "bin", file.to_binary().into()))?;
    }
    if context.wants("tracks.gltf") {
        let text = serde_json::to_vec(&file.to_gltf()).map_err(Failure::fault)?;
        context.put("tracks.gltf", bytes("model/gltf+json", "gltf", text.into()))?;
    }
    if context.wants("tracks.mfjson") {
        context.put("tracks.mfjson", bytes("application/geo+json", "mfjson", file.to_moving_features().into()))?;
    }
    Ok(())
}
