//! New arrangements with the curves of an exemplar (T 3.1.2, 3.3, 3.4.3, 3.5).

mod absence;
mod at_large;
mod border_table;
mod darts;
mod depths;
mod far;
mod filling;
mod goal;
mod intensity;
mod kernel_rows;
mod layout;
mod limits;
mod meter;
mod nodes;
mod outliers;
mod partners;
mod patch;
mod radii;
mod refine;
mod sampler;
mod scene;
mod settle;
mod shares;
mod strata;
mod trial;

use crate::compute::geometry::Point;
use crate::compute::geometry::Region;
use crate::compute::pcf::Analysis;
use crate::compute::pcf::ClassSummary;
use crate::compute::pcf::Curve;
use crate::compute::pcf::Element;
use crate::compute::pcf::PcfError;
use crate::compute::pcf::maximal_spacing;
use crate::compute::pcf::rms;
use crate::compute::raster::Raster;
use crate::compute::run::Run;
use intensity::Intensity;
use layout::Layout;
use layout::Tally;
use meter::Meter;
use sampler::Sampler;
use scene::Scene;

/// The most elements one synthesis lays out.
pub const MAX_ELEMENTS: usize = 1_000_000;

/// The densest packing of equal disks, π/(2√3): disks that never overlap in the exemplar cannot
/// cover more of the target.
const DENSEST_PACKING: f64 = 0.906_899_682_117_108_9;

/// Where and what to lay out.
#[derive(Debug, Clone)]
pub struct Target<'a> {
    /// The whole domain: densities and border weights refer to it.
    pub domain: &'a Region,
    /// Where new elements may lie, a part of the domain; `None`: everywhere.
    pub room: Option<&'a Region>,
    /// A painted density, relative; 0 bars a place. `None`: the same everywhere.
    pub density: Option<&'a Raster<f32>>,
    /// Elements that are there and stay; new ones keep their correlation with them.
    pub fixed: &'a [Element],
    /// Elements of each class in the result, those of `fixed` included.
    pub counts: Vec<usize>,
}

/// How elements are laid out.
#[derive(Debug, Clone, PartialEq)]
pub struct SynthesisOptions {
    /// Seed of all random choices.
    pub seed: u64,
    /// Successive rejections after which the grid search takes over. Default: 1000 (T 3.5.2).
    pub max_fails: usize,
    /// ε₀, the error (eq. 3.13) accepted at the first dart. Default: 0 (ours).
    pub tolerance: f64,
    /// ε_Δ, what every rejection since the last acceptance adds to it. Default: 0.5 (ours;
    /// T gives no number and counts all rejections of the class).
    pub tolerance_step: f64,
    /// The most iterations of a descent. Default: 12 (ours: settling does better what more would). 0: no refinement.
    pub max_iterations: usize,
    /// The descent ends when elements move less than this many r_max in the mean. Default:
    /// 0.0001 (ours).
    pub least_move: f64,
    /// Rounds in which elements are laid out again where they fit best. Default: 4 (ours).
    pub outlier_rounds: usize,
    /// An individual curve is outside the validity region when it leaves it by more than this
    /// share of the bound. Default: 0.5 (ours: the extremes of an exemplar's few curves are
    /// often passed a little by as many new ones).
    pub outlier_tolerance: f64,
    /// Elements of a class that are laid out as one block; larger classes are cut into blocks of
    /// about this size, each of which sees its neighbours. Default: 1500 (ours).
    pub block_elements: usize,
}

impl Default for SynthesisOptions {
    fn default() -> Self {
        Self {
            seed: 0,
            max_fails: 1000,
            tolerance: 0.0,
            tolerance_step: 0.5,
            max_iterations: 12,
            least_move: 1e-4,
            outlier_rounds: 4,
            outlier_tolerance: 0.5,
            block_elements: 1500,
        }
    }
}

/// A curve of the result and how near it is to the exemplar's.
#[derive(Debug, Clone)]
pub struct CurveReport {
    /// Root mean square error after the initialisation.
    pub before: f64,
    /// The same at the end.
    pub after: f64,
    /// The curve at the end, of the new elements.
    pub curve: Curve,
}

