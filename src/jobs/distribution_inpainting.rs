//! `distribution-inpainting`: fills the holes of an arrangement.

use biotope_api::error::ErrorCode;
use biotope_api::points::InpaintingInputs;
use biotope_api::warning::Warning;
use biotope_api::warning::WarningCode;
use serde_json::Value;

use crate::compute::geometry::Region;
use crate::compute::pcf;
use crate::compute::pcf::InpaintingOptions;
use crate::compute::pcf::Known;
use crate::jobs::Description;
use crate::jobs::Estimate;
use crate::jobs::Failure;
use crate::jobs::Invalid;
use crate::jobs::Job;
use crate::jobs::JobContext;
use crate::jobs::Process;
use crate::jobs::Sources;
use crate::jobs::points::exemplar::Exemplar;
use crate::jobs::points::faults;
use crate::jobs::points::regions;
use crate::jobs::points::synthesis;
use crate::jobs::process::ASYNC;
use crate::jobs::process::inputs_schema;
use crate::jobs::schema::read;

/// The process.
pub struct DistributionInpainting;

impl Process for DistributionInpainting {
    fn description(&self) -> Description {
        Description {
            id: "distribution-inpainting",
            title: "Distribution inpainting",
            text: "Fills the holes of an arrangement of points or disks with new elements of the same kind; what is \
                   there stays.",
            version: "1",
            keywords: &["point pattern", "pair correlation", "disks", "vegetation", "missing data"],
            control: ASYNC,
            inputs: inputs_schema::<InpaintingInputs>(),
            outputs: synthesis::outputs(),
        }
    }

    fn parse(&self, inputs: Value, sources: &dyn Sources) -> Result<Box<dyn Job>, Invalid> {
        let inputs: InpaintingInputs = read(inputs)?;
        let exemplar = Exemplar::parse(&inputs.exemplar, sources)?;
        let whole = match &inputs.domain {
            Some(given) => regions::open(given, "/domain", (&exemplar.named.elements, sources))?,
            None => Region::rectangle(exemplar.domain.bounds()).map_err(|e| faults::polygon(&e, "/domain"))?,
        };
        let missing = exemplar.named.elements.iter().position(|e| !whole.contains(e.centre));
        match missing {
            Some(i) => {
                let at = format!("/exemplar/elements/{i}");
                Err(Invalid::new(at, ErrorCode::OutsideDomain, "a place in the whole domain", "one outside"))
            }
            None => Ok(Box::new(InpaintingJob { inputs, exemplar, whole })),
        }
    }
}

struct InpaintingJob {
    inputs: InpaintingInputs,
    exemplar: Exemplar,
    whole: Region,
}

impl Job for InpaintingJob {
    fn estimate(&self) -> Estimate {
        let share = self.whole.area() / self.exemplar.domain.area();
        let elements = self.exemplar.named.elements.len() as f64 * share.max(1.0);
        Estimate { memory_bytes: self.exemplar.memory_bytes(false) + (elements * 2_000.0) as u64 }
    }

    fn parameters(&self) -> Value {
        serde_json::to_value(&self.inputs).unwrap_or_default()
    }

    fn stages(&self) -> &'static [(&'static str, u32)] {
        synthesis::STAGES
    }

    fn run(self: Box<Self>, context: &mut JobContext<'_>) -> Result<(), Failure> {
        let Exemplar { named, domain, graph, options } = &self.exemplar;
        let options = InpaintingOptions {
            known: Known::Region(domain.clone()),
            analysis: options.clone(),
            synthesis: synthesis::options(&self.inputs.options, context.seed),
        };
        let filled = pcf::inpaint(&named.elements, &self.whole, (graph, &options), &context.run)
            .map_err(|e| faults::failure(e, |class| named.name(class)))?;
        let mut warnings = self.exemplar.warnings();
        if filled.holes.is_none() {
            let message = "the pattern is known in the whole domain: there is no hole to fill";
            warnings.push(Warning::new(WarningCode::NoHoles, "/domain", message));
        }
        let told = (named.classes.as_slice(), warnings);
        synthesis::put(context, (&filled.analysis, &filled.synthesis, &self.whole), told)
    }
}
