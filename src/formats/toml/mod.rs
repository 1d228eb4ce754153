//! Scenes in TOML.

mod ior;
mod node;
mod read;
mod reader;
mod syntax;
mod write;

pub use self::read::{parse, read};
pub use self::write::{save, to_text};
