//! IOR rectification: finding what lies on the other side of every refractor's surface, place by place.
//!
//! ```text
//! contact    which faces do other surfaces touch                          ┐
//! cells      touched faces, divided until each part has one answer         │ geometry alone
//! layout     the rest, joined into connected patches                      ┘
//! pretrace   rays from every patch vote about every refractor
//! nest       where there are many, what lies in each other inherits its containers
//! surroundings, table   votes, priorities and media come to two media for every place
//! ```

mod adjacency;
pub mod cells;
pub mod contact;
pub mod containment;
pub mod copies;
pub mod encounters;
pub mod layout;
mod nest;
pub mod object;
pub mod pretrace;
pub mod progress;
mod random;
pub mod start;
pub mod surroundings;
pub mod table;
pub mod tolerance;

pub use progress::{Cancelled, Progress};
pub use table::{InterfaceTable, Patch, PatchKind};
