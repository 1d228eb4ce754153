//! What can be wrong with a scene, and where.

use std::fmt;
use std::path::{Path, PathBuf};

/// A place in a scene file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    pub file: PathBuf,
    /// 1-based line and column, where the error belongs to a line.
    pub line_column: Option<(usize, usize)>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some((line, column)) = self.line_column {
            write!(f, ":{line}:{column}")?;
        }
        Ok(())
    }
}

/// Most errors that [`SceneError`]'s text lists.
const MOST_LISTED: usize = 20;
/// Most errors that are kept.
const MOST_KEPT: usize = 1000;

/// A scene that cannot be used. The message says what is wrong and what to do about it.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{}", self.text())]
pub struct SceneError {
    pub place: Option<Place>,
    pub message: String,
    /// What else is wrong with the scene, in the order of places; these have no others of their own.
    pub others: Vec<Self>,
    /// How many more there are, which are not kept.
    pub left_out: usize,
}

impl SceneError {
    fn one(place: Option<Place>, message: String) -> Self {
        Self { place, message, others: Vec::new(), left_out: 0 }
    }

    /// An error that belongs to no file, such as an impossible value typed into the window.
    pub fn new(message: impl Into<String>) -> Self {
        Self::one(None, message.into())
    }

    /// An error in a file as a whole.
    pub fn in_file(file: impl Into<PathBuf>, message: impl Into<String>) -> Self {
        Self::one(Some(Place { file: file.into(), line_column: None }), message.into())
    }

    /// An error at a 1-based line and column of a file.
    pub fn at(file: impl Into<PathBuf>, line: usize, column: usize, message: impl Into<String>) -> Self {
        Self::one(Some(Place { file: file.into(), line_column: Some((line, column)) }), message.into())
    }

    /// Everything that is wrong with the scene in the file `scene`; `None` if that is nothing. Errors in the file itself come first, in the order
    /// of lines.
    pub fn all(mut errors: Vec<Self>, scene: &Path) -> Option<Self> {
        let order = |error: &Self| match &error.place {
            Some(place) => (place.file != scene, place.line_column),
            None => (true, None),
        };
        errors.sort_by_key(order);
        errors.dedup_by(|a, b| a.place == b.place && a.message == b.message);
        let left_out = errors.len().saturating_sub(MOST_KEPT);
        errors.truncate(MOST_KEPT);
        let mut errors = errors.into_iter();
        let first = errors.next()?;
        Some(Self { others: errors.collect(), left_out, ..first })
    }

    /// The error itself and the others.
    pub fn each(&self) -> impl Iterator<Item = &Self> {
        std::iter::once(self).chain(&self.others)
    }

    /// One line for each error, with its place.
    fn text(&self) -> String {
        let line = |error: &Self| match &error.place {
            Some(place) => format!("{place}: {}", error.message),
            None => error.message.clone(),
        };
        let mut lines: Vec<String> = self.each().take(MOST_LISTED).map(line).collect();
        match 1 + self.others.len() + self.left_out - lines.len() {
            0 => {}
            more => lines.push(format!("and {more} more {}", if more == 1 { "error" } else { "errors" })),
        }
        lines.join("\n")
    }
}

/// What is wrong with a table of a scene.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Fault {
    /// The key that is to blame, such as `radius`; empty where it is the table as a whole.
    pub key: &'static str,
    /// What is wrong and what would be right.
    pub message: String,
}

impl Fault {
    /// # Errors
    /// Always: the fault.
    pub fn at(key: &'static str, message: impl Into<String>) -> Result<(), Self> {
        Err(Self { key, message: message.into() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_listed_by_line_once_and_up_to_a_limit() {
        let at = |line: usize| SceneError::at("a.toml", line, 1, format!("wrong {line}"));
        assert!(SceneError::all(Vec::new(), Path::new("a.toml")).is_none());
        let text = |errors| SceneError::all(errors, Path::new("a.toml")).unwrap().to_string();
        assert_eq!(text(vec![at(5)]), "a.toml:5:1: wrong 5");
        let elsewhere = SceneError::at("A.obj", 1, 1, "bad");
        assert_eq!(
            text(vec![elsewhere, at(12), at(3), at(12)]),
            "a.toml:3:1: wrong 3\na.toml:12:1: wrong 12\nA.obj:1:1: bad"
        );
        for (count, end) in [(20, "wrong 20"), (21, "and 1 more error"), (5000, "and 4980 more errors")] {
            let text = text((1..=count).map(at).collect());
            assert!(text.ends_with(end) && text.lines().count() == count.min(21), "{count}");
        }
    }
}
