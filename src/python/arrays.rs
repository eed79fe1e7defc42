//! Arrays for `NumPy`: they own the buffers of the library, and are read-only.

use numpy::{Element, IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use septet_doors::NONE;

/// From this number of points or simplices on, indices have 64 bits.
const WIDE: usize = 1 << 31;

/// Number of sides of a box in space, which ridges name by negative numbers.
const SIDES: u32 = 6;

/// An array of Python.
pub type Array = Py<PyAny>;

/// The width of the indices of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// int32.
    Narrow,
    /// int64.
    Wide,
}

impl Width {
    /// Returns the width for numbers of points and simplices.
    pub fn of(points: usize, simplices: usize) -> Self {
        if points.max(simplices) < WIDE { Width::Narrow } else { Width::Wide }
    }

    /// Returns indices as an array of one dimension.
    pub fn list(self, py: Python<'_>, ids: Vec<u32>) -> PyResult<Array> {
        match self {
            Width::Narrow => list(py, narrow(ids)),
            Width::Wide => list(py, wide(&ids)),
        }
    }

    /// Returns indices as rows.
    pub fn rows(self, py: Python<'_>, ids: Vec<u32>, columns: usize) -> PyResult<Array> {
        match self {
            Width::Narrow => rows(py, narrow(ids), columns),
            Width::Wide => rows(py, wide(&ids), columns),
        }
    }
}

/// Reads indices as signed numbers, without a copy. None becomes -1.
fn narrow(ids: Vec<u32>) -> Vec<i32> {
    bytemuck::allocation::cast_vec(ids)
}

fn wide(ids: &[u32]) -> Vec<i64> {
    // The last numbers are none and the sides of a box.
    let signed = |id: u32| if id > NONE - SIDES { i64::from(id.cast_signed()) } else { i64::from(id) };
    ids.iter().map(|&id| signed(id)).collect()
}

/// Returns an array of one dimension that owns a buffer.
pub fn list<T: Element>(py: Python<'_>, values: Vec<T>) -> PyResult<Array> {
    Ok(frozen(py, values)?.into_any().unbind())
}

/// Returns rows that own a buffer.
pub fn rows<T: Element>(py: Python<'_>, values: Vec<T>, columns: usize) -> PyResult<Array> {
    let count = values.len() / columns;
    Ok(frozen(py, values)?.reshape([count, columns])?.into_any().unbind())
}

/// Returns an array of three dimensions that owns a buffer.
pub fn blocks<T: Element>(py: Python<'_>, values: Vec<T>, shape: [usize; 2]) -> PyResult<Array> {
    let count = values.len() / (shape[0] * shape[1]);
    Ok(frozen(py, values)?.reshape([count, shape[0], shape[1]])?.into_any().unbind())
}

/// Returns positions as int64.
pub fn offsets(py: Python<'_>, offsets: Vec<u64>) -> PyResult<Array> {
    list(py, bytemuck::allocation::cast_vec::<u64, i64>(offsets))
}

/// Returns a read-only array. Its memory belongs to a capsule, so that `NumPy` does not make it or its views writable again.
fn frozen<T: Element>(py: Python<'_>, values: Vec<T>) -> PyResult<Bound<'_, PyArray1<T>>> {
    let array = values.into_pyarray(py);
    array.getattr("flags")?.setattr("writeable", false)?;
    Ok(array)
}

/// Returns the numbers of an array of rows.
pub fn flat<'a>(array: &'a PyReadonlyArray2<'_, f64>) -> PyResult<&'a [f64]> {
    array
        .as_slice()
        .map_err(|_| PyValueError::new_err("an array must be C-contiguous; use numpy.ascontiguousarray"))
}
