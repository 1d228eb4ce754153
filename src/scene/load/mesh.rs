//! Meshes from files: what is common to all formats.

use std::path::Path;

use glam::DVec3;

use super::polygon::triangulate;
use super::{obj, ply};
use crate::geometry::Mesh;

/// A mesh format that is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Obj,
    Ply,
}

impl Format {
    /// The format that a file's ending names.
    ///
    /// # Errors
    /// Lists the formats that are read.
    pub fn of(path: &Path) -> Result<Self, String> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
        match ending.as_str() {
            "obj" => Ok(Self::Obj),
            "ply" => Ok(Self::Ply),
            "glb" | "gltf" => Err("glTF meshes are not yet supported; use .obj or .ply".into()),
            _ => Err(format!("`{}` is no mesh that is read: use .obj or .ply", path.display())),
        }
    }
}

/// What is wrong in a mesh file.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Fault {
    /// 1-based, in text formats.
    pub line: Option<usize>,
    pub message: String,
}

impl Fault {
    pub fn new(message: impl Into<String>) -> Self {
        Self { line: None, message: message.into() }
    }

    pub fn at(line: usize, message: impl Into<String>) -> Self {
        Self { line: Some(line), message: message.into() }
    }
}

/// A mesh as it grows while its file is read. Corners must be in range: the readers know the place of those that are not.
#[derive(Debug, Default)]
pub(super) struct Builder {
    pub positions: Vec<DVec3>,
    /// One for each position, or none.
    pub normals: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    /// Triangles left out because they have no area.
    dropped: usize,
}

impl Builder {
    /// Adds a face of three or more corners.
    pub fn push_face(&mut self, corners: &[u32]) {
        if let [a, b, c] = *corners {
            self.push_triangle([a, b, c]);
            return;
        }
        let points: Vec<DVec3> = corners.iter().map(|&i| self.positions[i as usize]).collect();
        for triangle in triangulate(&points) {
            self.push_triangle(triangle.map(|k| corners[k]));
        }
    }

    fn push_triangle(&mut self, triangle: [u32; 3]) {
        let [a, b, c] = triangle.map(|i| self.positions[i as usize]);
        let (u, v) = (b - a, c - a);
        // Scaled by the longest edge, so that tiny triangles are not taken for flat ones by underflow.
        let longest = u.abs().max(v.abs()).max_element();
        let has_area = longest > 0.0 && (u / longest).cross(v / longest) != DVec3::ZERO;
        if has_area {
            self.triangles.push(triangle);
        } else {
            self.dropped += 1;
        }
    }

    /// The mesh, and how many triangles were left out of it.
    fn finish(self) -> Result<(Mesh, usize), Fault> {
        if self.triangles.is_empty() {
            return Err(Fault::new(match self.dropped {
                0 => "the mesh has no faces".to_owned(),
                dropped => format!("none of the mesh's {dropped} triangles has any area"),
            }));
        }
        let mut normals = self.normals;
        normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
        // A normal without direction is of no use, and the others make no whole: the faces give better ones.
        if normals.len() != self.positions.len() || normals.contains(&DVec3::ZERO) {
            normals.clear();
        }
        Ok((Mesh { positions: self.positions, normals, triangles: self.triangles }, self.dropped))
    }
}

/// Reads a mesh, and says how many triangles without area were left out of it.
pub(super) fn read(bytes: &[u8], format: Format) -> Result<(Mesh, usize), Fault> {
    match format {
        Format::Obj => obj::read(bytes)?.finish(),
        Format::Ply => ply::read(bytes)?.finish(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_by_ending() {
        assert_eq!(Format::of(Path::new("a/b.OBJ")), Ok(Format::Obj));
        assert_eq!(Format::of(Path::new("b.ply")), Ok(Format::Ply));
        assert!(Format::of(Path::new("b.glb")).unwrap_err().contains("not yet supported"));
        assert!(Format::of(Path::new("b")).unwrap_err().contains("use .obj or .ply"));
    }

    #[test]
    fn triangles_without_area_are_dropped_and_counted() {
        let mut builder = Builder {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X * 2.0, DVec3::X, DVec3::Y * 1e-200],
            ..Builder::default()
        };
        for face in [[0, 1, 2], [0, 1, 1], [0, 1, 3], [1, 4, 2], [0, 1, 5]] {
            builder.push_face(&face);
        }
        let (mesh, dropped) = builder.finish().unwrap();
        assert_eq!((mesh.triangles, dropped), (vec![[0, 1, 2], [0, 1, 5]], 3));
    }

    #[test]
    fn only_flat_triangles_is_an_error() {
        let mut builder = Builder { positions: vec![DVec3::ZERO, DVec3::X], ..Builder::default() };
        builder.push_face(&[0, 1, 0]);
        assert!(builder.finish().unwrap_err().message.contains("none of the mesh's 1 triangles"));
        assert!(Builder::default().finish().unwrap_err().message.contains("no faces"));
    }
}
