//! Scenes made in memory, and ways to ask them, shared by the whole-system tests.

pub mod exr_bytes;
pub mod meshes;
pub mod parts;
pub mod random_scene;
pub mod touch;
pub mod truth;

use std::path::Path;

use iorect::formats;
use iorect::geometry::Mesh;
use iorect::render::Film;
use iorect::report::stability::scenes;
pub use iorect::report::stability::scenes::{
    Numbers, add, deflection_degrees, empty, icosphere, interfaces, layers, mean, mesh_shape, nest, sphere, through,
};
use iorect::scene::description::{Description, Shape};
use iorect::tracking::Mode;
use iorect::tracking::Prepared;

pub fn ready(description: Description) -> Prepared {
    scenes::ready(description).expect("the scene is fine")
}

/// Renders and returns the film.
pub fn render(prepared: &Prepared, mode: Mode, size: (u32, u32), spp: u32, max_depth: Option<u32>) -> Film {
    scenes::render(prepared, mode, size, spp, 1, max_depth).expect("the camera is fine")
}

/// A scene of `tests/data/cases`.
pub fn case(path: &str) -> Description {
    formats::file(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cases").join(path)).unwrap()
}

/// The triangles of a shape that has some, without normals.
pub fn mesh_of(shape: &Shape) -> Mesh {
    scenes::mesh_of(shape).unwrap()
}

/// Several meshes as one.
pub fn joined(meshes: impl IntoIterator<Item = Mesh>) -> Mesh {
    let mut all = Mesh::default();
    for mesh in meshes {
        let first = all.positions.len() as u32;
        all.positions.extend(mesh.positions);
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|i| i + first)));
    }
    all
}

pub fn reversed(mut mesh: Mesh) -> Mesh {
    mesh.reverse();
    mesh
}
