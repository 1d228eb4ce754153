//! Figures of numbers: means, medians and slopes, with intervals from Student's t.
//!
//! All intervals are two-sided and hold with [`CONFIDENCE`]. They speak of the numbers given: where those are runs with seeds of
//! their own, of what other seeds would have given. Nothing here draws random numbers.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Probability with which an interval holds the true value.
pub const CONFIDENCE: f64 = 0.95;

/// An estimate and the bounds it lies between.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    pub value: f64,
    pub low: f64,
    pub high: f64,
}

impl Interval {
    /// `value` ± `half_width`.
    pub fn around(value: f64, half_width: f64) -> Self {
        Self { value, low: value - half_width, high: value + half_width }
    }

    pub fn contains(&self, x: f64) -> bool {
        self.low <= x && x <= self.high
    }

    /// Applies an increasing function to the estimate and both bounds.
    pub fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self { value: f(self.value), low: f(self.low), high: f(self.high) }
    }
}

/// A line y = intercept + slope · x fitted by ordinary least squares.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Line {
    pub slope: f64,
    pub intercept: f64,
    /// Of the slope, if the points scatter about the line independently and alike; 0 for two points.
    pub slope_standard_error: f64,
    pub points: usize,
}

/// y = factor · x^exponent, fitted as a line on log–log.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PowerLaw {
    /// Its interval supposes points that scatter independently. [`slope_over_runs`] is for points that do not.
    pub exponent: Interval,
    pub factor: f64,
}

/// The value that |t| stays below with probability `confidence`, for Student's t with `degrees` ≥ 1 degrees of freedom.
pub fn t_quantile(confidence: f64, degrees: usize) -> f64 {
    // A mean of 0, a scale of 1 and at least one degree are always accepted.
    StudentsT::new(0.0, 1.0, degrees.max(1) as f64).map_or(f64::NAN, |t| t.inverse_cdf(0.5 + confidence / 2.0))
}

/// Arithmetic mean; `None` of nothing.
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Unbiased sample variance; `None` of fewer than two.
pub fn variance(values: &[f64]) -> Option<f64> {
    let center = mean(values).filter(|_| values.len() > 1)?;
    Some(values.iter().map(|x| (x - center).powi(2)).sum::<f64>() / (values.len() - 1) as f64)
}

/// The middle value, between two of them their mean; `None` of nothing. NaN sorts last.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    let upper = *sorted.get(middle)?;
    Some(if sorted.len().is_multiple_of(2) { (sorted[middle - 1] + upper) / 2.0 } else { upper })
}

/// The mean of independent `values` with its t-interval; `None` of fewer than two.
pub fn mean_interval(values: &[f64]) -> Option<Interval> {
    let standard_error = (variance(values)? / values.len() as f64).sqrt();
    Some(Interval::around(mean(values)?, t_quantile(CONFIDENCE, values.len() - 1) * standard_error))
}

/// The geometric mean with a t-interval on the logarithm. `None` of fewer than two, or where a value is not positive.
pub fn geometric_mean(values: &[f64]) -> Option<Interval> {
    Some(mean_interval(&logarithms(values)?)?.map(f64::exp))
}

/// What leave-one-out tells about an estimate from n ≥ 2 runs: `whole` of all, `left_out[i]` of all but run i (Efron and Stein 1981). The
/// interval lies about `whole`.
pub fn jackknife(whole: f64, left_out: &[f64]) -> Option<Interval> {
    let count = left_out.len() as f64;
    // The estimates without one run lie n − 1 times closer together than runs do.
    let variance_of_whole = variance(left_out)? * (count - 1.0).powi(2) / count;
    Some(Interval::around(whole, t_quantile(CONFIDENCE, left_out.len() - 1) * variance_of_whole.sqrt()))
}

