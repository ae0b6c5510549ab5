use super::Format;

/// Why a raster cannot be used. Each carries what was expected and what was found, for a
/// problem document.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RasterError {
    /// No bytes.
    #[error("the file is empty")]
    Empty,
    /// None of the formats that are read.
    #[error("the file is in no format that is read here: {found}")]
    UnknownFormat {
        /// What the first bytes look like.
        found: String,
    },
    /// The file is damaged, or uses a part of its format that is not read.
    #[error("the {format} cannot be read: {reason}")]
    Unreadable {
        /// The format it claims.
        format: Format,
        /// What is wrong.
        reason: String,
    },
    /// A picture in colour.
    #[error("one value a pixel is needed, this is {found}")]
    Colour {
        /// The kind of picture.
        found: String,
    },
    /// More cells than allowed; found out before they were allocated.
    #[error("{width} × {height} cells are more than the {max_cells} allowed")]
    TooLarge {
        /// Columns.
        width: u64,
        /// Rows.
        height: u64,
        /// Cells allowed.
        max_cells: u64,
    },
    /// Fewer than two columns or rows.
    #[error("{width} × {height} cells are too few")]
    TooSmall {
        /// Columns.
        width: u64,
        /// Rows.
        height: u64,
    },
    /// Another size than that of the terrain it belongs to.
    #[error("a size of {} × {} was expected, this is {} × {}", .expected.0, .expected.1, .found.0, .found.1)]
    SizeMismatch {
        /// Columns and rows expected.
        expected: (usize, usize),
        /// Columns and rows found.
        found: (usize, usize),
    },
    /// More or fewer values than the size says.
    #[error("{expected} {what} were expected, {found} were found")]
    CountMismatch {
        /// What is counted.
        what: &'static str,
        /// As the header or the request says.
        expected: u64,
        /// As the file holds.
        found: u64,
    },
    /// Levels without the range they stand for.
    #[error("the {format} holds no heights in metres: the range they span must be given")]
    NoRange {
        /// The format.
        format: Format,
    },
    /// A range that is none.
    #[error("the range from {min} to {max} is none")]
    BadRange {
        /// Lower end.
        min: f64,
        /// Upper end.
        max: f64,
    },
    /// A file that does not say how large a cell is, and no one else does.
    #[error("the {format} does not say how large a cell is: its size in metres must be given")]
    NoCellSize {
        /// The format.
        format: Format,
    },
    /// A cell size that is none.
    #[error("a cell of {cell_m} m is none")]
    BadCellSize {
        /// The size given.
        cell_m: f64,
    },
    /// A place that is not a number, or cells without extent.
    #[error("the place of the raster is not usable: {found}")]
    Georeference {
        /// What stands there.
        found: String,
    },
    /// A coordinate system that cannot be worked with.
    #[error("the coordinate system is not known here: {found}")]
    UnknownCrs {
        /// What stands there.
        found: String,
    },
    /// No cell has a value.
    #[error("none of the {cells} cells has a value")]
    AllNodata {
        /// Cells.
        cells: usize,
    },
    /// Values that are infinite.
    #[error("{count} cells are infinite, the first at column {column}, row {row}")]
    Infinite {
        /// Cells concerned.
        count: usize,
        /// Column of the first, from 0.
        column: usize,
        /// Row of the first, from 0 in the file.
        row: usize,
    },
    /// A comma where the decimal point belongs.
    #[error("numbers must be written with a decimal point, this has a comma: {found}")]
    DecimalComma {
        /// The number.
        found: String,
    },
    /// A value outside the limits of its kind.
    #[error("values from {min} to {max} were expected, {found} was found")]
    OutOfRange {
        /// Least value allowed.
        min: f64,
        /// Greatest value allowed.
        max: f64,
        /// The first that is neither.
        found: f64,
    },
}

