//! Extraction of animals from one photo (T 4.2.1, H "Data extraction from a single image"):
//! scribbles → support vector machine on colour → mask → watershed → ellipses by second moments.
//!
//! Places are in the **photo's map frame**: one pixel is one unit, x to the right, y **up** from
//! the lower-left corner, as on every map here; angles counter-clockwise from the right.

mod classifier;
mod colour;
mod correction;
mod ellipses;
mod error;
mod machine;
mod mask;
mod outliers;
mod photo;
mod scribbles;
mod watershed;

pub use classifier::ClassifierOptions;
pub use correction::{Corrections, Replacement};
pub use error::ExtractionError;
pub use outliers::{OutlierOptions, Suspicion};
pub use photo::Photo;
pub use scribbles::{Mark, Scribbles, Stroke};
pub use watershed::WatershedOptions;

use crate::compute::geometry::Ellipse;
use crate::compute::geometry::Point;
use crate::compute::raster::Raster;
use crate::compute::raster::distance_to_zero;
use crate::compute::run::Run;

/// Regions below this share of the typical one are noise (ours), ...
const LEAST_SHARE: f64 = 0.15;

/// ... and so are regions of fewer pixels than this, which have no shape.
const LEAST_PIXELS: f64 = 8.0;

/// What may be chosen about an extraction.
#[derive(Debug, Clone, PartialEq)]
pub struct ExtractionOptions {
    /// The support vector machine on colour.
    pub classifier: ClassifierOptions,
    /// Passes of a 3 × 3 binomial over the decision values before they become a mask; each adds
    /// half a pixel to the variance of the blur. Default: 3 (ours).
    pub smoothing: u32,
    /// How touching animals are parted.
    pub watershed: WatershedOptions,
    /// Regions smaller than this many pixels are noise and dropped. Default: 15 % of the
    /// median region under the animal strokes, at least 8 (ours).
    pub min_area_px: Option<f64>,
    /// When a region is flagged as `suspect`.
    pub outliers: OutlierOptions,
    /// The heading that all animals are first turned to within a quarter turn of, in radians:
    /// moments give an axis, not a heading (T 4.2.1). Default: 0, to the right.
    pub direction: f64,
    /// What the user changes in the animals found.
    pub corrections: Corrections,
}

impl Default for ExtractionOptions {
    fn default() -> Self {
        Self {
            classifier: ClassifierOptions::default(),
            smoothing: 3,
            watershed: WatershedOptions::default(),
            min_area_px: None,
            outliers: OutlierOptions::default(),
            direction: 0.0,
            corrections: Corrections::default(),
        }
    }
}

/// An animal found in a photo, or put there by the user.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Stays the same from run to run as long as photo, scribbles and options do: corrections
    /// name animals by it.
    pub id: u64,
    /// Its outline, in pixels of the photo's map frame.
    pub ellipse: Ellipse,
    /// Why the region may not be one animal; empty when nothing speaks against it.
    pub suspicions: Vec<Suspicion>,
}

/// The animals of a photo.
#[derive(Debug, Clone, PartialEq)]
pub struct Extraction {
    /// The animals in the order of their ids.
    pub animals: Vec<Found>,
    /// Which pixels show an animal (1) and which do not (0).
    pub mask: Raster<u8>,
    /// Share of the training samples that the classifier gives back as they were marked.
    pub training_accuracy: f64,
    /// Regions dropped as smaller than the least area.
    pub specks_dropped: usize,
}

/// Finds the animals of a photo from a few scribbles.
///
/// # Errors
/// Scribbles that cannot teach anything, no region found, corrections that name no animal, or a
/// stop: see [`ExtractionError`].
pub fn extract(
    photo: &Photo,
    scribbles: &Scribbles,
    options: &ExtractionOptions,
    run: &Run,
) -> Result<Extraction, ExtractionError> {
    const STAGE: &str = "extraction";
    // 1. Scribbles become a mark per pixel.
    let marks = scribbles::rasterise(scribbles, photo.grid(), run)?;
    // 2. A light blur takes the sensor's noise out of the colours.
    let smooth = photo.blurred();
    run.progress(STAGE, 1, 6)?;
    // 3. A support vector machine learns animal from ground, once per colour that occurs.
    let classifier = classifier::train(&smooth, &marks, &options.classifier, run)?;
    let scores = classifier.scores(&smooth, run)?;
    run.progress(STAGE, 2, 6)?;
    // 4. Smoothed decision values become the mask.
    let mask = mask::threshold(scores, photo.grid(), options.smoothing, run)?;
    run.progress(STAGE, 3, 6)?;
    // 5. The watershed of the distance to the ground parts animals that touch.
    let distance = distance_to_zero(&mask, run)?;
    run.progress(STAGE, 4, 6)?;
    let regions = watershed::regions(&distance, &options.watershed, run)?;
    run.progress(STAGE, 5, 6)?;
    // 6. Each region becomes an ellipse by its second moments; outliers are flagged, not dropped.
    let marked = ellipses::marked(&regions, &marks);
    let typical_px = ellipses::typical_area(&regions, &marked).ok_or(ExtractionError::NoRegion)?;
    let least = options.min_area_px.unwrap_or((LEAST_SHARE * typical_px).max(LEAST_PIXELS));
    let (kept, marked): (Vec<_>, Vec<_>) =
        regions.shapes.iter().zip(marked).filter(|(shape, _)| shape.area() >= least).unzip();
    if kept.is_empty() {
        return Err(ExtractionError::NoRegion);
    }
    let suspicions = outliers::suspicions(&kept, &marked, &options.outliers);
    let found = (0u64..).zip(kept.iter().zip(suspicions)).map(|(id, (shape, suspicions))| {
        let ellipse = ellipses::facing(shape.ellipse(photo.grid()), Point::from_angle(options.direction));
        Found { id, ellipse, suspicions }
    });
    // 7. The user's corrections come last.
    let animals = correction::apply(found.collect(), &options.corrections, photo.grid())?;
    run.progress(STAGE, 6, 6)?;
    Ok(Extraction {
        animals,
        mask,
        training_accuracy: classifier.training_accuracy,
        specks_dropped: regions.shapes.len() - kept.len(),
    })
}
