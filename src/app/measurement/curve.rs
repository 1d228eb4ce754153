//! A mode's errors while its film grows, and what they tell: how fast they fall, and whether they stop at a bias.

use super::ErrorMetric;
use crate::measure::UnbiasedDifference;
use crate::measure::statistics::line;

/// A film at one moment, measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Samples per pixel.
    pub samples: u32,
    /// Time spent rendering, and on rectification where the mode needs it.
    pub seconds: f64,
    /// Against both halves of the ground truth, whose noise cancels.
    pub squared: UnbiasedDifference,
    /// Against their mean, whose noise does not.
    pub smape: f64,
    /// Mean FLIP, where it was asked for.
    pub flip: Option<f64>,
    /// How far relMSE can be off because pixels are few and noisy: its standard error over the pixels.
    pub relmse_standard_error: f64,
    /// Samples per pixel of each half of the ground truth.
    pub truth_samples: u32,
}

impl Point {
    pub fn error(&self, metric: ErrorMetric) -> Option<f64> {
        match metric {
            ErrorMetric::RelMse => Some(self.squared.relmse),
            ErrorMetric::RelMseTrimmed => Some(self.squared.relmse_trimmed),
            ErrorMetric::Mse => Some(self.squared.mse),
            ErrorMetric::Smape => Some(self.smape),
            ErrorMetric::Flip => self.flip,
        }
    }

    /// Whether the error is larger than what chance can make of none.
    pub fn is_resolved(&self) -> bool {
        self.squared.relmse > RESOLVED * self.relmse_standard_error
    }
}

/// All points of a mode, by rising samples.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Curve {
    pub points: Vec<Point>,
    /// Rectification's share of every point's time.
    pub rectification_seconds: f64,
}

/// What a curve tells.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Trend {
    /// The power of time by which the error falls, above the level of a bias; `None` of fewer than three points.
    pub slope: Option<f64>,
    /// The level at which the error stays because the mode is wrong; `None` where no bias shows.
    pub bias: Option<f64>,
}

/// Standard errors that an error must have to be one.
const RESOLVED: f64 = 3.0;
/// Share of the latest error that must be bias for a mode to be called biased.
const BIASED_SHARE: f64 = 0.6;
/// Least samples of the latest point, and points, before that is judged.
const LEAST_SAMPLES: u32 = 16;
const LEAST_POINTS: usize = 4;
/// A biased error has fallen by less than this factor over the last three doublings of the samples: one without bias falls by about 8, and by
/// 5 where tails are heavy.
const STAYED: f64 = 2.0;
/// Slopes are fitted where the error is this many times its final level.
const ABOVE_BIAS: f64 = 2.0;

impl Curve {
    pub fn latest(&self) -> Option<&Point> {
        self.points.last()
    }

    pub fn trend(&self, metric: ErrorMetric) -> Trend {
        let bias = self.is_biased().then(|| self.level(metric)).flatten();
        let floor = bias.map_or(0.0, |bias| bias * if metric.is_squared() { ABOVE_BIAS } else { ABOVE_BIAS.sqrt() });
        let (mut times, mut errors) = (Vec::new(), Vec::new());
        for point in self.points.iter().filter(|point| point.is_resolved()) {
            if let Some(error) = point.error(metric).filter(|error| *error > floor && point.seconds > 0.0) {
                times.push(point.seconds.ln());
                errors.push(error.ln());
            }
        }
        let slope = line(&times, &errors).filter(|line| line.points > 2).map(|line| line.slope);
        Trend { slope, bias }
    }

    /// Judged by relMSE, which is free of the ground truth's noise.
    fn is_biased(&self) -> bool {
        let Some(latest) = self.latest() else { return false };
        let Some(before) = self.points.iter().rfind(|point| point.samples <= latest.samples / 8) else { return false };
        before.squared.relmse < STAYED * latest.squared.relmse
            && self.points.len() >= LEAST_POINTS
            && latest.samples >= LEAST_SAMPLES
            && latest.is_resolved()
            && self.level(ErrorMetric::RelMse).is_some_and(|level| level > BIASED_SHARE * latest.squared.relmse)
    }

