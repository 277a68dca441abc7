//! What one frame tells the next.

use punctual::PairMemory;
use pyo3::prelude::*;

/// What one query tells the next about the same pair of trees, at poses that follow each other: a part of the time is
/// spared.
///
/// It never changes an answer that is proven. Used with another pair of trees, it forgets.
#[pyclass(module = "punctual")]
#[derive(Default)]
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

    /// How often the verdict changes from one decided frame to the next, 0 to 1.
    #[getter]
    fn change_rate(&self) -> f64 {
        self.0.change_rate()
    }
}

/// The memory that an argument holds, if it is given.
pub fn lent<'a>(memory: &'a mut Option<PyRefMut<'_, Memory>>) -> Option<&'a mut PairMemory> {
    memory.as_mut().map(|memory| &mut memory.0)
}
