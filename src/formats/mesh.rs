//! Meshes from files, whatever their format.

use std::path::Path;

use super::encoding::without_mark;
use super::ending::{Format, by_ending, list};
use super::files::Input;
use super::parts::NoSuchPart;
use super::polygons::{Fault, Polygons};
use super::{gltf, obj, ply, scenes, serialized, stl};
use crate::geometry::Mesh;
use crate::scene::description::{MeshPart, Shape};
use crate::scene::{Description, LoadNote, SceneError};

pub(super) type MeshFormat = Format<fn(&Input<'_>) -> Result<MeshFile, Fault>>;

/// The endings of files that meshes are read from, in lower case.
pub const MESH_ENDINGS: &[&str] = &["obj", "ply", "stl", "glb", "gltf", "serialized"];

/// Every mesh format that is read.
const FORMATS: &[MeshFormat] = &[
    MeshFormat { endings: &["obj"], read: |input| surface(obj::read(input.bytes)) },
    MeshFormat { endings: &["ply"], read: |input| surface(ply::read(input.bytes)) },
    MeshFormat { endings: &["stl"], read: |input| surface(stl::read(input.bytes)) },
    MeshFormat {
        endings: &["glb", "gltf"],
        read: |input| gltf::File::read(input).map(|file| MeshFile::Gltf(Box::new(file))),
    },
    MeshFormat { endings: &["serialized"], read: |input| surface(serialized::read(input.bytes)) },
];

/// Scenes of other formats, whose objects have meshes that are in no file of their own: they are named so until the scene is saved.
const SCENES: &[MeshFormat] = &[MeshFormat {
    endings: &["xml", "pbrt"],
    read: |input| match scenes::read(input) {
        Ok(scene) => Ok(MeshFile::Scene(Box::new(scene))),
        Err(error) => Err(Fault::new(error.to_string())),
    },
}];

fn surface(read: Result<Polygons, Fault>) -> Result<MeshFile, Fault> {
    read.map(Box::new).map(MeshFile::Surface)
}

/// The format that a file's ending names; an error lists those that are read.
pub(super) fn format_of(path: &Path) -> Result<&'static MeshFormat, String> {
    (by_ending(FORMATS, path).or_else(|| by_ending(SCENES, path)))
        .ok_or_else(|| format!("`{}` is no mesh that is read: use {}", path.display(), list(FORMATS)))
}

/// A mesh's file as it was read, of which parts can be taken.
#[derive(Debug)]
pub(super) enum MeshFile {
    Surface(Box<Polygons>),
    Gltf(Box<gltf::File>),
    Scene(Box<Description>),
}

/// Why a part cannot be had.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum PartFault {
    NoSuchPart(NoSuchPart),
    Fault(Fault),
}

impl MeshFile {
    pub fn read(input: &Input<'_>, format: &MeshFormat) -> Result<Self, Fault> {
        let bytes = &*without_mark(input.bytes);
        (format.read)(&Input { bytes, ..*input })
    }

    /// The whole mesh, and what was passed over.
    pub fn whole(self) -> Result<(Mesh, Vec<LoadNote>), Fault> {
        match self {
            Self::Surface(surface) => surface.finish(),
            Self::Gltf(file) => file.whole(),
            Self::Scene(_) => Err(Fault::new("is a scene: name the mesh of one of its objects by `group`")),
        }
    }

    /// A part of the mesh, and what was passed over.
    pub fn part(&self, part: &MeshPart) -> Result<(Mesh, Vec<LoadNote>), PartFault> {
        match self {
            Self::Surface(surface) => {
                surface.part(part).map_err(PartFault::NoSuchPart)?.finish().map_err(PartFault::Fault)
            }
            Self::Gltf(file) => file.part(part),
            Self::Scene(scene) => of_object(scene, part).map_err(PartFault::NoSuchPart),
        }
    }

    /// The files of materials that it names.
    pub fn libraries(&self) -> &[String] {
        match self {
            Self::Surface(surface) => &surface.libraries,
            Self::Gltf(_) | Self::Scene(_) => &[],
        }
    }

    /// The material of all faces, if they have the same.
    pub fn only_material(&self) -> Option<String> {
        let Self::Surface(surface) = self else { return None };
        let Polygons { parts, faces, .. } = &**surface;
        let materials = parts.materials(faces.len());
        if let [only] = materials[..] { Some(only.to_owned()) } else { None }
    }

    /// The parts that together are the whole, each face in one: by materials, or else by groups. Fewer than two: it is all of one piece.
    pub fn pieces(&self) -> Vec<MeshPart> {
        // Of glTF there are whole scenes instead.
        let Self::Surface(surface) = self else { return Vec::new() };
        let Polygons { parts, faces, .. } = &**surface;
        let count = faces.len();
        let materials = parts.materials(count);
        if materials.len() > 1 {
            return materials.into_iter().map(MeshPart::of_material).collect();
        }
        let groups = if parts.has_one_group_each(count) { parts.groups(count) } else { Vec::new() };
        groups.into_iter().map(MeshPart::of_group).collect()
    }
}

/// The mesh of an object of a scene, which is its part `group`.
fn of_object(scene: &Description, part: &MeshPart) -> Result<(Mesh, Vec<LoadNote>), NoSuchPart> {
    let found = scene.objects.iter().find_map(|object| match &object.shape {
        Shape::Mesh { part: own, mesh, notes, .. } if own == part => Some((Mesh::clone(mesh), notes.clone())),
        _ => None,
    });
    let name = part.group.as_deref().unwrap_or_default();
    let missing = || NoSuchPart { key: "group", message: format!("has no mesh of its own for an object `{name}`") };
    found.ok_or_else(missing)
}

/// Reads a whole mesh, and says what was passed over.
pub(super) fn read(input: &Input<'_>, format: &MeshFormat) -> Result<(Mesh, Vec<LoadNote>), Fault> {
    MeshFile::read(input, format)?.whole()
}

/// Whether a path's ending is that of a mesh format.
pub(super) fn is_mesh(path: &Path) -> bool {
    by_ending(FORMATS, path).is_some()
}

/// What is wrong in the file `path`.
pub(super) fn error_in(path: &Path, fault: Fault) -> SceneError {
    match fault.line {
        Some(line) => SceneError::at(path, line, 1, fault.message),
        None => SceneError::in_file(path, fault.message),
    }
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
        assert_eq!(first_ending("b.GLTF"), Ok("glb"));
        assert!(first_ending("b").unwrap_err().contains("use .obj, .ply, .stl, .glb or .serialized"));
    }
}
