//! `herd-extraction`: the animals of a photo as ellipses (T 4.2.1).

use biotope_api::error::ErrorCode;
use biotope_api::herds::CorrectionsInput;
use biotope_api::herds::EllipseInput;
use biotope_api::herds::ExtractionOptionsInput;
use biotope_api::herds::HerdExtractionInputs;
use biotope_api::warning::Warning;
use biotope_api::warning::WarningCode;
use serde_json::Value;
use serde_json::json;

use crate::codec::map::Category;
use crate::codec::map::Georeference;
use crate::codec::map::Legend;
use crate::codec::map::Map;
use crate::codec::map::MapData;
use crate::codec::picture::Image;
use crate::compute::geometry::Bounds;
use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Point;
use crate::compute::herds::extraction::Corrections;
use crate::compute::herds::extraction::Extraction;
use crate::compute::herds::extraction::ExtractionError;
use crate::compute::herds::extraction::ExtractionOptions;
use crate::compute::herds::extraction::Found;
use crate::compute::herds::extraction::OutlierOptions;
use crate::compute::herds::extraction::Photo;
use crate::compute::herds::extraction::Replacement;
use crate::compute::herds::extraction::Scribbles;
use crate::compute::herds::extraction::Suspicion;
use crate::compute::herds::extraction::WatershedOptions;
use crate::compute::herds::extraction::extract;
use crate::compute::raster::Grid;
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
use crate::jobs::herds::ellipses;
use crate::jobs::herds::ellipses::Row;
use crate::jobs::herds::faults;
use crate::jobs::herds::photo;
use crate::jobs::herds::pictures;
use crate::jobs::herds::scribbles;
use crate::jobs::process::ASYNC;
use crate::jobs::process::inputs_schema;
use crate::jobs::schema::read;

/// The process.
pub struct HerdExtraction;

impl Process for HerdExtraction {
    fn description(&self) -> Description {
        Description {
            id: "herd-extraction",
            title: "Herd extraction",
            text: "Finds the animals of a photo from a few spots marked as animal or ground, and gives each as an \
                   ellipse with its heading; regions that may not be one animal are flagged.",
            version: "1",
            keywords: &["herd", "photo", "segmentation", "animals"],
            control: ASYNC,
            inputs: inputs_schema::<HerdExtractionInputs>(),
            outputs: outputs(),
        }
    }

    fn parse(&self, inputs: Value, sources: &dyn Sources) -> Result<Box<dyn Job>, Invalid> {
        let inputs: HerdExtractionInputs = read(inputs)?;
        let mut all = Invalid::default();
        let Some(photo) = all.keep(photo::open(&inputs.photo, "/photo", sources)) else { return Err(all) };
        let grid = Grid::new(photo.width, photo.height, 1.0);
        let scribbles = all.keep(scribbles::open(&inputs.scribbles, grid, sources));
        let corrections = all.keep(corrections(&inputs.corrections, grid));
        match (scribbles, corrections) {
            (Some(scribbles), Some(corrections)) => {
                let options = ExtractionOptions { corrections, ..options(&inputs.options) };
                Ok(Box::new(ExtractionJob { inputs, photo, scribbles, options }))
            }
            _ => Err(all),
        }
    }
}

fn outputs() -> Vec<Output> {
    let table = "The animals: id, x, y, a, b, theta, suspect, why. Pixels of the upright photo, y up from its lower \
                 left corner; a is half the length, b half the width, theta the heading in radians counter-clockwise \
                 from the right. Corrections name animals by their id.";
    vec![
        Output::new("ellipses", "Animals", table, Kind::Table).in_unit("px"),
        Output::new("mask", "Mask", "Which pixels show an animal.", Kind::Map),
        Output::new(
            "overlay",
            "Overlay",
            "The photo with the outline, heading and number of every animal; suspect ones in another colour. At most \
             2,400 pixels a side.",
            Kind::Picture,
        ),
        Output::new("report", "Report", "Numbers of animals, and how well the scribbles tell them apart.", Kind::Json),
    ]
}

fn options(input: &ExtractionOptionsInput) -> ExtractionOptions {
    let default = ExtractionOptions::default();
    ExtractionOptions {
        smoothing: input.smoothing.unwrap_or(default.smoothing),
        watershed: WatershedOptions {
            merge_depth: input.merge_depth.unwrap_or(default.watershed.merge_depth),
            merge_fill: input.merge_fill.unwrap_or(default.watershed.merge_fill),
        },
        min_area_px: input.min_area_px,
        outliers: OutlierOptions {
            deviations: input.suspect_deviations.unwrap_or(default.outliers.deviations),
            least_fill: input.suspect_fill.unwrap_or(default.outliers.least_fill),
            ..default.outliers
        },
        direction: input.direction.unwrap_or(default.direction),
        ..default
    }
}

/// The corrections, with every ellipse an ellipse in the picture.
fn corrections(input: &CorrectionsInput, grid: Grid) -> Result<Corrections, Invalid> {
    let mut faults = Invalid::default();
    let mut drawn = |inputs: &[EllipseInput], pointer: String| {
        let list = faults.keep(ellipses::ellipses(inputs, &pointer)).unwrap_or_default();
        list.iter().enumerate().for_each(|(i, e)| faults.extend(outside(e, &format!("{pointer}/{i}"), grid)));
        list
    };
    let add = drawn(&input.add, "/corrections/add".to_owned());
    let replacement = |(i, r): (usize, &biotope_api::herds::ReplacementInput)| Replacement {
        id: r.id,
        by: drawn(&r.by, format!("/corrections/replace/{i}/by")),
    };
    let replace = input.replace.iter().enumerate().map(replacement).collect();
    let corrections =
        Corrections { remove: input.remove.clone(), replace, add, flip: input.flip.clone(), flip_all: input.flip_all };
    faults.into_result().map(|()| corrections)
}

