//! An index of refraction as a person types it.

use super::expression::{begins_as_number, evaluate};
use super::{Refusal, quoted};
use crate::formats::closest;
use crate::optics::ior::{IOR_RANGE, WAVELENGTH_C_UM, WAVELENGTH_F_UM};
use crate::optics::{Ior, catalog};
use crate::spectrum::WAVELENGTH_D_UM;

/// An index: a number or a calculation (`1.333`, `4/3`, `1,5`, `n = 1.5`), a name from the catalogue or its beginning (`water`, `BK7`), or
/// an index with Abbe's number (`1.5168 V 64.2`), which becomes a Cauchy formula.
///
/// # Errors
/// When it is none of these, with the reason in a sentence.
pub fn ior(text: &str) -> Result<Ior, Refusal> {
    let text = without_symbol(text.trim());
    if text.is_empty() {
        return Err(Refusal::new("Type a number such as 1.333, a calculation such as 4/3, or a name such as water."));
    }
    if let Some((index, abbe)) = with_abbe_number(text) {
        return dispersive(checked(evaluate(index, &index_of)?)?, evaluate(abbe, &index_of)?);
    }
    if !begins_as_number(text) {
        match named(text) {
            Ok(ior) => return Ok(ior),
            // Something such as `sqrt(2)` or `water + 0.01`.
            Err(refusal) if !text.contains(|c: char| "+*/^()√×·".contains(c)) => return Err(refusal),
            Err(_) => {}
        }
    }
    evaluate(text, &index_of).and_then(checked).map(Ior::Constant)
}

/// Without `n =`, `nd` or the like at its beginning.
fn without_symbol(text: &str) -> &str {
    let symbols = ["ior", "n_d", "nd", "n", "η"];
    for symbol in symbols {
        let Some(head) = text.get(..symbol.len()).filter(|head| head.to_lowercase() == symbol) else { continue };
        let rest = text[head.len()..].trim_start();
        if let Some(value) = rest.strip_prefix(['=', ':', '≈']) {
            return value.trim();
        }
        // `nd 1.5168`, but not `n-bk7`.
        if text[head.len()..].starts_with(char::is_whitespace) && rest.starts_with(|c: char| c.is_ascii_digit()) {
            return rest;
        }
    }
    text
}

/// An index and Abbe's number: `1.5168 V 64.2`, `1.5168, Vd = 64.2`, `d 1.5168 v 64.2`.
fn with_abbe_number(text: &str) -> Option<(&str, &str)> {
    let (at, mark) = text.char_indices().find(|(_, c)| matches!(c, 'v' | 'V' | 'ν'))?;
    let (index, abbe) = (&text[..at], &text[at + mark.len_utf8()..]);
    let index = index.trim().trim_end_matches([',', ';']).trim_end();
    let index = index.strip_prefix(['d', 'D']).unwrap_or(index).trim();
    let abbe = abbe.trim_start_matches(['_', 'd', 'D']).trim_start().trim_start_matches(['=', ':']).trim();
    let is_number = |text: &str| begins_as_number(text) && !text.contains(char::is_alphabetic);
    (is_number(index) && is_number(abbe)).then_some((index, abbe))
}

/// n = A + B/λ² with the given index at the d line and V = (n_d − 1)/(n_F − n_C).
fn dispersive(index: f64, abbe: f64) -> Result<Ior, Refusal> {
    if !(abbe.is_finite() && abbe > 0.0) {
        return Err(Refusal::new(format!("{abbe} is no Abbe number: it must be above 0.")));
    }
    let inverse_square = |wavelength: f64| 1.0 / (wavelength * wavelength);
    let spread = inverse_square(WAVELENGTH_F_UM) - inverse_square(WAVELENGTH_C_UM);
    let b = (index - 1.0) / abbe / spread;
    let model = Ior::Cauchy([index - b * inverse_square(WAVELENGTH_D_UM), b, 0.0]);
    // An Abbe number near 0 would take the index through 0 within the visible.
    let is_real = [0.38, 0.78].iter().all(|um| IOR_RANGE.contains(&(1.0 + model.ior_minus_one(*um))));
    if is_real {
        Ok(model)
    } else {
        Err(Refusal::new(format!("An Abbe number of {abbe} would make the index impossible within visible light.")))
    }
}

/// # Errors
/// When `n` is no index.
fn checked(n: f64) -> Result<f64, Refusal> {
    if n <= 0.0 {
        Err(Refusal::new(format!("{n} is no index of refraction: it must be above 0.")))
    } else if IOR_RANGE.contains(&n) {
        Ok(n)
    } else {
        Err(Refusal::new(format!("{n:e} is no index of refraction here: it must be between 1e-6 and 1e6.")))
    }
}

/// The index of a medium of the catalogue that stands in a calculation.
fn index_of(word: &str) -> Result<f64, Refusal> {
    named(word).map(|ior| ior.ior())
}

