//! One sample of one pixel, and one path told vertex by vertex.

pub mod path;
pub mod sampler;
pub mod trace;
