//! What was found.

use std::collections::HashMap;

use iorect_library::check::{Problem, Severity};
use iorect_library::export::resolved::pieces::interfaces;
use iorect_library::geometry::PrimitiveId;
use iorect_library::rectify::containment::medium_at;
use iorect_library::rectify::subjects::primitives_of;
use iorect_library::scene::{MediumId, ObjectId};
use iorect_library::tracking::Prepared;
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;

use crate::arrays::array;
use crate::body::Body;

/// No medium, where the number of one is asked for: the face is no interface.
const NONE: i32 = -1;

/// Something doubtful, or worth knowing.
#[pyclass(frozen, get_all, module = "iorect")]
#[derive(Clone)]
pub struct Warning {
    /// "error", "warning" or "advice".
    severity: &'static str,
    /// A stable word for the kind.
    kind: &'static str,
    /// The bodies or media concerned, by name, with commas between them.
    place: String,
    message: String,
}

#[pymethods]
impl Warning {
    fn __repr__(&self) -> String {
        format!("Warning({}, {}, {:?}: {})", self.severity, self.kind, self.place, self.message)
    }
}

impl Warning {
    fn of(problem: Problem) -> Self {
        let severity = match problem.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Advice => "advice",
        };
        Self { severity, kind: problem.kind, place: problem.place, message: problem.message }
    }
}

/// The faces of one body, in the order in which they were given. Media are numbers in `Rectified.media`; −1 where a face is no interface: it has no area, or
/// a coincident one stands for it.
#[pyclass(frozen, module = "iorect")]
pub struct Faces {
    outside: Vec<i32>,
    inside: Vec<i32>,
    confidence: Vec<f32>,
    patch: Vec<i32>,
    mixed: Vec<u8>,
}

#[pymethods]
impl Faces {
    /// The medium outside of each face, int32; of a mixed one that in its middle.
    #[getter]
    fn outside<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, &self.outside, "int32", 0)
    }

    /// The medium inside of each face, int32.
    #[getter]
    fn inside<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, &self.inside, "int32", 0)
    }

    /// How sure that is, from 0.5 to 1, float32: the share of the rays that agreed.
    #[getter]
    fn confidence<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, &self.confidence, "float32", 0)
    }

    /// The patch of each face, int32: parts of the surface with the same surroundings everywhere.
    #[getter]
    fn patch<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, &self.patch, "int32", 0)
    }

    /// Whether other surfaces cross a face, so that its media differ from place to place, bool. `Rectified.pieces()` cuts such faces.
    #[getter]
    fn mixed<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, &self.mixed, "bool", 0)
    }

    fn __len__(&self) -> usize {
        self.outside.len()
    }
}

/// A part of a body's surface with one medium on each side.
#[pyclass(frozen, module = "iorect")]
pub struct Piece {
    /// The body.
    #[pyo3(get)]
    name: String,
    /// Numbers of media, as in `Rectified.media`.
    #[pyo3(get)]
    outside: u32,
    #[pyo3(get)]
    inside: u32,
    vertices: Vec<f64>,
    faces: Vec<u32>,
}

#[pymethods]
impl Piece {
    /// (count, 3), float64.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, &self.vertices, "float64", 3)
    }

    /// (count, 3), uint32: counter-clockwise seen from outside.
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        array(py, &self.faces, "uint32", 3)
    }
}

/// The media on both sides of every face of some bodies.
#[pyclass(frozen, module = "iorect")]
pub struct Rectified {
    prepared: Prepared,
    bodies: Vec<Body>,
    warnings: Vec<Warning>,
}

#[pymethods]
impl Rectified {
    /// Names of the media. The first is "world", the second, "vacuum", occurs nowhere.
    #[getter]
    fn media(&self) -> Vec<String> {
        self.prepared.scene.media.iter().map(|medium| medium.name.clone()).collect()
    }

