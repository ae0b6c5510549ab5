//! `key-herd`: any number of animals on the ground that look like the herd of a photo (T 4.2).

use biotope_api::error::ErrorCode;
use biotope_api::herds::DensityInput;
use biotope_api::herds::HeadingsInput;
use biotope_api::herds::KeyHerdInputs;
use biotope_api::herds::OrientationEditInput;
use biotope_api::herds::SuspectsInput;
use biotope_api::points::PaintedInput;
use biotope_api::warning::Warning;
use biotope_api::warning::WarningCode;
use serde_json::Value;

use crate::codec::map::Georeference;
use crate::compute::geometry::Bounds;
use crate::compute::geometry::Ellipse;
use crate::compute::herds::Obstacles;
use crate::compute::herds::key_herd;
use crate::compute::herds::key_herd::DensitySource;
use crate::compute::herds::key_herd::Headings;
use crate::compute::herds::key_herd::KeyHerdOptions;
use crate::compute::herds::key_herd::OrientationEdit;
use crate::compute::herds::key_herd::Site;
use crate::compute::raster::Raster;
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
use crate::jobs::given;
use crate::jobs::herds::ellipses;
use crate::jobs::herds::faults;
use crate::jobs::herds::key_herd_outputs;
use crate::jobs::herds::obstacles;
use crate::jobs::herds::site;
use crate::jobs::herds::site::Place;
use crate::jobs::points::regions;
use crate::jobs::process::ASYNC;
use crate::jobs::process::inputs_schema;
use crate::jobs::rasters;
use crate::jobs::rasters::Land;
use crate::jobs::schema::read;

/// The process.
pub struct KeyHerd;

impl Process for KeyHerd {
    fn description(&self) -> Description {
        Description {
            id: "key-herd",
            title: "Key-herd",
            text: "Places any number of animals on the ground so that they look like an exemplar herd: by its \
                   correlation curve, its orientation field and its density map, turned to a trajectory and round \
                   obstacles.",
            version: "1",
            keywords: &["herd", "synthesis", "pair correlation", "orientation field"],
            control: ASYNC,
            inputs: inputs_schema::<KeyHerdInputs>(),
            outputs: outputs(),
        }
    }

    fn parse(&self, inputs: Value, sources: &dyn Sources) -> Result<Box<dyn Job>, Invalid> {
        let inputs: KeyHerdInputs = read(inputs)?;
        let mut all = Invalid::default();
        let exemplar = all.keep(exemplar(&inputs, sources));
        let place = all.keep(site::open(&inputs.place, sources));
        let count = place.as_ref().and_then(|place| all.keep(count(&inputs, place)));
        let land = inputs.terrain.as_ref().map(|terrain| all.keep(rasters::terrain(terrain, sources)));
        let obstacles = all.keep(obstacles::open(&inputs.obstacles, sources));
        let density = all.keep(density(&inputs.density, sources));
        let orientation = inputs.orientation.as_ref().map(|map| all.keep(angles(map, sources)));
        if inputs.body.width_m > inputs.body.length_m {
            let expected = format!("at most the length, {} m", inputs.body.length_m);
            all.push("/body/width_m", ErrorCode::Inconsistent, expected, inputs.body.width_m);
        }
        if let (Some(place), Some(Some(land)), Some(density)) = (&place, &land, &density) {
            all.extend(off_terrain(place, land, density));
        }
        all.into_result()?;
        match (exemplar, place, count, obstacles, density) {
            (Some(exemplar), Some(place), Some(count), Some(obstacles), Some(density)) => {
                let options = options(&inputs, (count, &place), (density, orientation.flatten()));
                Ok(Box::new(KeyHerdJob { inputs, exemplar, place, land: land.flatten(), obstacles, options }))
            }
            _ => Err(Invalid::default()),
        }
    }
}

