//! Media with measured, cited indices.

/// A catalogue entry.
#[derive(Debug, PartialEq)]
pub struct Entry {
    /// The name used in scene files, such as `water`.
    pub name: &'static str,
}
