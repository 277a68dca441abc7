//! What a frame tells of contacts, of distances that are asked for, and of motions.

use crate::arrays::{column, table};
use crate::distance_batch::span;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use punctual_scene::{BodyContact, BodyId, GroupDistance, MeasureId, PairDistance, PairPassage};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

/// Contacts of bodies that begin, go on and end: a row for each.
///
/// They begin and end in frames that prove it. Contacts of a body that was removed end in the next frame, under its
/// name.
#[pyclass(module = "punctual3d", frozen, get_all)]
#[derive(Serialize, Deserialize)]
pub struct BodyContacts {
    /// (N, 2) uint64: the two bodies.
    #[serde(with = "crate::arrays::bytes")]
    bodies: Py<PyArray2<u64>>,
    /// N texts: "began", proven in this frame and not known before; "persists", proven again; "undecided", not decided
    /// in this frame; "ended", proven to be apart, or they may not meet any more, or one was removed, or both
    /// are fixed and their distance is measured no more.
    phases: Vec<String>,
    /// (N,) uint64: frames since the contact began; 0 in the frame in which it did.
    #[serde(with = "crate::arrays::bytes")]
    ages: Py<PyArray1<u64>>,
}

/// What is known of the distances that are measured: a row for each pair of bodies. Their margins are taken
/// off.
#[pyclass(module = "punctual3d", frozen, get_all)]
#[derive(Serialize, Deserialize)]
pub struct PairDistances {
    /// (N, 2) uint64: the two bodies.
    #[serde(with = "crate::arrays::bytes")]
    bodies: Py<PyArray2<u64>>,
    /// (N,) float64, a length: proven, they were no closer; 0 if nothing is known.
    #[serde(with = "crate::arrays::bytes")]
    low: Py<PyArray1<f64>>,
    /// (N,) float64, a length: proven, the distance of `triangles`, 0 if they met; infinite if nothing is known.
    #[serde(with = "crate::arrays::bytes")]
    high: Py<PyArray1<f64>>,
    /// (N, 2) int64: the closest triangles found, of the two bodies; -1 for none.
    #[serde(with = "crate::arrays::bytes")]
    triangles: Py<PyArray2<i64>>,
    /// (N,) uint64: frames since this was proven; 0 if it holds where the bodies are now.
    #[serde(with = "crate::arrays::bytes")]
    ages: Py<PyArray1<u64>>,
}

/// What is known of the least distances between groups of bodies: a row for each two groups. It holds where the bodies are
/// in this frame, whatever the budget reached.
#[pyclass(module = "punctual3d", frozen, get_all)]
#[derive(Serialize, Deserialize)]
pub struct GroupDistances {
    /// (N,) uint64: the names that `Scene.measure_groups` gave.
    #[serde(with = "crate::arrays::bytes")]
    ids: Py<PyArray1<u64>>,
    /// (N,) float64, a length: proven, no point of one group is closer to the other; 0 if nothing is known.
    #[serde(with = "crate::arrays::bytes")]
    low: Py<PyArray1<f64>>,
    /// (N,) float64, a length: proven, the groups are no farther apart, 0 if they meet; infinite if nothing is known.
    #[serde(with = "crate::arrays::bytes")]
    high: Py<PyArray1<f64>>,
    /// N pairs of the names of the two bodies that prove `high`; None where it is that of boxes.
    bodies: Vec<Option<(u64, u64)>>,
    /// (N, 2) int64: their closest triangles found; -1 for none.
    #[serde(with = "crate::arrays::bytes")]
    triangles: Py<PyArray2<i64>>,
    /// (N,) uint64: pairs of bodies that may still be closer. 0: high - low is within the tolerance.
    #[serde(with = "crate::arrays::bytes")]
    open: Py<PyArray1<u64>>,
}

/// Until when bodies in motion are free: a row for each pair of bodies that may meet on their way. Times from 0, this
/// frame, to 1, the end of the motions.
#[pyclass(module = "punctual3d", frozen, get_all)]
#[derive(Serialize, Deserialize)]
pub struct PairPassages {
    /// (N, 2) uint64: the two bodies.
    #[serde(with = "crate::arrays::bytes")]
    bodies: Py<PyArray2<u64>>,
    /// (N,) float64: proven, they meet at no time before; 0 if the budget did not reach the pair. If it is 1
    /// and `touching_at` NaN, they are free to the end.
    #[serde(with = "crate::arrays::bytes")]
    free_until: Py<PyArray1<f64>>,
    /// (N,) float64: proven, they meet at this time; NaN for none, no contact was found (yet).
    #[serde(with = "crate::arrays::bytes")]
    touching_at: Py<PyArray1<f64>>,
    /// (N, 2) int64: the triangles that meet then, of the two bodies; -1 for none.
    #[serde(with = "crate::arrays::bytes")]
    triangles: Py<PyArray2<i64>>,
}

