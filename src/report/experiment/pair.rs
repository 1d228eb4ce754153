//! How much sooner the difference of two modes is known than either of their images, because both use the same random numbers.

use super::curve::images;
use super::data::{Pair, PairPoint};
use super::plan::Plan;
use super::run::Run;
use super::spread::Spread;
use super::sums::Image;
use super::technique::Technique;
use super::truth::{TruePixel, Truth};
use crate::measure::statistics::jackknife;
use crate::tracking::Mode;

/// `mode` against `rectified`, whose runs have the same seeds in the same order.
pub fn pair(mode: Mode, technique: Technique, runs: &[Run], rectified: &[Run], plan: &Plan, truth: &Truth) -> Pair {
    let levels: Vec<_> =
        (0..plan.spp.len()).map(|level| variances(truth, &images(runs, level), &images(rectified, level))).collect();
    let point = |(&spp, (all, _)): (&u32, &(Variances, Vec<Variances>))| {
        let [of_mode, of_against, of_difference] = *all;
        PairPoint { spp, of_mode, of_against, of_difference }
    };
    // On the logarithm, where ratios scatter evenly. `None` where one is not finite: of a difference without variance.
    let sooner = |than: fn(f64, f64) -> f64| {
        let (all, without_one) = levels.last()?;
        let ratio = |[a, b, difference]: &Variances| Some((than(*a, *b) / difference).ln()).filter(|x| x.is_finite());
        let left_out = without_one.iter().map(ratio).collect::<Option<Vec<f64>>>()?;
        Some(jackknife(ratio(all)?, &left_out)?.map(f64::exp))
    };
    Pair {
        mode,
        against: Mode::Rectified,
        technique,
        points: plan.spp.iter().zip(&levels).map(point).collect(),
        sooner_than_mode: sooner(|mode, _| mode),
        sooner_than_against: sooner(|_, against| against),
        sooner_than_unpaired: sooner(|mode, against| mode + against),
    }
}

/// Relative variances of one run of two modes and of their difference.
type Variances = [f64; 3];

/// Over the seeds: of all, and of all but one for each.
fn variances(truth: &Truth, mode: &[&Image], against: &[&Image]) -> (Variances, Vec<Variances>) {
    let minus = |(a, b): (&[f32; 3], &[f32; 3])| std::array::from_fn(|c| a[c] - b[c]);
    let apart: Vec<Image> = mode.iter().zip(against).map(|(a, b)| a.iter().zip(*b).map(minus).collect()).collect();
    // Taken about 0, where images are equal the variance of their difference is exactly 0.
    let about_zero = |pixel: &TruePixel| TruePixel { mean: [0.0; 3], half_gap: [0.0; 3], ..*pixel };
    let about_zero: Vec<TruePixel> = truth.pixels.iter().map(about_zero).collect();
    let apart: Vec<&Image> = apart.iter().collect();
    let three = [(&truth.pixels, mode), (&truth.pixels, against), (&about_zero, &apart)];
    let spreads = three.map(|(truth, images)| Spread::new(truth, images));
    let without_one = spreads.each_ref().map(Spread::parts_without_one);
    let without = |run: usize| without_one.each_ref().map(|parts| parts[run].variance);
    (spreads.map(|spread| spread.parts().variance), (0..mode.len()).map(without).collect())
}

#[cfg(test)]
mod tests {
    use super::super::truth::tests::{SIZE, image, noise, references};
    use super::*;

    /// A mode that adds a tenth of fresh noise to what it shares with the other: its difference has 1 % of the variance.
    #[test]
    fn what_pairs_share_drops_out() {
        let shared: Vec<Image> = (0..5).map(|seed| image(|pixel, c| 0.5 * noise(seed, pixel, c))).collect();
        let mode: Vec<Image> = (0..5)
            .map(|seed| image(|pixel, c| 0.5 * noise(seed, pixel, c) + 0.05 * noise(900 + seed, pixel, c)))
            .collect();
        let unrelated: Vec<Image> = (0..5).map(|seed| image(|pixel, c| 0.5 * noise(700 + seed, pixel, c))).collect();
        let truth = Truth::new(references(0.0), SIZE).unwrap();
        let of =
            |mode: &[Image]| variances(&truth, &mode.iter().collect::<Vec<_>>(), &shared.iter().collect::<Vec<_>>());
        let ([of_mode, of_against, of_difference], without_one) = of(&mode);
        assert!((of_against / of_difference / 100.0 - 1.0).abs() < 0.05, "{of_against} {of_difference}");
        assert!((of_mode / of_difference / 101.0 - 1.0).abs() < 0.05, "{of_mode} {of_difference}");
        assert_eq!(without_one.len(), 5);
        assert!(without_one.iter().all(|one| (one[0] / of_mode - 1.0).abs() < 0.1), "{without_one:?}");
        // The twin: modes that share nothing have a difference that is noisier than either.
        let [_, of_against, of_difference] = of(&unrelated).0;
        assert!((of_difference / of_against / 2.0 - 1.0).abs() < 0.05, "{of_against} {of_difference}");
    }
}
