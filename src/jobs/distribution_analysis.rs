//! `distribution-analysis`: the correlation curves of a pattern.

use biotope_api::points::AnalysisInputs;
use serde_json::Value;

use crate::jobs::Artefact;
use crate::jobs::Description;
use crate::jobs::Estimate;
use crate::jobs::Failure;
use crate::jobs::Invalid;
use crate::jobs::Job;
use crate::jobs::JobContext;
use crate::jobs::Output;
use crate::jobs::Process;
use crate::jobs::Sources;
use crate::jobs::artefact::Kind;
use crate::jobs::points::documents;
use crate::jobs::points::exemplar::Exemplar;
use crate::jobs::points::pictures;
use crate::jobs::process::QUICK;
use crate::jobs::process::inputs_schema;
use crate::jobs::schema::read;

/// The process.
pub struct DistributionAnalysis;

impl Process for DistributionAnalysis {
    fn description(&self) -> Description {
        Description {
            id: "distribution-analysis",
            title: "Distribution analysis",
            text: "Learns the correlation curves of an arrangement of points or disks in classes: how many partners \
                   an element has at each distance, over the number in a uniform pattern.",
            version: "1",
            keywords: &["point pattern", "pair correlation", "disks", "vegetation"],
            control: QUICK,
            inputs: inputs_schema::<AnalysisInputs>(),
            outputs: vec![
                Output::new("analysis", "Analysis", "Classes, r_max, curves with envelopes, border.", Kind::Json),
                Output::new("curves.table", "Curves", "class, looks_at, r, mean, lower, upper.", Kind::Table),
                Output::new("picture", "Picture", "The pattern as disks coloured by class.", Kind::Picture),
                Output::new("curves", "Curves", "The curves with their envelopes.", Kind::Picture),
            ],
        }
    }

    fn parse(&self, inputs: Value, sources: &dyn Sources) -> Result<Box<dyn Job>, Invalid> {
        let inputs: AnalysisInputs = read(inputs)?;
        let exemplar = Exemplar::parse(&inputs.exemplar, sources)?;
        Ok(Box::new(AnalysisJob { inputs, exemplar }))
    }
}

struct AnalysisJob {
    inputs: AnalysisInputs,
    exemplar: Exemplar,
}

impl Job for AnalysisJob {
    fn estimate(&self) -> Estimate {
        Estimate { memory_bytes: self.exemplar.memory_bytes(self.inputs.individual) }
    }

    fn parameters(&self) -> Value {
        serde_json::to_value(&self.inputs).unwrap_or_default()
    }

    fn stages(&self) -> &'static [(&'static str, u32)] {
        &[("distribution.analysis", 1)]
    }

    fn run(self: Box<Self>, context: &mut JobContext<'_>) -> Result<(), Failure> {
        let Exemplar { named, domain, .. } = &self.exemplar;
        let name = |class: usize| named.name(class);
        let analysis = self.exemplar.analyse(self.inputs.individual, &context.run)?;
        self.exemplar.warnings().into_iter().for_each(|warning| context.warn(warning));
        let document = documents::analysis(&analysis, domain, name);
        context.put("analysis", Artefact::document(&document).map_err(Failure::fault)?)?;
        context.put("curves.table", Artefact::Table(documents::curve_table(analysis.curves.iter(), name)))?;
        let of = |i: usize| named.elements[i].class;
        context.put("picture", pictures::pattern(&named.elements, domain, (&named.classes, of))?)?;
        context.put("curves", pictures::curves(&analysis, &[], name)?)
    }
}
