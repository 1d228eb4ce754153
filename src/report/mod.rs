//! Measurements of whole scenes, and the page that shows them.

mod checked;
pub mod csv;
pub mod data;
pub mod experiment;
pub mod growth;
pub mod left_out;
pub mod machine;
pub mod make;
pub mod page;
pub mod pictures;
pub mod progress;
pub mod reference;
pub mod stability;
pub mod store;
pub mod timing;
pub mod write;
