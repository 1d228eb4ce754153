//! Numbers as the page shows them.

use maud::{Markup, html};

use super::plot::{minus, superscript};
use crate::export::words;
use crate::measure::Interval;

/// Three significant digits: `0.0123`, `45.6`, `1.23·10⁻⁵`; `–` for what is not a number.
pub fn number(x: f64) -> String {
    if x.is_nan() {
        return "–".to_owned();
    }
    if x.is_infinite() {
        return if x > 0.0 { "∞" } else { "−∞" }.to_owned();
    }
    if x == 0.0 {
        return "0".to_owned();
    }
    // The exponent of what is left after rounding: 0.09999 is 0.1.
    let text = format!("{x:.2e}");
    let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-2..=3).contains(&exponent) {
        minus(&format!("{x:.decimals$}", decimals = (2 - exponent).max(0) as usize))
    } else {
        let digits = minus(digits.trim_end_matches('0').trim_end_matches('.'));
        let power = superscript(exponent);
        if digits == "1" { format!("10{power}") } else { format!("{digits}·10{power}") }
    }
}

/// As many decimals as asked for.
pub fn fixed(x: f64, decimals: usize) -> String {
    if x.is_nan() { "–".to_owned() } else { minus(&format!("{x:.decimals$}")) }
}

/// `1.23 (1.1 to 1.4)`, in two sizes.
pub fn interval(interval: &Interval, show: impl Fn(f64) -> String) -> Markup {
    html! { (show(interval.value)) " " span class="interval" { "(" (show(interval.low)) " to " (show(interval.high)) ")" } }
}

/// Seconds with the unit that suits them, from nanoseconds on.
pub fn time(seconds: f64) -> String {
    match seconds {
        x if x.is_nan() => "–".to_owned(),
        x if x < 0.9995e-6 => format!("{} ns", number(x * 1e9)),
        x if x < 0.9995e-3 => format!("{} µs", number(x * 1e6)),
        x => words::duration(x),
    }
}

/// Bytes with the unit that suits them.
pub fn bytes(bytes: u64) -> String {
    let bytes = bytes as f64;
    match bytes {
        b if b >= 1024.0 * 1024.0 * 1024.0 => format!("{:.1} GiB", b / (1024.0 * 1024.0 * 1024.0)),
        b if b >= 1024.0 * 1024.0 => format!("{:.0} MiB", b / (1024.0 * 1024.0)),
        b => format!("{:.0} KiB", b / 1024.0),
    }
}

/// A sign and a word for what came of something: neither needs colour.
pub fn verdict(is_good: Option<bool>, word: &str) -> Markup {
    let (class, sign) = match is_good {
        Some(true) => ("good", "✓"),
        Some(false) => ("bad", "✗"),
        None => ("open", "○"),
    };
    html! { span class={ "verdict " (class) } { span aria-hidden="true" { (sign) } " " (word) } }
}

/// A table that scrolls where it is too wide, of columns with these headings and classes: `n` for numbers.
pub fn table(class: Option<&str>, caption: &str, columns: &[(&str, &str)], rows: &Markup) -> Markup {
    let columns = columns.iter().map(|(heading, class)| (heading, Some(class).filter(|class| !class.is_empty())));
    html! {
        div class="scroll" {
            table class=[class] {
                caption { (caption) }
                thead { tr { @for (heading, class) in columns { th class=[class] { (heading) } } } }
                tbody { (rows) }
            }
        }
    }
}

/// Colours from left to right as a scale so many rem wide, with words below.
pub fn ramp(rem: u32, about: &str, colors: impl IntoIterator<Item = [u8; 3]>, words: &[String]) -> Markup {
    let stops: Vec<String> = colors.into_iter().map(|[r, g, b]| format!("rgb({r} {g} {b})")).collect();
    html! {
        div style={ "max-width: " (rem) "rem" } {
            div class="ramp" style={ "background: linear-gradient(to right, " (stops.join(", ")) ")" } role="img" aria-label=(about) {}
            div class="ramp-ends" { @for words in words { span { (words) } } }
        }
    }
}

/// A PNG in base64 as an image.
pub fn image(png: &str, [width, height]: [usize; 2], about: &str) -> Markup {
    html! { img src={ "data:image/png;base64," (png) } width=(width) height=(height) alt=(about); }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        for (x, text) in [
            (0.0, "0"),
            (1.0, "1.00"),
            (-0.01234, "−0.0123"),
            (0.099_99, "0.100"),
            (999.9, "1000"),
            (1234.5, "1234"),
            (12_345.0, "1.23·10⁴"),
            (1e-5, "10⁻⁵"),
            (-1.234e-7, "−1.23·10⁻⁷"),
            (1.5e-3, "1.5·10⁻³"),
            (f64::NAN, "–"),
            (f64::NEG_INFINITY, "−∞"),
        ] {
            assert_eq!(number(x), text, "{x}");
        }
        assert_eq!([time(2e-7), time(2.5e-5), time(0.25)], ["200 ns", "25.0 µs", "250 ms"]);
        assert_eq!([bytes(1 << 20), bytes(3 << 30), bytes(2048)], ["1 MiB", "3.0 GiB", "2 KiB"]);
    }
}
