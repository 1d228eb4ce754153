//! IOR rectification: finding what lies on the other side of every refractor's surface, place by place.
//!
//! ```text
//! subjects, relation, face, tolerance   primitives, and how two of them meet                   ┐
//! contact, copies                       which faces other surfaces touch                       │
//! cells, asked, coarseness              touched faces, divided until each part has one answer  │ geometry alone
//! split, site                           the other faces, joined into connected pieces          │
//! layout                                all objects together                                   │
//! changes                               what of all this an edit leaves as it was               ┘
//! containment                           which refractors contain a point: rays vote
//! pretrace, nest                        votes about every piece; in deep nests containers are inherited
//! surroundings, table, patch            votes, priorities and media come to two media for every place
//! placed                                the media in which lights without a surface stand
//! flat                                  the arrays that are looked up at a crossing, on the CPU and on the GPU
//! containers                            what most of an object's surface lies in, for a tree of objects
//! object_table                          one exterior for each object, the source's method, to compare with
//! ```

pub mod asked;
pub mod cells;
pub mod changes;
mod coarseness;
pub mod contact;
pub mod containers;
pub mod containment;
pub mod copies;
pub mod encounters;
pub mod face;
pub mod flat;
pub mod layout;
mod nest;
pub mod object_table;
pub mod patch;
mod placed;
pub mod planes;
pub mod pretrace;
pub mod progress;
mod random;
pub mod relation;
pub mod site;
pub mod split;
pub mod start;
pub mod subjects;
pub mod surroundings;
pub mod table;
pub mod tolerance;

pub use patch::{Patch, PatchKind};
pub use progress::{Cancelled, Progress};
pub use table::InterfaceTable;
