//! Dielectrics as they are given.

use std::sync::Arc;

use glam::DVec3;
use iorect_library::geometry::Mesh;
use iorect_library::optics::{Ior, Medium};
use iorect_library::scene::Description;
use iorect_library::scene::description::{
    CameraDescription, Environment, Object, Objects, Refractor, Shape, WorldMedium,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::rows_of_three;

/// A dielectric: a triangle mesh, faces counter-clockwise seen from outside, and the index of refraction of its inside.
///
/// Body(name, vertices, faces, ior, *, medium=None, priority=0, outside=None)
///
/// `vertices` is an array of (count, 3) coordinates, `faces` one of (count, 3) indices into it. Bodies with the same `medium` are of one medium, which by
/// default is called as the body. Where volumes overlap, the higher priority wins. `outside` is the medium that the author believes to be outside, or
/// "world": a warning says where it is another.
#[pyclass(frozen, module = "iorect")]
#[derive(Clone)]
pub struct Body {
    #[pyo3(get)]
    pub name: String,
    #[pyo3(get)]
    pub ior: f64,
    #[pyo3(get)]
    pub medium: String,
    #[pyo3(get)]
    pub priority: i32,
    #[pyo3(get)]
    pub outside: Option<String>,
    pub mesh: Arc<Mesh>,
}

#[pymethods]
impl Body {
    #[new]
    #[pyo3(signature = (name, vertices, faces, ior, *, medium = None, priority = 0, outside = None))]
    fn new(
        name: String,
        vertices: &Bound<'_, PyAny>,
        faces: &Bound<'_, PyAny>,
        ior: f64,
        medium: Option<String>,
        priority: i32,
        outside: Option<String>,
    ) -> PyResult<Self> {
        let fault = |what: String| PyValueError::new_err(format!("`{name}`: {what}"));
        let positions: Vec<DVec3> =
            rows_of_three::<f64>(vertices, "float64", "vertices")?.into_iter().map(DVec3::from).collect();
        if let Some(index) = positions.iter().position(|position| !position.is_finite()) {
            return Err(fault(format!("vertex {index} is not finite")));
        }
        let mut triangles = Vec::new();
        for (face, corners) in rows_of_three::<i64>(faces, "int64", "faces")?.into_iter().enumerate() {
            match corners.iter().find(|corner| **corner < 0 || **corner >= positions.len() as i64) {
                Some(corner) => {
                    let count = positions.len();
                    return Err(fault(format!("face {face} names vertex {corner}, there are {count}")));
                }
                None => triangles.push(corners.map(|corner| corner as u32)),
            }
        }
        let mesh = Arc::new(Mesh { positions, normals: Vec::new(), triangles, uvs: Vec::new() });
        let medium = medium.unwrap_or_else(|| name.clone());
        Ok(Self { name, ior, medium, priority, outside, mesh })
    }

    fn __repr__(&self) -> String {
        format!(
            "Body({:?}, {} faces, ior={}, medium={:?})",
            self.name,
            self.mesh.triangles.len(),
            self.ior,
            self.medium
        )
    }
}

/// The scene that bodies make.
pub fn description_of(bodies: &[Body], world_ior: f64) -> PyResult<Description> {
    let mut media: Vec<Medium> = Vec::new();
    let mut objects = Objects::default();
    for (index, body) in bodies.iter().enumerate() {
        if bodies[..index].iter().any(|earlier| earlier.name == body.name) {
            return Err(PyValueError::new_err(format!("two bodies are called `{}`", body.name)));
        }
        if body.medium == "world" || body.medium == "vacuum" {
            return Err(PyValueError::new_err(format!("`{}`: `{}` is no name for a medium", body.name, body.medium)));
        }
        match media.iter().find(|medium| medium.name == body.medium) {
            Some(known) if known.ior != Ior::Constant(body.ior) => {
                let message = format!("`{}`: the medium `{}` has two indices of refraction", body.name, body.medium);
                return Err(PyValueError::new_err(message));
            }
            Some(_) => {}
            None => {
                media.push(Medium { name: body.medium.clone(), ior: Ior::Constant(body.ior), absorption: [0.0; 3] })
            }
        }
        let shape = Shape::mesh(format!("{}.ply", body.name), Arc::clone(&body.mesh));
        let mut refractor = Refractor::of(body.medium.clone());
        (refractor.priority, refractor.outside) = (body.priority, body.outside.clone());
        objects.push(Object::new(body.name.clone(), shape, refractor));
    }
    let named = |name: &String| name == "world" || media.iter().any(|medium| medium.name == *name);
    if let Some(body) = bodies.iter().find(|body| body.outside.as_ref().is_some_and(|outside| !named(outside))) {
        let outside = body.outside.as_deref().unwrap_or_default();
        return Err(PyValueError::new_err(format!("`{}`: there is no medium `{outside}`", body.name)));
    }
    Ok(Description {
        name: "bodies".into(),
        camera: CameraDescription {
            // Beyond everything, where nobody asks.
            position: DVec3::new(0.0, 0.0, 1.0),
            target: DVec3::ZERO,
            up: DVec3::Y,
            vertical_fov: 40.0,
            aperture_radius: 0.0,
            focus_distance: None,
        },
        camera_medium: None,
        world: WorldMedium { ior: Ior::Constant(world_ior), absorption: [0.0; 3] },
        environment: Environment::Color([1.0; 3]),
        media,
        objects,
        source: None,
    })
}
