//! NumPy arrays in and out, and the poses and meshes that they hold.

use crate::errors::value_error;
use numpy::ndarray::{ArrayView1, Dimension, Ix2, Ix3};
use numpy::{
    Element, PyArray, PyArray1, PyArray2, PyArray3, PyArrayDescrMethods, PyArrayMethods,
    PyUntypedArray, PyUntypedArrayMethods,
};
use punctual::{Mesh, MeshError, Pose};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

/// Anything that NumPy makes an array of.
fn as_array<'py>(given: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyUntypedArray>> {
    static AS_ARRAY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let py = given.py();
    Ok(AS_ARRAY
        .import(py, "numpy", "asarray")?
        .call1((given,))?
        .cast_into()?)
}

/// An array with elements of this type and this many dimensions, converted if it has others of a kind that is fine.
fn converted<'py, T: Element, D: Dimension>(
    array: &Bound<'py, PyUntypedArray>,
    what: &str,
    kinds: &[u8],
    shape: &str,
) -> PyResult<Bound<'py, PyArray<T, D>>> {
    if !kinds.contains(&array.dtype().kind()) {
        let expected = if kinds.contains(&b'f') {
            "real numbers"
        } else {
            "integers"
        };
        return Err(PyTypeError::new_err(format!(
            "{what}: dtype {}, expected {expected}",
            array.dtype()
        )));
    }
    let converted = array.call_method1(
        "astype",
        (numpy::dtype::<T>(array.py()), "K", "unsafe", false, false),
    )?;
    let typed = converted.cast_into();
    typed.map_err(|_| {
        value_error(format_args!(
            "{what}: shape {:?}, expected {shape}",
            array.shape()
        ))
    })
}

/// Floats of any size and integers; of as many dimensions as `D` has.
fn floats<'py, D: Dimension>(
    given: &Bound<'py, PyAny>,
    what: &str,
    shape: &str,
) -> PyResult<Bound<'py, PyArray<f64, D>>> {
    match given.cast::<PyArray<f64, D>>() {
        Ok(array) => Ok(array.clone()),
        Err(_) => converted(&as_array(given)?, what, b"fiu", shape),
    }
}

/// The rows of an `(N, 3)` array.
fn rows<'py, T: Element, D: Copy>(
    array: &Bound<'py, PyArray2<T>>,
    what: &str,
    convert: impl Fn(ArrayView1<T>) -> D,
) -> PyResult<Vec<D>> {
    let py = array.py();
    let array = array.try_readonly()?;
    let array = array.as_array();
    if array.ncols() != 3 {
        return Err(value_error(format_args!(
            "{what}: shape {:?}, expected (N, 3)",
            array.shape()
        )));
    }
    each(py, array.rows().into_iter(), |_, row| Ok(convert(row)))
}

/// Rows that are converted between two looks whether the user cancels the call: some milliseconds.
const BETWEEN_LOOKS: usize = 1 << 18;

/// Converts rows, of which there may be millions.
pub fn each<R, D>(
    py: Python<'_>,
    rows: impl ExactSizeIterator<Item = R>,
    mut convert: impl FnMut(usize, R) -> PyResult<D>,
) -> PyResult<Vec<D>> {
    let mut converted = Vec::with_capacity(rows.len());
    for (at, row) in rows.enumerate() {
        if at % BETWEEN_LOOKS == BETWEEN_LOOKS - 1 {
            py.check_signals()?;
        }
        converted.push(convert(at, row)?);
    }
    Ok(converted)
}

/// Whether an array has no rows. It may be of any type: `numpy.asarray([])` has floats.
fn has_no_rows(array: &Bound<'_, PyUntypedArray>) -> bool {
    array.shape().first() == Some(&0)
}

