//! A pattern to learn from, parsed and checked.

use biotope_api::error::ErrorCode;
use biotope_api::points::DomainInput;
use biotope_api::points::ExemplarInput;
use biotope_api::points::MetricInput;
use biotope_api::warning::Warning;
use biotope_api::warning::WarningCode;

use crate::compute::geometry::Region;
use crate::compute::pcf;
use crate::compute::pcf::Analysis;
use crate::compute::pcf::AnalysisOptions;
use crate::compute::pcf::Axis;
use crate::compute::pcf::Dependencies;
use crate::compute::pcf::Metric;
use crate::compute::pcf::PcfError;
use crate::compute::run::Run;
use crate::jobs::Failure;
use crate::jobs::Invalid;
use crate::jobs::Sources;
use crate::jobs::points::elements;
use crate::jobs::points::elements::Named;
use crate::jobs::points::faults;
use crate::jobs::points::regions;

/// Where an exemplar stands in the inputs.
const AT: &str = "/exemplar";

/// A pattern with its domain, ready to be analysed.
#[derive(Debug, Clone)]
pub struct Exemplar {
    /// Its elements and the names of their classes.
    pub named: Named,
    /// Its domain, given or learnt.
    pub domain: Region,
    /// Which class looks at which.
    pub graph: Dependencies,
    /// How it is analysed.
    pub options: AnalysisOptions,
}

impl Exemplar {
    /// Parses and checks the exemplar of a request.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn parse(input: &ExemplarInput, sources: &dyn Sources) -> Result<Self, Invalid> {
        Self::parse_within(input, sources, true)
    }

    /// The same; elements outside the domain are allowed unless `all_inside`.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn parse_within(input: &ExemplarInput, sources: &dyn Sources, all_inside: bool) -> Result<Self, Invalid> {
        let named = elements::open(&input.elements, &format!("{AT}/elements"), (Vec::new(), sources))?;
        let name = |class: usize| named.name(class);
        let fault = |e: PcfError| faults::pattern(&e, AT, name).unwrap_or_default();
        pcf::check_elements(&named.elements).map_err(fault)?;
        let mut all = Invalid::default();
        let learnt = DomainInput::FreeForm { max_circumradius: None, edge_ratio: None, margin: None };
        let domain = input.domain.as_ref().unwrap_or(&learnt);
        let domain = all.keep(regions::open(domain, &format!("{AT}/domain"), (&named.elements, sources)));
        let options = all.keep(options(input, &named).map_err(fault));
        let graph = all.keep(graph(input, &named));
        if let (Some(domain), true) = (&domain, all_inside) {
            all.keep(pcf::check_inside(&named.elements, domain).map_err(fault));
        }
        match (domain, options, graph) {
            (Some(domain), Some(options), Some(graph)) => {
                all.into_result().map(|()| Self { named, domain, graph, options })
            }
            _ => Err(all),
        }
    }

    /// Analyses it; its own curves are kept if `keep_individual`.
    ///
    /// # Errors
    /// A stop.
    pub fn analyse(&self, keep_individual: bool, run: &Run) -> Result<Analysis, Failure> {
        let options = AnalysisOptions { keep_individual, triplets: true, ..self.options.clone() };
        pcf::analyse(&self.named.elements, &self.domain, (&self.graph, &options), run)
            .map_err(|e| faults::failure(e, |class| self.named.name(class)))
    }

    /// What readers should know of it.
    pub fn warnings(&self) -> Vec<Warning> {
        let shared = pcf::shared_places(&self.named.elements);
        let Some((first, second)) = shared.first() else { return Vec::new() };
        let message = format!("elements {first} and {second} of different classes or sizes share one place");
        let pointer = format!("{AT}/elements/{second}");
        vec![Warning::new(WarningCode::SharedPlaces, pointer, message).with_count(shared.len() as u64)]
    }

    /// Memory of an analysis with `individual` curves kept, in bytes, about.
    pub fn memory_bytes(&self, individual: bool) -> u64 {
        let (count, bins) = (self.named.elements.len() as u64, self.options.axis.bins() as u64);
        let kept = if individual { count } else { count.min(1024) };
        (64 << 20) + count * 256 + kept * bins * 8 * (self.graph.curves().len() as u64)
    }
}

fn options(input: &ExemplarInput, named: &Named) -> Result<AnalysisOptions, PcfError> {
    let has_disks = named.elements.iter().any(|e| e.radius > 0.0);
    let metric = match input.metric {
        Some(MetricInput::Point) => Metric::Point,
        Some(MetricInput::Disk) => Metric::Disk,
        None => {
            if has_disks {
                Metric::Disk
            } else {
                Metric::Point
            }
        }
    };
    let default = AnalysisOptions::of(metric);
    let axis = Axis {
        sigma: input.sigma.unwrap_or(default.axis.sigma),
        step: input.step.unwrap_or(default.axis.step),
        extent: input.extent.unwrap_or(default.axis.extent),
    };
    Ok(AnalysisOptions { axis: axis.checked()?, ..default })
}

fn graph(input: &ExemplarInput, named: &Named) -> Result<Dependencies, Invalid> {
    let classes = named.classes.len();
    let Some(given) = &input.dependencies else { return Ok(Dependencies::by_size(classes, &named.elements)) };
    let mut faults = Invalid::default();
    let mut number = |name: &String, pointer: String| {
        let found = named.classes.iter().position(|c| c == name);
        if found.is_none() {
            faults.push(pointer, ErrorCode::EmptyClass, "a class that has elements", name);
        }
        found
    };
    let mut pairs = Vec::new();
    for (i, dependency) in given.iter().enumerate() {
        let child = number(&dependency.class, format!("{AT}/dependencies/{i}/class"));
        for (k, parent) in dependency.depends_on.iter().enumerate() {
            let parent = number(parent, format!("{AT}/dependencies/{i}/depends_on/{k}"));
            pairs.extend(child.zip(parent));
        }
    }
    faults.into_result()?;
    Dependencies::new(classes, &pairs)
        .map_err(|e| faults::pattern(&e, AT, |class| named.name(class)).unwrap_or_default())
}