/// Least squares through (x, y). `None` of fewer than two different x.
pub fn line(x: &[f64], y: &[f64]) -> Option<Line> {
    let points = x.len().min(y.len());
    let (x, y) = (&x[..points], &y[..points]);
    let (center_x, center_y) = (mean(x)?, mean(y)?);
    let xx: f64 = x.iter().map(|x| (x - center_x).powi(2)).sum();
    if xx == 0.0 {
        return None;
    }
    let slope = x.iter().zip(y).map(|(x, y)| (x - center_x) * (y - center_y)).sum::<f64>() / xx;
    let intercept = center_y - slope * center_x;
    let squares: f64 = x.iter().zip(y).map(|(x, y)| (y - intercept - slope * x).powi(2)).sum();
    let slope_standard_error = if points > 2 { (squares / (points - 2) as f64 / xx).sqrt() } else { 0.0 };
    Some(Line { slope, intercept, slope_standard_error, points })
}

/// A power law through positive (x, y), each y measured for itself. `None` of fewer than three points, two different x, or where a number is
/// not positive.
pub fn power_law(x: &[f64], y: &[f64]) -> Option<PowerLaw> {
    let line = line(&logarithms(x)?, &logarithms(y)?).filter(|line| line.points > 2)?;
    let half_width = t_quantile(CONFIDENCE, line.points - 2) * line.slope_standard_error;
    Some(PowerLaw { exponent: Interval::around(line.slope, half_width), factor: line.intercept.exp() })
}

/// The exponent of a power law that independent runs follow, each given as its x and y. `None` of fewer than two runs, where a run has fewer
/// than two different x, or where a number is not positive.
///
/// Each run is fitted for itself and the interval is that of the mean of the slopes. A run that goes on from x to the next carries its
/// errors along, so its points do not scatter independently, and the standard error of one regression through them would be too
/// small; runs with seeds of their own are independent whatever happens within each.
pub fn slope_over_runs(runs: &[(Vec<f64>, Vec<f64>)]) -> Option<Interval> {
    let slope = |(x, y): &(Vec<f64>, Vec<f64>)| Some(line(&logarithms(x)?, &logarithms(y)?)?.slope);
    mean_interval(&runs.iter().map(slope).collect::<Option<Vec<f64>>>()?)
}

