//! One sample of one pixel.

pub mod trace;
