use super::ExtractionError;
use super::Mark;
use super::Photo;
use super::colour;
use super::machine::Machine;
use super::machine::Sample;
use crate::compute::run::Run;
use rayon::prelude::*;

/// Decision values are cut to ±1 and stored in this many steps.
const SCORE_SCALE: f64 = 100.0;

/// The support vector machine on colour.
#[derive(Debug, Clone, PartialEq)]
pub struct ClassifierOptions {
    /// The most pixels learnt from, half of each kind, spread evenly over all that are marked.
    /// The solver keeps the square of it in memory. Default: 2,000.
    pub max_samples: usize,
    /// Price of a sample on the wrong side. Default: 10 (ours: noise at the rims of scribbles is
    /// to be overruled, whole scribbles are not).
    pub c: f64,
    /// The least share of samples that must be told apart. Default: 0.7 (ours); below it the
    /// scribbles contradict each other.
    pub least_accuracy: f64,
}

impl Default for ClassifierOptions {
    fn default() -> Self {
        Self { max_samples: 2000, c: 10.0, least_accuracy: 0.7 }
    }
}

/// A trained support vector machine with a Gaussian kernel on standardised L\*a\*b\*.
pub(super) struct Classifier {
    machine: Machine,
    standard: Standard,
    /// Share of the training samples that are given back as they were marked.
    pub training_accuracy: f64,
}

/// What makes each part of the colour vary by 1 over the samples.
struct Standard {
    mean: [f64; 3],
    deviation: [f64; 3],
}

/// Learns animal from ground.
pub(super) fn train(
    photo: &Photo,
    marks: &[Mark],
    options: &ClassifierOptions,
    run: &Run,
) -> Result<Classifier, ExtractionError> {
    let half = (options.max_samples / 2).max(1);
    let (animals, ground) = (samples(photo, marks, Mark::Animal, half), samples(photo, marks, Mark::Ground, half));
    let count = animals.len() + ground.len();
    // Sides of unequal number weigh the same.
    let price = |n: usize| options.c * count as f64 / (2.0 * n as f64);
    let standard = Standard::of(&[animals.as_slice(), &ground].concat());
    let marked = |colours: Vec<[f64; 3]>, side: f64| {
        let (standard, price) = (&standard, price(colours.len()));
        colours.into_iter().map(move |c| Sample { feature: standard.apply(c), side, price })
    };
    let samples: Vec<Sample> = marked(animals, 1.0).chain(marked(ground, -1.0)).collect();
    let machine = Machine::train(&samples, run)?;
    let right = samples.iter().filter(|s| (machine.decide(s.feature) >= 0.0) == (s.side > 0.0)).count();
    let training_accuracy = right as f64 / count as f64;
    if training_accuracy < options.least_accuracy {
        return Err(ExtractionError::SameColours { percent: 100.0 * training_accuracy });
    }
    Ok(Classifier { machine, standard, training_accuracy })
}

/// Up to `most` colours under `mark`, evenly spread over all its pixels.
fn samples(photo: &Photo, marks: &[Mark], mark: Mark, most: usize) -> Vec<[f64; 3]> {
    let pixels: Vec<usize> = (0..marks.len()).filter(|&i| marks[i] == mark).collect();
    let count = pixels.len().min(most);
    (0..count)
        .map(|k| colour::lab(photo.pixel(pixels[(2 * k + 1) * pixels.len() / (2 * count)]).map(f64::from)))
        .collect()
}

impl Classifier {
    /// The decision value of every pixel, cut to ±1 and in steps of 1/100: positive for animals.
    /// Evaluated once per colour that occurs, the rest is looking up.
    pub(super) fn scores(&self, photo: &Photo, run: &Run) -> Result<Vec<i8>, ExtractionError> {
        let mut occurs = vec![false; colour::COLOURS];
        photo.rgb().chunks_exact(3).for_each(|p| occurs[colour::quantise([p[0], p[1], p[2]])] = true);
        run.check()?;
        let table: Vec<i8> =
            occurs.par_iter().enumerate().map(|(i, &occurs)| if occurs { self.score(i) } else { 0 }).collect();
        run.check()?;
        Ok(photo.rgb().par_chunks_exact(3).map(|p| table[colour::quantise([p[0], p[1], p[2]])]).collect())
    }

    fn score(&self, colour: usize) -> i8 {
        let feature = self.standard.apply(colour::lab(colour::representative(colour)));
        (self.machine.decide(feature).clamp(-1.0, 1.0) * SCORE_SCALE) as i8
    }
}

impl Standard {
    fn of(colours: &[[f64; 3]]) -> Self {
        let n = colours.len() as f64;
        let mean = [0, 1, 2].map(|i| colours.iter().map(|c| c[i]).sum::<f64>() / n);
        // A part that does not vary (grey pictures) is left as it is: one unit of L*a*b*.
        let deviation =
            [0, 1, 2].map(|i| (colours.iter().map(|c| (c[i] - mean[i]).powi(2)).sum::<f64>() / n).sqrt().max(1.0));
        Self { mean, deviation }
    }

    fn apply(&self, colour: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| (colour[i] - self.mean[i]) / self.deviation[i])
    }
}
