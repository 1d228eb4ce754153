//! Shapes.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::materials::Material;
use super::state::Reader;
use super::tokens::Parameters;
use crate::formats::importing::place::{Facing, Placed, placed_mesh};
use crate::formats::importing::{FileMesh, at, shapes};
use crate::geometry::Mesh;
use crate::scene::Place;
use crate::scene::SceneError;
use crate::scene::description::{Light, MeshPart, Paint, Solid};

/// A shape with the attributes that it has where it stands.
#[derive(Debug, Clone)]
pub(super) struct Found {
    pub name: String,
    pub surface: Surface,
    pub matrix: DAffine3,
    pub is_reversed: bool,
    pub material: Material,
    pub light: Option<Light>,
    pub media: [String; 2],
}

#[derive(Debug, Clone)]
pub(super) enum Surface {
    Mesh {
        mesh: Arc<FileMesh>,
        /// Whether normals of the file's own point against the order of corners.
        has_opposed_normals: bool,
    },
    Sphere {
        radius: f64,
    },
    Disk {
        height: f64,
        inner: f64,
        outer: f64,
    },
    Tube {
        radius: f64,
        from: f64,
        to: f64,
    },
}

impl Surface {
    /// Whether pbrt's normals point against those of the surface here, which keep an outside outside.
    pub fn is_flipped(&self, found: &Found, matrix: &DAffine3) -> bool {
        let is_mirrored = found.matrix.matrix3.determinant() < 0.0;
        match self {
            // Those of meshes are made anew where a transform mirrors.
            Self::Mesh { has_opposed_normals, .. } => found.is_reversed != *has_opposed_normals,
            Self::Sphere { .. } | Self::Tube { .. } => found.is_reversed != is_mirrored,
            Self::Disk { .. } => {
                let is_here = matrix.matrix3.determinant() < 0.0;
                (found.is_reversed != is_mirrored) != is_here
            }
        }
    }

    /// The shape where it stands, `matrix` being the one of `found` or its mirror image.
    pub fn placed(&self, found: &Found, matrix: &DAffine3) -> Placed {
        let is_flipped = self.is_flipped(found, matrix);
        let placed = match self {
            Self::Mesh { mesh, .. } => {
                return placed_mesh(mesh, matrix, is_flipped, !mesh.mesh.normals.is_empty());
            }
            Self::Sphere { radius } => shapes::sphere(DVec3::ZERO, *radius, matrix),
            Self::Disk { height, inner, outer } => shapes::disk(*height, *inner, *outer, matrix),
            Self::Tube { radius, from, to } => shapes::tube(DVec3::Z * *from, DVec3::Z * *to, *radius, matrix),
        };
        Placed { is_inward: is_flipped, ..placed }
    }
}

pub(super) fn shape(
    reader: &mut Reader<'_>,
    kind: &str,
    parameters: &Parameters,
    place: &Place,
) -> Result<(), SceneError> {
    if parameters.get("alpha").is_some() {
        reader.importer.note("mask", place, "masks are taken for wholly opaque");
    }
    let is_partial = parameters.number("phimax").is_some_and(|degrees| degrees < 360.0)
        || (kind == "sphere" && (parameters.get("zmin").is_some() || parameters.get("zmax").is_some()));
    if is_partial {
        reader.importer.note("partial", place, "parts of spheres, disks and cylinders are taken for the whole");
    }
    let number = |name: &str, otherwise: f64| parameters.number(name).unwrap_or(otherwise);
    let mut name = kind.to_owned();
    let surface = match kind {
        "trianglemesh" | "loopsubdiv" | "bilinearmesh" => {
            if kind == "loopsubdiv" {
                reader.importer.note("subdivision", place, "subdivision surfaces are taken by their control meshes");
            }
            name = "mesh".to_owned();
            let has_image =
                matches!(&reader.state.material, Material::Solid(Solid { paint: Paint::Texture { .. }, .. }));
            mesh_surface(inline_mesh(kind, parameters, has_image, place)?)
        }
        "plymesh" => {
            if parameters.get("displacement").is_some() {
                reader.importer.note("bump", place, "displacement and normal maps are left out");
            }
            let file = parameters.text("filename").ok_or_else(|| at(place, "a `plymesh` needs a `filename`"))?;
            let mesh = reader.importer.mesh(file, &MeshPart::default(), place)?;
            name.clone_from(&mesh.name);
            Surface::Mesh { has_opposed_normals: has_opposed_normals(&mesh.mesh), mesh }
        }
        "sphere" => Surface::Sphere { radius: number("radius", 1.0).abs() },
        "disk" => {
            let (outer, inner) = (number("radius", 1.0).abs(), number("innerradius", 0.0).abs());
            Surface::Disk { height: number("height", 0.0), inner: inner.min(0.999_999 * outer), outer }
        }
        "cylinder" => {
            let (from, to) = (number("zmin", -1.0), number("zmax", 1.0));
            Surface::Tube { radius: number("radius", 1.0).abs(), from: from.min(to), to: from.max(to) }
        }
        kind => {
            let message = format!("shapes of the type {kind} are left out");
            reader.importer.note("shape", place, message);
            return Ok(());
        }
    };
    let state = &reader.state;
    if state.matrix.matrix3.determinant() == 0.0 {
        return Err(at(place, "the shape's transform leaves no volume"));
    }
    let found = Found {
        name,
        surface,
        matrix: state.matrix,
        is_reversed: state.is_reversed,
        material: state.material.clone(),
        light: state.light.clone(),
        media: state.media.clone(),
    };
    reader.place(found, place)
}

