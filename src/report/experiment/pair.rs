//! How much sooner the difference of two modes is known than either of their images, because both use the same random numbers.

use super::curve::images;
use super::data::{Pair, PairPoint};
use super::plan::Plan;
use super::run::Run;
use super::spread::{PairedVariances, paired_variances};
use super::technique::Technique;
use super::truth::Truth;
use crate::measure::Interval;
use crate::measure::statistics::jackknife;
use crate::tracking::Mode;

/// `mode` against `rectified`, whose runs have the same seeds in the same order.
pub fn pair(mode: Mode, technique: Technique, runs: &[Run], rectified: &[Run], plan: &Plan, truth: &Truth) -> Pair {
    let mut points = Vec::with_capacity(plan.spp.len());
    let mut last = None;
    for (level, &spp) in plan.spp.iter().enumerate() {
        let variances = paired_variances(truth, &images(runs, level), &images(rectified, level));
        let PairedVariances { of_mode, of_against, of_difference } = variances.0;
        points.push(PairPoint { spp, of_mode, of_against, of_difference });
        last = Some(variances);
    }
    let sooner = |than: fn(&PairedVariances) -> f64| {
        let (all, without_one) = last.as_ref()?;
        ratio(all, without_one, |variances| than(variances) / variances.of_difference)
    };
    Pair {
        mode,
        against: Mode::Rectified,
        technique,
        points,
        sooner_than_mode: sooner(|variances| variances.of_mode),
        sooner_than_against: sooner(|variances| variances.of_against),
        sooner_than_unpaired: sooner(|variances| variances.of_mode + variances.of_against),
    }
}

/// On the logarithm, where ratios scatter evenly. `None` where one is not finite: of a difference without variance.
fn ratio(
    all: &PairedVariances,
    without_one: &[PairedVariances],
    of: impl Fn(&PairedVariances) -> f64,
) -> Option<Interval> {
    let logarithm = |variances: &PairedVariances| Some(of(variances).ln()).filter(|x| x.is_finite());
    let left_out = without_one.iter().map(logarithm).collect::<Option<Vec<f64>>>()?;
    Some(jackknife(logarithm(all)?, &left_out)?.map(f64::exp))
}