impl RasterError {
    /// The stable code of the problem.
    pub const fn code(&self) -> &'static str {
        match self {
            Self::Empty | Self::UnknownFormat { .. } | Self::Unreadable { .. } | Self::DecimalComma { .. } => {
                "unreadable"
            }
            Self::Colour { .. } => "COLOR_PNG",
            Self::TooLarge { .. } => "raster-too-large",
            Self::TooSmall { .. } => "raster-too-small",
            Self::SizeMismatch { .. } | Self::CountMismatch { .. } => "SIZE_MISMATCH",
            Self::NoRange { .. } => "NO_RANGE",
            Self::NoCellSize { .. } => "no-cell-size",
            Self::BadRange { .. } | Self::BadCellSize { .. } | Self::OutOfRange { .. } => "out-of-range",
            Self::Georeference { .. } | Self::UnknownCrs { .. } => "georeference-unusable",
            Self::AllNodata { .. } => "no-data",
            Self::Infinite { .. } => "infinite-values",
        }
    }

    /// The field beside the file that the problem concerns: `range_m`, `cell_m` or `raw`; empty
    /// for the file itself.
    pub const fn field(&self) -> &'static str {
        match self {
            Self::NoRange { .. } | Self::BadRange { .. } => "range_m",
            Self::NoCellSize { .. } | Self::BadCellSize { .. } => "cell_m",
            _ => "",
        }
    }

    /// What was expected.
    pub fn expected(&self) -> String {
        match self {
            Self::Empty | Self::UnknownFormat { .. } => Format::READ.to_owned(),
            Self::Unreadable { format, .. } => format!("a whole {format}"),
            Self::Colour { .. } => "one band of grey or of numbers".to_owned(),
            Self::TooLarge { max_cells, .. } => format!("at most {max_cells} cells"),
            Self::TooSmall { .. } => "at least 2 × 2 cells".to_owned(),
            Self::SizeMismatch { expected, .. } => format!("{} × {} cells", expected.0, expected.1),
            Self::CountMismatch { what, expected, .. } => format!("{expected} {what}"),
            Self::NoRange { .. } => "the heights in metres of the lowest and the highest level".to_owned(),
            Self::BadRange { .. } => "a finite minimum below a finite maximum".to_owned(),
            Self::NoCellSize { .. } => "the side of a cell in metres".to_owned(),
            Self::BadCellSize { .. } => "a finite size above 0 m".to_owned(),
            Self::Georeference { .. } => "finite coordinates and cells with an extent".to_owned(),
            Self::UnknownCrs { .. } => "an EPSG code of a projected or geographic coordinate system".to_owned(),
            Self::AllNodata { .. } => "at least one cell with a value".to_owned(),
            Self::Infinite { .. } => "finite values".to_owned(),
            Self::DecimalComma { .. } => "numbers with a decimal point".to_owned(),
            Self::OutOfRange { min, max, .. } => format!("values from {min} to {max}"),
        }
    }

    /// What was found.
    pub fn found(&self) -> String {
        match self {
            Self::Empty => "0 bytes".to_owned(),
            Self::Unreadable { reason, .. } => reason.clone(),
            Self::TooLarge { width, height, .. } | Self::TooSmall { width, height } => {
                format!("{width} × {height} cells")
            }
            Self::SizeMismatch { found, .. } => format!("{} × {} cells", found.0, found.1),
            Self::CountMismatch { what, found, .. } => format!("{found} {what}"),
            Self::NoRange { format } | Self::NoCellSize { format } => format!("a {format} without it"),
            Self::BadRange { min, max } => format!("{min} to {max}"),
            Self::BadCellSize { cell_m } => format!("{cell_m} m"),
            Self::UnknownFormat { found }
            | Self::Colour { found }
            | Self::Georeference { found }
            | Self::UnknownCrs { found }
            | Self::DecimalComma { found } => found.clone(),
            Self::AllNodata { cells } => format!("{cells} cells without data"),
            Self::Infinite { count, column, row } => {
                format!("{count} infinite, the first at column {column}, row {row}")
            }
            Self::OutOfRange { found, .. } => found.to_string(),
        }
    }
}
