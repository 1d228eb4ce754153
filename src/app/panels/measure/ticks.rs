//! Which values of a logarithmic axis get a number: two at least, and no more than there is room for.

use crate::app::measurement::ErrorAxis;
use crate::app::widgets::{short_count, short_seconds};

/// Values to number, coarsest first: every so many powers of ten, then more and more within each.
const STRIDES: [i32; 6] = [50, 20, 10, 5, 2, 1];
const FACTORS: [&[f64]; 2] = [&[1.0, 3.0], &[1.0, 2.0, 5.0]];

/// The decimal logarithms of the values to number on an axis from `low` to `high` (decimal logarithms, a decade apart at least): as many
/// as possible up to `most`, two at least.
pub fn numbered(low: f64, high: f64, most: usize) -> Vec<f64> {
    let (first, last) = (low.floor() as i32, high.ceil() as i32);
    let within = |value: &f64| (low..=high).contains(value);
    let strided = STRIDES.into_iter().map(|stride| {
        let start = first.div_euclid(stride) * stride;
        (start..=last).step_by(stride.unsigned_abs() as usize).map(f64::from).filter(within).collect::<Vec<f64>>()
    });
    let finer = FACTORS.into_iter().map(|factors| {
        let values = (first..=last).flat_map(|decade| factors.iter().map(move |f| f64::from(decade) + f.log10()));
        values.filter(within).collect()
    });
    let mut best = Vec::new();
    for candidate in strided.chain(finer) {
        if candidate.len() >= 2 && (best.is_empty() || candidate.len() <= most) {
            best = candidate;
        }
    }
    best
}

/// What stands at `value` on the axis to the right.
pub fn text(axis: ErrorAxis, value: f64) -> String {
    match axis {
        ErrorAxis::Time if value < 1e-6 => format!("{value:.0e} s"),
        ErrorAxis::Time => short_seconds(value),
        ErrorAxis::Samples if value < 1.0 => format!("{value:.0e}"),
        ErrorAxis::Samples if value < 9999.5 => format!("{value:.0}"),
        ErrorAxis::Samples => short_count(value).replace(".0 ", " "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_axis_has_two_different_numbers_at_least_and_not_too_many() {
        for low in -60..=60 {
            let low = f64::from(low) * 0.17;
            for span in [1.0, 1.03, 1.2, 1.5, 1.9, 2.0, 2.6, 4.0, 7.5, 15.0, 40.0] {
                for most in [2, 3, 4, 6, 9] {
                    let values = numbered(low, low + span, most);
                    assert!(values.len() >= 2, "{low} + {span}: {values:?}");
                    assert!(values.len() <= most.max(4), "{low} + {span}, at most {most}: {values:?}");
                    assert!(values.windows(2).all(|pair| pair[0] < pair[1]));
                    assert!(values.iter().all(|value| (low..=low + span).contains(value)));
                }
            }
        }
    }

    #[test]
    fn numbers_at_an_axis_are_told_apart() {
        for axis in [ErrorAxis::Time, ErrorAxis::Samples] {
            for low in -8..=4 {
                let low = f64::from(low) - 0.3;
                let texts: Vec<String> =
                    numbered(low, low + 1.4, 9).into_iter().map(|value| text(axis, 10_f64.powf(value))).collect();
                for (index, text) in texts.iter().enumerate() {
                    assert!(!texts[index + 1..].contains(text), "{axis:?}: {texts:?}");
                    assert!(text.chars().count() <= 8, "{text}");
                }
            }
        }
    }
}
