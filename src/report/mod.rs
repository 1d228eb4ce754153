//! Measurements of whole scenes, and the page that shows them.

mod checked;
pub mod experiment;
pub mod growth;
pub mod left_out;
pub mod machine;
pub mod progress;
pub mod reference;
pub mod stability;
pub mod store;
pub mod timing;
