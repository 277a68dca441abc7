//! The Python package `punctual3d`: trees, queries, batches and scenes, with NumPy arrays in and out.
//!
//! A thin face. Here are the arrays, the interpreter's lock and the exceptions; `python/punctual3d` has the rest of the
//! package: its names and its types.
//!
//! **The interpreter's lock.** Builds, batches and queries run without it. A query with a budget of less than 50 ms
//! keeps it: to get it back from another thread may take 5 ms.
//!
//! **Ctrl-C.** Every call that may take longer looks for it every 50 ms (`interrupt`).

#![deny(missing_docs, unsafe_code)]

mod answer;
mod arrays;
mod batch;
mod collision_manager;
mod contacts;
mod distance;
mod distance_batch;
mod errors;
mod estimate;
mod interrupt;
mod limit;
mod manifolds;
mod memory;
mod motion;
mod penetration;
mod query;
mod query_batch;
mod rays;
mod record;
mod robot;
mod robot_motion;
mod scene;
mod scene_cast;
mod scene_contacts;
mod scene_shapes;
mod scene_tables;
mod scene_view;
mod shapes;
mod tree;
mod view;
mod window;

/// The compiled part of the package.
#[pyo3::pymodule]
mod _punctual3d {
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::answer::Answer;
    #[pymodule_export]
    use super::collision_manager::{CollisionManager, ContactData, DistanceData};
    #[pymodule_export]
    use super::contacts::{Contacts, contacts};
    #[pymodule_export]
    use super::distance::{Distance, DistanceQuery, closer_than, distance};
    #[pymodule_export]
    use super::distance_batch::{DistanceBatch, distance_batch};
    #[pymodule_export]
    use super::errors::{ResumeError, UndecidedError};
    #[pymodule_export]
    use super::estimate::{
        Certificate, DistanceEstimate, Estimate, Prediction, Quantiles, Remaining,
    };
    #[pymodule_export]
    use super::manifolds::{Manifolds, manifolds, overlap};
    #[pymodule_export]
    use super::memory::Memory;
    #[pymodule_export]
    use super::motion::{MotionQuery, Passage, motion};
    #[pymodule_export]
    use super::penetration::{Penetration, penetration};
    #[pymodule_export]
    use super::query::{Collision, Query, collide};
    #[pymodule_export]
    use super::query_batch::{CollisionBatch, collide_batch};
    #[pymodule_export]
    use super::rays::{RayHits, rays};
    #[pymodule_export]
    use super::record::{_restore, _state};
    #[pymodule_export]
    use super::robot::{
        Robot, RobotClearances, RobotCollisions, RobotEdges, RobotMeetings, RobotNearPairs,
        braking_time, safe_speed,
    };
    #[pymodule_export]
    use super::robot_motion::{Ahead, Horizon, Trajectory};
    #[pymodule_export]
    use super::scene::{Report, Scene};
    #[pymodule_export]
    use super::scene_cast::BodyHits;
    #[pymodule_export]
    use super::scene_contacts::ContactPoints;
    #[pymodule_export]
    use super::scene_shapes::{ClosestBody, Overlaps, SceneHits, ShapeCast};
    #[pymodule_export]
    use super::scene_tables::{BodyContacts, GroupDistances, PairDistances, PairPassages};
    #[pymodule_export]
    use super::shapes::{cuboid, icosphere, torus, torus_knot};
    #[pymodule_export]
    use super::tree::Tree;
    #[pymodule_export]
    use super::view::View;
    #[pymodule_export]
    use super::window::PointWindow;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
