//! Mesh collision detection that answers by the deadline, and says how sure it is.
//!
//! A [`Mesh`] is checked once, and its [`Tree`] is built once. A [`Query`] asks about two trees,
//! within a [`Budget`], in a [`Workspace`] that the caller keeps. The [`Answer`] states what is
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
//! let (found, most) = (answer.stats.found, certificate.upper_bound());
//! println!("{found} pairs of triangles meet, and at most {most}");
//!
//! // Later, with more time, it goes on where it was stopped.
//! let answer = query.resume(&mut workspace, Budget::time(std::time::Duration::from_millis(100)))?;
//! assert!(matches!(answer.value, Verdict::Intersecting { .. }));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # From alpha to confidence
//!
//! After R. Weller, J. Klein, G. Zachmann, "A Model for the Expected Running Time of Collision
//! Detection using AABB Trees" (EGVE 2006):
//!
//! 1. Each subtree stores its measured **alpha**, the factor by which boxes shrink from level to
//!    level ([`tree::Subtree::alpha_product`]).
//! 2. Alpha and the levels left give **N_v**, the expected number of box tests
//!    ([`Query::predict`]). A [`PairMemory`] corrects the predictions of its pair.
//! 3. Node pairs that overlap wait in a **priority queue**, by depth, size and levels left
//!    ([`intersection::Order`]). The first is replaced by the pairs of its children.
//! 4. The **budget** may stop the query between two steps of bounded work ([`Budget`]).
//! 5. A stopped query returns what it has found. [`Query::remaining`] tells the work and time left
//!    and the **confidence**: the probability of an intersection. [`Query::estimate`] tells the
//!    share found too.
//!
//! # Guarantees
//!
//! - **No false answer.** [`Verdict::Intersecting`] carries a witness: two triangles that
//!   intersect. [`Verdict::Within`] carries two triangles that are within the margins of two bodies
//!   of a scene. [`Verdict::Separated`] is returned only when nothing is left to visit. Everything
//!   else is [`Verdict::Undecided`]. The answer is exact for the pose as given.
//! - **It stops.** A query exceeds a budget of work by at most
//!   [`MAX_STEP_WORK`](prediction::MAX_STEP_WORK). Under a budget of time it reads the clock more
//!   often the nearer the deadline, in the end every [`Budget::poll_interval`] units of work.
//! - **The [`Certificate`] bounds what is missing**: an upper bound of the number of intersections,
//!   and boxes that hold every intersection not reported.
//! - **Nothing is lost.** A stopped query can be resumed ([`Query::resume`]). However budgets of
//!   work cut it, it ends with the same bits.
//! - **Deterministic and quiet.** A query does not lock or panic. It does not allocate, but for the
//!   first in a workspace for contacts, manifolds, solids, all hits of a ray, or a larger batch of
//!   rays or points ([`Query::run`]). The same input and budget of work give the same bits.
//!
//! The rest is estimated: the cost of a query ([`Query::predict`]), and for a stopped query the
//! work and time left, the probability that the surfaces intersect ([`Query::remaining`]), and the
//! share of the intersections found ([`Query::estimate`]).
//!
//! # Further
//!
//! - Distance: [`Query::distance`]. Contacts and their normals: [`Query::contacts`]; few points
//!   with depths for a solver: [`Query::manifolds`]. Time of impact: [`Query::impact`]. Ray casts:
//!   [`Query::ray`], [`Query::rays`]. A translation that separates the surfaces: the crate
//!   `punctual-depenetrate`.
//! - Point clouds, and which of their points are near a surface: [`Tree::from_points`],
//!   [`Query::points_within`].
//! - Many bodies that move, with one budget for each frame: the crate `punctual-scene`.
//! - Shapes: [`Tree::ball`], [`Tree::capsule`], [`Tree::cuboid`], [`Tree::cylinder`] and others.
//! - A mesh against itself: [`Query::self_intersections`]. Instances of a mesh, scaled or mirrored:
//!   [`Tree::scaled`]. Meshes that deform: [`Tree::refit`]. Built trees as bytes:
//!   [`Tree::to_bytes`]. Mesh files: the crate `punctual-io`.
//! - State kept from frame to frame: [`PairMemory`]. Without a system clock: [`Budget::clock`],
//!   [`Clock`].
//! - The guides and measurements are the pages of [`guide`] and of the folder `docs`.
//!   `ARCHITECTURE.md` explains the code.

