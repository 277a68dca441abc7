//! Mesh collision detection that answers by the deadline, and says how sure it is.
//!
//! A [`Mesh`] is checked once; its [`Tree`] is built once; a [`Query`] asks about two trees at a [`Pose`], within a [`Budget`],
//! in a [`Workspace`] that the caller keeps; the [`Outcome`] is a [`Verdict`] that is never wrong and never a bare `bool`,
//! and what a stopped query left open is in its [`Certificate`]. What a query will cost, what is left of a stopped one, and
//! how likely the surfaces meet are told by [`Query::predict`] and [`Query::estimate`].
//!
//! Many bodies that move, with one budget for each frame, are a [`Scene`].
//!
//! To read the code, begin with `query/traversal.rs`: it has the one loop, the stop rule and the guarantee.

#![cfg_attr(not(feature = "std"), no_std)]
#![deny(missing_docs)]
#![forbid(unsafe_code)]
#![cfg_attr(doctest, doc = include_str!("../README.md"))]
#![cfg_attr(doctest, doc = include_str!("../docs/guide/games.md"))]
#![cfg_attr(doctest, doc = include_str!("../docs/guide/controllers.md"))]
#![cfg_attr(doctest, doc = include_str!("../docs/guide/benchmarking.md"))]

extern crate alloc;

#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod internals;
mod math;
mod mesh;
mod model;
mod names;
mod query;
mod scene;
mod tree;
mod triangle;

/// The version of glam whose vectors and matrices are handed out.
///
/// Those that make a [`Pose`], a [`Mesh`] or a shape may be of any version, or plain arrays. Results go over to another version
/// by `to_array` and `to_cols_array`, which all versions have: a program that does so does not notice which one is used here.
pub use glam;
pub use math::{Aabb, Pose, PoseError};
pub use mesh::{Mesh, MeshError, shapes};
pub use model::confidence::{DEFAULT_PRIOR, History};
pub use model::cost::{
    CostModel, Counts, MAX_STEP_WORK, WORK_PER_EXACT_TEST, WORK_PER_EXPANSION, WORK_PER_TRIANGLE_TEST,
};
pub use model::prediction::Quantiles;
pub use names::UnknownName;
#[cfg(feature = "std")]
pub use query::SystemClock;
pub use query::{
    Budget, Certificate, Clock, Estimate, LEVELS, ManualClock, Mode, Order, Outcome, PairMemory, Prediction, Query,
    ResumeError, Stats, StopReason, Verdict, Workspace,
};
pub use scene::{Body, BodyId, BodyKind, Filter, PairCertificate, PairReport, Reach, Report, Scene, SceneError};
pub use tree::{BuildOptions, Effort, LevelProfile, Subtree, Tree, TreeFault, TreeFileError, TreeStats};
pub use triangle::triangles_intersect;
