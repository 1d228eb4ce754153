//! What can go wrong when something is written.

use std::path::PathBuf;

use crate::measure::MetricError;
use crate::writing::WriteError;

/// A picture that could not be made or written. Nothing was left behind.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The file name's extension names no known format.
    #[error("{}: cannot tell the format; use a name that ends in {expected}", path.display())]
    UnknownExtension {
        /// As asked for.
        path: PathBuf,
        /// The valid extensions.
        expected: &'static str,
    },
    /// The file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The encoder refused.
    #[error("{}: cannot be encoded: {message}", path.display())]
    Encode {
        /// As asked for.
        path: PathBuf,
        /// The encoder's reason.
        message: String,
    },
    /// A picture without pixels, or whose pixels do not go with its size.
    #[error("a picture of {width}×{height} cannot hold {pixels} pixels")]
    BadPicture {
        /// Claimed width.
        width: u32,
        /// Claimed height.
        height: u32,
        /// Pixels given.
        pixels: usize,
    },
    /// Panes that should be compared have different sizes, or there is none, or the baseline is not among them.
    #[error("cannot compare: {0}")]
    BadComparison(String),
    /// The panes hold numbers that cannot be compared.
    #[error(transparent)]
    Metric(#[from] MetricError),
}
