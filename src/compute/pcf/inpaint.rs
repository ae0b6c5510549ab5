use crate::compute::geometry::Point;
use crate::compute::geometry::Region;
use crate::compute::pcf::Analysis;
use crate::compute::pcf::AnalysisOptions;
use crate::compute::pcf::BorderOptions;
use crate::compute::pcf::Dependencies;
use crate::compute::pcf::Element;
use crate::compute::pcf::PcfError;
use crate::compute::pcf::Synthesis;
use crate::compute::pcf::SynthesisOptions;
use crate::compute::pcf::Target;
use crate::compute::pcf::analyse;
use crate::compute::pcf::learn_border;
use crate::compute::pcf::synthesise;
use crate::compute::run::Run;

/// Where a pattern is known.
#[derive(Debug, Clone)]
pub enum Known {
    /// In this region.
    Region(Region),
    /// Where its points lie, by a free-form border (T 3.2.3).
    Learnt(BorderOptions),
}

/// How holes are filled.
#[derive(Debug, Clone)]
pub struct InpaintingOptions {
    /// Where the pattern is known; the rest of the domain is filled.
    pub known: Known,
    /// How the pattern is analysed.
    pub analysis: AnalysisOptions,
    /// How new elements are laid out.
    pub synthesis: SynthesisOptions,
}

/// A pattern with its holes filled.
#[derive(Debug, Clone)]
pub struct Inpainting {
    /// The known region.
    pub known: Region,
    /// What was filled; `None` when there was no hole.
    pub holes: Option<Region>,
    /// What was learnt in the known region.
    pub analysis: Analysis,
    /// All old elements in their order, then the new ones.
    pub synthesis: Synthesis,
}

/// Fills the part of `domain` where the pattern is not known with elements of the same
/// arrangement and density; the `elements` that are there stay (T 3.2.3).
///
/// # Errors
/// Those of [`analyse()`], [`learn_border`] and [`synthesise`]; [`PcfError::NoRoom`] when the
/// known region and the domain are apart.
pub fn inpaint(
    elements: &[Element],
    domain: &Region,
    (dependencies, options): (&Dependencies, &InpaintingOptions),
    run: &Run,
) -> Result<Inpainting, PcfError> {
    // 1. What is known, and what is learnt from it.
    let known = match &options.known {
        Known::Region(region) => region.clone(),
        Known::Learnt(border) => learn_border(&elements.iter().map(|e| e.centre).collect::<Vec<Point>>(), border)?,
    };
    let known = known.intersection(domain).ok_or(PcfError::NoRoom)?;
    let seen: Vec<Element> = elements.iter().filter(|e| known.contains(e.centre)).copied().collect();
    let learning = AnalysisOptions { triplets: true, ..options.analysis.clone() };
    let analysis = analyse(&seen, &known, (dependencies, &learning), run)?;
    // 2. The holes, as many elements in them as the density asks for.
    let holes = domain.minus(&known);
    let hole_area = holes.as_ref().map_or(0.0, Region::area);
    let count = |class: usize| {
        let there = elements.iter().filter(|e| e.class == class).count();
        there + (analysis.classes[class].count as f64 / known.area() * hole_area).round() as usize
    };
    let counts = (0..analysis.classes.len()).map(count).collect();
    let target = Target { domain, room: holes.as_ref(), density: None, fixed: elements, counts };
    let synthesis = synthesise(&analysis, &target, &options.synthesis, run)?;
    Ok(Inpainting { known, holes, analysis, synthesis })
}
