//! Scenes made in memory, and ways to ask them, shared by the whole-system tests.

pub mod exr_bytes;
pub mod meshes;
pub mod parts;
pub mod random_scene;
pub mod touch;
pub mod truth;

use std::path::Path;

use glam::DVec3;
use iorect::formats;
use iorect::geometry::Mesh;
use iorect::render::{Estimator, Film};
use iorect::report::stability::scenes;
pub use iorect::report::stability::scenes::{
    Numbers, add, deflection_degrees, empty, icosphere, interfaces, layers, mean, mesh_shape, nest, sphere, through,
};
use iorect::scene::description::{Description, Environment, Object, Paint, Shape, Solid};
use iorect::tracking::Mode;
use iorect::tracking::Prepared;

pub fn ready(description: Description) -> Prepared {
    scenes::ready(description).expect("the scene is fine")
}

/// Renders and returns the film.
pub fn render(prepared: &Prepared, mode: Mode, size: (u32, u32), spp: u32, max_depth: Option<u32>) -> Film {
    scenes::render(prepared, mode, size, spp, 1, max_depth).expect("the camera is fine")
}

/// The same in mode rectified by an estimator.
pub fn render_by(
    prepared: &Prepared,
    estimator: Estimator,
    size: (u32, u32),
    spp: u32,
    max_depth: Option<u32>,
) -> Film {
    scenes::render_by(prepared, estimator, Mode::Rectified, size, spp, 1, max_depth).expect("the camera is fine")
}

/// All estimators, and the part by which each may be biased in images of few samples.
pub const ESTIMATORS: [(Estimator, f64); 3] =
    [(Estimator::Path, 0.0), (Estimator::Bidirectional, 0.0), (Estimator::Merging, 0.01)];

/// Of what is grey.
pub const ALBEDO: f64 = 0.6;

/// A wide grey floor in the dark, seen at the origin from above.
pub fn floor() -> Description {
    let mut description = empty(1.0);
    description.environment = Environment::Color([0.0; 3]);
    description.objects.push(Object::new(
        "floor",
        Shape::Quad { center: DVec3::ZERO, edge_u: DVec3::Z * 200.0, edge_v: DVec3::X * 200.0 },
        Solid::of(Paint::Color([ALBEDO; 3])),
    ));
    description.camera.position = DVec3::new(3.0, 4.0, 0.0);
    description.camera.vertical_fov = 1e-6;
    description
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
