//! What can go wrong when something is written.

use std::path::PathBuf;

use crate::measure::MetricError;
use crate::writing::WriteError;

/// A picture that could not be made or written. Nothing was left behind.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    #[error("{}: cannot tell the format; use a name that ends in {expected}", path.display())]
    UnknownExtension { path: PathBuf, expected: &'static str },
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The encoder refused.
    #[error("{}: cannot be encoded: {message}", path.display())]
    Encode { path: PathBuf, message: String },
    /// A picture without pixels, or whose pixels do not go with its size.
    #[error("a picture of {width}×{height} cannot hold {pixels} pixels")]
    BadPicture { width: u32, height: u32, pixels: usize },
    /// Panes that should be compared have different sizes, or there is none, or the baseline is not among them.
    #[error("cannot compare: {0}")]
    BadComparison(String),
    /// The panes hold numbers that cannot be compared.
    #[error(transparent)]
    Metric(#[from] MetricError),
}
