//! Meshes and images from bytes instead of files: for programs that have them elsewhere, and for tests that damage them.

use std::path::Path;

use super::{image, mesh};
use crate::geometry::Mesh;
use crate::scene::environment::EnvironmentImage;

/// A mesh from the `bytes` of a file called `name`, of which only the ending counts.
///
/// # Errors
/// When the ending names no mesh format that is read, or the bytes hold no mesh: says why, with the line in text formats.
pub fn mesh_from_bytes(bytes: &[u8], name: &Path) -> Result<Mesh, String> {
    match mesh::read(bytes, mesh::Format::of(name)?) {
        Ok((mesh, _)) => Ok(mesh),
        Err(fault) => Err(fault.line.map(|line| format!("line {line}: ")).unwrap_or_default() + &fault.message),
    }
}

/// An environment image from the `bytes` of a file called `name`, of which only the ending counts.
///
/// # Errors
/// When the ending names no image format that is read, or the bytes hold no image that can be used.
pub fn image_from_bytes(bytes: &[u8], name: &Path) -> Result<EnvironmentImage, String> {
    image::read(bytes, image::format_of(name)?)
}
