//! Names and numbers as messages have them.

use glam::DVec3;

use crate::scene::{ObjectId, Scene};

/// Names that one problem lists at the most; of more, it says how many.
const MOST: usize = 8;

/// The names themselves, for [`super::Problem::place`].
pub(super) fn place<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    names.into_iter().take(MOST).collect::<Vec<_>>().join(", ")
}

/// The names of objects, for [`super::Problem::place`].
pub(super) fn place_of(scene: &Scene, objects: &[ObjectId]) -> String {
    place(objects.iter().map(|id| scene.object(*id).name.as_str()))
}

/// `` `a` ``, `` `a` and `b` ``, `` `a`, `b` and 7 more ``.
pub(super) fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let mut names: Vec<String> = names.into_iter().map(|name| format!("`{name}`")).collect();
    let last = if names.len() > MOST {
        let more = format!("{} more", names.len() + 1 - MOST);
        names.truncate(MOST - 1);
        Some(more)
    } else {
        names.pop()
    };
    match last {
        Some(last) if !names.is_empty() => format!("{} and {last}", names.join(", ")),
        last => last.unwrap_or_default(),
    }
}

/// The names of objects, in a sentence.
pub(super) fn list_of(scene: &Scene, objects: &[ObjectId]) -> String {
    list(objects.iter().map(|id| scene.object(*id).name.as_str()))
}

/// A place in scene coordinates.
pub(super) fn near(point: DVec3) -> String {
    let [x, y, z] = point.to_array();
    format!("near [{x:.4}, {y:.4}, {z:.4}]")
}

/// A length or an index to `digits` significant digits, without zeros at its end.
pub(super) fn brief(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-5..15).contains(&magnitude) {
        return format!("{value:.*e}", (digits - 1).max(0) as usize);
    }
    let text = format!("{value:.*}", (digits - 1 - magnitude).max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A length that is at least `value`, of two digits.
pub(super) fn rounded_up(value: f64) -> String {
    let step = 10_f64.powf(value.abs().log10().floor() - 1.0);
    if step > 0.0 && step.is_finite() { brief((value / step).ceil() * step, 2) } else { brief(value, 2) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_a_sentence() {
        assert_eq!(list([]), "");
        assert_eq!(list(["a"]), "`a`");
        assert_eq!(list(["a", "b", "c"]), "`a`, `b` and `c`");
        let names: Vec<String> = (0..12).map(|k| k.to_string()).collect();
        let names = || names.iter().map(String::as_str);
        assert_eq!(list(names()), "`0`, `1`, `2`, `3`, `4`, `5`, `6` and 5 more");
        assert_eq!(list(names().take(8)).matches('`').count(), 16);
        assert_eq!(place(names()).split(", ").count(), 8);
    }

    #[test]
    fn numbers() {
        let brief_of = [(1.5, "1.5"), (0.000_123_4, "0.000123"), (1234.0, "1234"), (2e-9, "2.00e-9"), (0.0, "0")];
        for (value, text) in brief_of {
            assert_eq!(brief(value, 3), text);
        }
        for (value, text) in [(0.001_01, "0.0011"), (0.3, "0.3"), (47.1, "48"), (1e-12, "1.0e-12")] {
            assert_eq!(rounded_up(value), text);
        }
    }
}
