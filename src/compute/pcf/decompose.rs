use crate::compute::geometry::Region;
use crate::compute::pcf::AnalysisOptions;
use crate::compute::pcf::Dependencies;
use crate::compute::pcf::Element;
use crate::compute::pcf::PcfError;
use crate::compute::pcf::analyse;
use crate::compute::random::Purpose;
use crate::compute::random::Stream;
use crate::compute::run::Run;
use rayon::prelude::*;

const START: Purpose = Purpose::new("distribution.clusters");

/// Starts of which the tightest clustering is taken (ours).
const STARTS: u64 = 8;

/// The most rounds of one start (ours).
const MOST_ROUNDS: usize = 100;

/// Elements told apart by their surroundings.
#[derive(Debug, Clone, PartialEq)]
pub struct Decomposition {
    /// The cluster of each element; clusters are numbered by falling size.
    pub labels: Vec<usize>,
    /// The mean individual curve of each cluster.
    pub centres: Vec<Vec<f64>>,
    /// Σ of squared distances of all curves to their cluster's centre.
    pub scatter: f64,
}

/// Groups `elements`, whatever their class, into `clusters` by their individual curves: k-means
/// in the space of curves (T 3.2.4), started by k-means++ (Arthur and Vassilvitskii 2007).
///
/// # Errors
/// [`PcfError::BadClusterCount`] for none or more than there are elements; those of [`analyse()`].
pub fn decompose(
    elements: &[Element],
    domain: &Region,
    (clusters, seed, options): (usize, u64, &AnalysisOptions),
    run: &Run,
) -> Result<Decomposition, PcfError> {
    if clusters == 0 || clusters > elements.len() {
        return Err(PcfError::BadClusterCount { asked: clusters, most: elements.len() });
    }
    // 1. The individual curves of all elements as one class.
    let one: Vec<Element> = elements.iter().map(|e| Element { class: 0, ..*e }).collect();
    let options = AnalysisOptions { keep_individual: true, ..options.clone() };
    let analysis = analyse(&one, domain, (&Dependencies::new(1, &[])?, &options), run)?;
    let curves = &analysis.curves[0].individual;
    // 2. The tightest of several clusterings.
    let starts: Vec<Result<Decomposition, PcfError>> =
        (0..STARTS).into_par_iter().map(|start| cluster(curves, clusters, (seed, start), run)).collect();
    let mut best: Option<Decomposition> = None;
    for found in starts {
        let found = found?;
        if best.as_ref().is_none_or(|b| found.scatter < b.scatter) {
            best = Some(found);
        }
    }
    best.map(by_size).ok_or(PcfError::BadClusterCount { asked: clusters, most: elements.len() })
}

fn distance_sq(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum()
}

/// The nearest centre of a curve and its squared distance.
fn nearest(curve: &[f64], centres: &[Vec<f64>]) -> (usize, f64) {
    let distances = centres.iter().map(|c| distance_sq(curve, c)).enumerate();
    distances.fold((0, f64::INFINITY), |best, this| if this.1 < best.1 { this } else { best })
}

/// One start of k-means.
fn cluster(curves: &[Vec<f64>], clusters: usize, at: (u64, u64), run: &Run) -> Result<Decomposition, PcfError> {
    let mut centres = spread_centres(curves, clusters, &mut Stream::new(at.0, START, at.1));
    let mut labels = vec![usize::MAX; curves.len()];
    let mut scatter = 0.0;
    for _ in 0..MOST_ROUNDS {
        run.check()?;
        let found: Vec<(usize, f64)> = curves.iter().map(|c| nearest(c, &centres)).collect();
        let next: Vec<usize> = found.iter().map(|(label, _)| *label).collect();
        scatter = found.iter().map(|(_, d)| d).sum();
        if next == labels {
            break;
        }
        labels = next;
        centres = means(curves, &labels, centres);
    }
    Ok(Decomposition { labels, centres, scatter })
}

/// k-means++: each further centre is a curve drawn by its squared distance to the nearest one.
fn spread_centres(curves: &[Vec<f64>], clusters: usize, random: &mut Stream) -> Vec<Vec<f64>> {
    let mut centres = vec![curves[random.below(curves.len())].clone()];
    while centres.len() < clusters {
        let distances: Vec<f64> = curves.iter().map(|c| nearest(c, &centres).1).collect();
        let mut at = random.unit() * distances.iter().sum::<f64>();
        let drawn = distances.iter().position(|d| {
            at -= d;
            at < 0.0
        });
        centres.push(curves[drawn.unwrap_or(random.below(curves.len()))].clone());
    }
    centres
}

/// The mean curve of each cluster; an empty one keeps its centre.
fn means(curves: &[Vec<f64>], labels: &[usize], mut centres: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    for (cluster, centre) in centres.iter_mut().enumerate() {
        let members = || curves.iter().zip(labels).filter(|(_, l)| **l == cluster).map(|(c, _)| c);
        let count = members().count() as f64;
        if count > 0.0 {
            for (bin, value) in centre.iter_mut().enumerate() {
                *value = members().map(|c| c[bin]).sum::<f64>() / count;
            }
        }
    }
    centres
}

/// Numbers the clusters by falling size.
fn by_size(found: Decomposition) -> Decomposition {
    let size = |cluster: usize| found.labels.iter().filter(|l| **l == cluster).count();
    let mut order: Vec<usize> = (0..found.centres.len()).collect();
    order.sort_by(|a, b| size(*b).cmp(&size(*a)).then(a.cmp(b)));
    let mut rank = vec![0; order.len()];
    order.iter().enumerate().for_each(|(place, cluster)| rank[*cluster] = place);
    Decomposition {
        labels: found.labels.iter().map(|l| rank[*l]).collect(),
        centres: order.iter().map(|c| found.centres[*c].clone()).collect(),
        scatter: found.scatter,
    }
}