fn mesh_surface(mesh: Mesh) -> Surface {
    let has_opposed_normals = has_opposed_normals(&mesh);
    let facing = Facing::of(&mesh);
    let (path, part, name) = Default::default();
    let mesh = FileMesh { mesh: Arc::new(mesh), notes: Vec::new(), path, part, name, facing };
    Surface::Mesh { mesh: Arc::new(mesh), has_opposed_normals }
}

/// Whether a mesh's normals point, over most of it, against the order of corners.
fn has_opposed_normals(mesh: &Mesh) -> bool {
    if mesh.normals.len() != mesh.positions.len() {
        return false;
    }
    let along = mesh.triangles.iter().map(|triangle| {
        let [a, b, c] = triangle.map(|corner| mesh.positions[corner as usize]);
        let normal: DVec3 = triangle.iter().map(|&corner| mesh.normals[corner as usize]).sum();
        (b - a).cross(c - a).dot(normal)
    });
    along.sum::<f64>() < 0.0
}

/// `has_image`: whether texture coordinates are asked for.
fn inline_mesh(kind: &str, parameters: &Parameters, has_image: bool, place: &Place) -> Result<Mesh, SceneError> {
    let positions = parameters.points("P")?;
    let mut normals = parameters.points("N")?;
    if normals.len() != positions.len() {
        normals.clear();
    }
    let mut corners = Vec::new();
    if let Some(indices) = parameters.get("indices") {
        for &index in &indices.numbers {
            if !(index >= 0.0 && index < positions.len() as f64 && index.fract() == 0.0) {
                return Err(at(
                    &indices.place,
                    format!("`indices` names the point {index}, but there are {}", positions.len()),
                ));
            }
            corners.push(index as u32);
        }
    } else {
        let count = if kind == "bilinearmesh" { 4 } else { 3 };
        if positions.len() != count {
            return Err(at(place, format!("`{kind}` needs `indices`, or {count} points")));
        }
        corners.extend(0..count as u32);
    }
    let triangles: Vec<[u32; 3]> = match kind {
        "bilinearmesh" => corners.chunks_exact(4).flat_map(|c| [[c[0], c[1], c[3]], [c[0], c[3], c[2]]]).collect(),
        _ => corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
    };
    if triangles.is_empty() {
        return Err(at(place, format!("`{kind}` has no faces")));
    }
    let pairs = ["uv", "st"].iter().find_map(|name| parameters.get(name)).map_or(&[][..], |uv| &uv.numbers);
    let corner = |index: u32| [0, 1].map(|k| pairs[2 * index as usize + k] as f32);
    let uvs = match pairs.len() == 2 * positions.len() {
        _ if !has_image => Vec::new(),
        true => triangles.iter().map(|triangle| triangle.map(corner)).collect(),
        // As pbrt has them where a file says nothing.
        false if kind == "bilinearmesh" => {
            let halves = [[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]];
            (0..triangles.len()).map(|triangle| halves[triangle % 2]).collect()
        }
        false => vec![[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]; triangles.len()],
    };
    // Normals are interpolated, whatever their length.
    normals.iter_mut().for_each(|normal| *normal = normal.normalize_or(DVec3::Y));
    Ok(Mesh { positions, normals, triangles, uvs })
}