/// `None` where one does not exist.
fn logarithms(values: &[f64]) -> Option<Vec<f64>> {
    values.iter().map(|&x| (x > 0.0 && x.is_finite()).then(|| x.ln())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn close(a: f64, b: f64, relative: f64) {
        assert!((a - b).abs() <= relative * b.abs(), "{a} is not {b}");
    }

    /// NIST/SEMATECH e-Handbook of Statistical Methods, 1.3.6.7.2, and further digits from R's `qt`.
    #[test]
    fn quantiles_are_those_of_the_tables() {
        for (degrees, expected) in [(1, 12.706_204_736), (3, 3.182_446_305), (4, 2.776_445_105), (15, 2.131_449_546)] {
            close(t_quantile(0.95, degrees), expected, 1e-8);
        }
        close(t_quantile(0.99, 9), 3.249_835_542, 1e-8);
        assert!((t_quantile(0.95, 2) - t_quantile(0.95, 3)).abs() > 1.0, "degrees do not matter");
    }

    /// Student's sleep data (Biometrika 1908), as in R's `t.test(extra ~ group, data = sleep, paired = TRUE)`: 1.58 in 0.7001142 to
    /// 2.4598858.
    #[test]
    fn interval_of_a_mean() {
        let gains = [1.2, 2.4, 1.3, 1.3, 0.0, 1.0, 1.8, 0.8, 4.6, 1.4];
        let interval = mean_interval(&gains).unwrap();
        close(interval.value, 1.58, 1e-12);
        close(interval.low, 0.700_114_2, 1e-7);
        close(interval.high, 2.459_885_8, 1e-7);
        assert!(interval.contains(1.0) && !interval.contains(0.0));

        let exponentials: Vec<f64> = gains.iter().map(|x: &f64| x.exp()).collect();
        let geometric = geometric_mean(&exponentials).unwrap();
        close(geometric.low.ln(), 0.700_114_2, 1e-7);
        close(geometric.value.ln(), 1.58, 1e-12);

        assert_eq!(mean_interval(&[1.0]), None);
        assert_eq!(geometric_mean(&[1.0, -1.0, 2.0]), None);
    }

    /// For the mean, leaving one out gives the t-interval itself.
    #[test]
    fn jackknife_of_a_mean_is_its_interval() {
        let values = [1.2, 2.4, 1.3, 1.3, 0.0, 1.0, 1.8, 0.8, 4.6, 1.4];
        let sum: f64 = values.iter().sum();
        let left_out: Vec<f64> = values.iter().map(|x| (sum - x) / 9.0).collect();
        let (a, b) = (jackknife(sum / 10.0, &left_out).unwrap(), mean_interval(&values).unwrap());
        close(a.low, b.low, 1e-9);
        close(a.high, b.high, 1e-9);
    }

    #[test]
    fn medians() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), Some(2.5));
        assert_eq!(median(&[]), None);
    }

    /// The Norris data of NIST's Statistical Reference Datasets, whose certified values have 15 digits.
    #[test]
    fn line_through_certified_data() {
        #[rustfmt::skip]
        let data = [
            (0.2, 0.1), (337.4, 338.8), (118.2, 118.1), (884.6, 888.0), (10.1, 9.2), (226.5, 228.1), (666.3, 668.5),
            (996.3, 998.5), (448.6, 449.1), (777.0, 778.9), (558.2, 559.2), (0.4, 0.3), (0.6, 0.1), (775.5, 778.1),
            (666.9, 668.8), (338.0, 339.3), (447.5, 448.9), (11.6, 10.8), (556.0, 557.7), (228.1, 228.3), (995.8, 998.0),
            (887.6, 888.8), (120.2, 119.6), (0.3, 0.3), (0.3, 0.6), (556.8, 557.6), (339.1, 339.3), (887.2, 888.0),
            (999.0, 998.5), (779.0, 778.9), (11.1, 10.2), (118.3, 117.6), (229.2, 228.9), (669.1, 668.4),
            (448.9, 449.2), (0.5, 0.2),
        ];
        let (x, y): (Vec<f64>, Vec<f64>) = data.into_iter().unzip();
        let line = line(&x, &y).unwrap();
        close(line.slope, 1.002_116_818_020_45, 1e-12);
        close(line.intercept, -0.262_323_073_774_029, 1e-9);
        close(line.slope_standard_error, 0.429_796_848_199_937e-3, 1e-9);
        assert_eq!(line.points, 36);
    }

    #[test]
    fn power_laws() {
        let x = [1.0, 2.0, 4.0, 8.0];
        let law = power_law(&x, &x.map(|x: f64| 3.0 * x.powf(-0.5))).unwrap();
        close(law.exponent.value, -0.5, 1e-12);
        close(law.factor, 3.0, 1e-12);
        assert!(law.exponent.high - law.exponent.low < 1e-9);
        assert_eq!(power_law(&x[..2], &x[..2]), None);
        assert_eq!(power_law(&[2.0; 4], &x), None);
        assert_eq!(power_law(&x, &[1.0, 0.0, 1.0, 1.0]), None);
    }

    /// Two runs of slopes −1 ± d: their mean is −1, and the interval t(1) · d wide to either side.
    #[test]
    fn slopes_of_runs() {
        let x = [4.0, 8.0, 16.0];
        let run = |slope: f64| (x.to_vec(), x.iter().map(|x: &f64| x.powf(slope)).collect::<Vec<_>>());
        let interval = slope_over_runs(&[run(-1.1), run(-0.9)]).unwrap();
        close(interval.value, -1.0, 1e-12);
        close(interval.high + 1.0, 12.706_204_736 * 0.1, 1e-6);
        // The planted error: runs that agree on another slope are not taken for −1.
        assert!(!slope_over_runs(&[run(-0.52), run(-0.5), run(-0.51)]).unwrap().contains(-1.0));
        assert_eq!(slope_over_runs(&[run(-1.0)]), None);
        assert_eq!(slope_over_runs(&[run(-1.0), (x.to_vec(), vec![1.0, 0.0, 0.5])]), None);
    }
}
