//! From runs to a curve: intervals over seeds, slope, bias and plateau.

use super::data::{Bias, Curve, Plateau, Point, RunPoint, Slope};
use super::plan::Plan;
use super::run::{Level, Run};
use super::spread::{Parts, Spread};
use super::sums::Image;
use super::technique::Technique;
use super::truth::{Relative, Truth, worst};
use crate::measure::Interval;
use crate::measure::MetricError;
use crate::measure::statistics::{geometric_mean, jackknife, mean, median, slope_over_runs};
use crate::tracking::Events;
use crate::tracking::Mode;
use crate::transport::sampler::Sequence;

/// A slope is fitted to no fewer points.
const LEAST_POINTS: usize = 3;
/// Variance over squared bias from which on a biased mode's error falls like an unbiased one's, to a tenth.
const ABOVE_PLATEAU: f64 = 10.0;

/// What a curve is of.
#[derive(Clone, Copy)]
pub struct Subject {
    pub mode: Mode,
    pub technique: Technique,
    pub equal_to: Option<Mode>,
    pub secs_before: f64,
}

/// The curve of `runs`, three or more, each with every sample count of the plan.
///
/// # Errors
/// When an image does not fit the references or holds a component that is not finite.
pub fn curve(subject: &Subject, runs: &[Run], plan: &Plan, truth: &Truth) -> Result<Curve, MetricError> {
    let last = images(runs, plan.spp.len() - 1);
    let left_out: Vec<Vec<usize>> = runs.iter().map(|run| unsteady(run, truth)).collect();
    let mut points = Vec::with_capacity(plan.spp.len());
    for (level, &spp) in plan.spp.iter().enumerate() {
        let images = images(runs, level);
        let spread = Spread::new(truth, &images);
        points.push(point(subject, spp, level, runs, &left_out, truth, spread.parts())?);
    }
    let bias = Spread::new(truth, &last).bias();
    let mut events = Events::default();
    runs.iter().for_each(|run| events += run.events);
    let plateau = bias.is_biased.then(|| plateau(subject, &points, &bias, runs, plan, truth)).flatten();
    Ok(Curve {
        mode: subject.mode,
        technique: subject.technique,
        equal_to: subject.equal_to,
        secs_before: subject.secs_before,
        slope: slope(&points, &bias, truth.noise()),
        points,
        bias,
        plateau,
        events,
    })
}

/// The 0.1 % of a run's pixels whose quarters scatter the most: bright rare paths have struck there. The order of a run's samples does not
/// matter, so none of its sample counts is favoured; and where noise is Gaussian, how much quarters scatter about their mean says nothing
/// about the mean. The pixels that merely are the worst in the end would have taken most from the last error.
fn unsteady(run: &Run, truth: &Truth) -> Vec<usize> {
    let Some((whole, quarters)) = run.quarters() else { return Vec::new() };
    let mut scatter = vec![Relative::default(); whole.len()];
    for quarter in &quarters {
        for (((scatter, x), mean), truth) in scatter.iter_mut().zip(quarter).zip(whole).zip(&truth.pixels) {
            scatter.badness += (0..3).map(|c| f64::from(x[c] - mean[c]).powi(2) * truth.weight[c]).sum::<f64>();
        }
    }
    worst(&scatter)
}

/// The images of all runs at one sample count.
pub fn images(runs: &[Run], level: usize) -> Vec<&Image> {
    runs.iter().map(|run| &run.levels[level].image).collect()
}

fn point(
    subject: &Subject,
    spp: u32,
    level: usize,
    runs: &[Run],
    left_out: &[Vec<usize>],
    truth: &Truth,
    parts: Parts,
) -> Result<Point, MetricError> {
    let runs = (runs.iter())
        .zip(left_out)
        .map(|(run, left_out)| {
            let Level { render_secs, image } = &run.levels[level];
            truth.errors(image, left_out, run.seed, *render_secs)
        })
        .collect::<Result<Vec<RunPoint>, _>>()?;
    let over_runs = |figure: &dyn Fn(&RunPoint) -> f64| geometric_mean(&runs.iter().map(figure).collect::<Vec<f64>>());
    let secs = over_runs(&|run| run.render_secs + subject.secs_before);
    Ok(Point {
        spp,
        secs: secs.map_or(subject.secs_before, |secs| secs.value),
        relmse: over_runs(&|run| run.relmse),
        relmse_trimmed: over_runs(&|run| run.relmse_trimmed),
        mse: over_runs(&|run| run.mse),
        smape: over_runs(&|run| run.smape),
        flip: over_runs(&|run| run.flip.unwrap_or_default()),
        variance: parts.variance,
        bias_squared: parts.bias_squared,
        efficiency: over_runs(&|run| 1.0 / (run.relmse * run.render_secs)),
        runs,
    })
}

