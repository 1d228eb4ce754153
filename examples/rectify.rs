//! Meshes and IORs in, the media on both sides of every face out: `cargo run --example rectify`.

#![expect(clippy::print_stdout, reason = "what it prints is what it is for")]

use std::sync::Arc;

use glam::DVec3;
use iorect::geometry::Mesh;
use iorect::optics::{Ior, Medium};
use iorect::rectify::subjects::primitives_of;
use iorect::scene::description::{
    CameraDescription, Description, Environment, Object, Objects, Refractor, Shape, WorldMedium,
};
use iorect::scene::{MediumId, SceneError};
use iorect::tracking::prepare;

/// One face: the object, the face's middle, and each side's medium with its IOR.
pub type Face = (String, DVec3, [(String, f64); 2]);

fn main() -> Result<(), SceneError> {
    // Ice floats half out of the water, with a bubble in it. Each is closed and gives the IOR of its own inside.
    let meshes = [
        ("water", cuboid(DVec3::ZERO, DVec3::splat(1.0)), 1.33),
        ("ice", cuboid(DVec3::Y, DVec3::splat(0.5)), 1.31),
        ("air", cuboid(DVec3::Y * 1.2, DVec3::splat(0.1)), 1.0),
    ];
    for (object, middle, [(outside, outside_ior), (inside, inside_ior)]) in sides(1.0, meshes)? {
        println!("{object:5} at {middle:6.3}: outside {outside} {outside_ior}, inside {inside} {inside_ior}");
    }
    Ok(())
}

/// The sides of every face of `meshes` (name, mesh, IOR inside) in a world of IOR `world`. Of coincident faces one stands for both.
///
/// # Errors
/// When a mesh or an IOR is impossible.
pub fn sides<'a>(world: f64, meshes: impl IntoIterator<Item = (&'a str, Mesh, f64)>) -> Result<Vec<Face>, SceneError> {
    let mut description = empty(world);
    for (name, mesh, ior) in meshes {
        description.media.push(Medium { name: name.into(), ior: Ior::Constant(ior), absorption: [0.0; 3] });
        let shape = Shape::mesh(name, Arc::new(mesh));
        description.objects.push(Object::new(name, shape, Refractor::of(name)));
    }
    let prepared = &prepare(Arc::new(description), None)?;
    let (scene, geometry) = (&*prepared.scene, &*prepared.scene.geometry);
    let medium = |id: MediumId| (scene.medium(id).name.clone(), scene.medium(id).ior());
    let faces = scene.refractors().flat_map(|(object, _)| {
        primitives_of(geometry, object).filter_map(move |face| {
            let sides = prepared.table.sides_of(scene, face)?;
            let middle = geometry.origin + geometry.corners(face).iter().sum::<DVec3>() / 3.0;
            Some((scene.object(object).name.clone(), middle, [medium(sides.outside), medium(sides.inside)]))
        })
    });
    Ok(faces.collect())
}

fn empty(world: f64) -> Description {
    Description {
        name: "in memory".into(),
        camera: CameraDescription::blank(),
        camera_medium: None,
        world: WorldMedium { ior: Ior::Constant(world), absorption: [0.0; 3] },
        environment: Environment::Color([1.0; 3]),
        media: Vec::new(),
        objects: Objects::default(),
        source: None,
    }
}

/// Twelve triangles, counter-clockwise seen from outside.
pub fn cuboid(center: DVec3, half: DVec3) -> Mesh {
    let sign = |bit: usize| if bit == 1 { 1.0 } else { -1.0 };
    let corner = |i: usize| center + half * DVec3::new(sign(i & 1), sign(i >> 1 & 1), sign(i >> 2 & 1));
    let squares = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    Mesh {
        positions: (0..8).map(corner).collect(),
        triangles: squares.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        ..Mesh::default()
    }
}
