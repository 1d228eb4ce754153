//! glTF 2.0 (`.gltf`, `.glb`): whole scenes, and their meshes for scenes of other formats. Khronos Group, "glTF 2.0 Specification", 2021.
//!
//! What a scene has no counterpart for is approximated or left out, and told once a kind. All numbers that ask for memory are held against
//! the bytes that are there.

mod accessor;
mod build;
mod container;
mod file;
mod lights;
mod materials;
mod nodes;
mod scene;
mod schema;
mod surface;
#[cfg(test)]
mod tests;
mod textures;

use super::files::Input;

/// The bytes of an image of a file; an error says why there are none.
pub(super) fn image(input: &Input<'_>, index: usize) -> Result<Vec<u8>, String> {
    let container = container::Container::read(input).map_err(|fault| fault.message)?;
    container.image(index).map(|bytes| bytes.to_vec())
}

pub(super) use self::file::File;
pub(super) use self::nodes::transform;
pub(super) use self::scene::scene;
