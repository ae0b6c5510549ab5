//! Every error code, in one table: code → status → meaning; and the one error envelope.

use std::fmt;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::Serialize;

/// Makes [`ErrorCode`] out of the table below.
macro_rules! error_codes {
    ($($name:ident = $code:literal, $status:literal, $meaning:literal;)*) => {
        /// What went wrong, as a stable code. The table in the source is the whole list; the
        /// page `/problems` is made from it.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
        pub enum ErrorCode {
            $(#[doc = $meaning] $name,)*
        }

        impl ErrorCode {
            /// Every code, in the order of the table.
            pub const ALL: &'static [Self] = &[$(Self::$name,)*];

            /// The code as it stands on the wire.
            pub const fn code(self) -> &'static str {
                match self { $(Self::$name => $code,)* }
            }

            /// The HTTP status of a problem whose code this is.
            pub const fn status(self) -> u16 {
                match self { $(Self::$name => $status,)* }
            }

            /// What the code means, in one sentence.
            pub const fn meaning(self) -> &'static str {
                match self { $(Self::$name => $meaning,)* }
            }
        }
    };
}

error_codes! {
    // The request as a whole.
    NotFound = "not-found", 404, "There is no resource at this address.";
    MethodNotAllowed = "method-not-allowed", 405, "The resource exists but does not know this method.";
    NotAcceptable = "not-acceptable", 406, "The resource cannot be written in any of the media types asked for.";
    BodyTooSlow = "body-too-slow", 408, "The body of the request did not arrive in time.";
    BodyTooLarge = "body-too-large", 413, "The body of the request is larger than this service accepts.";
    UnsupportedMediaType = "unsupported-media-type", 415, "The body is of a media type this resource does not read.";
    BodyNotJson = "body-not-json", 400, "The body is not a JSON document.";
    BodyUnreadable = "body-unreadable", 400, "The body of the request broke off or could not be read.";
    InvalidParameter = "invalid-parameter", 400, "A parameter of the address is not as described.";
    InvalidHeader = "invalid-header", 400, "A header of the request is not as described.";
    InvalidInput = "invalid-input", 400, "The inputs are not as the process describes them; every fault is listed.";
    IdempotencyKeyReused = "idempotency-key-reused", 422, "The Idempotency-Key was used before with another request.";
    QueueFull = "queue-full", 503, "As many jobs wait as the queue holds; try again later.";
    Draining = "draining", 503, "The service is about to stop and accepts no new work.";
    PreconditionFailed = "precondition-failed", 412, "The resource is not in the state the request asks for.";
    RangeNotSatisfiable = "range-not-satisfiable", 416, "The range asked for lies outside the resource.";
    Internal = "internal", 500, "A fault of the service; it has been logged.";

    // Resources.
    NoSuchProcess = "no-such-process", 404, "There is no process of this id.";
    NoSuchJob = "no-such-job", 404, "There is no job of this id.";
    NoSuchOutput = "no-such-output", 404, "The job has no output of this id.";
    NoSuchAsset = "no-such-asset", 404, "There is no asset of this digest.";
    ResultNotReady = "result-not-ready", 404, "The job has not finished yet.";
    JobDismissed = "job-dismissed", 410, "The job was dismissed; its results are gone.";
    CrashedRepeatedly = "crashed-repeatedly", 500, "The service stopped each time it ran this job; it is not tried again.";

    // Inputs in general.
    Missing = "missing", 400, "A required field is missing.";
    UnknownField = "unknown-field", 400, "A field is not one that is described.";
    WrongType = "wrong-type", 400, "A value is of another JSON type than described.";
    OutOfRange = "out-of-range", 400, "A number is outside its limits, or is not a number.";
    NotOneOf = "not-one-of", 400, "A value is not one of the values allowed.";
    Malformed = "malformed", 400, "A text is not of the form described.";
    WrongCount = "wrong-count", 400, "A list or text is too short or too long.";
    Mismatch = "mismatch", 400, "A value does not fit any of the forms allowed.";
    Inconsistent = "inconsistent", 400, "Two values that are each valid contradict each other.";
    UnknownOutput = "unknown-output", 400, "An output was asked for that the process does not have.";
    HrefNotAllowed = "href-not-allowed", 400, "Only /assets/… and /jobs/…/results/… of this service and data: addresses may be referred to.";
    HrefNotFound = "href-not-found", 400, "Nothing stands behind the reference.";
    Unreadable = "unreadable", 400, "The bytes given are not in a format that can be read here.";
    NeedsTooMuchMemory = "needs-too-much-memory", 400, "The work would need more memory than this service may use.";

    // Terrains and other rasters.
    ColorPng = "COLOR_PNG", 400, "A picture in colour was given where one value a pixel is needed.";
    SizeMismatch = "SIZE_MISMATCH", 400, "A raster is of another size than the terrain it belongs to.";
    UnknownSpecies = "unknown-species", 400, "A species is not one of the library and does not bring all its numbers.";
    DuplicateSpecies = "duplicate-species", 400, "Two species have the same name.";
    FoodChainCycle = "food-chain-cycle", 400, "Animals eat each other in a circle.";
    MissingPrey = "missing-prey", 400, "An animal finds nothing of its diet among the species of the request.";
    ZeroProportions = "zero-proportions", 400, "The proportions asked for sum to zero.";
    NoRange = "NO_RANGE", 400, "The format holds no heights in metres; the range must be given beside it.";
    NoCellSize = "no-cell-size", 400, "The format does not say how large a cell is; its size must be given beside it.";
    RasterTooLarge = "raster-too-large", 400, "A raster has more cells than this service accepts.";
    RasterTooSmall = "raster-too-small", 400, "A raster has too few cells to be worked on.";
    NoData = "no-data", 400, "No cell of a raster has a value.";
    InfiniteValues = "infinite-values", 400, "A raster holds infinite values.";
    GeoreferenceUnusable = "georeference-unusable", 400, "The place or the coordinate system of a raster cannot be worked with.";
    PictureTooLarge = "picture-too-large", 400, "A picture has more pixels than this service accepts.";
    PictureAnimated = "picture-animated", 400, "A moving picture was given where a still one is needed.";
    PictureCmyk = "picture-cmyk", 400, "A picture in printing colours was given; red, green and blue are needed.";

    // Arrangements.
    DuplicateElements = "duplicate-elements", 400, "Two elements of one class have the same place and radius.";
    OutsideDomain = "outside-domain", 400, "An element lies outside its domain.";
    NoBorder = "no-border", 400, "No border can be learnt from elements on one line or at fewer than three places.";
    EmptyClass = "empty-class", 400, "A class is named that has no elements.";
    DependencyCycle = "dependency-cycle", 400, "Classes depend on each other in a circle.";
    ZeroArea = "zero-area", 400, "A domain has no area, or nothing of it is left.";
    SelfCrossing = "self-crossing", 400, "The rings of a polygon cross themselves or each other.";
    CannotFit = "cannot-fit", 400, "More disks are asked for than can lie in the target.";

    // Herds.
    OneKindOfScribble = "one-kind-of-scribble", 400, "Only animals or only ground is marked; both must be.";
    OutsidePicture = "outside-picture", 400, "A place lies outside the picture.";
    ContradictingScribbles = "contradicting-scribbles", 400, "The same pixels are marked as animal and as ground.";
    ColoursAlike = "colours-alike", 400, "What is marked as animal has the colours of what is marked as ground.";
    NoRegion = "no-region", 400, "Nothing in the picture looks like the marked animals.";
    UnknownAnimal = "unknown-animal", 400, "A number names no animal that was found.";
    NoRoomForHerd = "no-room-for-herd", 400, "So many animals find no room where they may stand.";
    NoDensity = "no-density", 400, "A painted density is nowhere above zero where animals may stand.";
    NoSuchHerd = "no-such-herd", 400, "The ecosystem has no herd of this number, or it has no path at this time.";
    TimesNotRising = "times-not-rising", 400, "A key-frame is not later than the one before it.";
    OffTerrain = "off-terrain", 400, "A place lies off the terrain, or in a hole of it.";
    InObstacle = "in-obstacle", 400, "A place lies inside an obstacle.";
    NoWay = "no-way", 400, "Obstacles leave no way from one key-frame to the next.";
    NumbersDiffer = "numbers-differ", 400, "Two key-herds have different numbers of animals.";
    NotAnEllipse = "not-an-ellipse", 400, "An ellipse has no axes a ≥ b > 0, or is not where it must be.";
}

