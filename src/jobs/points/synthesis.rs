//! What disk synthesis and inpainting share: options in, warnings and outputs out.

use biotope_api::points::SynthesisInput;
use biotope_api::warning::Warning;
use biotope_api::warning::WarningCode;

use crate::compute::geometry::Region;
use crate::compute::pcf::Analysis;
use crate::compute::pcf::Curve;
use crate::compute::pcf::Synthesis;
use crate::compute::pcf::SynthesisOptions;
use crate::jobs::Artefact;
use crate::jobs::Failure;
use crate::jobs::JobContext;
use crate::jobs::Output;
use crate::jobs::artefact::Kind;
use crate::jobs::points::documents;
use crate::jobs::points::pictures;

/// The stages of a synthesis with their share of the time.
pub const STAGES: &[(&str, u32)] = &[("distribution.analysis", 5), ("distribution.synthesis", 95)];

/// The outputs of a synthesis.
pub fn outputs() -> Vec<Output> {
    vec![
        Output::new("elements", "Elements", "The arrangement: id, class, x, y, radius.", Kind::Table).in_unit("m"),
        Output::new(
            "report",
            "Report",
            "Error of every curve before and after the refinement, iterations, counts and warnings.",
            Kind::Json,
        ),
        Output::new("picture", "Picture", "The arrangement as disks coloured by class.", Kind::Picture),
        Output::new("curves", "Curves", "The exemplar's curves with envelopes, and the result's.", Kind::Picture),
        Output::new(
            "curves.table",
            "Curves",
            "The result's curves: class, looks_at, r, mean, lower, upper.",
            Kind::Table,
        ),
    ]
}

/// The options of a request over the defaults.
pub fn options(input: &SynthesisInput, seed: u64) -> SynthesisOptions {
    let default = SynthesisOptions::default();
    let count = |given: Option<u32>, default: usize| given.map_or(default, |n| n as usize);
    SynthesisOptions {
        seed,
        max_fails: count(input.max_fails, default.max_fails),
        tolerance: input.tolerance.unwrap_or(default.tolerance),
        tolerance_step: input.tolerance_step.unwrap_or(default.tolerance_step),
        max_iterations: count(input.max_iterations, default.max_iterations),
        outlier_rounds: count(input.outlier_rounds, default.outlier_rounds),
        block_elements: count(input.block_elements, default.block_elements),
        ..default
    }
}

/// What readers of a synthesis should know.
pub fn warnings(synthesis: &Synthesis, name: impl Fn(usize) -> String) -> Vec<Warning> {
    let mut warnings = Vec::new();
    for class in &synthesis.classes {
        let name = name(class.class);
        if class.missing > 0 {
            let message =
                format!("{} of {} {name} found no place that the exemplar allows", class.missing, class.asked);
            warnings
                .push(Warning::new(WarningCode::CountNotReached, "/target", message).with_count(class.missing as u64));
        }
        if class.outside > 0 {
            let message = format!(
                "{} of {} new {name} have surroundings that no element of the exemplar has: \
                 the pattern is too regular or too constrained to be met everywhere",
                class.outside, class.placed
            );
            warnings.push(
                Warning::new(WarningCode::OutsideValidity, "/exemplar", message).with_count(class.outside as u64),
            );
        }
    }
    warnings
}

/// Hands back everything a synthesis gives.
///
/// # Errors
/// When an output cannot be made or stored.
pub fn put(
    context: &mut JobContext<'_>,
    (analysis, synthesis, domain): (&Analysis, &Synthesis, &Region),
    (classes, mut noticed): (&[String], Vec<Warning>),
) -> Result<(), Failure> {
    let name = |class: usize| classes[class].clone();
    noticed.extend(warnings(synthesis, name));
    context.put("elements", Artefact::Table(documents::element_table(&synthesis.elements, name)))?;
    let report = documents::report(synthesis, domain.area(), &noticed, name);
    context.put("report", Artefact::document(&report).map_err(Failure::fault)?)?;
    noticed.into_iter().for_each(|warning| context.warn(warning));
    let of = |i: usize| synthesis.elements[i].class;
    context.put("picture", pictures::pattern(&synthesis.elements, domain, (classes, of))?)?;
    let curves: Vec<&Curve> = synthesis.curves.iter().map(|c| &c.curve).collect();
    context.put("curves", pictures::curves(analysis, &curves, name)?)?;
    context.put("curves.table", Artefact::Table(documents::curve_table(curves.into_iter(), name)))
}
