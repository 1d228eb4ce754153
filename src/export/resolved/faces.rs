//! The scene as tables, for renderers of one's own: each refractor's faces with the media on both of their sides.

use serde::Serialize;

use super::files::Bundle;
use super::pieces::Piece;
use super::scene::ResolvedScene;
use crate::formats::{PlyExtra, ply_bytes};
use crate::geometry::Mesh;
use crate::scene::ObjectId;

/// What `faces.json` holds.
#[derive(Serialize)]
struct Table<'a> {
    scene: &'a str,
    /// A face's `outside` and `inside` are indices into this list. The first is the global medium.
    media: Vec<Medium<'a>>,
    /// Number in `media` of the medium that the camera is in.
    camera: u32,
    refractors: Vec<Refractor<'a>>,
    lights: Vec<Surroundings<'a>>,
    notes: &'a [String],
}

#[derive(Serialize)]
struct Medium<'a> {
    name: &'a str,
    /// At 587.56 nm.
    ior: f64,
    /// σ per scene unit, in linear RGB.
    absorption: [f64; 3],
}

#[derive(Serialize)]
struct Refractor<'a> {
    name: &'a str,
    /// A PLY file whose faces have the properties `outside` and `inside`; none where the refractor has no interface anywhere.
    file: Option<String>,
    faces: usize,
}

#[derive(Serialize)]
struct Surroundings<'a> {
    name: &'a str,
    outside: u32,
}

pub fn write(resolved: &ResolvedScene) -> Bundle {
    let scene = resolved.scene();
    let mut files = Bundle::new(resolved.notes.clone());
    let refractors = (scene.refractors())
        .map(|(refractor, _)| {
            let (mesh, outside, inside) = of_refractor(resolved, refractor);
            let faces = mesh.triangles.len();
            let file = (faces > 0).then(|| format!("{}.ply", resolved.name(refractor)));
            if let Some(file) = &file {
                let of_faces = [("outside", outside), ("inside", inside)];
                files.add(file, ply_bytes(&mesh, PlyExtra { of_faces: &of_faces, ..PlyExtra::default() }));
            }
            Refractor { name: &scene.object(refractor).name, file, faces }
        })
        .collect();
    let media = scene.media.iter().map(|medium| Medium {
        name: &medium.name,
        ior: medium.ior(),
        absorption: medium.absorption.to_rgb(),
    });
    let is_light = |id: &ObjectId| resolved.emission(*id).is_some();
    let lights = (0..scene.objects.len() as u32).map(ObjectId).filter(is_light);
    let table = Table {
        scene: &resolved.description().name,
        media: media.collect(),
        camera: resolved.camera_medium.0,
        refractors,
        lights: lights
            .map(|id| Surroundings { name: &scene.object(id).name, outside: resolved.medium_around(id).0 })
            .collect(),
        notes: &resolved.notes,
    };
    // Numbers and texts only: this does not fail.
    let text = serde_json::to_string_pretty(&table).unwrap_or_default();
    files.add_main("faces.json", (text + "\n").into_bytes());
    files
}

/// All pieces of a refractor's surface in one mesh, with the media on both sides of each face.
fn of_refractor(resolved: &ResolvedScene, refractor: ObjectId) -> (Mesh, Vec<i32>, Vec<i32>) {
    let (mut all, mut outside, mut inside) = (Mesh::default(), Vec::new(), Vec::new());
    let pieces = resolved.interfaces.iter().filter(|interface| interface.refractor == refractor);
    for interface in pieces {
        let mesh = Piece::clone(&interface.piece).into_mesh();
        let first = all.positions.len() as u32;
        outside.resize(outside.len() + mesh.triangles.len(), interface.outside.0 as i32);
        inside.resize(inside.len() + mesh.triangles.len(), interface.inside.0 as i32);
        all.positions.extend(mesh.positions);
        all.normals.extend(mesh.normals);
        all.triangles.extend(mesh.triangles.iter().map(|triangle| triangle.map(|corner| corner + first)));
    }
    (all, outside, inside)
}