/// Of the points where the error falls as it should: above the noise of the references and, of a biased mode, above its plateau.
fn slope(points: &[Point], bias: &Bias, reference_noise: f64) -> Option<Slope> {
    let is_falling = |point: &&Point| {
        let is_above_plateau = !bias.is_biased || point.variance > ABOVE_PLATEAU * bias.squared.value;
        point.variance > reference_noise && is_above_plateau
    };
    let fitted: Vec<&Point> = points.iter().take_while(is_falling).collect();
    if fitted.len() < LEAST_POINTS {
        return None;
    }
    let fit = |x: &dyn Fn(&Point, &RunPoint) -> f64, y: &dyn Fn(&RunPoint) -> f64| {
        let run = |run: usize| {
            fitted.iter().map(|point| (x(point, &point.runs[run]), y(&point.runs[run]))).unzip::<_, _, Vec<_>, Vec<_>>()
        };
        slope_over_runs(&(0..fitted[0].runs.len()).map(run).collect::<Vec<_>>())
    };
    let spp = |point: &Point, _: &RunPoint| f64::from(point.spp);
    Some(Slope {
        trimmed: fit(&spp, &|run| run.relmse_steady)?,
        trimmed_anew: fit(&spp, &|run| run.relmse_trimmed),
        untrimmed: fit(&spp, &|run| run.relmse),
        by_secs: fit(&|_, run| run.render_secs, &|run| run.relmse_steady),
        from_spp: fitted[0].spp,
        to_spp: fitted[fitted.len() - 1].spp,
    })
}

fn plateau(
    subject: &Subject,
    points: &[Point],
    bias: &Bias,
    runs: &[Run],
    plan: &Plan,
    truth: &Truth,
) -> Option<Plateau> {
    let last = points.last()?;
    let of_one_sample = points.iter().map(|point| point.variance * f64::from(point.spp)).collect::<Vec<_>>();
    let spp = median(&of_one_sample)? / bias.squared.value;
    let render_secs = mean(&last.runs.iter().map(|run| run.render_secs).collect::<Vec<_>>())?;
    Some(Plateau {
        relmse: bias.squared,
        relmse_trimmed: bias.squared_trimmed,
        spp,
        secs: subject.secs_before + render_secs * spp / f64::from(last.spp),
        measured_over_predicted: measured_over_predicted(subject, runs, plan, truth),
    })
}

/// The error at the last sample count, over what bias and variance at a quarter of the samples predict of it: the bias is to stay, the
/// variance to fall to a quarter, as it does of independent samples. The references' noise is much the same in both and cancels.
fn measured_over_predicted(subject: &Subject, runs: &[Run], plan: &Plan, truth: &Truth) -> Option<Interval> {
    if subject.technique.sampler != Sequence::Independent || subject.technique.adaptive {
        return None;
    }
    let high = plan.spp.len().checked_sub(1)?;
    let low = high.checked_sub(2)?;
    let (high_images, low_images) = (images(runs, high), images(runs, low));
    let (of_high, of_low) = (Spread::new(truth, &high_images), Spread::new(truth, &low_images));
    let falls = f64::from(plan.spp[low]) / f64::from(plan.spp[high]);
    let ratio =
        |high: Parts, low: Parts| (high.bias_squared + high.variance) / (low.bias_squared + low.variance * falls);
    let without_one = of_high.parts_without_one().into_iter().zip(of_low.parts_without_one());
    let left_out: Vec<f64> = without_one.map(|(high, low)| ratio(high, low)).collect();
    jackknife(ratio(of_high.parts(), of_low.parts()), &left_out)
}

#[cfg(test)]
mod tests {
    use super::super::truth::tests::{SIZE, image, references};
    use super::*;
    use crate::transport::sampler::Sampler;

