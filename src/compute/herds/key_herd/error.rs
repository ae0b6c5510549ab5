use crate::compute::pcf::PcfError;
use crate::compute::run::Stopped;

/// Why there is no key-herd.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum KeyHerdError {
    /// No animal to learn from.
    #[error("the exemplar holds no animal")]
    NoExemplar,
    /// An ellipse of the exemplar is none.
    #[error("animal {index} of the exemplar has axes that are not a ≥ b > 0")]
    BadEllipse {
        /// Which.
        index: usize,
    },
    /// An option is out of its range.
    #[error("{field} is {found}, not {expected}")]
    BadOption {
        /// Which option.
        field: &'static str,
        /// What it may be.
        expected: &'static str,
        /// What it is.
        found: f64,
    },
    /// The domain has no room for so many.
    #[error("{wanted} animals find no room: at most about {most} do, given the density, the obstacles and the terrain")]
    NoRoom {
        /// Animals asked for.
        wanted: usize,
        /// About how many there is room for.
        most: usize,
    },
    /// A painted map has no cell where an animal may be.
    #[error("the painted density is nowhere positive outside obstacles")]
    NoDensity,
    /// The curve of the exemplar could not be made.
    #[error(transparent)]
    Curve(#[from] PcfError),
    /// The work was stopped.
    #[error(transparent)]
    Stopped(#[from] Stopped),
}