/// That an ellipse has its centre outside the picture.
fn outside(ellipse: &Ellipse, pointer: &str, grid: Grid) -> Invalid {
    let picture = Bounds::new(Point::default(), Point::new(grid.width as f64, grid.height as f64));
    if picture.contains(ellipse.centre) {
        return Invalid::default();
    }
    let expected = format!("a centre in the picture: x 0 to {}, y 0 to {}", grid.width, grid.height);
    let found = format!("({}, {})", ellipse.centre.x, ellipse.centre.y);
    Invalid::new(pointer, ErrorCode::OutsidePicture, expected, found)
}

struct ExtractionJob {
    inputs: HerdExtractionInputs,
    photo: Image,
    scribbles: Scribbles,
    options: ExtractionOptions,
}

impl Job for ExtractionJob {
    fn estimate(&self) -> Estimate {
        // Measured at 24 megapixels: 18 bytes a pixel with everything, the classifier's kernel included.
        Estimate { memory_bytes: (96 << 20) + 24 * (self.photo.width * self.photo.height) as u64 }
    }

    fn parameters(&self) -> Value {
        serde_json::to_value(&self.inputs).unwrap_or_default()
    }

    fn stages(&self) -> &'static [(&'static str, u32)] {
        &[("extraction", 1)]
    }

    fn run(self: Box<Self>, context: &mut JobContext<'_>) -> Result<(), Failure> {
        let Self { inputs, photo, scribbles, options } = *self;
        let (width, height) = (photo.width, photo.height);
        let pixels = Photo::new(width, height, photo.rgb.as_flattened().to_vec());
        let pixels = pixels.ok_or_else(|| Failure::fault("a photo without pixels"))?;
        let found =
            extract(&pixels, &scribbles, &options, &context.run).map_err(|e| failure(e, &inputs.corrections))?;
        let rows: Vec<Row> = found.animals.iter().map(row).collect();
        warnings(context, &found);
        context.put("report", Artefact::Json(report(&found, (width, height))))?;
        context.put("ellipses", Artefact::Table(ellipses::table(&rows, "px")))?;
        if context.wants("overlay") {
            context.put("overlay", pictures::overlay(&photo, &rows)?)?;
        }
        context.put("mask", Artefact::Map(mask(found.mask)))
    }
}

fn row(found: &Found) -> Row {
    let word = |suspicion: &Suspicion| match suspicion {
        Suspicion::Size => "size",
        Suspicion::Proportion => "proportion",
        Suspicion::Shape => "shape",
    };
    let why: Vec<&str> = found.suspicions.iter().map(word).collect();
    Row { id: found.id, ellipse: found.ellipse, why: why.join(" ") }
}

fn suspects(found: &Extraction) -> usize {
    found.animals.iter().filter(|animal| !animal.suspicions.is_empty()).count()
}

fn warnings(context: &mut JobContext<'_>, found: &Extraction) {
    let suspects = suspects(found) as u64;
    if suspects > 0 {
        let message = format!(
            "{suspects} of {} regions are of outlying size, proportion or shape; replace or remove those that are not \
             one animal each",
            found.animals.len()
        );
        context.warn(Warning::new(WarningCode::SuspectAnimals, "/photo", message).with_count(suspects));
    }
    let specks = found.specks_dropped as u64;
    if specks > 0 {
        let message = format!("{specks} regions smaller than the least area were left out");
        context.warn(Warning::new(WarningCode::SpecksDropped, "/options/min_area_px", message).with_count(specks));
    }
}

fn report(found: &Extraction, (width, height): (usize, usize)) -> Value {
    json!({
        "animals": found.animals.len(),
        "suspect": suspects(found),
        "specks_dropped": found.specks_dropped,
        "training_accuracy": found.training_accuracy,
        "photo": {"width_px": width, "height_px": height},
    })
}

fn mask(mask: Raster<u8>) -> Map {
    let category = |(value, label, colour): (u32, &str, [u8; 3])| Category { value, label: label.to_owned(), colour };
    let classes = [(0, "ground", [240, 240, 236]), (1, "animal", [40, 40, 46])].map(category);
    Map {
        data: MapData::U8(mask),
        legend: Legend::categories("Animals in the photo", classes.to_vec()),
        georeference: Georeference::local("photo"),
    }
}

/// Why the extraction ended; an unknown number points to where the corrections name it.
fn failure(error: ExtractionError, corrections: &CorrectionsInput) -> Failure {
    let ExtractionError::UnknownAnimal { id, .. } = error else { return faults::extraction_failure(error) };
    let replaced: Vec<u64> = corrections.replace.iter().map(|r| r.id).collect();
    let lists = [("remove", &corrections.remove, ""), ("flip", &corrections.flip, ""), ("replace", &replaced, "/id")];
    let place = |(list, numbers, field): (&str, &Vec<u64>, &str)| {
        numbers.iter().position(|n| *n == id).map(|i| format!("/corrections/{list}/{i}{field}"))
    };
    let pointer = lists.into_iter().find_map(place);
    match (pointer, faults::extraction_failure(error)) {
        (Some(pointer), Failure::Invalid(mut faults)) => {
            faults.errors.iter_mut().for_each(|fault| fault.pointer.clone_from(&pointer));
            faults.into()
        }
        (_, failure) => failure,
    }
}
