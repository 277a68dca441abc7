//! What a query will take, what a stopped one leaves open: estimates, and what is proven.

use crate::arrays::points;
use numpy::PyArray3;
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

/// An uncertain number: its median, and its 10 % and 90 % quantiles.
#[pyclass(module = "punctual3d", frozen, get_all)]
#[derive(Clone, Copy, Serialize, Deserialize)]
pub struct Quantiles {
    /// Below this with probability 10 %.
    p10: f64,
    /// The median.
    p50: f64,
    /// Below this with probability 90 %.
    p90: f64,
}

impl From<punctual::prediction::Quantiles> for Quantiles {
    fn from(
        punctual::prediction::Quantiles { p10, p50, p90 }: punctual::prediction::Quantiles,
    ) -> Self {
        Self { p10, p50, p90 }
    }
}

#[pymethods]
impl Quantiles {
    fn __repr__(&self) -> String {
        format!(
            "Quantiles(p10={:.4}, p50={:.4}, p90={:.4})",
            self.p10, self.p50, self.p90
        )
    }
}

/// What a stopped query has still to do, expected.
#[pyclass(module = "punctual3d", frozen, get_all)]
#[derive(Clone, Copy, Serialize, Deserialize)]
pub struct Remaining {
    /// Units of work.
    work: Quantiles,
    /// Seconds: at the pace of the run so far; of runs without a budget of time, on a common machine.
    time: Quantiles,
}

impl From<punctual::prediction::Remaining> for Remaining {
    fn from(left: punctual::prediction::Remaining) -> Self {
        Self {
            work: left.work.into(),
            time: left.time.map(|nanoseconds| nanoseconds * 1e-9).into(),
        }
    }
}

impl From<Prediction> for Remaining {
    fn from(Prediction { work, time, .. }: Prediction) -> Self {
        Self { work, time }
    }
}

#[pymethods]
impl Remaining {
    fn __repr__(&self) -> String {
        let [work, time] = [self.work, self.time].map(|number| number.__repr__());
        format!("Remaining(work={work}, time={time})")
    }
}

/// What a query, or the rest of one, is expected to take.
#[pyclass(module = "punctual3d", frozen, get_all)]
#[derive(Clone, Copy, Serialize, Deserialize)]
pub struct Prediction {
    /// BV tests.
    bv_tests: Quantiles,
    /// Triangle pairs tested.
    triangle_tests: Quantiles,
    /// Units of work.
    work: Quantiles,
    /// Seconds: of the rest of a query by what its steps took so far, before it by those of a common machine.
    time: Quantiles,
}

impl Prediction {
    pub fn new(
        prediction: &punctual::prediction::Prediction,
        costs: &punctual::prediction::CostModel,
    ) -> Self {
        Self {
            bv_tests: prediction.bv_tests.into(),
            triangle_tests: prediction.triangle_tests.into(),
            work: prediction.work.into(),
            time: prediction
                .time(costs)
                .map(|nanoseconds| nanoseconds * 1e-9)
                .into(),
        }
    }
}

#[pymethods]
impl Prediction {
    fn __repr__(&self) -> String {
        let [bv_tests, triangle_tests, work, time] =
            [self.bv_tests, self.triangle_tests, self.work, self.time]
                .map(|number| number.__repr__());
        format!(
            "Prediction(bv_tests={bv_tests}, triangle_tests={triangle_tests}, work={work}, time={time})"
        )
    }
}

/// What can be said of a stopped query. Not proven: only the verdict and the certificate are.
#[pyclass(module = "punctual3d", frozen, get_all)]
#[derive(Clone, Copy, Serialize, Deserialize)]
pub struct Estimate {
    /// Probability that the surfaces meet.
    pub probability: f64,
    /// Expected share of the intersecting pairs that has been found.
    pub recall: f64,
    /// What the query has still to do.
    pub remaining: Prediction,
}

impl Estimate {
    pub fn new(
        estimate: &punctual::prediction::Estimate,
        costs: &punctual::prediction::CostModel,
    ) -> Self {
        let remaining = Prediction::new(&estimate.remaining, costs);
        Self {
            probability: estimate.probability,
            recall: estimate.recall,
            remaining,
        }
    }
}

#[pymethods]
impl Estimate {
    fn __repr__(&self) -> String {
        let Self {
            probability,
            recall,
            remaining,
        } = self;
        format!(
            "Estimate(probability={probability:.4}, recall={recall:.4}, remaining={})",
            remaining.__repr__()
        )
    }
}

/// What can be said of a stopped distance query. Not proven: only its bounds and the certificate are.
#[pyclass(module = "punctual3d", frozen, get_all)]
#[derive(Serialize, Deserialize)]
pub struct DistanceEstimate {
    /// The distance, in the length unit of the meshes.
    distance: Quantiles,
    /// Units of work that the query has still to do.
    remaining: Quantiles,
}

impl From<punctual::distance::DistanceEstimate> for DistanceEstimate {
    fn from(estimate: punctual::distance::DistanceEstimate) -> Self {
        Self {
            distance: estimate.distance.into(),
            remaining: estimate.remaining.into(),
        }
    }
}

#[pymethods]
impl DistanceEstimate {
    fn __repr__(&self) -> String {
        let [distance, remaining] = [self.distance, self.remaining].map(|number| number.__repr__());
        format!("DistanceEstimate(distance={distance}, remaining={remaining})")
    }
}

/// What is proven about that which a stopped query has not looked at.
#[pyclass(module = "punctual3d", frozen)]
#[derive(Serialize, Deserialize)]
pub struct Certificate {
    /// Number of open pairs, of nodes or triangles. 0 means that nothing was missed.
    #[pyo3(get)]
    open_pairs: usize,
    /// No more triangle pairs than this intersect (or, of a distance query, are closer than its upper bound by more than the
    /// tolerance).
    #[pyo3(get)]
    upper_bound: u64,
    /// The longest edge of the boxes, in the length unit of the meshes.
    #[pyo3(get)]
    largest_extent: f64,
    boxes: Vec<[[f64; 3]; 2]>,
}

impl From<punctual::Certificate<'_>> for Certificate {
    fn from(certificate: punctual::Certificate<'_>) -> Self {
        Self {
            open_pairs: certificate.open_pairs(),
            upper_bound: certificate.upper_bound(),
            largest_extent: certificate.largest_extent(),
            boxes: certificate
                .boxes()
                .map(|open| [open.min.to_array(), open.max.to_array()])
                .collect(),
        }
    }
}

#[pymethods]
impl Certificate {
    /// Boxes in A's frame, (K, 2, 3): least and greatest corner. Every intersection that was not reported lies in one
    /// of them.
    #[getter]
    fn boxes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        points(py, self.boxes.iter().copied())
    }

    fn __repr__(&self) -> String {
        let Self {
            open_pairs,
            upper_bound,
            largest_extent,
            ..
        } = self;
        format!(
            "<punctual3d.Certificate: {open_pairs} open pairs, upper bound {upper_bound}, largest extent {largest_extent}>"
        )
    }
}