    /// Where the error goes with ever more samples: the constant of error² = bias² + variance/samples, fitted with relative weights. A
    /// low-discrepancy sequence falls faster than that, which makes the constant smaller and never larger.
    fn level(&self, metric: ErrorMetric) -> Option<f64> {
        let squared = |error: f64| if metric.is_squared() { error } else { error * error };
        let points: Vec<(f64, f64)> = (self.points.iter())
            .filter_map(|point| Some((1.0 / f64::from(point.samples), squared(point.error(metric)?))))
            .filter(|(_, y)| *y > 0.0)
            .collect();
        let [mut w, mut wx, mut wy, mut wxx, mut wxy] = [0.0; 5];
        for (x, y) in &points {
            let weight = 1.0 / (y * y);
            w += weight;
            wx += weight * x;
            wy += weight * y;
            wxx += weight * x * x;
            wxy += weight * x * y;
        }
        let determinant = w * wxx - wx * wx;
        let level = (wxx * wy - wx * wxy) / determinant;
        (points.len() > 1 && level > 0.0).then(|| if metric.is_squared() { level } else { level.sqrt() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points at doublings whose relMSE is bias + noise/samples^power.
    fn curve(bias: f64, noise: f64, power: f64) -> Curve {
        let points = (0..10).map(|i| {
            let samples = 1_u32 << i;
            let relmse = bias + noise / f64::from(samples).powf(power);
            Point {
                samples,
                seconds: 0.1 * f64::from(samples),
                squared: UnbiasedDifference { mse: relmse, relmse, relmse_trimmed: relmse },
                smape: relmse.sqrt(),
                flip: None,
                relmse_standard_error: 1e-6,
                truth_samples: 1000,
            }
        });
        Curve { points: points.collect(), rectification_seconds: 0.0 }
    }

    #[test]
    fn an_unbiased_error_has_its_slope_and_no_bias() {
        let trend = curve(0.0, 0.5, 1.0).trend(ErrorMetric::RelMse);
        assert!((trend.slope.unwrap() + 1.0).abs() < 1e-9 && trend.bias.is_none(), "{trend:?}");
        let trend = curve(0.0, 0.5, 1.0).trend(ErrorMetric::Smape);
        assert!((trend.slope.unwrap() + 0.5).abs() < 1e-9 && trend.bias.is_none(), "{trend:?}");
        // Low discrepancy and, the other way, heavy tails are no bias.
        for power in [1.5, 0.8] {
            let trend = curve(0.0, 0.5, power).trend(ErrorMetric::RelMse);
            assert!((trend.slope.unwrap() + power).abs() < 1e-9 && trend.bias.is_none(), "{trend:?}");
        }
    }

    #[test]
    fn a_bias_is_found_with_its_level_and_the_slope_above_it() {
        let trend = curve(0.03, 0.5, 1.0).trend(ErrorMetric::RelMse);
        assert!((trend.bias.unwrap() / 0.03 - 1.0).abs() < 1e-6, "{trend:?}");
        assert!(trend.slope.unwrap() < -0.6, "{trend:?}");
        let trend = curve(0.03, 0.5, 1.0).trend(ErrorMetric::Smape);
        assert!((trend.bias.unwrap() / 0.03_f64.sqrt() - 1.0).abs() < 1e-6, "{trend:?}");
        // All bias from the beginning: nothing falls, so there is no slope.
        let trend = curve(0.5, 0.01, 1.0).trend(ErrorMetric::RelMse);
        assert!(trend.bias.is_some() && trend.slope.is_none(), "{trend:?}");
    }

    #[test]
    fn nothing_is_said_of_too_little() {
        let mut few = curve(0.03, 0.5, 1.0);
        few.points.truncate(2);
        assert_eq!(few.trend(ErrorMetric::RelMse), Trend::default());
        assert_eq!(Curve::default().trend(ErrorMetric::Flip), Trend::default());
        // An error that chance can explain is no bias.
        let mut lost = curve(0.03, 0.5, 1.0);
        lost.points.iter_mut().for_each(|point| point.relmse_standard_error = 1.0);
        assert_eq!(lost.trend(ErrorMetric::RelMse), Trend::default());
    }
}
