//! IOR rectification for Python: arrays of vertices and faces in, the media on both sides of each face out.

mod arrays;
mod body;
mod rectified;

use std::sync::Arc;

use iorect_library::check::check;
use iorect_library::tracking::prepare;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::body::{Body, description_of};
use crate::rectified::{Faces, Piece, Rectified, Warning};

/// Finds the media on both sides of every face of closed or open meshes that lie in each other, overlap, touch or coincide.
///
/// `bodies` are the dielectrics, in an order that breaks ties between overlapping ones; `world_ior` is the index of what surrounds them all.
#[pyfunction]
#[pyo3(signature = (bodies, *, world_ior = 1.0))]
fn rectify(py: Python<'_>, bodies: Vec<PyRef<'_, Body>>, world_ior: f64) -> PyResult<Rectified> {
    let bodies: Vec<Body> = bodies.iter().map(|body| (**body).clone()).collect();
    let description = Arc::new(description_of(&bodies, world_ior)?);
    let found = py.detach(|| {
        let prepared = prepare(Arc::clone(&description), None)?;
        let problems = check(&prepared);
        Ok::<_, iorect_library::scene::SceneError>((prepared, problems))
    });
    let (prepared, problems) = found.map_err(|error| PyValueError::new_err(error.to_string()))?;
    Ok(Rectified::new(prepared, bodies, problems))
}

#[pymodule]
fn iorect(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<Body>()?;
    module.add_class::<Rectified>()?;
    module.add_class::<Faces>()?;
    module.add_class::<Piece>()?;
    module.add_class::<Warning>()?;
    module.add_function(wrap_pyfunction!(rectify, module)?)
}
