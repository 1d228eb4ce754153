//! Numbers and distances as they are typed. Scenes have no metres: a unit is refused, and the message says what to do.

use std::ops::RangeInclusive;

use super::expression::evaluate;
use super::{Refusal, quoted};

const LENGTHS: [&str; 16] =
    ["nm", "µm", "μm", "um", "mm", "cm", "dm", "m", "km", "in", "inch", "ft", "metre", "metres", "meter", "meters"];

/// A plain number or a calculation; a degree sign after it is passed over.
///
/// # Errors
/// When it is neither.
pub fn number(text: &str) -> Result<f64, Refusal> {
    let text = text.trim().trim_end_matches('°');
    evaluate(text, &|word| {
        Err(Refusal::new(if is_length(word) {
            format!("{} does not belong here: lengths are in scene units, which have no size in metres.", quoted(word))
        } else {
            format!("{} is no number.", quoted(word))
        }))
    })
}

/// A number within `range`.
///
/// # Errors
/// When it is none, or outside.
pub fn number_within(text: &str, range: &RangeInclusive<f64>) -> Result<f64, Refusal> {
    let value = number(text)?;
    let (least, most) = (range.start(), range.end());
    match value {
        value if value < *least => Err(Refusal::new(format!("{value} is too small: at least {least}."))),
        value if value > *most => Err(Refusal::new(format!("{value} is too large: at most {most}."))),
        value => Ok(value),
    }
}

/// A whole number within `range`.
///
/// # Errors
/// When it is none, or outside.
pub fn whole(text: &str, range: &RangeInclusive<i64>) -> Result<f64, Refusal> {
    let value = number_within(text, &(*range.start() as f64..=*range.end() as f64))?;
    if value.fract() == 0.0 { Ok(value) } else { Err(Refusal::new(format!("{value} is no whole number."))) }
}

/// A distance above 0, in scene units.
///
/// # Errors
/// When it is none, or has a unit.
pub fn distance(text: &str) -> Result<f64, Refusal> {
    match number(text)? {
        value if value > 0.0 => Ok(value),
        value => Err(Refusal::new(format!("{value} is no distance: it must be above 0."))),
    }
}

fn is_length(word: &str) -> bool {
    LENGTHS.contains(&word.to_lowercase().as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_units() {
        assert_eq!(number("1,5"), Ok(1.5));
        assert_eq!(number("90/4°"), Ok(22.5));
        assert_eq!(distance("1/4"), Ok(0.25));
        assert_eq!([number_within("90*2", &(0.0..=180.0)), whole("2^6", &(1..=64))], [Ok(180.0), Ok(64.0)]);
        for (refusal, reason) in [
            (number("2 mm"), "scene units, which have no size in metres"),
            (number("0.3/cm"), "“cm” does not belong here"),
            (number("0.3 m⁻¹"), "“m” does not belong here"),
            (number("1/µm"), "“µm” does not belong here"),
            (number("two"), "“two” is no number"),
            (distance("0"), "0 is no distance"),
            (distance("-1"), "-1 is no distance"),
            (number_within("180,5", &(0.0..=180.0)), "180.5 is too large: at most 180."),
            (number_within("-1e-9", &(0.0..=180.0)), "is too small: at least 0."),
            (whole("65", &(1..=64)), "65 is too large: at most 64."),
            (whole("1.5", &(1..=64)), "1.5 is no whole number"),
        ] {
            let refusal = refusal.expect_err(reason);
            assert!(refusal.0.contains(reason), "{refusal}");
        }
    }

    proptest::proptest! {
        #[test]
        fn no_text_is_too_much(text in "\\PC{0,40}") {
            let _ = number(&text);
            assert!(distance(&text).is_ok_and(|x| x > 0.0 && x.is_finite()) || distance(&text).is_err());
        }
    }
}
