//! Arrays of NumPy, in and out.

use bytemuck::{NoUninit, Pod, pod_collect_to_vec};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

/// Rows of three numbers, from anything that NumPy makes an array of that shape of. `what` names it in errors.
pub fn rows_of_three<T: Pod>(given: &Bound<'_, PyAny>, kind: &str, what: &str) -> PyResult<Vec<[T; 3]>> {
    let py = given.py();
    let numpy = py.import("numpy")?;
    let array = numpy.call_method1("asarray", (given,))?;
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    if !matches!(shape[..], [_, 3]) && shape != [0] {
        return Err(PyValueError::new_err(format!("{what} have the shape {shape:?}, must be (count, 3)")));
    }
    let keywords = PyDict::new(py);
    keywords.set_item("dtype", kind)?;
    let array = numpy.call_method("ascontiguousarray", (array,), Some(&keywords))?;
    let bytes = array.call_method0("tobytes")?;
    Ok(pod_collect_to_vec(bytes.cast::<PyBytes>()?.as_bytes()))
}

/// An array of NumPy with a copy of `values`, `width` to a row; one row of all where `width` is 0.
pub fn array<'py, T: NoUninit>(py: Python<'py>, values: &[T], kind: &str, width: usize) -> PyResult<Bound<'py, PyAny>> {
    let numpy = py.import("numpy")?;
    let bytes = PyBytes::new(py, bytemuck::cast_slice(values));
    let array = numpy.call_method1("frombuffer", (bytes, kind))?.call_method0("copy")?;
    if width == 0 { Ok(array) } else { array.call_method1("reshape", ((-1, width),)) }
}
