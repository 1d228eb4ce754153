//! The path of the inspected pixel: followed in the background, made into lines, drawn over the panes and exported.
//!
//! ```text
//! tracer     the thread: paths of the modes that are wanted, and where two of them part
//! line       a path as legs in space, with what each leg lets on, and what hides it from the camera
//! strokes    legs on the screen: where, how wide, how bright; where labels have room
//! outline    objects as a few edges, for a picture that shows nothing but the path
//! svg        the same as a vector drawing
//! export     what files of a path hold
//! ```

pub mod export;
pub mod line;
pub mod outline;
pub mod strokes;
pub mod svg;
pub mod tracer;

pub use line::Line;
pub use tracer::{Question, Traced, Tracer, Viewpoint};