impl fmt::Display for ErrorCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.code())
    }
}

impl ErrorCode {
    /// The code that stands on the wire as `code`; `None` when there is none.
    pub fn from_code(code: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|known| known.code() == code)
    }
}

/// One fault in what a client sent.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct FieldError {
    /// Where, as a JSON pointer into the body; empty for the body as a whole.
    pub pointer: String,
    /// What kind of fault; a stable code.
    pub code: String,
    /// What was expected there.
    pub expected: String,
    /// What was found there, shortened.
    pub found: String,
}

/// An error as every resource reports it (RFC 9457).
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Problem {
    /// Address that names the kind of problem.
    #[serde(rename = "type")]
    pub kind: String,
    /// The kind of problem, for people.
    pub title: String,
    /// The HTTP status.
    pub status: u16,
    /// What happened this time, for people.
    pub detail: String,
    /// The kind of problem, for programs; stable.
    pub code: String,
    /// Every fault found in the request; empty when the problem is of another kind.
    #[serde(default)]
    pub errors: Vec<FieldError>,
}

impl Problem {
    /// A problem of the kind `code` with a sentence on this occurrence.
    pub fn new(code: ErrorCode, detail: impl Into<String>) -> Self {
        Self {
            kind: problem_type(code),
            title: code.meaning().to_owned(),
            status: code.status(),
            detail: detail.into(),
            code: code.code().to_owned(),
            errors: Vec::new(),
        }
    }
}

/// The standard's own address for the kinds it names, else an anchor on our page of problems.
fn problem_type(code: ErrorCode) -> String {
    const OGC: &str = "http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/";
    match code {
        ErrorCode::NoSuchProcess | ErrorCode::NoSuchJob | ErrorCode::ResultNotReady => format!("{OGC}{code}"),
        _ => format!("/problems#{code}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_is_there_once_and_finds_itself() {
        for code in ErrorCode::ALL {
            assert_eq!(ErrorCode::from_code(code.code()), Some(*code));
            assert!((400..600).contains(&code.status()));
        }
    }
}