fn outputs() -> Vec<Output> {
    let table = "The animals: id, x, y, a, b, theta, suspect, why; metres, a is half the length, b half the width, \
                 theta the heading in radians counter-clockwise from east.";
    vec![
        Output::new("picture", "Picture", "The animals on the ground, with the density and obstacles.", Kind::Picture),
        Output::new("curves", "Curves", "The correlation curves of the exemplar and of the key-herd.", Kind::Picture),
        Output::new("ellipses", "Animals", table, Kind::Table).in_unit("m"),
        Output::new(
            "orientation",
            "Orientation",
            "The orientation field used; painted over, it is an input of a second run.",
            Kind::Map,
        )
        .in_unit("rad"),
        Output::new(
            "density",
            "Density",
            "The density map used; painted over, it is an input of a second run.",
            Kind::Map,
        )
        .in_unit("animals/m²"),
        Output::new("report", "Report", "How the herd came out: curves, error, scale, overlap.", Kind::Json),
    ]
}

/// The animals to learn from.
fn exemplar(inputs: &KeyHerdInputs, sources: &dyn Sources) -> Result<Vec<Ellipse>, Invalid> {
    const POINTER: &str = "/exemplar";
    let mut animals = given::open(&inputs.exemplar, POINTER, sources)?;
    if inputs.suspects == SuspectsInput::LeaveOut {
        animals.retain(|animal| animal.suspect != Some(true));
    }
    if animals.is_empty() {
        return Err(Invalid::new(POINTER, ErrorCode::WrongCount, "at least one animal", "none"));
    }
    ellipses::ellipses(&animals, POINTER)
}

/// That a herd's middle lies off the ground it is to stand on; a painted density is itself where
/// it stands.
fn off_terrain(place: &Place, land: &Land, density: &DensitySource) -> Invalid {
    if matches!(density, DensitySource::Painted(_)) || land.height.at(place.centre).is_some() {
        return Invalid::default();
    }
    let Bounds { min, max } = land.height.grid.bounds();
    let expected = format!("a middle of the herd on the terrain: x {} to {}, y {} to {}", min.x, max.x, min.y, max.y);
    Invalid::new("/place", ErrorCode::OffTerrain, expected, format!("({}, {})", place.centre.x, place.centre.y))
}

/// Number of animals: as asked, or the size of the ecosystem's herd.
fn count(inputs: &KeyHerdInputs, place: &Place) -> Result<usize, Invalid> {
    match (inputs.count, &place.herd) {
        (Some(count), _) => Ok(count as usize),
        (None, Some(herd)) if (1..=100_000).contains(&herd.size) => Ok(herd.size),
        (None, Some(herd)) => {
            let pointer = "/place/ecosystem_herd/herd";
            Err(Invalid::new(pointer, ErrorCode::OutOfRange, "a herd of 1 to 100,000 animals", herd.size))
        }
        (None, None) => Err(Invalid::new("/count", ErrorCode::Missing, "a number of animals", "nothing")),
    }
}

fn density(input: &DensityInput, sources: &dyn Sources) -> Result<DensitySource, Invalid> {
    const POINTER: &str = "/density/map";
    match input {
        DensityInput::Exemplar => Ok(DensitySource::Exemplar),
        DensityInput::Even => Ok(DensitySource::Even),
        DensityInput::Painted { map } => {
            let raster = regions::painted(map, POINTER, (None, sources))?;
            match raster.data.iter().find(|v| !(v.is_finite() && **v >= 0.0)) {
                None => Ok(DensitySource::Painted(raster)),
                Some(odd) => Err(Invalid::new(POINTER, ErrorCode::OutOfRange, "finite values from 0", odd)),
            }
        }
    }
}

/// A painted orientation field; the levels of a grey picture stand for a full turn.
fn angles(input: &PaintedInput, sources: &dyn Sources) -> Result<Raster<f32>, Invalid> {
    let (raster, levels) = regions::raster(input, "/orientation", (None, sources))?;
    let unit = levels.map_or(1.0, |highest| std::f32::consts::TAU / (highest as f32 + 1.0));
    Ok(raster.map(|v| v * unit))
}

