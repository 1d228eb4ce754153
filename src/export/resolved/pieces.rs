//! The surfaces of a scene, each piece with one medium on each side.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::cut::{Meeting, cut};
use crate::geometry::{CornerUvs, Geometry, Mesh, ObjectRange, PrimitiveId, SurfacePoint};
use crate::rectify::contact::Contact;
use crate::rectify::relation::Relation;
use crate::scene::description::{Description, Shape};
use crate::scene::shapes::tessellate;
use crate::scene::{Albedo, MediumId, ObjectId, SceneError, Surface};
use crate::tracking::{Prepared, prepare};

/// Halvings of the icosahedron that stands for an analytic sphere where a mesh is needed.
const SPHERE_SUBDIVISIONS: u32 = 5;

/// A surface in scene coordinates.
#[derive(Debug, Clone, PartialEq)]
pub enum Piece {
    Sphere { center: DVec3, radius: f64 },
    Mesh(Mesh),
}

impl Piece {
    /// Its triangles.
    pub fn into_mesh(self) -> Mesh {
        match self {
            Self::Mesh(mesh) => mesh,
            Self::Sphere { center, radius } => sphere_mesh(center, radius),
        }
    }
}

/// A piece of a refractor's surface. Its faces look outwards.
#[derive(Debug, Clone, PartialEq)]
pub struct Interface {
    pub refractor: ObjectId,
    pub outside: MediumId,
    pub inside: MediumId,
    pub piece: Piece,
}

/// A scene whose divided surfaces are all meshes, so that they can be cut, and the names of the spheres that have become meshes for it.
///
/// # Errors
/// When the scene is impossible.
pub fn with_meshes(description: &Arc<Description>) -> Result<(Prepared, Vec<String>), SceneError> {
    let prepared = prepare(Arc::clone(description), None)?;
    let is_met = |object: u32| match prepared.scene.geometry.range(object) {
        ObjectRange::Sphere(id) => !prepared.table.contacts_of(ObjectId(object), *id).is_empty(),
        ObjectRange::Triangles(_) => false,
    };
    let met: Vec<usize> = (0..description.objects.len()).filter(|index| is_met(*index as u32)).collect();
    if met.is_empty() {
        return Ok((prepared, Vec::new()));
    }
    let mut changed = (**description).clone();
    for &index in &met {
        if let Shape::Sphere { center, radius } = changed.objects[index].shape {
            changed.objects[index].shape = Shape::Icosphere { center, radius, subdivisions: SPHERE_SUBDIVISIONS };
            if let Some(refractor) = changed.objects[index].refractor_mut() {
                refractor.smooth = true;
            }
        }
    }
    let names = met.iter().map(|index| description.objects[*index].name.clone()).collect();
    Ok((prepare(Arc::new(changed), None)?, names))
}

/// Every place where light meets another medium, once: where the media on both sides are the same there is no interface, and of coincident
/// surfaces one stands for all. In the order of refractors.
pub fn interfaces(prepared: &Prepared) -> Vec<Interface> {
    let (scene, geometry) = (&*prepared.scene, &*prepared.scene.geometry);
    let mut all = Vec::new();
    for (refractor, _) in scene.refractors() {
        let range = match geometry.range(refractor.0) {
            ObjectRange::Triangles(range) => range.clone(),
            ObjectRange::Sphere(id) => {
                if let (Some(answer), Some(sphere)) = (prepared.table.sides_of(scene, *id), geometry.sphere(*id))
                    && answer.outside != answer.inside
                {
                    let piece = Piece::Sphere { center: sphere.center + geometry.origin, radius: sphere.radius };
                    all.push(Interface { refractor, outside: answer.outside, inside: answer.inside, piece });
                }
                continue;
            }
        };
        let pieces: Vec<Vec<FacePiece>> =
            range.into_par_iter().map(|face| pieces_of(prepared, refractor, face)).collect();
        let mut builders: Vec<((MediumId, MediumId), Builder)> = Vec::new();
        for piece in pieces.into_iter().flatten() {
            let sides = (piece.outside, piece.inside);
            let builder = match builders.iter_mut().position(|(known, _)| *known == sides) {
                Some(index) => &mut builders[index].1,
                None => {
                    builders.push((sides, Builder::new(geometry)));
                    &mut builders.last_mut().expect("it has just been added").1
                }
            };
            builder.add(&piece.corners, &piece.normals, None);
        }
        all.extend(builders.into_iter().map(|((outside, inside), builder)| Interface {
            refractor,
            outside,
            inside,
            piece: Piece::Mesh(builder.finish()),
        }));
    }
    all
}

