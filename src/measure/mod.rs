//! How far two images are apart, and what runs with different seeds tell together.

pub mod metrics;
pub mod statistics;

pub use metrics::{Difference, MetricError, block_means, difference};
pub use statistics::Interval;
