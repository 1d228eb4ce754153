//! "Did you mean": the closest of the valid names.

/// Longest words that are compared: that takes the product of two lengths.
const LONGEST: usize = 100;

/// `; did you mean …?`, or nothing where no name is close.
pub(super) fn suggestion<'a>(wrong: &str, valid: impl Iterator<Item = &'a str>) -> String {
    closest(wrong, valid).map_or_else(String::new, |name| format!("; did you mean `{name}`?"))
}

/// The valid name that was probably meant; `None` where none is close. Swapping two neighbours counts as one edit.
pub fn closest<'a>(wrong: &str, valid: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let allowed = 1 + wrong.chars().count() / 4;
    let wrong = wrong.to_lowercase();
    let distance = |name: &str| {
        let is_short = |word: &str| word.chars().count() <= LONGEST;
        let name = name.to_lowercase();
        (is_short(&wrong) && is_short(&name)).then(|| strsim::osa_distance(&wrong, &name))
    };
    valid
        .filter_map(|name| Some((distance(name)?, name)))
        .filter(|(distance, _)| *distance <= allowed)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_close_is_suggested() {
        let valid = ["color", "gradient", "image"];
        assert_eq!(suggestion("colour", valid.into_iter()), "; did you mean `color`?");
        assert_eq!(suggestion("iamge", valid.into_iter()), "; did you mean `image`?");
        assert_eq!(suggestion("temperature", valid.into_iter()), "");
    }
}
