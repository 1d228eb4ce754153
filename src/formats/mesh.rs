//! Meshes from files, whatever their format.

use std::path::Path;

use super::encoding::without_mark;
use super::ending::{Format, by_ending, list};
use super::polygons::{Fault, Polygons};
use super::{obj, ply, stl};
use crate::geometry::Mesh;
use crate::scene::LoadNote;

pub(super) type MeshFormat = Format<Result<Polygons, Fault>>;

/// The endings of files that meshes are read from, in lower case.
pub const MESH_ENDINGS: &[&str] = &["obj", "ply", "stl"];

/// Every mesh format that is read.
const FORMATS: &[MeshFormat] = &[
    MeshFormat { endings: &["obj"], read: obj::read },
    MeshFormat { endings: &["ply"], read: ply::read },
    MeshFormat { endings: &["stl"], read: stl::read },
];

/// The format that a file's ending names; an error lists those that are read.
pub(super) fn format_of(path: &Path) -> Result<&'static MeshFormat, String> {
    by_ending(FORMATS, path).ok_or_else(|| {
        let is_gltf = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb") || e.eq_ignore_ascii_case("gltf"));
        let list = list(FORMATS);
        match is_gltf {
            true => format!("glTF meshes are not yet supported; use {list}"),
            false => format!("`{}` is no mesh that is read: use {list}", path.display()),
        }
    })
}

/// Reads a mesh, and says what was passed over.
pub(super) fn read(bytes: &[u8], format: &MeshFormat) -> Result<(Mesh, Vec<LoadNote>), Fault> {
    (format.read)(&without_mark(bytes))?.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_by_ending() {
        let endings: Vec<&str> = FORMATS.iter().flat_map(|format| format.endings).copied().collect();
        assert_eq!(endings, MESH_ENDINGS);
        let first_ending = |path: &str| format_of(Path::new(path)).map(|format| format.endings[0]);
        assert_eq!(first_ending("a/b.OBJ"), Ok("obj"));
        assert_eq!(first_ending("b.ply"), Ok("ply"));
        assert!(first_ending("b.GLB").unwrap_err().contains("not yet supported"));
        assert!(first_ending("b").unwrap_err().contains("use .obj, .ply or .stl"));
    }
}
