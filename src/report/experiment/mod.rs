//! Error against run time: runs with different seeds, sample counts doubling, held against two independent references.
//!
//! # What is measured
//!
//! A run is one film that grows: the samples at N are the first half of those at 2N. That costs half of what films of their own would,
//! and is what a user sees. The errors along one run are correlated; so whatever has an interval is estimated from each run
//! for itself (a slope), or with each run left out in turn (a bias), and the interval is over the runs, whose seeds make them independent.
//!
//! # Error, bias and variance
//!
//! With an image x, references r₁ and r₂ and r their mean, the squared error of a component is (x − r₁)(x − r₂): the noise of the references
//! drops out of its expectation, and a figure of an image as good as the references can come out negative. It is divided by r² + 0.01 for
//! relMSE. With K runs of mean m and sample variance s², the bias squared is (m − r₁)(m − r₂) − s²/K, without a bias of its own.

pub mod data;
pub mod plan;

pub use data::{Bias, Curve, Pair, PairPoint, Plateau, Point, ReferenceAbout, RunPoint, SceneErrors, Slope, Technique};
pub use plan::{Effort, Plan};

/// Beyond this many standard deviations of what chance does, a mode is called biased: by chance one in thirty thousand is.
pub const BIAS_SIGNIFICANCE: f64 = 4.0;
