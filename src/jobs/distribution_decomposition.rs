//! `distribution-decomposition`: takes an arrangement apart into kinds of elements by their
//! surroundings.

use biotope_api::error::ErrorCode;
use biotope_api::points::DecompositionInputs;
use serde_json::Value;

use crate::compute::pcf;
use crate::compute::pcf::Dependencies;
use crate::compute::pcf::Element;
use crate::compute::pcf::PcfError;
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
use crate::jobs::Table;
use crate::jobs::artefact::Kind;
use crate::jobs::points::documents;
use crate::jobs::points::exemplar::Exemplar;
use crate::jobs::points::faults;
use crate::jobs::points::pictures;
use crate::jobs::process::ASYNC;
use crate::jobs::process::inputs_schema;
use crate::jobs::schema::read;

/// The process.
pub struct DistributionDecomposition;

impl Process for DistributionDecomposition {
    fn description(&self) -> Description {
        Description {
            id: "distribution-decomposition",
            title: "Distribution decomposition",
            text: "Tells the kinds of elements of an unlabelled arrangement apart by the correlation curve of every \
                   single element (k-means), and analyses each kind.",
            version: "1",
            keywords: &["point pattern", "pair correlation", "clustering", "k-means"],
            control: ASYNC,
            inputs: inputs_schema::<DecompositionInputs>(),
            outputs: vec![
                Output::new(
                    "labels",
                    "Labels",
                    "The cluster of every element: id, cluster, x, y, radius.",
                    Kind::Table,
                ),
                Output::new("analysis", "Analysis", "The clusters as classes, with their curves.", Kind::Json),
                Output::new("picture", "Picture", "The elements coloured by cluster.", Kind::Picture),
                Output::new("curves", "Curves", "The curves of the clusters with their envelopes.", Kind::Picture),
            ],
        }
    }

    fn parse(&self, inputs: Value, sources: &dyn Sources) -> Result<Box<dyn Job>, Invalid> {
        let inputs: DecompositionInputs = read(inputs)?;
        let exemplar = Exemplar::parse(&inputs.exemplar, sources)?;
        let most = exemplar.named.elements.len();
        if inputs.clusters as usize > most {
            let expected = format!("at most {most} clusters, one an element");
            return Err(Invalid::new("/clusters", ErrorCode::OutOfRange, expected, inputs.clusters));
        }
        Ok(Box::new(DecompositionJob { inputs, exemplar }))
    }
}

struct DecompositionJob {
    inputs: DecompositionInputs,
    exemplar: Exemplar,
}

impl Job for DecompositionJob {
    fn estimate(&self) -> Estimate {
        Estimate { memory_bytes: self.exemplar.memory_bytes(true) }
    }

    fn parameters(&self) -> Value {
        serde_json::to_value(&self.inputs).unwrap_or_default()
    }

    fn stages(&self) -> &'static [(&'static str, u32)] {
        &[("distribution.analysis", 1)]
    }

    fn run(self: Box<Self>, context: &mut JobContext<'_>) -> Result<(), Failure> {
        let Exemplar { named, domain, options, .. } = &self.exemplar;
        let asked = (self.inputs.clusters as usize, context.seed, options);
        let fail = |e: PcfError| faults::failure(e, cluster_name);
        let found = pcf::decompose(&named.elements, domain, asked, &context.run).map_err(fail)?;
        // The clusters as classes, numbered without gaps.
        let label = |(e, label): (&Element, &usize)| Element { class: *label, ..*e };
        let labelled: Vec<Element> = named.elements.iter().zip(&found.labels).map(label).collect();
        let clusters = found.labels.iter().max().map_or(0, |l| l + 1);
        let graph = Dependencies::by_size(clusters, &labelled);
        let analysis = pcf::analyse(&labelled, domain, (&graph, options), &context.run).map_err(fail)?;
        self.exemplar.warnings().into_iter().for_each(|warning| context.warn(warning));
        context.put("labels", Artefact::Table(labels(&labelled)))?;
        let document = documents::analysis(&analysis, domain, cluster_name);
        context.put("analysis", Artefact::document(&document).map_err(Failure::fault)?)?;
        let names: Vec<String> = (0..clusters).map(cluster_name).collect();
        let of = |i: usize| labelled[i].class;
        context.put("picture", pictures::pattern(&labelled, domain, (&names, of))?)?;
        context.put("curves", pictures::curves(&analysis, &[], cluster_name)?)
    }
}

fn cluster_name(cluster: usize) -> String {
    cluster.to_string()
}

fn labels(elements: &[Element]) -> Table {
    Table::new()
        .integers("id", "", 0..elements.len() as i64)
        .integers("cluster", "", elements.iter().map(|e| e.class as i64))
        .numbers("x", "m", elements.iter().map(|e| e.centre.x))
        .numbers("y", "m", elements.iter().map(|e| e.centre.y))
        .numbers("radius", "m", elements.iter().map(|e| e.radius))
}
