//! Everything that is read from files and written to them: scenes with their meshes and images.
//!
//! Scenes come in here, from a name, a file or bytes, and leave as a [`Description`] that knows what was passed over in its files. Where
//! those are found is a [`Files`]: the disk, what is compiled into the program, or memory.

pub mod builtin;
mod compressed;
mod corners;
pub mod disk;
mod encoding;
mod ending;
mod files;
mod gltf;
pub(crate) mod image;
mod importing;
mod lines;
mod mesh;
mod mitsuba;
mod names;
mod obj;
mod parts;
mod passed_over;
mod pbrt;
mod pieces;
mod ply;
mod polygon;
mod polygons;
mod scenes;
mod serialized;
mod stl;
mod studio;
mod suggest;
mod tally;
pub mod texture;
mod toml;

use std::path::Path;

pub use self::builtin::BuiltIn;
pub use self::disk::Disk;
pub use self::files::{Files, Memory};
pub(crate) use self::image::write::exr_of_pixels;
pub use self::mesh::MESH_ENDINGS;
pub use self::ply::{PlyExtra, to_bytes as ply_bytes};
pub use self::scenes::SCENE_ENDINGS;
pub use self::suggest::closest;
use self::suggest::suggestion;
pub use self::toml::{parse, save, to_text};
use crate::geometry::Mesh;
use crate::optics::Medium;
use crate::scene::description::Object;
use crate::scene::environment::EnvironmentImage;
use crate::scene::{Description, LoadNote, SceneError};

/// A scene by the name of a built-in one, or by its file's path.
///
/// # Errors
/// When there is no such scene, or it cannot be used.
pub fn open(name_or_path: impl AsRef<Path>) -> Result<Description, SceneError> {
    let path = name_or_path.as_ref();
    let name = path.to_string_lossy();
    if let Some(builtin) = builtin::find(&name) {
        return parse(builtin.text, &builtin.path(), &BuiltIn);
    }
    let looks_like_a_name = path.extension().is_none() && path.components().count() == 1;
    if looks_like_a_name && !path.exists() {
        let names = || builtin::all().iter().map(|scene| scene.name);
        return Err(SceneError::new(format!(
            "there is no file and no built-in scene `{name}`{}; built-in scenes: {}",
            suggestion(&name, names()),
            names().collect::<Vec<_>>().join(", ")
        )));
    }
    file(path)
}

/// A scene from a file on the disk, with the meshes and images that it names. A file that holds a mesh alone becomes a scene around it.
///
/// # Errors
/// When the file or one that it names cannot be read or used.
pub fn file(path: &Path) -> Result<Description, SceneError> {
    let bytes = match is_lone_mesh(path) {
        true => disk::read(path, disk::MAX_DATA_BYTES),
        false => disk::read_or_receive(path, scenes::most_bytes(path)),
    };
    read(&bytes.map_err(|error| SceneError::in_file(path, error.to_string()))?, path, &Disk)
}

/// A scene from the bytes of its file, or a scene around the mesh in them. `path` names it in errors, its ending tells the format (TOML where it is
/// that of none), and the files that it names are looked for in its folder, among `files`.
///
/// # Errors
/// When the scene or a file that it names cannot be used.
pub fn read(bytes: &[u8], path: &Path, files: &dyn Files) -> Result<Description, SceneError> {
    let input = files::Input { bytes, path, files };
    if is_lone_mesh(path) { studio::open(&input) } else { scenes::read(&input) }
}

/// Whether a file of that name holds a mesh and no scene.
fn is_lone_mesh(path: &Path) -> bool {
    scenes::format_of(path).is_none() && is_mesh(path)
}

/// Whether a path's ending is that of another format than the program's own, from which scenes or meshes are read.
fn is_of_another_format(path: &Path) -> bool {
    scenes::is_foreign(path) || is_mesh(path)
}

/// Whether a path's ending is that of a mesh format that is read.
pub fn is_mesh(path: &Path) -> bool {
    mesh::is_mesh(path)
}

/// A mesh from the `bytes` of a file called `name`, of which only the ending counts.
///
/// # Errors
/// When the ending names no mesh format that is read, or the bytes hold no mesh: says why, with the line in text formats.
pub fn mesh_from_bytes(bytes: &[u8], name: &Path) -> Result<Mesh, String> {
    let input = files::Input { bytes, path: name, files: &Memory::default() };
    match mesh::read(&input, mesh::format_of(name)?) {
        Ok((mesh, _)) => Ok(mesh),
        Err(fault) => Err(fault.line.map(|line| format!("line {line}: ")).unwrap_or_default() + &fault.message),
    }
}

/// A mesh from a file on the disk, and what of the file was passed over.
///
/// # Errors
/// When the file cannot be read or holds no mesh.
pub fn mesh_from_file(path: &Path) -> Result<(Mesh, Vec<LoadNote>), SceneError> {
    let format = mesh::format_of(path).map_err(|message| SceneError::in_file(path, message))?;
    let bytes = Disk.read(path).map_err(|message| SceneError::in_file(path, message))?;
    let input = files::Input { bytes: &bytes, path, files: &Disk };
    mesh::read(&input, format).map_err(|fault| mesh::error_in(path, fault))
}

/// The objects of a file on the disk that holds a mesh: one for each of its materials, or else of its groups, made of what its material
/// library says, or else of glass. Their shapes name the file as `written`; each comes with the medium of its name, if it is a refractor.
///
/// # Errors
/// When the file cannot be read or holds no mesh.
pub fn mesh_objects_from_file(path: &Path, written: &Path) -> Result<Vec<(Object, Option<Medium>)>, SceneError> {
    let bytes = Disk.read(path).map_err(|message| SceneError::in_file(path, message))?;
    studio::objects(&files::Input { bytes: &bytes, path, files: &Disk }, written)
}

/// An environment image from a file on the disk.
///
/// # Errors
/// When the file cannot be read or holds no image that can be used.
pub fn image_from_file(path: &Path) -> Result<EnvironmentImage, SceneError> {
    let in_file = |message| SceneError::in_file(path, message);
    let format = image::format_of(path).map_err(in_file)?;
    image::read(&Disk.read(path).map_err(in_file)?, format).map_err(in_file)
}

/// An environment image from the `bytes` of a file called `name`, of which only the ending counts.
///
/// # Errors
/// When the ending names no image format that is read, or the bytes hold no image that can be used.
pub fn image_from_bytes(bytes: &[u8], name: &Path) -> Result<EnvironmentImage, String> {
    image::read(bytes, image::format_of(name)?)
}

/// A picture that some renderer has made.
#[derive(Debug, Clone, PartialEq)]
pub struct RenderedPicture {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Mean radiance of each pixel, linear Rec. 709, every component finite, row 0 at the top.
    pub rgb: Vec<[f32; 3]>,
    /// What of the file was replaced or converted.
    pub notes: Vec<LoadNote>,
}

/// A rendered picture from a file on the disk.
///
/// # Errors
/// When the file cannot be read or holds no picture of linear light (EXR or Radiance HDR).
pub fn picture_from_file(path: &Path) -> Result<RenderedPicture, SceneError> {
    let in_file = |message| SceneError::in_file(path, message);
    let image = image::read_picture(&Disk.read(path).map_err(in_file)?, path).map_err(in_file)?;
    let size = [image.width, image.height].map(|side| side as u32);
    Ok(RenderedPicture { size, rgb: image.pixels, notes: image.notes })
}