/// The names of the two bodies of each row.
pub fn names(
    py: Python<'_>,
    pairs: impl IntoIterator<Item = [BodyId; 2]>,
) -> PyResult<Py<PyArray2<u64>>> {
    Ok(table(py, pairs.into_iter().map(|pair| pair.map(BodyId::to_bits)))?.unbind())
}

/// Triangles of the two bodies of each row.
fn triangles(
    py: Python<'_>,
    pairs: impl IntoIterator<Item = Option<[u32; 2]>>,
) -> PyResult<Py<PyArray2<i64>>> {
    Ok(table(
        py,
        pairs
            .into_iter()
            .map(|pair| pair.map_or([-1; 2], |pair| pair.map(i64::from))),
    )?
    .unbind())
}

impl BodyContacts {
    pub fn new(py: Python<'_>, contacts: &[BodyContact]) -> PyResult<Py<Self>> {
        let told = Self {
            bodies: names(py, contacts.iter().map(|contact| [contact.a, contact.b]))?,
            phases: contacts
                .iter()
                .map(|contact| contact.phase.to_string())
                .collect(),
            ages: column(py, contacts.iter().map(|contact| contact.age).collect()).unbind(),
        };
        Py::new(py, told)
    }
}

impl PairDistances {
    pub fn new(py: Python<'_>, pairs: &[PairDistance]) -> PyResult<Py<Self>> {
        let told = Self {
            bodies: names(py, pairs.iter().map(|pair| [pair.a, pair.b]))?,
            low: column(py, pairs.iter().map(|pair| pair.low).collect()).unbind(),
            high: column(py, pairs.iter().map(|pair| pair.high).collect()).unbind(),
            triangles: triangles(py, pairs.iter().map(|pair| pair.triangles))?,
            ages: column(py, pairs.iter().map(|pair| pair.age).collect()).unbind(),
        };
        Py::new(py, told)
    }
}

impl GroupDistances {
    pub fn new(py: Python<'_>, groups: &[GroupDistance]) -> PyResult<Py<Self>> {
        let told = Self {
            ids: column(
                py,
                groups
                    .iter()
                    .map(|group| MeasureId::to_bits(group.id))
                    .collect(),
            )
            .unbind(),
            low: column(py, groups.iter().map(|group| group.low).collect()).unbind(),
            high: column(py, groups.iter().map(|group| group.high).collect()).unbind(),
            bodies: groups
                .iter()
                .map(|group| group.bodies.map(|[a, b]| (a.to_bits(), b.to_bits())))
                .collect(),
            triangles: triangles(py, groups.iter().map(|group| group.triangles))?,
            open: column(py, groups.iter().map(|group| group.open as u64).collect()).unbind(),
        };
        Py::new(py, told)
    }
}

impl PairPassages {
    pub fn new(py: Python<'_>, pairs: &[PairPassage]) -> PyResult<Py<Self>> {
        let touching_at = pairs
            .iter()
            .map(|pair| pair.touching_at.unwrap_or(f64::NAN))
            .collect();
        let told = Self {
            bodies: names(py, pairs.iter().map(|pair| [pair.a, pair.b]))?,
            free_until: column(py, pairs.iter().map(|pair| pair.free_until).collect()).unbind(),
            touching_at: column(py, touching_at).unbind(),
            triangles: triangles(py, pairs.iter().map(|pair| pair.triangles))?,
        };
        Py::new(py, told)
    }
}

#[pymethods]
impl BodyContacts {
    fn __len__(&self) -> usize {
        self.phases.len()
    }

    fn __repr__(&self) -> String {
        let counts = ["began", "persists", "undecided", "ended"].map(|name| {
            let count = self.phases.iter().filter(|phase| *phase == name).count();
            format!("{count} {name}")
        });
        format!("<punctual3d.BodyContacts: {}>", counts.join(", "))
    }
}

#[pymethods]
impl PairDistances {
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.bodies.bind(py).as_any().len()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let [least, most] = span(&self.low.bind(py).to_vec()?, &self.high.bind(py).to_vec()?);
        Ok(format!(
            "<punctual3d.PairDistances: {} pairs, {least} to {most}>",
            self.__len__(py)?
        ))
    }
}

#[pymethods]
impl GroupDistances {
    fn __len__(&self) -> usize {
        self.bodies.len()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let [least, most] = span(&self.low.bind(py).to_vec()?, &self.high.bind(py).to_vec()?);
        Ok(format!(
            "<punctual3d.GroupDistances: {} groups, {least} to {most}>",
            self.__len__()
        ))
    }
}

#[pymethods]
impl PairPassages {
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.bodies.bind(py).as_any().len()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let touching = self
            .touching_at
            .bind(py)
            .to_vec()?
            .iter()
            .filter(|time| !time.is_nan())
            .count();
        let free = self
            .free_until
            .bind(py)
            .to_vec()?
            .into_iter()
            .reduce(f64::min)
            .unwrap_or(f64::NAN);
        let pairs = self.__len__(py)?;
        Ok(format!(
            "<punctual3d.PairPassages: {pairs} pairs, {touching} touch, all free until {free}>"
        ))
    }
}