#![cfg_attr(not(feature = "std"), no_std)]
#![deny(missing_docs)]
#![forbid(unsafe_code)]
#![cfg_attr(doctest, doc = include_str!("../README.md"))]

extern crate alloc;

#[cfg(all(target_arch = "x86", not(target_feature = "sse2")))]
compile_error!(
    "punctual needs SSE2 on x86: x87 rounds differently, so bounds and answers could be false"
);

pub mod engine;
#[cfg(any(doc, doctest))]
pub mod guide;
#[cfg(feature = "internals")]
#[doc(hidden)]
pub mod internals;
mod mesh;
mod model;
mod query;
mod room;
mod sets;
pub mod tree;

pub use engine::certificate::Certificate;
pub use engine::deadline::{Budget, Clock};
pub use engine::memory::PairMemory;
pub use engine::options::{Mode, OptionError};
pub use engine::outcome::{Answer, Stats, StopReason, Verdict};
pub use engine::question::Query;
pub use engine::workspace::{ResumeError, Workspace};
/// The version of glam whose vectors and matrices the results contain.
///
/// The arguments of a [`Pose`], a [`Mesh`] or a shape may be of any glam version, or plain arrays.
/// To convert results to another version, use `to_array` and `to_cols_array`, which all versions
/// have; the program then does not depend on the version used here.
pub use glam;
pub use mesh::depth::{DepthCamera, DepthError};
pub use mesh::{Mesh, MeshError, shapes};
#[doc(no_inline)]
pub use punctual_geom as geom;
pub use punctual_geom::{Aabb, Motion, Pose, PoseError, Ray};
pub use tree::{BuildOptions, Tree};

/// Clocks that measure the time of a [`Budget`].
pub mod clock {
    #[cfg(all(
        feature = "std",
        not(all(target_family = "wasm", target_os = "unknown"))
    ))]
    pub use crate::engine::deadline::system::SystemClock;
    pub use crate::engine::deadline::{
        budget::{Clock, ManualClock},
        system::ClockedBudget,
    };
}

/// Which triangles of two surfaces intersect: [`Query::intersection`], [`Query::all_pairs`], or of
/// one: [`Query::self_intersections`].
pub mod intersection {
    pub use crate::engine::frontier::order::Order;
    pub use crate::engine::options::Mode;
    pub use crate::engine::outcome::{Operand, Verdict};
    pub use crate::query::intersection::Intersection;
    pub use crate::query::self_intersection::SelfIntersection;
}

/// The distance of two surfaces, with bounds: [`Query::distance`].
pub mod distance {
    pub use crate::query::distance::estimate::DistanceEstimate;
    pub use crate::query::distance::{Bounds, Distance, Nearest};
}

/// Contacts, and manifolds of them for a solver: [`Query::contacts`], [`Query::manifolds`].
pub mod contacts {
    pub use crate::query::contacts::contact::Contact;
    pub use crate::query::contacts::{ContactBounds, Contacts};
    pub use crate::query::manifolds::manifold::{Manifold, ManifoldPoint};
    pub use crate::query::manifolds::overlaps::REGION_LIMIT;
    pub use crate::query::manifolds::{ManifoldBounds, Manifolds};
}

/// Time of impact of a body that moves: [`Query::impact`].
pub mod impact {
    pub use crate::query::motion::{Impact, TimeOfImpact};
}

/// Ray casts: [`Query::ray`], [`Query::rays`].
pub mod rays {
    pub use crate::query::rays::{RayBounds, RayCast, RayHit, RayMode, Rays};
    pub use punctual_geom::Side;
}

/// Points and solids: [`Query::winding`], [`Query::signed_distance`].
pub mod points {
    pub use crate::query::near_points::PointsWithin;
    pub use crate::query::points::{AtPoint, AtPoints, PointBounds, PointError, SignedDistance};
}

/// What a query will cost, what a stopped one has found, and the unit of work.
pub mod prediction {
    pub use crate::engine::question::Remaining;
    pub use crate::model::calibration::Calibration;
    pub use crate::model::confidence::{DEFAULT_PRIOR, History};
    pub use crate::model::cost::{
        CostModel, Counts, MAX_DISTANCE_STEP_WORK, MAX_STEP_WORK, WORK_PER_EDGE_TEST,
        WORK_PER_EXACT_TEST, WORK_PER_EXPANSION, WORK_PER_TRIANGLE_TEST,
    };
    pub use crate::model::prediction::Quantiles;
    pub use crate::query::intersection::estimate::{Estimate, Prediction};
}
