//! IOR rectification: finding what lies on the other side of every refractor.

pub mod containment;
pub mod pretrace;
mod random;
pub mod start;
pub mod table;

pub use pretrace::rectify;
pub use table::{InterfaceTable, Patch};
