//! What rays hit.

use crate::answer::Answer;
use crate::arrays::{column, each, vectors_or_one};
use crate::errors::{point_error, value_error};
use crate::limit::Limit;
use crate::query::with_workspace;
use crate::tree::Surface;
use numpy::PyArray1;
use punctual::rays::{RayHit, RayMode, Side};
use punctual::{Clock, Query, Ray, Stats, StopReason, Workspace};
use pyo3::prelude::*;
use serde::{Deserialize, Serialize};

/// What rays hit. In all arrays a row for each ray; of mode "all" a row for each hit, ray by ray, the nearest first.
///
/// The first `done` rays are answered. If the budget ended first, rows follow that say nothing: there `t` is NaN; of mode
/// "all" there are no rows of rays that are not answered.
#[pyclass(module = "punctual3d", frozen, extends = Answer)]
#[derive(Serialize, Deserialize)]
pub struct RayHits {
    hits: Vec<Option<RayHit>>,
    /// The ray of each hit; None: as many rows as rays.
    rays: Option<Vec<i64>>,
    done: usize,
    starts_inside: Option<Vec<bool>>,
}

#[pymethods]
impl RayHits {
    /// (N,) int64: which of the rays given each row is of.
    #[getter]
    fn rays<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        column(
            py,
            self.rays
                .clone()
                .unwrap_or_else(|| (0..self.hits.len() as i64).collect()),
        )
    }

    /// (N,) int64: the triangle that is hit, an index into the faces of the mesh; -1 for none.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        column(
            py,
            self.hits
                .iter()
                .map(|hit| hit.map_or(-1, |hit| hit.triangle.into()))
                .collect(),
        )
    }

    /// (N,) float64: the hit is at `origin + t * direction`, or at `origin + t * (end - origin)`; infinite for none.
    #[getter]
    fn t<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let done = self.done;
        let none = |row| if row < done { f64::INFINITY } else { f64::NAN };
        column(
            py,
            self.hits
                .iter()
                .enumerate()
                .map(|(row, hit)| hit.map_or(none(row), |hit| hit.t))
                .collect(),
        )
    }

    /// (N,) int8: 1 if the ray comes from the side from which the corners appear counterclockwise, -1 from the other;
    /// 0 if it lies in the plane of the triangle, or hits none.
    #[getter]
    fn sides<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i8>> {
        column(
            py,
            self.hits
                .iter()
                .map(|hit| hit.map_or(0, |hit| side(hit.side)))
                .collect(),
        )
    }

    /// (rays,) bool: whether each ray is known to start inside the solid or on its surface; None unless `solid` was asked.
    #[getter]
    fn starts_inside<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<bool>>> {
        let inside = self.starts_inside.clone()?;
        Some(column(py, inside))
    }

    /// The first so many rays are answered; all of them if `stop` is "finished".
    #[getter]
    fn done(&self) -> usize {
        self.done
    }

    fn __len__(&self) -> usize {
        self.hits.len()
    }

    fn __repr__(slf: PyRef<'_, Self>) -> String {
        let count = slf.hits.iter().flatten().count();
        format!(
            "<punctual3d.RayHits: {count} hits, {} rays done, {}>",
            slf.done,
            slf.as_super().stop
        )
    }
}

/// A side as a number.
pub fn side(side: Side) -> i8 {
    match side {
        Side::Front => 1,
        Side::Back => -1,
        Side::Edge => 0,
    }
}

/// One hit of each ray, or none.
fn one(
    tree: &punctual::Tree,
    rays: &[Ray],
    mode: RayMode,
    workspace: &mut Workspace,
    (limit, clock): (Limit, &dyn Clock),
) -> (RayHits, Answer) {
    let batch = Query::rays(tree, rays);
    let batch = if mode == RayMode::Any {
        batch.any()
    } else {
        batch
    };
    let answer = batch.run(workspace, limit.budget().clock(clock));
    let mut hits = workspace.first_hits().to_vec();
    hits.resize(rays.len(), None);
    (
        RayHits {
            hits,
            rays: None,
            done: answer.value,
            starts_inside: None,
        },
        Answer::of(&batch, workspace, None, &answer),
    )
}

/// Rays between two looks whether the user cancels the call.
const BETWEEN_LOOKS: usize = 64;

/// All hits of each ray.
fn all(
    tree: &punctual::Tree,
    rays: &[Ray],
    workspace: &mut Workspace,
    (mut limit, clock): (Limit, &dyn Clock),
) -> (RayHits, Answer) {
    let (mut hits, mut of_rays, mut done) = (Vec::new(), Vec::new(), 0);
    let mut answer = Answer::new(StopReason::Finished, &Stats::default());
    for ray in rays {
        // Each ray alone may take less than what a query does before it looks.
        if done % BETWEEN_LOOKS == 0 && clock.is_cancelled() {
            break;
        }
        let query = Query::ray(tree, *ray).mode(RayMode::All);
        let mut cast = query.run(workspace, limit.budget().clock(clock));
        let mut found: Vec<RayHit> = workspace.drain_ray_hits().collect();
        while cast.stop == StopReason::PairsFull {
            let left = limit.left(&Stats::default(), &cast.stats);
            let Ok(next) = query.resume(workspace, left.budget().clock(clock)) else {
                break;
            };
            cast = next;
            found.extend(workspace.drain_ray_hits());
        }
        limit = limit.left(&Stats::default(), &cast.stats);
        answer.work += cast.stats.work;
        answer.elapsed = cast
            .stats
            .elapsed
            .map(|elapsed| elapsed + answer.elapsed.unwrap_or_default());
        if cast.stop != StopReason::Finished {
            answer.stop = cast.stop;
            break;
        }
        found.sort_by(|x, y| x.t.total_cmp(&y.t).then(x.triangle.cmp(&y.triangle)));
        of_rays.extend(found.iter().map(|_| done as i64));
        hits.extend(found.into_iter().map(Some));
        done += 1;
    }
    (
        RayHits {
            hits,
            rays: Some(of_rays),
            done,
            starts_inside: None,
        },
        answer,
    )
}

