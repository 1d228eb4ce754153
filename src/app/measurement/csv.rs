//! The measured points as a table for other programs.

use std::fmt::Write as _;

use super::Measurements;

/// What the columns hold: names on the first line, then a line for each point. Times are in seconds, figures as in the panel; FLIP is
/// empty where it was not asked for.
const COLUMNS: &str = "scene,width,height,mode,samples,seconds,rectification_seconds,relmse,relmse_standard_error,relmse_trimmed,mse,\
                       smape,flip,reference_samples";

/// The whole table.
pub fn table(scene: &str, measurements: &Measurements) -> String {
    let mut text = format!("{COLUMNS}\n");
    let [width, height] = measurements.size;
    for (mode, curve) in &measurements.curves {
        for point in &curve.points {
            let figures = &point.squared;
            let flip = point.flip.map(|flip| format!("{flip:e}")).unwrap_or_default();
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{},{width},{height},{},{},{:e},{:e},{:e},{:e},{:e},{:e},{:e},{flip},{}",
                quoted(scene),
                mode.name(),
                point.samples,
                point.seconds,
                curve.rectification_seconds,
                figures.relmse,
                point.relmse_standard_error,
                figures.relmse_trimmed,
                figures.mse,
                point.smape,
                point.truth_samples,
            );
        }
    }
    text
}

/// A field as RFC 4180 wants it.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_with_commas_are_quoted() {
        assert_eq!(quoted("iced water"), "iced water");
        assert_eq!(quoted("a \"b\", c"), "\"a \"\"b\"\", c\"");
    }
}
