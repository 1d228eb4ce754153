//! An environment image as it was read.

use super::note::LoadNote;

/// A latitude–longitude image, linear Rec. 709, every component finite and ≥ 0.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentImage {
    pub width: usize,
    pub height: usize,
    /// Row-major, row 0 at +y.
    pub pixels: Vec<[f32; 3]>,
    /// What the file held otherwise, and was replaced, converted or passed over.
    pub notes: Vec<LoadNote>,
}
