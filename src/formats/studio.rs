//! A scene around a mesh that comes alone: the mesh in glass on a floor, lit from above.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use crate::geometry::Mesh;
use crate::optics::{Ior, Medium, catalog};
use crate::scene::description::{
    CameraDescription, Environment, Light, MeshPart, Object, Objects, Paint, Refractor, Shape, Solid, WorldMedium,
};
use crate::scene::{Description, LoadNote, SceneError};

/// Where the camera looks from, as the mesh sees it.
const VIEW: DVec3 = DVec3::new(0.55, 0.5, 1.0);
const VERTICAL_FOV: f64 = 34.0;

/// The scene around the mesh of a file. All lengths are in proportion to the mesh.
///
/// # Errors
/// When the mesh has no extent.
pub(super) fn around(path: &Path, mesh: Mesh, notes: Vec<LoadNote>) -> Result<Description, SceneError> {
    let used = || mesh.triangles.iter().flatten().map(|&corner| mesh.positions[corner as usize]);
    let (min, max) = used().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)));
    let (center, radius) = ((min + max) / 2.0, (max - min).length() / 2.0);
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(SceneError::in_file(path, "the mesh has no extent"));
    }
    let stem = path.file_stem().map_or_else(|| "mesh".into(), |stem| stem.to_string_lossy().into_owned());
    // Saved elsewhere, the scene must still find its mesh.
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let is_smooth = !mesh.normals.is_empty();
    let glass = catalog::find("glass").map_or(Ior::Constant(1.5), Ior::Catalog);
    // Not flush with it: what touches the floor is in optical contact.
    let floor = center.with_y(min.y - 1e-3 * radius);
    let quad = |center: DVec3, edge_u: DVec3, edge_v: DVec3| Shape::Quad { center, edge_u, edge_v };
    let mut objects = Objects::default();
    let shape = Shape::Mesh { path, part: MeshPart::default(), mesh: Arc::new(mesh), notes };
    objects.push(Object::new(stem.clone(), shape, Refractor { smooth: is_smooth, ..Refractor::of("glass") }));
    let checker = Paint::Checker { a: [0.42; 3], b: [0.3; 3], size: 0.5 * radius };
    let reach = 40.0 * radius;
    let name = |name: &str| if name == stem { format!("{name} 2") } else { name.to_owned() };
    objects.push(Object::new(name("floor"), quad(floor, DVec3::Z * reach, DVec3::X * reach), Solid::of(checker)));
    let softbox = center + DVec3::new(-1.6, 2.6, 1.2) * radius;
    let away = (softbox - center).normalize();
    let across = DVec3::Y.cross(away).normalize();
    let sheet = quad(softbox, away.cross(across) * 1.6 * radius, across * 2.2 * radius);
    objects.push(Object::new(name("softbox"), sheet, Light::of_radiance([8.0, 7.7, 7.2])));
    let distance = 1.1 * radius / (VERTICAL_FOV.to_radians() / 2.0).sin();
    Ok(Description {
        name: stem,
        camera: CameraDescription {
            position: center + VIEW.normalize() * distance,
            target: center,
            up: DVec3::Y,
            vertical_fov: VERTICAL_FOV,
            aperture_radius: 0.0,
            focus_distance: None,
        },
        world: WorldMedium { ior: Ior::Constant(1.0), absorption: [0.0; 3] },
        environment: Environment::Gradient { zenith: [0.5, 0.54, 0.6], horizon: [0.22, 0.23, 0.25], nadir: [0.1; 3] },
        media: vec![Medium { name: "glass".into(), ior: glass, absorption: [0.0; 3] }],
        objects,
        source: None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::compile::compile;
    use crate::scene::shapes::tessellate;

    /// Whatever its size and place, the mesh is in the middle of the picture, and its light faces it.
    #[test]
    fn any_mesh_is_framed() {
        for (scale, offset) in [(1e-6, 0.0), (1.0, 100.0), (1e6, -1e7)] {
            let center = DVec3::splat(offset);
            let shape = Shape::Box { min: center - scale, max: center + DVec3::new(1.0, 3.0, 0.2) * scale };
            let mesh = tessellate(&shape).unwrap().unwrap();
            let scene = around(Path::new("a/floor.stl"), mesh, Vec::new()).unwrap();
            let names: Vec<&str> = scene.objects.iter().map(|object| object.name.as_str()).collect();
            assert_eq!((scene.name.as_str(), names.len()), ("floor", 3));
            assert!(names.contains(&"floor 2"), "{names:?}");
            let compiled = compile(&scene, None).unwrap();
            assert_eq!(compiled.refractors().count(), 1);
            let light = &scene.objects.of(crate::scene::description::Kind::Light)[0];
            let Shape::Quad { center, edge_u, edge_v } = light.shape else { panic!("a sheet") };
            assert!(edge_u.cross(edge_v).dot(scene.camera.target - center) > 0.0);
        }
        let flat = Mesh { positions: vec![DVec3::ONE; 3], normals: Vec::new(), triangles: vec![[0, 1, 2]] };
        assert!(around(Path::new("a.stl"), flat, Vec::new()).is_err());
    }
}
