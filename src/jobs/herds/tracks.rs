//! Tracks as a table, as a picture and as a short animation.

use bytes::Bytes;

use crate::codec::colours::ColourMap;
use crate::codec::colours::Rgb;
use crate::codec::draw::Ink;
use crate::codec::picture::Animation as Film;
use crate::codec::picture::Image;
use crate::compute::geometry::Bounds;
use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Point;
use crate::compute::herds::Obstacles;
use crate::compute::herds::animation::Animation;
use crate::compute::herds::animation::KeyFrame;
use crate::compute::herds::animation::Tracks;
use crate::compute::run::Run;
use crate::jobs::Artefact;
use crate::jobs::Failure;
use crate::jobs::Table;
use crate::jobs::herds::key_frames::KeyFrames;
use crate::jobs::herds::pictures;
use crate::jobs::herds::scene::Scene;
use crate::jobs::rasters::Land;

/// Longer side of the picture and of the preview, in pixels.
const SIDE: f64 = 1200.0;
const PREVIEW_SIDE: f64 = 640.0;

/// Space for the key below the picture.
const KEY: usize = 30;

/// Frames of the preview, and the time each is shown.
const FRAMES: usize = 90;
const DELAY_MS: u16 = 80;

const WAY: Rgb = [40, 60, 120];
const PATH: Rgb = [200, 30, 60];
const COAT: Rgb = [62, 38, 24];

/// Positions of key-frames that are marked: more would hide the path.
const MOST_MARKS: usize = 200;

/// The table `tracks`: id, t, x, y, z, heading, animal by animal.
pub fn table(tracks: &Tracks) -> Table {
    let steps = tracks.times_s.len();
    let rows = || (0..tracks.animals).flat_map(move |animal| (0..steps).map(move |step| (animal, step)));
    let pose = |(animal, step): (usize, usize)| tracks.pose(step, animal);
    Table::new()
        .integers("id", "", rows().map(|(animal, _)| animal as i64))
        .numbers("t", "s", rows().map(|(_, step)| tracks.times_s[step]))
        .numbers("x", "m", rows().map(|row| pose(row).place.x))
        .numbers("y", "m", rows().map(|row| pose(row).place.y))
        .numbers("z", "m", rows().map(|row| pose(row).z))
        .numbers("heading", "rad", rows().map(|row| pose(row).heading))
}

/// Where a herd walks.
pub struct Place<'a> {
    /// The ground.
    pub land: &'a Land,
    /// What is closed.
    pub obstacles: &'a Obstacles,
    /// What the herd walks through.
    pub frames: &'a KeyFrames,
}

impl Place<'_> {
    /// The ground under the whole walk.
    fn scene(&self, walked: &Animation, side: f64, below: usize) -> Scene {
        let places = walked.tracks.poses.iter().map(|pose| pose.place);
        let herds = self.frames.frames.iter().filter_map(KeyFrame::herd).flatten().map(|e| e.centre);
        let all = places.chain(herds).chain(self.frames.frames.iter().map(KeyFrame::centre));
        let world = Bounds::of(all).unwrap_or(Bounds::new(Point::default(), Point::default()));
        let mut scene = Scene::new(world, side, below);
        scene.terrain(&self.land.height, below);
        scene.obstacles(self.obstacles);
        scene
    }

    /// The body of an animal in a pose.
    fn body(bodies: &[(f64, f64)], tracks: &Tracks, (step, animal): (usize, usize)) -> Ellipse {
        let pose = tracks.pose(step, animal);
        let (a, b) = bodies.get(animal).copied().unwrap_or((1.0, 0.5));
        Ellipse { centre: pose.place, a, b, theta: pose.heading }
    }
}

/// The ground with the way of every animal, the herd's path and its key-frames.
///
/// # Errors
/// When it cannot be encoded.
pub fn picture(walked: &Animation, place: &Place<'_>) -> Result<Artefact, Failure> {
    let tracks = &walked.tracks;
    let mut scene = place.scene(walked, SIDE, KEY);
    let way = |animal: usize| -> Vec<Point> {
        (0..tracks.times_s.len()).map(|step| scene.view.at(tracks.pose(step, animal).place)).collect()
    };
    let ways: Vec<Vec<Point>> = (0..tracks.animals).map(way).collect();
    let opacity = (12.0 / tracks.animals as f64).clamp(0.25, 0.8);
    ways.iter().for_each(|way| scene.canvas.stroke(way, 1.2, Ink::veil(WAY, opacity)));
    let path = scene.view.all(walked.trajectory.points());
    scene.canvas.stroke(&path, 2.0, Ink::solid(PATH));
    let frames = &place.frames.frames;
    let marks = frames.iter().filter(|frame| frame.herd().is_none()).take(MOST_MARKS);
    marks.for_each(|frame| scene.canvas.disk(scene.view.at(frame.centre()), 4.0, Ink::solid(PATH)));
    let herds: Vec<&KeyFrame> = frames.iter().filter(|frame| frame.herd().is_some()).collect();
    let mut entries = vec![(WAY, "ways".to_owned()), (PATH, "path and key-frames".to_owned())];
    for (k, frame) in herds.iter().enumerate() {
        let colour = ColourMap::Inferno.at(0.15 + 0.65 * k as f64 / herds.len() as f64);
        frame.herd().unwrap_or(&[]).iter().for_each(|e| scene.animal(e, colour));
        entries.push((colour, format!("key-herd at {:.0} s", frame.time_s)));
    }
    scene.scale_bar(KEY);
    pictures::key(&mut scene.canvas, &entries);
    pictures::encoded(scene.canvas)
}

/// The herd as it walks, as an animated PNG.
///
/// # Errors
/// When it cannot be encoded, or a stop.
pub fn preview(walked: &Animation, place: &Place<'_>, run: &Run) -> Result<Artefact, Failure> {
    let tracks = &walked.tracks;
    let ground = place.scene(walked, PREVIEW_SIDE, 0);
    let bodies = place.frames.bodies();
    let frame = |k: usize| -> Result<Image, Failure> {
        run.check()?;
        let step = k * (tracks.times_s.len() - 1) / (FRAMES - 1);
        let mut scene = Scene { view: ground.view, canvas: ground.canvas.clone() };
        (0..tracks.animals).for_each(|animal| scene.animal(&Place::body(&bodies, tracks, (step, animal)), COAT));
        scene.scale_bar(0);
        scene.title(&format!("{:.0} s", tracks.times_s[step]));
        Ok(scene.into_image())
    };
    let frames = (0..FRAMES).map(frame).collect::<Result<Vec<Image>, Failure>>()?;
    let film = Film { frames, delay_ms: DELAY_MS };
    Ok(Artefact::Picture(Bytes::from(film.to_apng().map_err(Failure::fault)?)))
}
