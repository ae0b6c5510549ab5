//! Every warning code, in one table, and a warning: something that could be worked with.

use std::fmt;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

/// Makes [`WarningCode`] out of the table below.
macro_rules! warning_codes {
    ($($name:ident = $code:literal, $meaning:literal;)*) => {
        /// What a result's reader should know, as a stable code.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
        pub enum WarningCode {
            $(#[doc = $meaning] $name,)*
        }

        impl WarningCode {
            /// Every code, in the order of the table.
            pub const ALL: &'static [Self] = &[$(Self::$name,)*];

            /// The code as it stands on the wire.
            pub const fn code(self) -> &'static str {
                match self { $(Self::$name => $code,)* }
            }

            /// What the code means, in one sentence.
            pub const fn meaning(self) -> &'static str {
                match self { $(Self::$name => $meaning,)* }
            }
        }
    };
}

warning_codes! {
    // Terrains and other rasters.
    EightBit = "EIGHT_BIT", "Heights of 8 bits: the ground will show steps.";
    LooksByteswapped = "LOOKS_BYTESWAPPED", "The heights are much smoother with their bytes swapped.";
    LooksFlipped = "LOOKS_FLIPPED", "The raster fits better when its rows are turned upside down.";
    NodataPresent = "NODATA_PRESENT", "Some cells hold no data.";
    NonSquareCell = "NON_SQUARE_CELL", "The cells are not square; the raster was resampled.";
    GeographicCrs = "GEOGRAPHIC_CRS", "The raster is in degrees; it was projected to metres.";
    StretchedCrs = "STRETCHED_CRS", "The raster is in web Mercator, whose metres are stretched; it was projected to true metres.";
    NotPow2Plus1 = "NOT_POW2_PLUS1", "The size is not a power of two plus one, which some engines ask for.";
    HalfPixelPoint = "HALF_PIXEL_POINT", "Values belong to points, not cells; the raster was moved by half a cell.";
    // Ecosystems.
    Estimated = "ESTIMATED", "Numbers were estimated; each stands with its source in the result.";
    NotPlaced = "NOT_PLACED", "A species that was asked for lives nowhere on this terrain; the message says why.";
    ProportionsNotReached = "PROPORTIONS_NOT_REACHED", "The proportions asked for could not be reached.";
    PaintedBeyondResources = "PAINTED_BEYOND_RESOURCES", "More was painted than the resources bear.";
    DensityOutOfRange = "DENSITY_OUT_OF_RANGE", "An animal lives denser than ten times its living relative.";
    BiomassOutOfRange = "BIOMASS_OUT_OF_RANGE", "The carnivores' biomass is not 0.3 to 3 % of their prey's.";
    HerdWaits = "HERD_WAITS", "Herds waited, or missed what they need every day; the message says what and why.";
    WaypointNotReached = "WAYPOINT_NOT_REACHED", "An animal cannot reach a way-point that is to draw it.";
    PlanningConflict = "PLANNING_CONFLICT", "An edit of a planning could not be kept.";
    HeightStep = "HEIGHT_STEP", "The smallest step of height is coarse.";
    FeetConverted = "FEET_CONVERTED", "The raster is in feet or another unit; it was converted to metres.";
    FirstBand = "FIRST_BAND", "The raster has several bands; the first was read.";
    ImplausibleHeight = "IMPLAUSIBLE_HEIGHT", "Some heights occur nowhere on Earth.";
    CellSizeIgnored = "CELL_SIZE_IGNORED", "The raster says itself how large its cells are; the size given beside it was not used.";
    // Herds.
    SuspectAnimals = "SUSPECT_ANIMALS", "Regions of outlying size, proportion or shape may not be one animal each.";
    NoHull = "NO_HULL", "A herd of one, two or in a line has no area: it has no curve, field or density map.";
    LateAnimals = "LATE_ANIMALS", "Animals were not at their place at a key-frame; the report says who and why.";
    KeyFrameUnreachable = "KEY_FRAME_UNREACHABLE", "No animal can reach a key-frame in its time; the message says how much is needed.";
    HerdSizeDiffers = "HERD_SIZE_DIFFERS", "The key-herd has another number of animals than the herd of the ecosystem.";
    SpecksDropped = "SPECKS_DROPPED", "Regions too small to be animals were left out.";
    // Arrangements.
    SharedPlaces = "SHARED_PLACES", "Elements of different classes or sizes share a place.";
    CountNotReached = "COUNT_NOT_REACHED", "Not all elements asked for found a place.";
    OutsideValidity = "OUTSIDE_VALIDITY", "Some elements have surroundings that none of the exemplar's has.";
    NoHoles = "NO_HOLES", "The pattern has no hole in its domain.";
}

impl fmt::Display for WarningCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.code())
    }
}

/// Something a reader of the result should know; the work went on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Warning {
    /// What it is about; a stable code.
    pub code: String,
    /// The input concerned, as a JSON pointer into the body; empty when none.
    pub pointer: String,
    /// A sentence for people.
    pub message: String,
    /// How many things it concerns (cells, animals …), at least 1.
    pub count: u64,
}

impl Warning {
    /// A warning of the kind `code` on the input at `pointer`, about one thing.
    pub fn new(code: WarningCode, pointer: impl Into<String>, message: impl Into<String>) -> Self {
        Self { code: code.code().to_owned(), pointer: pointer.into(), message: message.into(), count: 1 }
    }

    /// The same warning about `count` things.
    pub fn with_count(self, count: u64) -> Self {
        Self { count, ..self }
    }
}
