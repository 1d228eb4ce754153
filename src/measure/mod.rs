//! How far two images are apart, and what runs with different seeds tell together.

pub mod flip;
pub mod metrics;
pub mod statistics;

pub use metrics::{Difference, MetricError, UnbiasedDifference, block_means, difference, difference_from_two};
pub use statistics::Interval;
