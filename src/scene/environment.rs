//! Light from all around: constant, gradient, or an image that is importance sampled.

/// A latitude–longitude image, linear Rec. 709, every component finite and ≥ 0.
#[derive(Debug, Clone, PartialEq)]
pub struct EnvironmentImage {
    pub width: usize,
    pub height: usize,
    /// Row-major, row 0 at +y.
    pub pixels: Vec<[f32; 3]>,
    /// How many components were negative in the file and set to 0.
    pub clipped: usize,
}

/// The environment, ready to be looked up and sampled.
#[derive(Debug, Clone)]
pub struct EnvironmentLight {}