/// The whole surface of an object, cut nowhere; `None` where it has none.
pub fn surface(prepared: &Prepared, object: ObjectId) -> Option<Piece> {
    let geometry = &*prepared.scene.geometry;
    match geometry.range(object.0) {
        ObjectRange::Sphere(id) => {
            let sphere = geometry.sphere(*id)?;
            Some(Piece::Sphere { center: sphere.center + geometry.origin, radius: sphere.radius })
        }
        ObjectRange::Triangles(range) if range.is_empty() => None,
        ObjectRange::Triangles(range) => {
            let is_smooth = is_smooth(prepared, object);
            let texture = prepared.scene.albedo(object).and_then(Albedo::texture);
            let mut builder = Builder::new(geometry);
            for face in range.clone() {
                let uvs = texture.and_then(|texture| texture.corner_uvs(face));
                let uvs = uvs.map(|uvs| uvs.map(|uv| uv.as_vec2().to_array()));
                builder.add(&geometry.corners(face), &normals_of(geometry, face, is_smooth), uvs);
            }
            Some(Piece::Mesh(builder.finish()))
        }
    }
}

/// A part of a face with one medium on each side (local coordinates).
struct FacePiece {
    outside: MediumId,
    inside: MediumId,
    corners: [DVec3; 3],
    /// Unit; zero where faces are flat.
    normals: [DVec3; 3],
}

fn pieces_of(prepared: &Prepared, refractor: ObjectId, face: PrimitiveId) -> Vec<FacePiece> {
    let (scene, geometry, table) = (&*prepared.scene, &*prepared.scene.geometry, &*prepared.table);
    let corners = geometry.corners(face);
    let normals = normals_of(geometry, face, is_smooth(prepared, refractor));
    let is_mixed = table.is_mixed(refractor, face);
    let known = if is_mixed { None } else { table.sides_of(scene, face) };
    if !is_mixed && known.is_none_or(|answer| answer.outside == answer.inside) {
        return Vec::new();
    }
    // Surfaces that do no more than touch may still cut an edge: its other face is cut there too.
    let others: Vec<(Meeting, [DVec3; 3])> = (table.contacts_of(refractor, face).iter())
        .filter(|contact| geometry.sphere(contact.primitive).is_none())
        .map(|Contact { primitive, relation }| {
            let meeting = match relation {
                Relation::Touches | Relation::Crosses { .. } => Meeting::Crosses,
                Relation::Coincides { .. } => Meeting::Coincides,
            };
            (meeting, geometry.corners(*primitive))
        })
        .collect();
    let pieces = cut(corners, &others).unwrap_or_else(|| vec![corners]);
    let normal = geometry.face_normal(face);
    (pieces.into_iter())
        .filter_map(|piece| {
            let weights = piece.map(|corner| barycentric(&corners, corner));
            let [v, w] = [1, 2].map(|k| (weights[0][k] + weights[1][k] + weights[2][k]) / 3.0);
            let position = (piece[0] + piece[1] + piece[2]) / 3.0;
            let point = SurfacePoint { position, normal, primitive: face };
            let answer = known.unwrap_or_else(|| table.look(scene, refractor, &point, [v, w]));
            let interpolated = weights.map(|[a, b, c]| {
                (normals[0] * a + normals[1] * b + normals[2] * c).try_normalize().unwrap_or(DVec3::ZERO)
            });
            (!answer.is_masked() && answer.outside != answer.inside).then_some(FacePiece {
                outside: answer.outside,
                inside: answer.inside,
                corners: piece,
                normals: interpolated,
            })
        })
        .collect()
}

