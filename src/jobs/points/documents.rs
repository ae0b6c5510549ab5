//! The documents and tables of the four processes.

use biotope_api::points::AnalysisOutput;
use biotope_api::points::ClassOutput;
use biotope_api::points::ClassReportOutput;
use biotope_api::points::CurveOutput;
use biotope_api::points::CurveReportOutput;
use biotope_api::points::MetricInput;
use biotope_api::points::SynthesisReport;
use biotope_api::warning::Warning;

use crate::compute::geometry::Region;
use crate::compute::pcf::Analysis;
use crate::compute::pcf::Curve;
use crate::compute::pcf::Element;
use crate::compute::pcf::Metric;
use crate::compute::pcf::Synthesis;
use crate::jobs::Table;
use crate::jobs::points::regions;

/// The document `analysis`.
pub fn analysis(analysis: &Analysis, domain: &Region, name: impl Fn(usize) -> String) -> AnalysisOutput {
    let class = |c: usize| {
        let summary = &analysis.classes[c];
        ClassOutput {
            class: name(c),
            count: summary.count,
            mean_radius_m: summary.radii.iter().sum::<f64>() / summary.count.max(1) as f64,
            r_max_m: summary.r_max,
            depends_on: analysis.dependencies.parents(c).iter().map(|p| name(*p)).collect(),
        }
    };
    let curve = |c: &Curve| CurveOutput {
        class: name(c.child),
        looks_at: name(c.parent),
        r_max_m: c.unit,
        r: c.axis.places(),
        mean: c.mean.clone(),
        lower: c.lower.clone(),
        upper: c.upper.clone(),
        individual: c.individual.clone(),
    };
    AnalysisOutput {
        metric: if analysis.metric == Metric::Disk { MetricInput::Disk } else { MetricInput::Point },
        sigma: analysis.curves.first().map_or(0.0, |c| c.axis.sigma),
        area_m2: analysis.area,
        classes: (0..analysis.classes.len()).map(class).collect(),
        curves: analysis.curves.iter().map(curve).collect(),
        border: regions::polygons(domain),
    }
}

/// The curves as a table: class, looks_at, r, mean, lower, upper.
pub fn curve_table<'a>(curves: impl Iterator<Item = &'a Curve>, name: impl Fn(usize) -> String) -> Table {
    let curves: Vec<&Curve> = curves.collect();
    let rows = || curves.iter().flat_map(|c| (0..c.mean.len()).map(move |bin| (*c, bin)));
    Table::new()
        .texts("class", rows().map(|(c, _)| name(c.child)))
        .texts("looks_at", rows().map(|(c, _)| name(c.parent)))
        .numbers("r", "r_max", rows().map(|(c, bin)| c.axis.r(bin)))
        .numbers("mean", "", rows().map(|(c, bin)| c.mean[bin]))
        .numbers("lower", "", rows().map(|(c, bin)| c.lower[bin]))
        .numbers("upper", "", rows().map(|(c, bin)| c.upper[bin]))
}

/// The table `elements`: id, class, x, y, radius.
pub fn element_table(elements: &[Element], name: impl Fn(usize) -> String) -> Table {
    Table::new()
        .integers("id", "", 0..elements.len() as i64)
        .texts("class", elements.iter().map(|e| name(e.class)))
        .numbers("x", "m", elements.iter().map(|e| e.centre.x))
        .numbers("y", "m", elements.iter().map(|e| e.centre.y))
        .numbers("radius", "m", elements.iter().map(|e| e.radius))
}

/// The document `report`.
pub fn report(
    synthesis: &Synthesis,
    area_m2: f64,
    warnings: &[Warning],
    name: impl Fn(usize) -> String,
) -> SynthesisReport {
    let classes = synthesis.classes.iter().map(|c| ClassReportOutput {
        class: name(c.class),
        asked: c.asked,
        fixed: c.fixed,
        placed: c.placed,
        missing: c.missing,
        darts: c.darts,
        by_grid_search: c.by_grid,
        iterations: c.iterations,
        replaced: c.replaced,
        outside_validity: c.outside,
    });
    let curves = synthesis.curves.iter().map(|c| CurveReportOutput {
        class: name(c.curve.child),
        looks_at: name(c.curve.parent),
        error_before: c.before,
        error_after: c.after,
    });
    SynthesisReport { area_m2, classes: classes.collect(), curves: curves.collect(), warnings: warnings.to_vec() }
}
