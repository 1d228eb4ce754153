//! Scenes with every interface resolved, for other renderers: what rectification found, written down face by face.
//!
//! ```text
//! cut      a face, cut along the curves where other surfaces cross it
//! pieces   surfaces, each piece with one medium on each side
//! scene    the whole scene: interfaces, solids, lights, the camera, and the media that they are in
//! files    what is written, all or nothing
//! mitsuba, pbrt, glb, faces
//! ```

mod cut;
mod faces;
mod files;
mod glb;
mod mitsuba;
mod pbrt;
pub mod pieces;
mod scene;

use std::sync::Arc;

pub use files::Bundle;
pub use scene::{Frame, ResolvedScene};

use crate::scene::SceneError;
use crate::scene::description::Description;

named! {
    /// What scenes are written for.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum Target {
        /// An XML file for Mitsuba 3.
        Mitsuba = "mitsuba",
        /// A text file for pbrt-v4.
        Pbrt = "pbrt",
        /// Volumes as objects, for viewers: no surface is split.
        Gltf = "gltf",
        /// Tables of media by face, for renderers of one's own.
        Faces = "faces",
    }
}

/// The files of a scene for another renderer. Nothing is written yet.
///
/// # Errors
/// When the scene is impossible.
pub fn export(description: &Arc<Description>, target: Target, frame: Frame) -> Result<Bundle, SceneError> {
    let resolved = ResolvedScene::new(description)?;
    Ok(match target {
        Target::Mitsuba => mitsuba::write(&resolved, frame),
        Target::Pbrt => pbrt::write(&resolved, frame),
        Target::Gltf => glb::write(&resolved, frame),
        Target::Faces => faces::write(&resolved),
    })
}
