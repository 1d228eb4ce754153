//! One page that holds everything: no other file, no network, no script. Light or dark as its reader prefers, on a phone, on paper.

mod backends;
mod editing;
mod errors;
mod estimators;
mod files;
mod first_look;
mod frame;
mod growth;
mod left_out;
mod map;
pub mod plot;
mod scenes;
mod stability;
mod summary;
pub(super) mod words;

pub use frame::html;