fn options(
    inputs: &KeyHerdInputs,
    (count, place): (usize, &Place),
    (density, orientation): (DensitySource, Option<Raster<f32>>),
) -> KeyHerdOptions {
    let default = KeyHerdOptions::default();
    KeyHerdOptions {
        count,
        body: (inputs.body.length_m / 2.0, inputs.body.width_m / 2.0),
        centre: place.centre,
        direction: place.direction,
        headings: match inputs.headings {
            HeadingsInput::Trusted => Headings::Trusted,
            HeadingsInput::Axes => Headings::Axes,
        },
        density,
        orientation,
        orientation_edits: inputs.orientation_edits.iter().map(edit).collect(),
        max_fails: inputs.max_fails.map_or(default.max_fails, |n| n as usize),
        seed: inputs.seed,
    }
}

fn edit(input: &OrientationEditInput) -> OrientationEdit {
    match *input {
        OrientationEditInput::Blend { direction, weight } => OrientationEdit::Blend { direction, weight },
        OrientationEditInput::Rotate { angle } => OrientationEdit::Rotate { angle },
        OrientationEditInput::Smooth { radius_m } => OrientationEdit::Smooth { radius_m },
        OrientationEditInput::Noise { deviation, size_m } => OrientationEdit::Noise { deviation, size_m },
    }
}

struct KeyHerdJob {
    inputs: KeyHerdInputs,
    exemplar: Vec<Ellipse>,
    place: Place,
    land: Option<Land>,
    obstacles: Obstacles,
    options: KeyHerdOptions,
}

impl Job for KeyHerdJob {
    fn estimate(&self) -> Estimate {
        let cells = self.land.as_ref().map_or(0, |land| land.height.data.len()) as u64;
        let animals = (self.options.count + self.exemplar.len()) as u64;
        Estimate { memory_bytes: (128 << 20) + 8 * cells + 4_000 * animals }
    }

    fn parameters(&self) -> Value {
        serde_json::to_value(&self.inputs).unwrap_or_default()
    }

    fn stages(&self) -> &'static [(&'static str, u32)] {
        &[("key-herd.analysis", 10), ("key-herd.maps", 10), ("key-herd.darts", 80)]
    }

    fn run(self: Box<Self>, context: &mut JobContext<'_>) -> Result<(), Failure> {
        let Self { exemplar, place, land, obstacles, options, .. } = *self;
        land.iter().flat_map(|land| &land.warnings).for_each(|warning| context.warn(warning.clone()));
        let site = Site { terrain: land.as_ref().map(|land| &land.height), obstacles: &obstacles };
        let herd = key_herd::key_herd(&exemplar, site, &options, &context.run).map_err(faults::key_herd_failure)?;
        warnings(context, &herd.report);
        let picture = key_herd_outputs::picture(&herd, (land.as_ref(), &obstacles), &place.way)?;
        context.put("picture", picture)?;
        if let Some(target) = &herd.report.target {
            context.put("curves", key_herd_outputs::curves(target, herd.report.curve.as_ref())?)?;
        }
        let rows = key_herd_outputs::rows(&herd.ellipses);
        context.put("ellipses", Artefact::Table(ellipses::table(&rows, "m")))?;
        let report = key_herd_outputs::report(&herd, (place.centre, place.direction));
        context.put("report", Artefact::Json(report))?;
        let georeference = land.map_or_else(|| Georeference::local("herd"), |land| land.georeference);
        context.put("orientation", key_herd_outputs::orientation(herd.orientation, georeference.clone()))?;
        context.put("density", key_herd_outputs::density(herd.density, georeference))
    }
}

fn warnings(context: &mut JobContext<'_>, report: &key_herd::KeyHerdReport) {
    if report.target.is_none() {
        let message = "the exemplar is a herd of one, two or in a line, which has no area to learn from";
        context.warn(Warning::new(WarningCode::NoHull, "/exemplar", message));
    }
}
