//! Answers as bytes. Pickles hold them, and answers are equal if these are (`python/punctual3d/_records.py`).

use crate::answer::Answer;
use crate::contacts::Contacts;
use crate::distance::Distance;
use crate::distance_batch::DistanceBatch;
use crate::errors::value_error;
use crate::estimate::{Certificate, DistanceEstimate, Estimate, Prediction, Quantiles, Remaining};
use crate::manifolds::Manifolds;
use crate::memory::Memory;
use crate::motion::Passage;
use crate::penetration::Penetration;
use crate::query::Collision;
use crate::query_batch::CollisionBatch;
use crate::rays::RayHits;
use crate::robot::{RobotClearances, RobotCollisions, RobotEdges, RobotMeetings, RobotNearPairs};
use crate::robot_motion::Ahead;
use crate::scene::Report;
use crate::scene_cast::BodyHits;
use crate::scene_contacts::ContactPoints;
use crate::scene_shapes::{ClosestBody, Overlaps, SceneHits, ShapeCast};
use crate::scene_tables::{BodyContacts, GroupDistances, PairDistances, PairPassages};
use crate::view::View;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::Serialize;

/// The two functions of all classes: those that extend `Answer`, and the others.
macro_rules! records {
    ([$($answer:ident),+], [$($other:ident),+]) => {
        /// What a record holds, as bytes.
        #[pyfunction]
        pub fn _state<'py>(record: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyBytes>> {
            let py = record.py();
            $(if let Ok(record) = record.cast::<$answer>() {
                return written(py, &(record.as_super().get(), record.get()));
            })+
            $(if let Ok(record) = record.cast::<$other>() {
                return written(py, &*record.try_borrow()?);
            })+
            Err(PyTypeError::new_err(format!("no record: {}", record.get_type())))
        }

        /// The record of a class from its bytes. Raises ValueError for those of another version of the package.
        #[pyfunction]
        pub fn _restore<'py>(py: Python<'py>, name: &str, version: &str, state: &[u8]) -> PyResult<Bound<'py, PyAny>> {
            let own = env!("CARGO_PKG_VERSION");
            if version != own {
                let fault = format!("{name} was pickled by punctual3d {version}, this is {own}");
                return Err(value_error(fault));
            }
            let damaged = |fault| value_error(format_args!("{name}: the pickle is damaged: {fault}"));
            match name {
                $(stringify!($answer) => {
                    let (base, record) = postcard::from_bytes::<(Answer, $answer)>(state).map_err(damaged)?;
                    Ok(Bound::new(py, (record, base))?.into_any())
                })+
                $(stringify!($other) => {
                    Ok(Bound::new(py, postcard::from_bytes::<$other>(state).map_err(damaged)?)?.into_any())
                })+
                _ => Err(value_error(format_args!("no record: {name}"))),
            }
        }
    };
}

records!(
    [
        Collision,
        Distance,
        Contacts,
        Manifolds,
        Passage,
        Penetration,
        RayHits,
        BodyHits,
        ClosestBody,
        Overlaps,
        SceneHits,
        ShapeCast
    ],
    [
        Ahead,
        BodyContacts,
        Certificate,
        CollisionBatch,
        ContactPoints,
        DistanceBatch,
        DistanceEstimate,
        Estimate,
        GroupDistances,
        Memory,
        PairDistances,
        PairPassages,
        Prediction,
        Quantiles,
        Remaining,
        Report,
        RobotClearances,
        RobotCollisions,
        RobotEdges,
        RobotMeetings,
        RobotNearPairs,
        View
    ]
);

fn written<'py>(py: Python<'py>, record: &impl Serialize) -> PyResult<Bound<'py, PyBytes>> {
    Ok(PyBytes::new(
        py,
        &postcard::to_allocvec(record).map_err(value_error)?,
    ))
}

/// A record that another holds.
pub mod nested {
    use pyo3::prelude::*;
    use pyo3::{PyClass, PyClassInitializer};
    use serde::de::{Deserialize, Deserializer, Error};
    use serde::ser::{Serialize, Serializer};

    pub fn serialize<T, S>(record: &Py<T>, serializer: S) -> Result<S::Ok, S::Error>
    where
        T: PyClass<Frozen = pyo3::pyclass::boolean_struct::True> + Serialize + Sync,
        S: Serializer,
    {
        record.get().serialize(serializer)
    }

    pub fn deserialize<'de, T, S>(deserializer: S) -> Result<Py<T>, S::Error>
    where
        T: PyClass + Deserialize<'de> + Into<PyClassInitializer<T>>,
        S: Deserializer<'de>,
    {
        let record = T::deserialize(deserializer)?;
        Python::attach(|py| Py::new(py, record)).map_err(S::Error::custom)
    }
}