/// Points or vectors, `(N, 3)`.
pub fn vectors(given: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<[f64; 3]>> {
    let array = as_array(given)?;
    if has_no_rows(&array) {
        return Ok(Vec::new());
    }
    rows(&floats(&array, what, "(N, 3)")?, what, |row| {
        [row[0], row[1], row[2]]
    })
}

/// Points or vectors, `(N, 3)`, or one for all, `(3,)`.
pub fn vectors_or_one(given: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<[f64; 3]>> {
    let array = as_array(given)?;
    if array.shape() == [3] {
        Ok(vec![numbers(&array, what)?])
    } else {
        vectors(&array, what)
    }
}

/// `N` numbers, such as a vector.
pub fn numbers<const N: usize>(given: &Bound<'_, PyAny>, what: &str) -> PyResult<[f64; N]> {
    let expected = format!("({N},)");
    let array: Bound<'_, PyArray1<f64>> = floats(given, what, &expected)?;
    let read: [Option<f64>; N] = core::array::from_fn(|at| array.get_owned(at));
    if array.len() != N || read.contains(&None) {
        return Err(value_error(format_args!(
            "{what}: shape {:?}, expected {expected}",
            array.shape()
        )));
    }
    Ok(read.map(Option::unwrap_or_default))
}

/// `N` numbers, if they are given.
pub fn numbers_if<const N: usize>(
    given: Option<&Bound<'_, PyAny>>,
    what: &str,
) -> PyResult<Option<[f64; N]>> {
    given.map(|given| numbers(given, what)).transpose()
}

/// Triangles of a mesh, `(N, 3)` integers of any type; checked against the number of vertices where they do not fit.
fn triangles(given: &Bound<'_, PyAny>, vertices: usize) -> PyResult<Vec<[u32; 3]>> {
    let array = as_array(given)?;
    if has_no_rows(&array) {
        return Ok(Vec::new());
    }
    let wide: Bound<'_, PyArray2<i64>> = converted(&array, "faces", b"iu", "(N, 3)")?;
    let wide = rows(&wide, "faces", |row| [row[0], row[1], row[2]])?;
    let narrow = |triangle: usize, corners: &[i64; 3]| {
        let mut narrow = [0; 3];
        for (corner, &index) in corners.iter().enumerate() {
            narrow[corner] = u32::try_from(index).map_err(|_| {
                value_error(format_args!(
                    "corner {corner} of triangle {triangle} is vertex {index}, but there are {vertices} vertices"
                ))
            })?;
        }
        Ok(narrow)
    };
    each(given.py(), wide.iter(), narrow)
}

/// The mesh of vertices and faces, checked.
pub fn mesh(given: &Bound<'_, PyAny>, faces: &Bound<'_, PyAny>) -> PyResult<Mesh> {
    let vertices = vectors(given, "vertices")?;
    let triangles = triangles(faces, vertices.len())?;
    Mesh::from_f64(vertices, triangles).map_err(value_error)
}

/// The point cloud of an array, checked.
pub fn cloud(given: &Bound<'_, PyAny>) -> PyResult<Mesh> {
    let mesh = match given.cast::<PyArray2<f32>>() {
        Ok(narrow) => Mesh::from_points(rows(narrow, "points", |row| [row[0], row[1], row[2]])?),
        Err(_) => Mesh::from_points_f64(vectors(given, "points")?),
    };
    mesh.map_err(point_of_mesh)
}

/// The error of a point, which is a vertex of the library.
pub fn point_of_mesh(error: MeshError) -> PyErr {
    value_error(error.to_string().replace("vertex", "point"))
}

/// The numbers of a matrix, row by row, and how many columns it has.
pub fn grid(given: &Bound<'_, PyAny>, what: &str) -> PyResult<(Vec<f64>, usize)> {
    let array = floats::<Ix2>(given, what, "(rows, columns)")?.try_readonly()?;
    let array = array.as_array();
    Ok((array.iter().copied().collect(), array.ncols()))
}

/// A `(4, 4)` matrix that brings coordinates of B into those of A.
#[derive(Clone, Copy)]
pub struct Transform(pub Pose);

impl Default for Transform {
    fn default() -> Self {
        Self(Pose::IDENTITY)
    }
}

impl<'py> FromPyObject<'_, 'py> for Transform {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let array = floats::<Ix2>(&given, "T", "(4, 4)")?;
        if array.shape() != [4, 4] {
            return Err(value_error(format_args!(
                "T: shape {:?}, expected (4, 4)",
                array.shape()
            )));
        }
        // Entry by entry: to borrow so small an array as a whole takes longer.
        let at = |row, column| array.get_owned([row, column]).unwrap_or(f64::NAN);
        pose(at)
            .map(Self)
            .map_err(|fault| value_error(format_args!("T: {fault}")))
    }
}

