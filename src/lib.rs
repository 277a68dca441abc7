//! Mesh collision detection that answers by the deadline, and says how sure it is.
//!
//! A [`Mesh`] is checked once, and its [`Tree`] is built once. A [`Query`] asks about two trees,
//! within a [`Budget`], in a [`Workspace`] that the caller keeps. The [`Answer`] tells what is
//! proven, never a bare `bool`.
//!
//! ```
//! use punctual::glam::{DMat3, DVec3};
//! use punctual::{Budget, Pose, Query, Tree, Verdict, Workspace, shapes};
//!
//! let (a, b) = (Tree::new(shapes::torus_knot(2, 3, 0.2, 64)), Tree::new(shapes::icosphere(3)));
//! let mut workspace = Workspace::new();
//! let pose = Pose::new(DMat3::IDENTITY, DVec3::new(0.8, 0.5, 0.0))?;
//! let query = Query::all_pairs(&a, &b, pose);
//!
//! // Far too little: what was found is true, what was not looked at is named.
//! let answer = query.run(&mut workspace, Budget::work(2_000));
//! let certificate = query.certificate(&workspace)?;
//! println!("{} pairs of triangles meet, and at most {}", answer.stats.found, certificate.upper_bound());
//!
//! // Later, with more time, it goes on where it was stopped.
//! let answer = query.resume(&mut workspace, Budget::time(std::time::Duration::from_millis(100)))?;
//! assert!(matches!(answer.value, Verdict::Intersecting { .. }));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Guarantees
//!
//! - **No false answer.** [`Verdict::Intersecting`] has a witness, two triangles that do intersect;
//!   [`Verdict::Within`] one that is within the margins of two bodies of a scene;
//!   [`Verdict::Separated`] is said when nothing is left to visit; everything else is
//!   [`Verdict::Undecided`]. The answer is exact for the pose as given.
//! - **It stops.** A budget of work is passed by at most [`MAX_STEP_WORK`]; under a budget of time
//!   the clock is looked at more often the nearer the deadline, in the end every
//!   [`Budget::poll_interval`] units of work.
//! - **What is missing is named**, by the [`Certificate`]: an upper bound, and boxes that hold
//!   every intersection not reported.
//! - **Nothing is lost.** A stopped query can be resumed ([`Query::resume`]); cut in any way by
//!   budgets of work, it ends in the same bits.
//! - **No surprise.** A query does not allocate, lock or panic. The same input and budget of work
//!   give the same bits.
//!
//! What is not guaranteed is estimated: the cost of a query ([`Query::predict`]), and of a stopped
//! one the work left, the probability that the surfaces meet, and the share of the intersections
//! found ([`Query::estimate`]).
//!
//! # Further
//!
//! - How far apart: [`Query::distance`]. Where, and which way out: [`Query::contacts`],
//!   [`Patches`], [`PushOutQuery`]. Free until when: [`Query::impact`]. What a ray hits:
//!   [`Query::ray`], [`Query::rays`]; in a scene, [`Scene::cast`].
//! - Many bodies that move, with one budget for each frame: [`Scene`].
//! - Meshes that deform: [`Tree::refit`]. Built trees as bytes: [`Tree::to_bytes`]. Mesh files: the
//!   crate `punctual-io`.
//! - What one frame tells the next: [`PairMemory`]. Without a system clock: [`Budget::time`],
//!   [`Clock`].
//! - Guides and measurements are the pages of [`guide`] and the folder `docs`; the code is
//!   explained from `ARCHITECTURE.md` on.

#![cfg_attr(not(feature = "std"), no_std)]
#![deny(missing_docs)]
#![forbid(unsafe_code)]
#![cfg_attr(doctest, doc = include_str!("../README.md"))]

extern crate alloc;

#[cfg(all(target_arch = "x86", not(target_feature = "sse2")))]
compile_error!(
    "punctual needs SSE2 on x86: x87 rounds differently, so bounds and answers could be false"
);

mod contact;
#[cfg(any(doc, doctest))]
pub mod guide;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod internals;
mod math;
mod mesh;
mod model;
mod names;
mod push_out;
mod query;
mod scene;
mod tree;
mod triangle;

pub use contact::{Contact, Patch, Patches};
/// The version of glam whose vectors and matrices are handed out.
///
/// Those that make a [`Pose`], a [`Mesh`] or a shape may be of any version, or plain arrays.
/// Results go over to another version by `to_array` and `to_cols_array`, which all versions have: a
/// program that does so does not notice which one is used here.
pub use glam;
pub use math::{Aabb, Motion, MotionError, Pose, PoseError, Ray, RayError};
pub use mesh::{Mesh, MeshError, shapes};
pub use model::calibration::Calibration;
pub use model::confidence::{DEFAULT_PRIOR, History};
pub use model::cost::{
    CostModel, Counts, MAX_DISTANCE_STEP_WORK, MAX_STEP_WORK, WORK_PER_EDGE_TEST,
    WORK_PER_EXACT_TEST, WORK_PER_EXPANSION, WORK_PER_TRIANGLE_TEST,
};
pub use model::prediction::Quantiles;
pub use names::UnknownName;
pub use push_out::{Push, PushOut, PushOutQuery};
#[cfg(all(
    feature = "std",
    not(all(target_family = "wasm", target_os = "unknown"))
))]
pub use query::SystemClock;
pub use query::{
    Answer, Bounds, Budget, Certificate, Clock, ClockedBudget, ContactBounds, Contacts, Distance,
    DistanceEstimate, Estimate, Impact, Intersection, LEVELS, ManualClock, Mode, Nearest,
    OptionError, Order, PairMemory, Prediction, Query, QueryWithMemory, Question, RayBounds,
    RayCast, RayHit, RayMode, Rays, Remembers, ResumeError, Stats, StopReason, TimeOfImpact,
    Verdict, Workspace,
};
pub use scene::{
    Body, BodyContact, BodyHit, BodyId, BodyKind, CompoundId, ContactPhase, ContactPoint,
    ContactPoints, Filter, GroupDistance, MeasureId, PairCertificate, PairDistance, PairPassage,
    PairQuestion, PairReport, Reach, Report, Scene, SceneCast, SceneError, SceneRay,
};
pub use tree::{
    BuildOptions, Effort, LevelProfile, Subtree, Tree, TreeFault, TreeFileError, TreeStats,
};
pub use triangle::ray::Side;
pub use triangle::{triangle_segment, triangles_intersect};
