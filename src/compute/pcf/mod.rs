//! Pair correlation: what an arrangement looks like, and new arrangements that look the same.
//!
//! A pair correlation curve says how many partners an element has at each distance, over the
//! number it would have if all lay independently and uniformly (T chapter 3). Distances are
//! those of a [`Metric`]: of points, of disks that may overlap, of oriented ellipses.

mod analyse;
mod border;
mod classes;
mod correlate;
mod curve;
mod decompose;
mod ellipses;
mod error;
mod inpaint;
mod inset;
mod kernel;
pub mod mass;
mod mesh;
mod metric;
mod pattern;
pub mod quality;
mod synthesis;
mod tail;
mod windows;

pub use analyse::Analysis;
pub use analyse::AnalysisOptions;
pub use analyse::ClassSummary;
pub use analyse::analyse;
pub use analyse::summaries;
pub use border::BorderOptions;
pub use border::BorderRule;
pub use border::learn_border;
pub use classes::Dependencies;
pub use correlate::Body;
pub use correlate::BorderWeight;
pub use correlate::Correlator;
pub use correlate::Crowd;
pub use correlate::WEIGHT_CAP;
pub use curve::Curve;
pub use curve::RELATIVE_FLOOR;
pub use curve::relative_squares;
pub use curve::rms;
pub use decompose::Decomposition;
pub use decompose::decompose;
pub use ellipses::EllipseTrial;
pub use ellipses::analyse_ellipses;
pub use error::PcfError;
pub use inpaint::Inpainting;
pub use inpaint::InpaintingOptions;
pub use inpaint::Known;
pub use inpaint::inpaint;
pub use kernel::Axis;
pub use kernel::Kernel;
pub use kernel::MAX_BINS;
pub use metric::DISJOINT;
pub use metric::Frame;
pub use metric::Metric;
pub use pattern::Element;
pub use pattern::check_elements;
pub use pattern::check_inside;
pub use pattern::maximal_spacing;
pub use pattern::shared_places;
pub use synthesis::ClassReport;
pub use synthesis::CurveReport;
pub use synthesis::MAX_ELEMENTS;
pub use synthesis::Synthesis;
pub use synthesis::SynthesisOptions;
pub use synthesis::Target;
pub use synthesis::check_target;
pub use synthesis::synthesise;
pub use tail::Tail;
pub use tail::TailAxis;