/// The mode of rays by its name.
pub fn ray_mode(name: &str) -> PyResult<RayMode> {
    name.parse()
        .map_err(|error| value_error(format_args!("mode: {error}")))
}

/// Refuses limits of t that are no numbers.
pub fn not_nan([t_min, t_max]: [f64; 2]) -> PyResult<()> {
    for (limit, number) in [("t_min", t_min), ("t_max", t_max)] {
        if number.is_nan() {
            return Err(value_error(format_args!(
                "{limit} is NaN, expected a number"
            )));
        }
    }
    Ok(())
}

/// The rays of two arrays, checked: each origin with its direction, or with its end.
pub fn checked(
    py: Python<'_>,
    origins: &Bound<'_, PyAny>,
    [directions, ends]: [Option<&Bound<'_, PyAny>>; 2],
    [t_min, t_max]: [f64; 2],
) -> PyResult<Vec<Ray>> {
    let (what, targets) = match (directions, ends) {
        (Some(directions), None) => ("directions", directions),
        (None, Some(ends)) => ("ends", ends),
        _ => {
            return Err(value_error(
                "directions and ends: one of them is needed, not both",
            ));
        }
    };
    not_nan([t_min, t_max])?;
    let (origins, targets) = (
        vectors_or_one(origins, "origins")?,
        vectors_or_one(targets, what)?,
    );
    let count = match (origins.len(), targets.len()) {
        (1, count) | (count, 1) => count,
        (count, other) if count == other => count,
        (origins, targets) => {
            return Err(value_error(format_args!(
                "{what}: {targets} rows, but origins has {origins}"
            )));
        }
    };
    // One stands for all.
    let of = |rows: &[[f64; 3]], row| if rows.len() == 1 { rows[0] } else { rows[row] };
    each(py, 0..count, |row, _| {
        let (origin, target) = (of(&origins, row), of(&targets, row));
        let ray = if ends.is_some() {
            Ray::segment(origin, target)
        } else {
            Ray::new(origin, target)
        };
        let ray = ray.map_err(|error| value_error(format_args!("ray {row}: {error}")))?;
        Ok(ray.within(t_min, t_max))
    })
}

/// What each of many rays hits, in one call.
///
/// origins: (N, 3), in the frame of the tree's mesh. directions: (N, 3), of any length; t counts in that length. Or ends:
/// (N, 3), for segments, of which t goes from 0 to 1. One origin, direction or end, (3,) or (1, 3), stands for all.
/// mode:
/// "nearest" hit, "any", or "all". t_min, t_max: hits outside are left out. budget: seconds; work: units of work; of
/// all rays
/// together. solid: say first whether each ray starts inside the tree, which was built as a solid.
///
/// Whether a triangle is hit is exact: no ray slips through between two triangles that share an edge.
///
/// Raises ValueError for arrays of other shapes and numbers that are no ray, with the row, and TypeError for wrong types.
#[pyfunction]
#[pyo3(signature = (tree, origins, directions=None, *, ends=None, mode="nearest", t_min=0.0, t_max=f64::INFINITY,
    solid=false, budget=None, work=None))]
#[expect(
    clippy::too_many_arguments,
    reason = "the arguments of the Python function"
)]
pub fn rays<'py>(
    py: Python<'py>,
    tree: Surface<'_>,
    origins: &Bound<'_, PyAny>,
    directions: Option<&Bound<'_, PyAny>>,
    ends: Option<&Bound<'_, PyAny>>,
    mode: &str,
    t_min: f64,
    t_max: f64,
    solid: bool,
    budget: Option<f64>,
    work: Option<u64>,
) -> PyResult<Bound<'py, RayHits>> {
    let mode = ray_mode(mode)?;
    let limit = Limit::new(budget, work)?;
    let rays = checked(py, origins, [directions, ends], [t_min, t_max])?;
    let tree = &*tree.arc;
    let origins: Vec<[f64; 3]> = rays.iter().map(|ray| ray.origin().to_array()).collect();
    let points = solid.then(|| Query::windings(tree, &origins)).transpose();
    let points = points.map_err(point_error)?;
    let run = |workspace: &mut Workspace, (mut limit, clock): (Limit, &dyn Clock)| {
        let starts_inside = points.as_ref().map(|points| {
            let answer = points.run(workspace, limit.budget().clock(clock));
            limit = limit.left(&Stats::default(), &answer.stats);
            let found = workspace.points().iter();
            let mut inside: Vec<bool> = found.map(|point| point.inside == Some(true)).collect();
            inside.resize(rays.len(), false);
            inside
        });
        let (hits, answer) = match mode {
            RayMode::All => all(tree, &rays, workspace, (limit, clock)),
            RayMode::Nearest | RayMode::Any => one(tree, &rays, mode, workspace, (limit, clock)),
        };
        let hits = RayHits {
            starts_inside,
            ..hits
        };
        (hits, answer)
    };
    let hits = limit.run(py, |clock| {
        with_workspace(|workspace| run(workspace, (limit, clock)))
    })?;
    Bound::new(py, hits)
}
