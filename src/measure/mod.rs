//! How far two images are apart.

pub mod metrics;

pub use metrics::{Difference, MetricError, block_means, difference};