/// A medium by its name, or by the beginning of one that is the only one to begin so.
fn named(text: &str) -> Result<Ior, Refusal> {
    if let Some(entry) = catalog::find(text) {
        return Ok(Ior::Catalog(entry));
    }
    let wanted: String =
        text.to_lowercase().split([' ', '_', '-']).filter(|part| !part.is_empty()).collect::<Vec<_>>().join("-");
    if wanted == "vacuum" {
        return Ok(Ior::Constant(1.0));
    }
    if ["nm", "µm", "mm", "cm", "m"].contains(&wanted.as_str()) {
        return Err(Refusal::new(format!(
            "{} does not belong here: an index of refraction has no unit.",
            quoted(text)
        )));
    }
    // `bk7` for `n-bk7`, `silica` for `fused-silica`.
    let ends = |entry: &catalog::Entry| entry.name.strip_suffix(&wanted).is_some_and(|head| head.ends_with('-'));
    let begins = |entry: &catalog::Entry| entry.name.starts_with(&wanted);
    let is_enough = wanted.chars().count() >= 2;
    for fits in [&ends as &dyn Fn(&catalog::Entry) -> bool, &begins] {
        let found: Vec<&'static catalog::Entry> =
            catalog::ALL.iter().filter(|entry| is_enough && fits(entry)).collect();
        match found[..] {
            [] => {}
            [first, ..] if found.iter().all(|entry| entry.model == first.model) => return Ok(Ior::Catalog(first)),
            _ => {
                let names: Vec<&str> = found.iter().map(|entry| entry.name).collect();
                return Err(Refusal::new(format!("{} could be {}.", quoted(text), names.join(" or "))));
            }
        }
    }
    let hint = match closest(&wanted, catalog::ALL.iter().map(|entry| entry.name)) {
        Some(name) => format!("; did you mean “{name}”?"),
        None => ".".to_owned(),
    };
    Err(Refusal::new(format!("{} is not in the catalogue{hint}", quoted(text))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_calculations() {
        for (text, n) in [
            ("1.333", 1.333),
            ("4/3", 4.0 / 3.0),
            ("1,5", 1.5),
            ("n=1.5", 1.5),
            ("N = 4/3", 4.0 / 3.0),
            ("nd 1,5168", 1.5168),
            ("IOR: 2", 2.0),
            ("n_d = sqrt(2)", 2.0_f64.sqrt()),
            ("sqrt(2)", 2.0_f64.sqrt()),
            ("vacuum", 1.0),
        ] {
            assert_eq!(ior(text), Ok(Ior::Constant(n)), "{text}");
        }
        let water = catalog::find("water").unwrap().ior();
        assert_eq!(ior("water + 0.01"), Ok(Ior::Constant(water + 0.01)));
    }

    #[test]
    fn names_keep_their_dispersion() {
        for (text, name) in [
            ("water", "water"),
            ("WATER", "water"),
            ("wat", "water"),
            ("BK7", "n-bk7"),
            ("n-bk7", "n-bk7"),
            ("N BK7", "n-bk7"),
            ("fused silica", "fused-silica"),
            ("silica", "fused-silica"),
            ("acr", "acrylic"),
            ("dia", "diamond"),
            ("n = ice", "ice"),
        ] {
            assert_eq!(ior(text), Ok(Ior::Catalog(catalog::find(name).unwrap())), "{text}");
        }
        assert!(catalog::ALL.iter().all(|entry| ior(entry.name) == Ok(Ior::Catalog(entry))));
    }

    #[test]
    fn abbe_numbers_become_a_formula() {
        for text in ["1.5168 V 64.2", "d 1,5168 v 64,2", "nd = 1.5168, Vd = 64.2", "1.5168 ν 64.2"] {
            let model = ior(text).unwrap_or_else(|refusal| panic!("{text}: {refusal}"));
            assert!((model.ior() - 1.5168).abs() < 1e-12 && model.is_dispersive(), "{text}");
            assert!((model.abbe_number().unwrap() - 64.2).abs() < 1e-9, "{text}");
        }
        assert!(ior("1.5 V 0").unwrap_err().0.contains("Abbe number"));
        assert!(ior("1.5 V 0.01").unwrap_err().0.contains("impossible"));
    }

    #[test]
    fn what_is_refused_says_why() {
        for (text, reason) in [
            ("", "Type a number such as"),
            ("0", "0 is no index of refraction: it must be above 0."),
            ("-1.5", "-1.5 is no index of refraction: it must be above 0."),
            ("1e7", "between 1e-6 and 1e6"),
            ("1,5,2", "two decimal commas"),
            ("watr", "“watr” is not in the catalogue; did you mean “water”?"),
            ("xyzzy", "“xyzzy” is not in the catalogue."),
            ("s", "“s” is not in the catalogue"),
            ("gl", "“gl” could be glycerol or glass."),
            ("1.5 mm", "an index of refraction has no unit"),
            ("watr + 1", "did you mean “water”?"),
            ("1/0", "divided by 0"),
        ] {
            let refusal = ior(text).expect_err(text);
            assert!(refusal.0.contains(reason), "{text}: {refusal}");
        }
    }

    proptest::proptest! {
        /// Any text is read or refused; what is read is an index that scenes may have.
        #[test]
        fn no_text_is_too_much(text in "\\PC{0,40}|[nvdD0-9., =()/^water-]{0,30}") {
            match ior(&text) {
                Ok(ior) => assert!(IOR_RANGE.contains(&ior.ior()), "{text}"),
                Err(refusal) => assert!(refusal.0.ends_with(['.', '?']), "{text}: {refusal}"),
            }
        }
    }
}
