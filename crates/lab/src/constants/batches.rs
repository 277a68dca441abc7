//! Rays and points, alone and in batches, stopped on the way: what the model sees, and what came of
//! it.

use punctual::clock::ManualClock;
use punctual::engine::{Ask, Question};
use punctual::glam::DVec3;
use punctual::internals::{Batch, Random};
use punctual::rays::RayMode;
use punctual::tree::Solid;
use punctual::{Budget, BuildOptions, Query, Ray, StopReason, Tree, Workspace};

use super::cases::Case;
use super::sample::STOPS;

/// Sizes of the batches.
const SIZES: [usize; 4] = [1, 1, 16, 200];

/// Solids of more triangles are not asked about, because they take long to build.
const LARGEST_SOLID: usize = 100_000;

/// A run at one moment, and its end.
pub struct Moment {
    /// The case it is of, by number.
    pub case: usize,
    pub batch: Batch,
    /// Work of the whole run.
    pub total: f64,
    pub is_of_points: bool,
}

/// Rays and points about the first mesh of a case.
pub fn moments(number: usize, case: &Case) -> Vec<Moment> {
    let mut moments = Vec::new();
    let mut random = Random::new(number as u64 + 1);
    let (mesh, mut workspace) = (case.a.mesh(), Workspace::new());
    let bounds = mesh.aabb();
    let half = 0.6 * bounds.extents();
    let mut point = || {
        let at = DVec3::from_array([(); 3].map(|()| random.between(-1.0, 1.0)));
        bounds.center() + at * half
    };
    let triangles = mesh.len() as f64;
    let mut add = |is_of_points, is_thorough, [done, size]: [usize; 2], work, total| {
        let batch = Batch {
            triangles,
            done: done as f64,
            left: (size - done) as f64,
            work,
            is_thorough,
        };
        moments.push(Moment {
            case: number,
            batch,
            total,
            is_of_points,
        });
    };
    for size in SIZES {
        // From outside to a point in the box.
        let rays: Vec<Ray> = (0..size)
            .filter_map(|_| {
                let (from, to) = (bounds.center() + 4.0 * (point() - bounds.center()), point());
                Ray::new(from.to_array(), (to - from).to_array()).ok()
            })
            .collect();
        if let [ray] = rays[..] {
            for mode in [RayMode::Nearest, RayMode::All] {
                let query = Query::ray(&case.a, ray).mode(mode);
                sample(&query, &mut workspace, |_, work, total| {
                    add(false, mode == RayMode::All, [0, 1], work, total);
                });
            }
        } else {
            let query = Query::rays(&case.a, &rays);
            sample(&query, &mut workspace, |done, work, total| {
                add(false, false, [done, rays.len()], work, total);
            });
        }
    }
    if mesh.len() > LARGEST_SOLID {
        return moments;
    }
    let solid = Tree::with_options(mesh.clone(), &BuildOptions::default().solid(Solid::Keep));
    for size in SIZES {
        let points: Vec<[f64; 3]> = (0..size).map(|_| point().to_array()).collect();
        for is_thorough in [false, true] {
            let query = if is_thorough {
                Query::signed_distances(&solid, &points)
            } else {
                Query::windings(&solid, &points)
            };
            let Ok(query) = query else { continue };
            sample(&query, &mut workspace, |done, work, total| {
                add(true, is_thorough, [done, size], work, total);
            });
        }
    }
    moments
}

/// Calls `add` with what is done, the work done and the whole work, before the run and at each stop.
fn sample<'t, Q: Question>(
    query: &Query<'t, Q>,
    workspace: &mut Workspace,
    mut add: impl FnMut(usize, f64, f64),
) where
    Query<'t, Q>: Ask<Q>,
    Q::Value: Done,
{
    let clock = ManualClock::new();
    let mut run = |budget: Budget| query.run(workspace, budget.clock(&clock));
    let total = run(Budget::unlimited()).stats.work as f64;
    for stop in [0.0].into_iter().chain(STOPS) {
        let answer = run(Budget::work((stop * total) as u64));
        if answer.stop == StopReason::WorkLimit {
            add(answer.value.done(), answer.stats.work as f64, total);
        }
    }
}

/// How many of a batch are done.
trait Done {
    fn done(&self) -> usize;
}

impl Done for usize {
    fn done(&self) -> usize {
        *self
    }
}

impl Done for punctual::rays::RayBounds {
    fn done(&self) -> usize {
        0
    }
}
