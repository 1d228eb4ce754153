//! Measurements of whole scenes, and the page that shows them.
//!
//! [`make`] takes the measurements ([`experiment`], [`stability`], [`left_out`], [`editing`], [`first_look`], [`growth`], [`backends`], and
//! [`pictures`] to look at), piece by piece; [`store`] keeps finished pieces, so that an interruption costs one of them at most. What comes of it is [`data`]: plain, whole, and all
//! that [`page`] and [`csv`] see. Numbers are worked out where they are measured and shown as they are: the page computes none.

pub mod backends;
pub mod csv;
pub mod data;
pub mod editing;
pub mod estimators;
pub mod experiment;
pub mod extent;
pub mod first_look;
pub mod frame_times;
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
pub mod summary;
pub mod timing;
pub mod write;
