//! Where shapes stand: matrices as scale, rotation and translation where they are that, and meshes that are transformed where they are not.

use std::sync::Arc;

use glam::{DAffine2, DAffine3, DMat3, DVec3};

use super::FileMesh;
use crate::formats::gltf::transform;
use crate::geometry::Mesh;
use crate::scene::description::{MeshPart, Shape, Transform};

/// A surface whose area vectors cancel but for this share encloses something.
const ENCLOSES: f64 = 1.0 / 3.0;

/// A shape where it stands.
#[derive(Debug, Clone)]
pub struct Placed {
    pub shape: Shape,
    pub transform: Transform,
    /// Whether the file's normals point to the side that is inside here.
    pub is_inward: bool,
    pub is_smooth: bool,
    /// What stands in its place where an image is laid on it and its own texture coordinates are not the file's.
    pub with_uvs: Option<Box<(Shape, Transform)>>,
    /// The file's texture coordinates from those that it has here.
    pub file_uv_from_uv: DAffine2,
}

impl Placed {
    pub fn new(shape: Shape) -> Self {
        Self {
            shape,
            transform: Transform::IDENTITY,
            is_inward: false,
            is_smooth: false,
            with_uvs: None,
            file_uv_from_uv: DAffine2::IDENTITY,
        }
    }
}

/// Which way a mesh's faces look, counter-clockwise ones towards the viewer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Facing {
    /// It encloses something, and they look outward.
    Outward,
    /// They look inward; such a mesh is turned over when the scene is compiled.
    Inward,
    /// It is open: they look where they look.
    Open,
}

impl Facing {
    pub fn of(mesh: &Mesh) -> Self {
        let Some(&origin) = mesh.positions.first() else { return Self::Open };
        let (mut sum, mut area, mut volume) = (DVec3::ZERO, 0.0, 0.0);
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|corner| mesh.positions[corner as usize] - origin);
            let across = (b - a).cross(c - a);
            sum += across;
            area += across.length();
            volume += a.dot(b.cross(c));
        }
        match () {
            () if sum.length() > ENCLOSES * area => Self::Open,
            () if volume < 0.0 => Self::Inward,
            () => Self::Outward,
        }
    }
}

/// The mesh with `matrix` applied. Its outside stays outside.
pub fn transformed(mesh: &Mesh, matrix: &DAffine3) -> Mesh {
    let positions = mesh.positions.iter().map(|p| matrix.transform_point3(*p)).collect();
    let DMat3 { x_axis, y_axis, z_axis } = matrix.matrix3;
    let determinant = matrix.matrix3.determinant();
    let cofactors = DMat3::from_cols(y_axis.cross(z_axis), z_axis.cross(x_axis), x_axis.cross(y_axis))
        * if determinant < 0.0 { -1.0 } else { 1.0 };
    let normals = mesh.normals.iter().map(|n| (cofactors * *n).normalize_or(DVec3::Y)).collect();
    let triangles = mesh.triangles.clone();
    let mut mesh = Mesh { positions, normals, triangles, uvs: mesh.uvs.clone() };
    if determinant < 0.0 {
        mesh.turn_triangles();
    }
    mesh
}

/// The mesh with its faces and normals turned over.
pub fn turned_over(mesh: &Mesh) -> Mesh {
    let mut mesh = mesh.clone();
    mesh.reverse();
    mesh
}

/// A mesh that is made here, where it stands.
pub fn made(mesh: Mesh, is_smooth: bool) -> Placed {
    let shape =
        Shape::Mesh { path: Default::default(), part: MeshPart::default(), mesh: Arc::new(mesh), notes: Vec::new() };
    Placed { is_smooth, ..Placed::new(shape) }
}

/// A file's mesh. `is_flipped`: whether the file's normals point to the side from which its faces are clockwise, where a mirroring has turned them
/// so that their outside stays outside.
pub fn placed_mesh(file: &FileMesh, matrix: &DAffine3, is_flipped: bool, is_smooth: bool) -> Placed {
    let is_inward = (file.facing == Facing::Inward) != is_flipped;
    match transform(matrix) {
        Some(transform) => {
            let FileMesh { mesh, notes, path, part, .. } = file;
            let (mesh, notes) = (Arc::clone(mesh), notes.clone());
            let shape = Shape::Mesh { path: path.clone(), part: part.clone(), mesh, notes };
            Placed { transform, is_inward, is_smooth, ..Placed::new(shape) }
        }
        None => Placed { is_inward, ..made(transformed(&file.mesh, matrix), is_smooth) },
    }
}

/// The surface of a light, which shines from the side that its normals point to, and is not turned over when the scene is compiled.
pub fn shining(placed: Placed, is_flipped: bool) -> Placed {
    let shape = match placed.shape {
        Shape::Quad { center, edge_u, edge_v } if is_flipped => Shape::Quad { center, edge_u: edge_v, edge_v: edge_u },
        Shape::Mesh { mesh, .. } if is_flipped => {
            return made(turned_over(&transformed(&mesh, &placed.transform.matrix())), placed.is_smooth);
        }
        shape => shape,
    };
    Placed { shape, ..placed }
}

/// The mirror image in x of a light without a surface.
pub fn reflected(mut placed: Placed) -> Placed {
    let turn = |v: &mut DVec3| v.x = -v.x;
    match &mut placed.shape {
        Shape::Point { position } => turn(position),
        Shape::Spot { position, target, .. } => {
            turn(position);
            turn(target);
        }
        Shape::Directional { direction, .. } => turn(direction),
        _ => {}
    }
    placed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn which_way_a_mesh_faces() {
        let tetrahedron = Mesh {
            positions: [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].iter().map(|p| *p + 7.0).collect(),
            normals: Vec::new(),
            triangles: vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]],
            uvs: Vec::new(),
        };
        assert_eq!(Facing::of(&tetrahedron), Facing::Outward);
        assert_eq!(Facing::of(&turned_over(&tetrahedron)), Facing::Inward);
        let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        assert_eq!(Facing::of(&transformed(&tetrahedron, &mirror)), Facing::Outward);
        let open = Mesh { triangles: vec![[0, 1, 2]], ..tetrahedron };
        assert_eq!(Facing::of(&open), Facing::Open);
    }
}