/// What happened to a class.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ClassReport {
    /// The class.
    pub class: usize,
    /// Elements asked for, those that were there included.
    pub asked: usize,
    /// Elements that were there.
    pub fixed: usize,
    /// New elements.
    pub placed: usize,
    /// Darts thrown.
    pub darts: usize,
    /// Elements placed by the grid search.
    pub by_grid: usize,
    /// Iterations of the descents, the most of any block.
    pub iterations: usize,
    /// Elements laid out again as outliers.
    pub replaced: usize,
    /// Elements whose individual curve is outside the validity region in the end.
    pub outside: usize,
    /// Elements asked for that found no place.
    pub missing: usize,
}

/// A new arrangement.
#[derive(Debug, Clone)]
pub struct Synthesis {
    /// The fixed elements in their order, then the new ones, class by class.
    pub elements: Vec<Element>,
    /// One entry for each class, in the order they were laid out.
    pub classes: Vec<ClassReport>,
    /// One entry for each curve of a class that got new elements.
    pub curves: Vec<CurveReport>,
}

/// Lays out elements so that their curves are those of `analysis`.
///
/// The work grows linearly with the elements: classes above `block_elements` are cut into blocks
/// that are filled and refined in four colours, each seeing what its neighbours hold.
///
/// # Errors
/// A density that is negative or 0 everywhere, no room, too many elements, disks that cannot
/// fit, a stop.
pub fn synthesise(
    analysis: &Analysis,
    target: &Target<'_>,
    options: &SynthesisOptions,
    run: &Run,
) -> Result<Synthesis, PcfError> {
    // 1. Whether it can be done at all.
    check_counts((&analysis.classes, analysis.area), target)?;
    let intensity = relative_intensity(target)?;
    let mut result = Synthesis { elements: target.fixed.to_vec(), classes: Vec::new(), curves: Vec::new() };
    let fixed = |class: usize| target.fixed.iter().filter(|e| e.class == class).count();
    let passes = |class: usize| layout::steps(target.counts[class], options);
    let steps: usize = (0..target.counts.len()).map(|c| target.counts[c].saturating_sub(fixed(c)) * passes(c)).sum();
    let meter = Meter::new(run, steps as u64);
    meter.advance(0)?;
    for class in analysis.dependencies.order() {
        // 2. The radii to come, and the curves they are to have among what is there.
        let fixed = fixed(*class);
        let asked = target.counts[*class];
        let summary = &analysis.classes[*class];
        let radii = radii::draw(&summary.radii, asked.saturating_sub(fixed), (options.seed, *class));
        let mut report = ClassReport::new(*class, asked, fixed);
        if !radii.is_empty() {
            lay_out(analysis, (target, intensity), (&mut report, radii), (options, &meter), &mut result)?;
        }
        result.classes.push(report);
    }
    Ok(result)
}

/// Whether `target` can be asked for, given the classes of an exemplar and the area they were
/// observed in: what [`synthesise`] checks before it begins.
///
/// # Errors
/// Too many elements, disks that cannot fit, a density that is negative or 0 everywhere.
pub fn check_target(exemplar: (&[ClassSummary], f64), target: &Target<'_>) -> Result<(), PcfError> {
    check_counts(exemplar, target)?;
    relative_intensity(target).map(|_| ())
}