    /// Indices of refraction of the media, float64.
    #[getter]
    fn iors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let iors: Vec<f64> = self.prepared.scene.media.iter().map(|medium| medium.ior()).collect();
        array(py, &iors, "float64", 0)
    }

    /// What is doubtful, worst first: `Warning`s.
    #[getter]
    fn warnings(&self) -> Vec<Warning> {
        self.warnings.clone()
    }

    /// Names of the bodies.
    #[getter]
    fn bodies(&self) -> Vec<String> {
        self.bodies.iter().map(|body| body.name.clone()).collect()
    }

    /// The faces of the body of that name.
    fn __getitem__(&self, name: &str) -> PyResult<Faces> {
        let index = self.bodies.iter().position(|body| body.name == name);
        let index = index.ok_or_else(|| PyKeyError::new_err(format!("there is no body `{name}`")))?;
        Ok(self.faces_of(index))
    }

    /// All surfaces cut so that each piece has one medium on each side, as `Piece`s: what is no interface is left out, and pieces fit together.
    fn pieces(&self, py: Python<'_>) -> Vec<Piece> {
        let all = py.detach(|| interfaces(&self.prepared));
        (all.into_iter())
            .map(|interface| {
                let mesh = interface.piece.into_mesh();
                Piece {
                    name: self.bodies[interface.refractor.0 as usize].name.clone(),
                    outside: interface.outside.0,
                    inside: interface.inside.0,
                    vertices: mesh.positions.iter().flat_map(|position| position.to_array()).collect(),
                    faces: mesh.triangles.into_iter().flatten().collect(),
                }
            })
            .collect()
    }

    /// The number of the medium at a point, such as a camera's or a light's.
    fn medium_at(&self, point: [f64; 3]) -> PyResult<u32> {
        let point = glam::DVec3::from(point);
        if !point.is_finite() {
            return Err(PyValueError::new_err("the point is not finite"));
        }
        let scene = &self.prepared.scene;
        Ok(medium_at(scene, point - scene.geometry.origin).0.0)
    }

    fn __repr__(&self) -> String {
        format!("Rectified({} bodies, {} warnings)", self.bodies.len(), self.warnings.len())
    }
}

impl Rectified {
    pub fn new(prepared: Prepared, bodies: Vec<Body>, problems: Vec<Problem>) -> Self {
        // There is neither a camera nor a light.
        let is_told = |problem: &Problem| problem.place != "camera" && problem.kind != "no_light";
        let warnings = problems.into_iter().filter(is_told).map(Warning::of).collect();
        Self { prepared, bodies, warnings }
    }

    fn faces_of(&self, index: usize) -> Faces {
        let (scene, geometry, table) = (&*self.prepared.scene, &*self.prepared.scene.geometry, &*self.prepared.table);
        let refractor = ObjectId(index as u32);
        let primitives = primitives_of(geometry, refractor);
        let mesh = &self.bodies[index].mesh;
        let topology = scene.object(refractor).topology.as_ref();
        // A mesh that was repaired has other faces, over the same corners.
        let of_face: Vec<Option<PrimitiveId>> = match topology.and_then(|topology| topology.repaired.as_ref()) {
            None => (0..mesh.triangles.len()).map(|face| Some(primitives.start + face as u32)).collect(),
            Some(repaired) => {
                let by_corners: HashMap<_, _> = (repaired.triangles.iter().zip(primitives.clone()))
                    .map(|(triangle, primitive)| (corners_of(repaired, triangle), primitive))
                    .collect();
                mesh.triangles.iter().map(|triangle| by_corners.get(&corners_of(mesh, triangle)).copied()).collect()
            }
        };
        let mut faces = Faces {
            outside: Vec::new(),
            inside: Vec::new(),
            confidence: Vec::new(),
            patch: Vec::new(),
            mixed: Vec::new(),
        };
        let number = |medium: MediumId| medium.0 as i32;
        for primitive in of_face {
            let sides = primitive.and_then(|primitive| table.sides_of(scene, primitive));
            let patch = primitive.and_then(|primitive| table.patch_of(geometry, primitive));
            faces.outside.push(sides.map_or(NONE, |sides| number(sides.outside)));
            faces.inside.push(sides.map_or(NONE, |sides| number(sides.inside)));
            faces.confidence.push(patch.map_or(1.0, |patch| patch.confidence as f32));
            faces.patch.push(patch.map_or(NONE, |patch| patch.index as i32));
            faces.mixed.push(u8::from(primitive.is_some_and(|primitive| table.is_mixed(refractor, primitive))));
        }
        faces
    }
}

/// The places of a triangle's corners, whichever way it looks.
fn corners_of(mesh: &iorect_library::geometry::Mesh, triangle: &[u32; 3]) -> [[u64; 3]; 3] {
    let mut corners = triangle.map(|k| (mesh.positions[k as usize] + 0.0).to_array().map(f64::to_bits));
    corners.sort_unstable();
    corners
}
