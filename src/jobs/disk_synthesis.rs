//! `disk-synthesis`: a new arrangement that looks like an exemplar.

use biotope_api::error::ErrorCode;
use biotope_api::points::DiskSynthesisInputs;
use biotope_api::points::TargetInput;
use serde_json::Value;

use crate::compute::geometry::Region;
use crate::compute::pcf;
use crate::compute::pcf::Element;
use crate::compute::pcf::Target;
use crate::compute::raster::Raster;
use crate::jobs::Description;
use crate::jobs::Estimate;
use crate::jobs::Failure;
use crate::jobs::Invalid;
use crate::jobs::Job;
use crate::jobs::JobContext;
use crate::jobs::Process;
use crate::jobs::Sources;
use crate::jobs::points::elements;
use crate::jobs::points::exemplar::Exemplar;
use crate::jobs::points::faults;
use crate::jobs::points::regions;
use crate::jobs::points::synthesis;
use crate::jobs::process::ASYNC;
use crate::jobs::process::inputs_schema;
use crate::jobs::schema::read;

/// The process.
pub struct DiskSynthesis;

impl Process for DiskSynthesis {
    fn description(&self) -> Description {
        Description {
            id: "disk-synthesis",
            title: "Disk synthesis",
            text: "Lays out points or disks over a domain of any shape so that they look arranged like an exemplar, \
                   around elements that are there and by a painted density.",
            version: "1",
            keywords: &["point pattern", "pair correlation", "disks", "vegetation", "synthesis"],
            control: ASYNC,
            inputs: inputs_schema::<DiskSynthesisInputs>(),
            outputs: synthesis::outputs(),
        }
    }

    fn parse(&self, inputs: Value, sources: &dyn Sources) -> Result<Box<dyn Job>, Invalid> {
        let inputs: DiskSynthesisInputs = read(inputs)?;
        let exemplar = Exemplar::parse(&inputs.exemplar, sources)?;
        let target = ParsedTarget::parse(&inputs.target, &exemplar, sources)?;
        Ok(Box::new(SynthesisJob { inputs, exemplar, target }))
    }
}

/// Where and how much to lay out, parsed and checked.
struct ParsedTarget {
    domain: Region,
    density: Option<Raster<f32>>,
    fixed: Vec<Element>,
    counts: Vec<usize>,
}

impl ParsedTarget {
    fn parse(input: &TargetInput, exemplar: &Exemplar, sources: &dyn Sources) -> Result<Self, Invalid> {
        let named = &exemplar.named;
        let mut all = Invalid::default();
        let whole = match &input.domain {
            None => exemplar.domain.clone(),
            Some(given) => regions::open(given, "/target/domain", (&named.elements, sources))?,
        };
        let mut domain = whole.clone();
        for (i, excluded) in input.exclude.iter().enumerate() {
            let at = format!("/target/exclude/{i}");
            let Some(excluded) = all.keep(regions::open(excluded, &at, (&named.elements, sources))) else { continue };
            domain = domain
                .minus(&excluded)
                .ok_or_else(|| Invalid::new(&at, ErrorCode::ZeroArea, "a part of the target", "all of it"))?;
        }
        let density = input
            .density
            .as_ref()
            .map(|painted| regions::painted(painted, "/target/density", (Some(domain.bounds()), sources)));
        let density = density.and_then(|raster| all.keep(raster));
        let fixed = all.keep(fixed(input, (exemplar, &whole), sources)).unwrap_or_default();
        let counts = all.keep(counts(input, exemplar, &domain)).unwrap_or_default();
        all.into_result()?;
        let target = Self { domain, density, fixed, counts };
        target.check(exemplar).map(|()| target)
    }

    fn check(&self, exemplar: &Exemplar) -> Result<(), Invalid> {
        let named = &exemplar.named;
        let area = exemplar.domain.area();
        pcf::summaries(&named.elements, &exemplar.graph, area)
            .and_then(|classes| pcf::check_target((&classes, area), &self.as_target()))
            .map_err(|e| faults::pattern(&e, "/exemplar", |class| named.name(class)).unwrap_or_default())
    }

