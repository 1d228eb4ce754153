//! One sample of one pixel, and one path told vertex by vertex.

mod crossing;
mod direct;
pub mod inspect;
pub mod path;
pub mod sampler;
