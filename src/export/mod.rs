//! Pictures to files: PNG for looking at, EXR for measuring, and labelled comparisons of several modes in one picture. And scenes with every
//! interface resolved, for other renderers ([`resolved`]).
//!
//! Parts of images go to files of their own kind, which can be merged without rounding ([`write_sums`]).
//! Everything is written whole or not at all ([`crate::writing`]). A PNG carries what it shows as text chunks
//! ([`metadata`]).

mod canvas;
pub mod color_map;
mod comparison;
pub mod csv;
mod error;
pub mod escape;
mod metadata;
mod picture;
pub mod resolved;
mod slices;
mod sums;
mod surfaces;
pub mod tev;
pub mod words;

pub use comparison::{Comparison, LabelledPane, comparison};
pub use error::ExportError;
pub use metadata::{estimator, metadata, metadata_for_media, renderer};
pub use picture::{Format, Picture, exr, image_png, png, png_bytes, save};
pub use slices::slices;
pub use sums::{Head, SumsError, read_sums, read_sums_head, write_sums};
pub use surfaces::painted_surfaces;
