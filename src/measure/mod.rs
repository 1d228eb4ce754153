//! How far two images are apart.

pub mod flip;
pub mod metrics;

pub use metrics::{Difference, MetricError, UnbiasedDifference, block_means, difference, difference_from_two};
