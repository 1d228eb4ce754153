//! IOR rectification: finding what lies on the other side of every refractor.

pub mod containment;
pub mod pretrace;
pub mod table;

pub use table::{InterfaceTable, Patch};
