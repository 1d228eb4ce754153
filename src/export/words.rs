//! Numbers and counts in words, the same in the window, on exported pictures and in the terminal.

use crate::tracking::Events;

/// `"no events"`, or every count that is not 0.
pub fn events_in_words(events: &Events) -> String {
    if events.total() == 0 {
        return "no events".into();
    }
    let counts = events.named().into_iter().filter(|(_, count)| *count > 0);
    counts.map(|(name, count)| format!("{} {}", grouped(count), name.replace('_', " "))).collect::<Vec<_>>().join(" · ")
}

/// 1234567 as `1,234,567`.
pub fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// Two or three significant digits, without an exponent where that stays readable.
pub fn brief(x: f64) -> String {
    if x == 0.0 {
        "0".into()
    } else if x.abs() < 1e-3 || x.abs() >= 1e5 {
        let text = format!("{x:.1e}");
        // 5.0e-4 as 5e-4.
        text.replace(".0e", "e")
    } else {
        let decimals = (2 - x.abs().log10().floor() as i32).clamp(0, 5) as usize;
        let text = format!("{x:.decimals$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    }
}

/// A time in seconds with the unit that suits it.
pub fn duration(seconds: f64) -> String {
    if seconds < 1.0 {
        format!("{} ms", brief(seconds * 1e3))
    } else if seconds < 100.0 {
        format!("{} s", brief(seconds))
    } else if seconds < 3599.5 {
        let whole = seconds.round() as u64;
        format!("{} min {:02} s", whole / 60, whole % 60)
    } else {
        let minutes = (seconds / 60.0).round() as u64;
        format!("{} h {:02} min", minutes / 60, minutes % 60)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_short() {
        for (x, expected) in [
            (0.0, "0"),
            (0.1803, "0.18"),
            (0.5, "0.5"),
            (5e-4, "5e-4"),
            (1.23e-5, "1.2e-5"),
            (2.0, "2"),
            (123.4, "123"),
        ] {
            assert_eq!(brief(x), expected);
        }
    }

    #[test]
    fn counts_are_grouped_and_only_those_that_happened_are_named() {
        assert_eq!(grouped(0), "0");
        assert_eq!(grouped(999), "999");
        assert_eq!(grouped(1_234_567), "1,234,567");
        let events = Events { stack_underflow: 1200, inconsistent: 3, ..Events::default() };
        assert_eq!(events_in_words(&events), "1,200 stack underflow · 3 inconsistent");
        assert_eq!(events_in_words(&Events::default()), "no events");
    }

    #[test]
    fn times_have_the_unit_that_suits_them() {
        for (seconds, expected) in [
            (0.0004, "0.4 ms"),
            (0.25, "250 ms"),
            (2.14, "2.14 s"),
            (99.0, "99 s"),
            (200.4, "3 min 20 s"),
            (7260.0, "2 h 01 min"),
            (0.0, "0 ms"),
        ] {
            assert_eq!(duration(seconds), expected);
        }
    }
}
