//! Measurements of whole scenes, and the page that shows them.

pub mod stability;
