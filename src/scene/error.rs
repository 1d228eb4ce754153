//! What can be wrong with a scene, and where.

use std::fmt;
use std::path::PathBuf;

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

/// A scene that cannot be used. The message says what is wrong and what to do about it.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{}{message}", place.as_ref().map(|p| format!("{p}: ")).unwrap_or_default())]
pub struct SceneError {
    pub place: Option<Place>,
    pub message: String,
}

impl SceneError {
    /// An error that belongs to no file, such as an impossible value typed into the window.
    pub fn new(message: impl Into<String>) -> Self {
        Self { place: None, message: message.into() }
    }

    /// An error in a file as a whole.
    pub fn in_file(file: impl Into<PathBuf>, message: impl Into<String>) -> Self {
        Self { place: Some(Place { file: file.into(), line_column: None }), message: message.into() }
    }

    /// An error at a 1-based line and column of a file.
    pub fn at(file: impl Into<PathBuf>, line: usize, column: usize, message: impl Into<String>) -> Self {
        Self { place: Some(Place { file: file.into(), line_column: Some((line, column)) }), message: message.into() }
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