/// The pose of a `(4, 4)` matrix.
fn pose(at: impl Fn(usize, usize) -> f64) -> Result<Pose, String> {
    let last: [f64; 4] = core::array::from_fn(|column| at(3, column));
    if last != [0.0, 0.0, 0.0, 1.0] {
        return Err(format!("row 3 is {last:?}, expected [0, 0, 0, 1]"));
    }
    Pose::from_row_major(core::array::from_fn(|entry| at(entry / 4, entry % 4)))
        .map_err(|error| error.to_string())
}

/// Poses, `(N, 4, 4)`, or one, `(4, 4)`.
pub struct Transforms(pub Vec<Pose>);

impl<'py> FromPyObject<'_, 'py> for Transforms {
    type Error = PyErr;

    fn extract(given: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let array = as_array(&given)?;
        if has_no_rows(&array) {
            return Ok(Self(Vec::new()));
        }
        let rows = if array.ndim() == 2 {
            array.get_item(None::<()>)?.cast_into()?
        } else {
            array.clone()
        };
        let rows = floats::<Ix3>(&rows, "poses", "(N, 4, 4)")?.try_readonly()?;
        let view = rows.as_array();
        if view.shape()[1..] != [4, 4] {
            return Err(value_error(format_args!(
                "poses: shape {:?}, expected (N, 4, 4) or (4, 4)",
                array.shape()
            )));
        }
        let checked = each(given.py(), view.outer_iter(), |row, matrix| {
            let at = |row, column| matrix[[row, column]];
            pose(at).map_err(|fault| value_error(format_args!("pose {row}: {fault}")))
        });
        checked.map(Self)
    }
}

/// A column of numbers.
pub fn column<T: Element>(py: Python<'_>, numbers: Vec<T>) -> Bound<'_, PyArray1<T>> {
    PyArray1::from_vec(py, numbers)
}

/// Rows of `N` numbers each.
pub fn table<T: Element + Copy, const N: usize>(
    py: Python<'_>,
    rows: impl IntoIterator<Item = [T; N]>,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    let flat: Vec<T> = rows.into_iter().flatten().collect();
    let count = flat.len() / N;
    column(py, flat).reshape([count, N])
}

/// The `(4, 4)` matrix of a pose.
pub fn matrix<'py>(py: Python<'py>, pose: &Pose) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let m = pose.to_row_major();
    let rows = [0, 4, 8].map(|at| [m[at], m[at + 1], m[at + 2], m[at + 3]]);
    table(py, rows.into_iter().chain([[0.0, 0.0, 0.0, 1.0]]))
}

/// Blocks of `M` rows of three coordinates.
pub fn points<const M: usize>(
    py: Python<'_>,
    blocks: impl IntoIterator<Item = [[f64; 3]; M]>,
) -> PyResult<Bound<'_, PyArray3<f64>>> {
    let flat: Vec<f64> = blocks.into_iter().flatten().flatten().collect();
    let count = flat.len() / (3 * M);
    column(py, flat).reshape([count, M, 3])
}

/// Arrays to and from bytes, for pickles.
pub mod bytes {
    use numpy::ndarray::{ArrayD, Dimension};
    use numpy::{Element, PyArray, PyArrayMethods};
    use pyo3::prelude::*;
    use serde::de::{Deserialize, Deserializer, Error as _};
    use serde::ser::{Error as _, Serialize, Serializer};

    pub fn serialize<T, D, S>(array: &Py<PyArray<T, D>>, serializer: S) -> Result<S::Ok, S::Error>
    where
        T: Element + Serialize,
        D: Dimension,
        S: Serializer,
    {
        Python::attach(|py| {
            let array = array.bind(py).try_readonly().map_err(S::Error::custom)?;
            let array = array.as_array();
            (array.shape(), array.iter().collect::<Vec<_>>()).serialize(serializer)
        })
    }

    pub fn deserialize<'de, T, D, S>(deserializer: S) -> Result<Py<PyArray<T, D>>, S::Error>
    where
        T: Element + Deserialize<'de>,
        D: Dimension,
        S: Deserializer<'de>,
    {
        let (shape, elements) = <(Vec<usize>, Vec<T>)>::deserialize(deserializer)?;
        let array = ArrayD::from_shape_vec(shape, elements).map_err(S::Error::custom)?;
        let array = array.into_dimensionality::<D>().map_err(S::Error::custom)?;
        Ok(Python::attach(|py| {
            PyArray::from_owned_array(py, array).unbind()
        }))
    }
}
