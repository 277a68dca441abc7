//! What one frame tells the next.

use crate::arrays::Transform;
use crate::tree::Tree;
use punctual::PairMemory;
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

/// What one query tells the next about the same pair of trees, at poses that follow each other: a part of the time is
/// spared.
///
/// It never changes an answer that is proven. Used with another pair of trees, it forgets. A pickle keeps what it
/// learned, but
/// not the clearance.
#[pyclass(module = "punctual3d")]
#[derive(Default, Serialize, Deserialize)]
pub struct Memory(pub PairMemory);

#[pymethods]
impl Memory {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// Whether the surfaces met when it was last decided; None if it never was.
    #[getter]
    fn last_verdict(&self) -> Option<bool> {
        self.0.last_verdict()
    }

    /// Frames since it was last decided.
    #[getter]
    fn frames_undecided(&self) -> u32 {
        self.0.frames_undecided()
    }

    /// Proven: how far apart the surfaces of a and b are at least at T, as far as `distance` with this memory has shown it,
    /// here or at another pose; 0 if nothing is known.
    ///
    /// T: (4, 4) matrix that brings coordinates of b into those of a; the identity by default. Raises ValueError if it is
    /// not rigid.
    #[pyo3(signature = (a, b, T=None))]
    #[expect(non_snake_case, reason = "the name of the argument in Python")]
    fn clearance(&self, a: PyRef<'_, Tree>, b: PyRef<'_, Tree>, T: Option<Transform>) -> f64 {
        self.0.clearance(&a.arc, &b.arc, &T.unwrap_or_default().0)
    }

    /// How often the verdict changes from one decided frame to the next, 0 to 1.
    #[getter]
    fn change_rate(&self) -> f64 {
        self.0.change_rate()
    }

    fn __copy__(&self) -> Self {
        Self(self.0.clone())
    }

    fn __deepcopy__(&self, _memo: &Bound<'_, PyAny>) -> Self {
        self.__copy__()
    }

    fn __repr__(&self) -> String {
        let last = match self.last_verdict() {
            Some(true) => "met",
            Some(false) => "apart",
            None => "never decided",
        };
        format!(
            "<punctual3d.Memory: {last}, {} frames undecided>",
            self.frames_undecided()
        )
    }
}

/// The memory that an argument holds, if it is given.
pub fn lent<'a>(memory: &'a mut Option<PyRefMut<'_, Memory>>) -> Option<&'a mut PairMemory> {
    memory.as_mut().map(|memory| &mut memory.0)
}