    fn as_target(&self) -> Target<'_> {
        Target {
            domain: &self.domain,
            room: None,
            density: self.density.as_ref(),
            fixed: &self.fixed,
            counts: self.counts.clone(),
        }
    }
}

/// The elements that are there: of the exemplar's classes and in the `whole` domain, what is cut
/// out of it included.
fn fixed(
    input: &TargetInput,
    (exemplar, whole): (&Exemplar, &Region),
    sources: &dyn Sources,
) -> Result<Vec<Element>, Invalid> {
    const AT: &str = "/target/fixed";
    let Some(given) = &input.fixed else { return Ok(Vec::new()) };
    let known = exemplar.named.classes.clone();
    let named = elements::open(given, AT, (known.clone(), sources))?;
    let mut faults = Invalid::default();
    for (i, element) in named.elements.iter().enumerate() {
        if element.class >= known.len() {
            let at = format!("{AT}/{i}/class");
            faults.push(at, ErrorCode::EmptyClass, "a class of the exemplar", named.name(element.class));
        }
        if !(element.centre.is_finite() && element.radius.is_finite() && element.radius >= 0.0) {
            faults.push(format!("{AT}/{i}"), ErrorCode::OutOfRange, "finite numbers, a radius from 0", "others");
        } else if !whole.contains(element.centre) {
            let found = format!("({}, {})", element.centre.x, element.centre.y);
            faults.push(format!("{AT}/{i}"), ErrorCode::OutsideDomain, "a place in the target's domain", found);
        }
    }
    faults.into_result().map(|()| named.elements)
}

/// Elements of each class: as asked, or by the exemplar's density.
fn counts(input: &TargetInput, exemplar: &Exemplar, domain: &Region) -> Result<Vec<usize>, Invalid> {
    let named = &exemplar.named;
    let factor = input.density_factor.unwrap_or(1.0) * domain.area() / exemplar.domain.area();
    let by_density = |class: usize| {
        let there = named.elements.iter().filter(|e| e.class == class).count();
        (there as f64 * factor).round() as usize
    };
    let mut counts: Vec<usize> = (0..named.classes.len()).map(by_density).collect();
    let mut faults = Invalid::default();
    for (name, count) in input.counts.iter().flatten() {
        match named.classes.iter().position(|c| c == name) {
            Some(class) => counts[class] = usize::try_from(*count).unwrap_or(usize::MAX),
            None => {
                let at = format!("/target/counts/{name}");
                faults.push(at, ErrorCode::EmptyClass, "a class of the exemplar", name);
            }
        }
    }
    let total = counts.iter().fold(0_usize, |sum, c| sum.saturating_add(*c));
    if total > pcf::MAX_ELEMENTS {
        let expected = format!("at most {} elements", pcf::MAX_ELEMENTS);
        faults.push("/target/counts", ErrorCode::OutOfRange, expected, total);
    }
    faults.into_result().map(|()| counts)
}

struct SynthesisJob {
    inputs: DiskSynthesisInputs,
    exemplar: Exemplar,
    target: ParsedTarget,
}

impl Job for SynthesisJob {
    fn estimate(&self) -> Estimate {
        let elements: usize = self.target.counts.iter().sum();
        Estimate { memory_bytes: self.exemplar.memory_bytes(false) + elements as u64 * 2_000 }
    }

    fn parameters(&self) -> Value {
        serde_json::to_value(&self.inputs).unwrap_or_default()
    }

    fn stages(&self) -> &'static [(&'static str, u32)] {
        synthesis::STAGES
    }

    fn run(self: Box<Self>, context: &mut JobContext<'_>) -> Result<(), Failure> {
        let named = &self.exemplar.named;
        let analysis = self.exemplar.analyse(false, &context.run)?;
        let options = synthesis::options(&self.inputs.options, context.seed);
        let result = pcf::synthesise(&analysis, &self.target.as_target(), &options, &context.run)
            .map_err(|e| faults::failure(e, |class| named.name(class)))?;
        let told = (named.classes.as_slice(), self.exemplar.warnings());
        synthesis::put(context, (&analysis, &result, &self.target.domain), told)
    }
}