fn is_smooth(prepared: &Prepared, object: ObjectId) -> bool {
    match prepared.scene.object(object).surface {
        Surface::Refractor { smooth, .. } | Surface::Diffuse { smooth, .. } | Surface::Mirror { smooth, .. } => smooth,
        Surface::Light { .. } => false,
    }
}

fn normals_of(geometry: &Geometry, face: PrimitiveId, is_smooth: bool) -> [DVec3; 3] {
    if is_smooth { geometry.corner_normals(face).map(glam::Vec3::as_dvec3) } else { [DVec3::ZERO; 3] }
}

/// Weights of a triangle's corners at a point of it.
fn barycentric(corners: &[DVec3; 3], point: DVec3) -> [f64; 3] {
    let (u, v, p) = (corners[1] - corners[0], corners[2] - corners[0], point - corners[0]);
    let (uu, uv, vv, pu, pv) = (u.dot(u), u.dot(v), v.dot(v), p.dot(u), p.dot(v));
    let determinant = uu * vv - uv * uv;
    let b = (vv * pu - uv * pv) / determinant;
    let c = (uu * pv - uv * pu) / determinant;
    // On a sliver the quotient may be anything.
    let [b, c] = [b, c].map(|weight| if weight.is_finite() { weight.clamp(0.0, 1.0) } else { 1.0 / 3.0 });
    [(1.0 - b - c).max(0.0), b, c]
}

/// Joins triangles whose corners are equal. Coordinates are those of the scene, rounded to single precision as files hold them: what has no area then
/// is left out.
struct Builder {
    origin: DVec3,
    mesh: Mesh,
    numbers: HashMap<[u32; 6], u32>,
}

impl Builder {
    fn new(geometry: &Geometry) -> Self {
        Self { origin: geometry.origin, mesh: Mesh::default(), numbers: HashMap::new() }
    }

    fn add(&mut self, corners: &[DVec3; 3], normals: &[DVec3; 3], uvs: Option<CornerUvs>) {
        let rounded = corners.map(|corner| (corner + self.origin).as_vec3() + 0.0);
        if rounded[0] == rounded[1] || rounded[1] == rounded[2] || rounded[2] == rounded[0] {
            return;
        }
        let triangle = [0, 1, 2].map(|k| {
            let ([x, y, z], [nx, ny, nz]) = (rounded[k].to_array(), (normals[k].as_vec3() + 0.0).to_array());
            let mesh = &mut self.mesh;
            *self.numbers.entry([x, y, z, nx, ny, nz].map(f32::to_bits)).or_insert_with(|| {
                mesh.positions.push(rounded[k].as_dvec3());
                mesh.normals.push(normals[k]);
                mesh.positions.len() as u32 - 1
            })
        });
        self.mesh.triangles.push(triangle);
        self.mesh.uvs.extend(uvs);
    }

    /// Without normals where faces are flat.
    fn finish(self) -> Mesh {
        let mut mesh = self.mesh;
        if mesh.normals.contains(&DVec3::ZERO) {
            mesh.normals = Vec::new();
        }
        mesh
    }
}

/// A sphere as a mesh with its own normals, in single precision as well.
fn sphere_mesh(center: DVec3, radius: f64) -> Mesh {
    let shape = Shape::Icosphere { center, radius, subdivisions: SPHERE_SUBDIVISIONS };
    let mut mesh = tessellate(&shape).ok().flatten().unwrap_or_default();
    mesh.positions.iter_mut().for_each(|position| *position = position.as_vec3().as_dvec3());
    mesh
}