/// Lays out one class and adds it to `result`.
fn lay_out(
    analysis: &Analysis,
    (target, intensity): (&Target<'_>, Intensity<'_>),
    (report, radii): (&mut ClassReport, Vec<f64>),
    (options, meter): (&SynthesisOptions, &Meter<'_>),
    result: &mut Synthesis,
) -> Result<(), PcfError> {
    let class = report.class;
    let scene = Scene::new(analysis, (target.domain, intensity), (class, &radii), &result.elements);
    let room = target.room.unwrap_or(target.domain);
    let (wide, least) = block_width(&scene, options);
    let sampler = Sampler::new(room, intensity, (scene.unit, wide, least));
    if sampler.mass() <= 0.0 {
        return Err(PcfError::NoRoom);
    }
    // 3. Initialisation: darts, then the grid search.
    let (mut layout, mut tally) = (Layout::new(&scene, &sampler), Tally::default());
    layout.fill(&radii, (options, meter), &mut tally)?;
    let before = layout.curves(meter.run)?;
    // 4. Refinement, outliers laid out again; a large class twice, the seams of its blocks inside
    //    the blocks of the second pass.
    layout.improve((options, meter), &mut tally)?;
    let shifted;
    if layout::passes(scene.count, options) > 1 {
        shifted = sampler.between();
        layout.regroup(&shifted);
        tally.outside = 0;
        layout.improve((options, meter), &mut tally)?;
    }
    // 5. The report.
    let error = |curve: &Curve, view: &scene::View<'_>| rms(&curve.mean, &view.target.mean);
    for ((before, curve), view) in before.iter().zip(layout.curves(meter.run)?).zip(&scene.views) {
        result.curves.push(CurveReport { before: error(before, view), after: error(&curve, view), curve });
    }
    report.take(&tally, layout.elements.len());
    let element = |(centre, radius): &(Point, f64)| Element { centre: *centre, radius: *radius, class };
    result.elements.extend(layout.elements.iter().map(element));
    Ok(())
}

impl ClassReport {
    fn new(class: usize, asked: usize, fixed: usize) -> Self {
        Self {
            class,
            asked,
            fixed,
            placed: 0,
            darts: 0,
            by_grid: 0,
            iterations: 0,
            replaced: 0,
            outside: 0,
            missing: 0,
        }
    }

    fn take(&mut self, tally: &Tally, placed: usize) {
        self.placed = placed;
        (self.darts, self.by_grid, self.missing) = (tally.darts, tally.by_grid, tally.missing);
        (self.iterations, self.replaced, self.outside) = (tally.iterations, tally.replaced, tally.outside);
    }
}

/// How wide a block is that is all of the room, and at least; in metres.
const ONE_BLOCK: (f64, f64) = (f64::INFINITY, 0.0);

/// How wide a block is to be, and at least: all of the domain for a small class, and never less
/// than the farthest two elements can see each other; in metres.
fn block_width(scene: &Scene<'_>, options: &SynthesisOptions) -> (f64, f64) {
    if scene.count <= options.block_elements {
        return ONE_BLOCK;
    }
    let sight = scene.metric.reach(scene.axis.reach(), scene.largest_radius(), scene.largest_radius());
    let wide = (options.block_elements.max(1) as f64 * scene.domain.area() / scene.count as f64).sqrt();
    (wide, sight * scene.unit)
}

/// The painted density over its mean in the domain.
fn relative_intensity<'a>(target: &Target<'a>) -> Result<Intensity<'a>, PcfError> {
    let intensity = Intensity::new(target.density)?;
    if intensity.is_flat() {
        return Ok(intensity);
    }
    let total: usize = target.counts.iter().sum();
    let unit = maximal_spacing(target.domain.area(), total);
    let whole = Sampler::new(target.domain, intensity, (unit, ONE_BLOCK.0, ONE_BLOCK.1));
    let mean = whole.mass() / target.domain.area();
    if mean > 0.0 { Ok(intensity.relative_to(mean)) } else { Err(PcfError::BadDensity { reason: "0 everywhere" }) }
}

fn check_counts((classes, area): (&[ClassSummary], f64), target: &Target<'_>) -> Result<(), PcfError> {
    let asked = target.counts.iter().fold(0_usize, |sum, count| sum.saturating_add(*count));
    if asked > MAX_ELEMENTS {
        return Err(PcfError::TooManyElements { asked, most: MAX_ELEMENTS });
    }
    for (class, summary) in classes.iter().enumerate() {
        let mean_area = summary.radii.iter().map(|r| std::f64::consts::PI * r * r).sum::<f64>() / summary.count as f64;
        let asked = target.counts[class];
        let cover = asked as f64 * mean_area / target.domain.area();
        if !summary.overlaps && cover > DENSEST_PACKING {
            let exemplar = summary.count as f64 * mean_area / area;
            return Err(PcfError::CannotFit { class, asked, cover, exemplar });
        }
    }
    Ok(())
}