    const SPP: u32 = 64;

    fn plan(seeds: u64) -> Plan {
        let spp = (0..=SPP.ilog2()).map(|doubling| 1 << doubling).collect();
        Plan { size: SIZE, seeds: (0..seeds).collect(), max_depth: None, spp, reference_spp: 1 }
    }

    /// A run as a renderer would make it: each sample is the truth and `bias`, plus noise with mean 0 that is even but for one sample in
    /// five hundred, a firefly.
    fn run(seed: u64, bias: f64) -> Run {
        let sample = |pixel: usize, c: usize, sample: u32| {
            let [u, v] = Sampler::of(Sequence::Independent, seed, pixel as u32, sample).get_2d(c as u32);
            u - 0.5 + if v < 0.002 { 9.98 } else { -0.02 } + bias
        };
        let mean = |count: u32| {
            image(|pixel, c| (0..count).map(|index| sample(pixel, c, index)).sum::<f64>() / f64::from(count))
        };
        let level = |&spp: &u32| Level { render_secs: 0.1 * f64::from(spp), image: mean(spp) };
        let levels = plan(1).spp.iter().map(level).collect();
        Run { seed, levels, at_three_quarters: mean(SPP / 4 * 3), events: Events::default() }
    }

    fn curve_of(seeds: u64, bias: f64) -> Curve {
        let subject =
            Subject { mode: Mode::Rectified, technique: Technique::independent(), equal_to: None, secs_before: 0.5 };
        let runs: Vec<Run> = (0..seeds).map(|seed| run(seed, bias)).collect();
        let truth = Truth::new(&references(0.02), SIZE).unwrap();
        curve(&subject, &runs, &plan(seeds), &truth).unwrap()
    }

    /// Fireflies bend the line of an error whose worst pixels are left out anew each time; of the same pixels it is straight.
    #[test]
    fn an_unbiased_run_falls_with_its_samples() {
        let curve = curve_of(16, 0.0);
        let slope = curve.slope.unwrap();
        assert!(slope.trimmed.contains(-1.0), "{slope:?}");
        assert!(slope.trimmed.high - slope.trimmed.low < 0.08, "{slope:?}");
        assert!(!slope.trimmed_anew.unwrap().contains(-1.0), "{slope:?}");
        assert!(slope.by_secs.unwrap().contains(-1.0), "{slope:?}");
        assert_eq!((slope.from_spp, slope.to_spp), (1, SPP));
        assert!(!curve.bias.is_biased && curve.plateau.is_none(), "{:?}", curve.bias);
        // Rectification is in the time and not in the efficiency.
        let last = curve.points.last().unwrap();
        assert!((last.secs - 6.9).abs() < 1e-9, "{}", last.secs);
        assert!((last.efficiency.unwrap().value * last.relmse.unwrap().value * 6.4 - 1.0).abs() < 1e-9);
    }

    /// Off by 0.3 everywhere: the error stays at 0.09 weighted as in relMSE, and noise, of variance 1/12 + 0.2 a sample, is as large after 3.
    #[test]
    fn a_biased_run_stays_at_its_bias() {
        let curve = curve_of(6, 0.3);
        let truth = Truth::new(&references(0.0), SIZE).unwrap();
        let weight = truth.pixels.iter().flat_map(|pixel| pixel.weight).sum::<f64>() / truth.components();
        let plateau = curve.plateau.unwrap();
        assert!(plateau.relmse.contains(0.09 * weight), "{plateau:?} {}", 0.09 * weight);
        assert!((plateau.relmse_trimmed / plateau.relmse.value - 1.0).abs() < 0.05, "{plateau:?}");
        let noise = 1.0 / 12.0 + 0.002 * 0.998 * 100.0;
        assert!((plateau.spp / (noise / 0.09) - 1.0).abs() < 0.15, "{plateau:?}");
        assert!((plateau.secs - (0.5 + 0.1 * plateau.spp)).abs() < 1e-6, "{plateau:?}");
        assert!(plateau.measured_over_predicted.unwrap().contains(1.0), "{plateau:?}");
        // No sample count is so far above the plateau that a line could be told from a bend.
        assert_eq!(curve.slope, None);
        assert!((curve.bias.brightness - 0.3).abs() < 0.03, "{:?}", curve.bias);
    }
}
